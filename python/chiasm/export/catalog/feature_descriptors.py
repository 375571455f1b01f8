"""Features: descriptors, orientation and shape of patches."""

from collections.abc import Sequence
from typing import Any

import torch
from torch import Generator, Tensor

from ..spec import Spec, TensorSpec, Tolerance, image
from . import add, rejected
from .feature_frames import frames

_PATCHES = TensorSpec("patches", ("N", 1, 16, 16), layout="NCHW", range=(0.0, 1.0), description="patches")
_DESCRIPTORS = TensorSpec("descriptors", description="unit vectors")
#: The derivative of the root of a histogram's entry is large near 0, and random patches have many gradients
#: near 0.
_ROOT = {"float32": Tolerance(5e-2, 5e-3)}


def _make_patches(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Patches that change more in one direction than in others, like those around key points."""
    grid = torch.arange(16, dtype=torch.float64)
    draw = torch.rand((sizes["N"], 3, 1, 1), generator=generator, dtype=torch.float64)
    wave = torch.sin(
        0.3 * (2 * draw[:, 0] - 1) * grid[:, None] + 0.3 * (2 * draw[:, 1] - 1) * grid + 6 * draw[:, 2]
    )
    noise = torch.rand((sizes["N"], 16, 16), generator=generator, dtype=torch.float64)
    return {"patches": (0.5 + 0.4 * wave + 0.1 * noise)[:, None].to(dtype)}


def _make_regions(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    img = torch.rand((sizes["B"], 1, sizes["H"], sizes["W"]), generator=generator, dtype=torch.float64)
    laf = frames(generator, sizes)
    return {"img": img.to(dtype), "lafs": laf.to(dtype), "laf": laf.to(dtype)}


def _add(
    name: str,
    inputs: Sequence[TensorSpec],
    output: TensorSpec,
    reference: str,
    fn: str | None = None,
    **rest: Any,
):
    add(
        Spec(f"feature.{name}", inputs, [output], reference=reference, **rest),
        fn=fn or f"feature.{name.partition('.')[0]}",
    )


_add(
    "sift_describe.root",
    [_PATCHES],
    _DESCRIPTORS,
    "a loop in NumPy; OpenCV SIFT",
    make_inputs=_make_patches,
    gradient_tolerances=_ROOT,
    picture="SIFT descriptors",
)
_add(
    "sift_describe.plain",
    [_PATCHES],
    _DESCRIPTORS,
    "a loop in NumPy; OpenCV SIFT",
    config={"rootsift": False},
    make_inputs=_make_patches,
    picture="SIFT descriptors",
)
_add(
    "dense_sift",
    [image("input", channels=1)],
    TensorSpec("descriptors", layout="NCHW", description="unit vectors"),
    "sift_describe's histograms in NumPy",
    config={"rootsift": False, "stride": 3, "spatial_bin_size": 3},
    also=({"padding": 2},),
    errors=rejected("padding", "a number >= 0", -1),
    symbols={"H": (16, 32768), "W": (16, 32768)},
    picture="dense descriptors",
)
_add(
    "mean_patch",
    [TensorSpec("patches", ("N", "C", 16, 16), layout="NCHW", range=(0.0, 1.0))],
    TensorSpec("descriptors", description="means"),
    "NumPy",
    picture="mean colours",
)
_add(
    "convert_sift_descriptor_layout",
    [TensorSpec("descriptors", ("N", 128), range=(0.0, 1.0))],
    TensorSpec("output", description="reordered"),
    "NumPy transposition",
    config={"source": "opencv", "target": "kornia"},
    picture="reordered descriptor",
)
_add(
    "dominant_orientation",
    [_PATCHES],
    TensorSpec("angles", description="radians"),
    "a loop in NumPy; turned patches",
    make_inputs=_make_patches,
    picture="orientations",
)
_add(
    "affine_shape",
    [_PATCHES],
    TensorSpec("ellipses", description="a, b, c"),
    "NumPy; stretched blobs",
    make_inputs=_make_patches,
    picture="ellipses of patches",
)


def _make_learned(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    projection = torch.randn((63, 32), generator=generator, dtype=torch.float64)
    mean = 0.1 * torch.rand(63, generator=generator, dtype=torch.float64)
    return {
        **_make_patches(generator, sizes, dtype),
        "whitening": projection.to(dtype),
        "mean": mean.to(dtype),
    }


_KERNELS: dict[str, Any] = {
    "picture": "rows of descriptors",
    "reference": "the kernel summed over pairs of pixels in NumPy",
    "gradient_tolerances": {"float32": Tolerance(5e-3, 1e-3)},
}
_add("mkd_describe.concat", [_PATCHES], _DESCRIPTORS, make_inputs=_make_patches, **_KERNELS)
_add(
    "mkd_describe.whitened",
    [
        _PATCHES,
        TensorSpec("whitening", (63, 32), description="a projection"),
        TensorSpec("mean", (63,), description="subtracted before it"),
    ],
    _DESCRIPTORS,
    config={"kernel_type": "cart", "power": 0.5},
    make_inputs=_make_learned,
    **_KERNELS,
)

_REGIONS = [
    image("img", channels=1, color="GRAY"),
    TensorSpec("laf", ("B", "N", 2, 3), description="local affine frames"),
]
_OUT = TensorSpec("output", description="local affine frames")
_LARGE: dict[str, Any] = {
    "symbols": {"H": (16, 32768), "W": (16, 32768)},
    "make_inputs": _make_regions,
    "config": {"PS": 16},
    "picture": "local affine frames",
}
_add("orient_laf", _REGIONS, _OUT, "its parts", tolerances={"float32": Tolerance(1e-3, 1e-4)}, **_LARGE)
_add(
    "adapt_laf_shape",
    _REGIONS,
    _OUT,
    "its parts; stretched blobs",
    tolerances={"float32": Tolerance(1e-3, 1e-4)},
    gradient_tolerances=_ROOT,
    **_LARGE,
)
_add(
    "get_laf_descriptors.sift",
    [_REGIONS[0], TensorSpec("lafs", ("B", "N", 2, 3), description="local affine frames")],
    _DESCRIPTORS,
    "its parts",
    fn="feature.described.sift_laf_descriptors",
    symbols={"H": (16, 32768), "W": (16, 32768)},
    make_inputs=_make_regions,
    config={"patch_size": 16, "rootsift": False},
    tolerances={"float32": Tolerance(1e-3, 1e-3)},
    gradient_tolerances=_ROOT,
    picture="SIFT descriptors",
)
