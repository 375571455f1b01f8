"""Anti-aliased pooling against SciPy and PyTorch's own convolution."""

import numpy as np
import pytest
import scipy.ndimage as ndi
import scipy.special
import torch
from borders import SHAPES, per_plane
from photos import photo

from chiasm.filters import blur_pool2d, edge_aware_blur_pool2d, max_blur_pool2d
from chiasm.primitives.core.target import exporting

X = torch.zeros(1, 3, 8, 9)


def binomial(size: int) -> np.ndarray:
    return scipy.special.comb(size - 1, np.arange(size)) / 2.0 ** (size - 1)


def pooled(p: np.ndarray, ky: int, kx: int, stride: int) -> np.ndarray:
    """The definition: a valid correlation of the zero-padded plane, thinned."""
    ry, rx = (ky - 1) // 2, (kx - 1) // 2
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(p, ((ry, ry), (rx, rx))), (ky, kx))
    return np.einsum("hwij,i,j->hw", windows, binomial(ky), binomial(kx))[::stride, ::stride]


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(("size", "stride"), [(3, 2), ((5, 3), 2), (4, 3), ((1, 2), 1), (7, 4)])
def test_blur_pool(shape: tuple[int, ...], size: int | tuple[int, int], stride: int) -> None:
    x = photo(*shape, torch.float64)
    ky, kx = (size, size) if isinstance(size, int) else size
    expected = per_plane(x, lambda p: pooled(p, ky, kx, stride))
    np.testing.assert_allclose(blur_pool2d(x, size, stride), expected, atol=1e-12)
    for target in ("onnx", "native", "vjp"):
        with exporting(target):
            np.testing.assert_allclose(blur_pool2d(x, size, stride), expected, atol=1e-12)


@pytest.mark.parametrize("pool", [1, 2, 3])
def test_max_blur_pool(pool: int) -> None:
    x = photo(2, 5, 19, 24, torch.float64)
    maxima = torch.nn.functional.max_pool2d(x, pool, 1)
    expected = per_plane(maxima, lambda p: pooled(p, 3, 3, 2))
    np.testing.assert_allclose(max_blur_pool2d(x, 3, 2, pool), expected, atol=1e-12)
    np.testing.assert_allclose(max_blur_pool2d(x, 3, 2, pool, ceil_mode=True), expected, atol=1e-12)


@pytest.mark.parametrize("channels", [1, 3, 7])
@pytest.mark.parametrize(("size", "dilation"), [((3, 3), 3), ((5, 3), 5), ((7, 7), 1)])
def test_edge_aware(channels: int, size: tuple[int, int], dilation: int) -> None:
    x = photo(2, channels, 40, 33, torch.float64)
    actual = edge_aware_blur_pool2d(x, size, 1.5, dilation, 1e-3)
    kernel = np.outer(binomial(size[0]), binomial(size[1]))
    shares = []
    for sample, result in zip(x.numpy(), actual.numpy(), strict=True):
        levels = np.log2(sample + 1e-3).mean(0)
        slopes = [
            np.abs(ndi.correlate1d(levels, [-1, 0, 0, 0, 1], axis=axis, mode="mirror")) for axis in (0, 1)
        ]
        edges = ndi.maximum_filter(np.maximum(*slopes) > np.log2(1.5), dilation, mode="constant")
        blurred = np.stack([ndi.correlate(p, kernel, mode="mirror") for p in sample])
        np.testing.assert_allclose(result, np.where(edges, sample, blurred), atol=1e-12)
        shares.append(edges.mean())
    assert min(shares) > 0.005 and max(shares) < 0.95  # both cases occurred


WRONG = [
    (lambda: blur_pool2d(X[0], 3), ValueError, "input: expected shape"),
    (lambda: blur_pool2d(X.int(), 3), TypeError, "input: expected a floating-point"),
    (lambda: blur_pool2d(X, 0), ValueError, r"kernel_size: expected positive sizes, got \(0, 0\)"),
    (lambda: blur_pool2d(X, 3, 0), ValueError, "stride: expected at least 1, got 0"),
    (lambda: blur_pool2d(X, 3, (2, 2)), TypeError, "stride: expected a number or a tensor, got tuple"),
    (lambda: max_blur_pool2d(X, 3, 2, 0), ValueError, "max_pool_size: expected at least 1, got 0"),
    (lambda: max_blur_pool2d(X.int(), 3), TypeError, "input: expected a floating-point"),
    (lambda: edge_aware_blur_pool2d(X, 4), ValueError, r"kernel_size: expected odd .* got \(4, 4\)"),
    (lambda: edge_aware_blur_pool2d(X, 3, 1.0), ValueError, "edge_threshold: expected more than 1, got 1.0"),
    (lambda: edge_aware_blur_pool2d(X, 3, 1.5, 2), ValueError, "edge_dilation_kernel_size: expected odd"),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG)
def test_wrong_arguments(call: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
