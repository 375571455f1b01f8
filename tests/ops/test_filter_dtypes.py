"""Linear filters, their kernels and thresholds keep their input's dtype and device, and are close to float32
in half precision."""

from collections.abc import Callable

import pytest
import torch
from torch import Tensor

from chiasm import filters
from chiasm.export import example_inputs
from chiasm.export.catalog import Entry, catalog
from chiasm.export.tracing.module import bind_spec
from chiasm.geometry.transform import pyrdown, pyrup

#: Comparisons, whose outputs are discontinuous: only the dtype is compared.
JUMPS = ("adaptive", "otsu", "edge_aware", "in_range", "get_motion_kernel3d")
MODULES = (
    "box",
    "correlation",
    "edges",
    "gabor",
    "gaussian",
    "gaussian_kernels",
    "gradient",
    "gradient3d",
    "motion",
    "pooling",
    "sharpen",
    "threshold",
)
ENTRIES = {
    n: e for n, e in catalog().items() if e.function().__module__.removeprefix("chiasm.filters.") in MODULES
}
SIZES = {"B": 2, "C": 3, "H": 12, "W": 11, "N": 5}


def results(entry: Entry, dtype: str) -> list[Tensor]:
    spec = entry.spec
    # The same scene for all: values that every dtype has.
    made = example_inputs.make(spec, example_inputs.fit(spec, SIZES), "bfloat16")
    inputs = [v.to(getattr(torch, dtype)) if v.is_floating_point() else v for v in made.values()]
    result = bind_spec(entry.function(), spec)(*inputs)
    return [result] if isinstance(result, Tensor) else list(result)


@pytest.mark.parametrize(("dtype", "tolerance"), [("float64", 1e-4), ("float16", 2e-2), ("bfloat16", 1e-1)])
@pytest.mark.parametrize("entry", ENTRIES.values(), ids=ENTRIES)
def test_dtype_is_kept(entry: Entry, dtype: str, tolerance: float) -> None:
    for actual, expected in zip(results(entry, dtype), results(entry, "float32"), strict=True):
        if not expected.is_floating_point():
            continue
        assert actual.dtype == getattr(torch, dtype)
        assert torch.isfinite(actual).all()
        if not any(word in entry.spec.name for word in JUMPS):
            scale = expected.abs().max().item()
            torch.testing.assert_close(actual.float(), expected, rtol=0.0, atol=tolerance * max(scale, 1.0))


def scene(scale: float, size: int = 40) -> Tensor:
    return scale * torch.rand(1, 1, size, size, generator=torch.Generator().manual_seed(7))


#: Results that float16 holds, of sums, squares or quotients that it does not hold.
LARGE = {
    "adaptive_threshold": (
        lambda x: filters.adaptive_threshold(x.round(), 255.0, "mean", block_size=19),
        255.0,
    ),
    "bilateral_blur l1": (lambda x: filters.bilateral_blur(x, 5, 0.002, (1.5, 1.5)), 0.01),
    "bilateral_blur l2": (
        lambda x: filters.bilateral_blur(x, 5, 40.0, (1.5, 1.5), color_distance_type="l2"),
        800.0,
    ),
    "bilateral_blur sigma": (
        lambda x: filters.bilateral_blur(x, 5, torch.tensor([2.0**-9], dtype=x.dtype), (1.5, 1.5)),
        0.01,
    ),
    "box_blur": (lambda x: filters.box_blur(x, 25), 255.0),
    "canny": (lambda x: filters.canny(x, 100.0, 200.0)[0], 255.0),
    "joint_bilateral_blur": (
        lambda x: filters.joint_bilateral_blur(x, x.flip(3), 3, 300.0, (9.0, 9.0)),
        800.0,
    ),
    "laplacian": (lambda x: filters.laplacian(x, 25), 255.0),
    "prewitt": (lambda x: filters.prewitt(x, normalized=False), 255.0),
    "pyrdown": (lambda x: pyrdown(x, sampling="alternate"), 8000.0),
    "pyrup": (lambda x: pyrup(x, sampling="alternate"), 8000.0),
    "scharr": (lambda x: filters.scharr(x), 2000.0),
    "sobel": (lambda x: filters.sobel(x, normalized=False), 255.0),
}


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16])
@pytest.mark.parametrize(("op", "scale"), LARGE.values(), ids=LARGE)
def test_half_precision_holds_what_fits(
    op: Callable[[Tensor], Tensor], scale: float, dtype: torch.dtype
) -> None:
    x = scene(scale).to(dtype)
    expected, actual = op(x.float()), op(x)
    assert actual.dtype == dtype and actual.isfinite().all()
    if op is LARGE["canny"][0]:  # the blur before it rounds, which moves some ridges
        assert ((actual.float() - expected).abs() <= 2.0**-6 * expected).float().mean() > 0.9
    else:
        torch.testing.assert_close(actual, expected.to(dtype), rtol=0.0, atol=0.0)


X = torch.zeros(2, 3, 12, 11, device="meta")
V = torch.zeros(2, 1, 6, 7, 8, device="meta")
ANGLES = torch.zeros(2, device="meta")


@pytest.mark.parametrize("call", [
    lambda: filters.motion_blur(X, 5, 30.0, 0.2),
    lambda: filters.motion_blur(X, 5, ANGLES, 0.2),
    lambda: filters.motion_blur3d(V, 3, (1.0, 2.0, 3.0), 0.1),
    lambda: filters.gabor(X, 5, 2.0, 0.3, 4.0),
    lambda: filters.gabor(X, 5, 2.0, ANGLES, 4.0),
    lambda: filters.gaussian(5, ANGLES, 1.0),
    lambda: filters.get_motion_kernel3d(5, V[:, 0, 0, 0, :3], 0.1),
    lambda: filters.unsharp_mask(X, 3, (1.0, 1.0)),
    lambda: filters.gaussian_blur2d(X, 3, (1.0, 1.0), separable=False),
    lambda: filters.edge_aware_blur_pool2d(X, 3),
    lambda: filters.in_range(X, [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]),
    lambda: filters.adaptive_threshold(X, 1.0, "gaussian"),
    lambda: filters.otsu_threshold(X)[0],
    lambda: filters.otsu_threshold(X, slow_and_differentiable=True)[1],
    lambda: filters.blur_pool2d(X, 3),
])  # fmt: skip
def test_device_is_kept_beside_numbers(call: object) -> None:
    # The meta device computes nothing, but rejects tensors on the CPU.
    assert call().device.type == "meta"
