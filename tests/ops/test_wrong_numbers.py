"""Invalid numbers are rejected with the argument's name: standard deviations of 0, negative factors, sizes of
three."""

from collections.abc import Callable

import pytest
import torch

from chiasm import enhance, filters
from chiasm.geometry import transform

X = torch.rand(1, 3, 9, 9)
BOX = torch.tensor([[[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]]])
EYE = torch.eye(3)[None]


@pytest.mark.parametrize("sigma", [(0.0, 1.0), (1.0, -2.0)])
@pytest.mark.parametrize(
    "blur",
    [
        lambda s: filters.gaussian_blur2d(X, 3, s),
        lambda s: filters.gaussian_blur2d(X, 3, s, separable=False),
        lambda s: filters.gaussian_blur2d((X * 255).to(torch.uint8), 3, s),
        lambda s: filters.unsharp_mask(X, 3, s),
        lambda s: filters.canny(X, sigma=s),
        lambda s: filters.get_gaussian_kernel2d(3, s),
    ],
)
def test_deviations_are_positive(blur: Callable, sigma: tuple[float, float]) -> None:
    with pytest.raises(ValueError, match=r"sigma: expected positive numbers, got"):
        blur(sigma)


@pytest.mark.parametrize(
    "kernel",
    [
        filters.get_gaussian_kernel1d,
        filters.get_gaussian_erf_kernel1d,
        filters.get_gaussian_discrete_kernel1d,
        filters.gaussian,
    ],
)
def test_one_deviation_is_positive(kernel: Callable) -> None:
    for sigma in (0.0, -1.0):
        with pytest.raises(ValueError, match=f"sigma: expected a positive number, got {sigma}"):
            kernel(3, sigma)


def test_factors_are_not_negative() -> None:
    with pytest.raises(ValueError, match=r"factor: expected a number that is not negative, got -0.5"):
        enhance.adjust_contrast(X, -0.5)
    with pytest.raises(ValueError, match=r"gamma: expected a number that is not negative, got -1"):
        enhance.adjust_gamma(X, -1.0)
    with pytest.raises(ValueError, match=r"gain: expected a number that is not negative, got -1"):
        enhance.adjust_gamma(X, 1.0, -1.0)
    with pytest.raises(TypeError, match=r"factor: expected a number or a tensor, got list"):
        enhance.adjust_contrast(X, [0.5])


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("size", lambda n: transform.crop_and_resize(X, BOX, n)),
        ("size", lambda n: transform.center_crop(X, n)),
        ("out_size", lambda n: transform.crop_by_transform_mat(X, EYE, n)),
        ("dsize", lambda n: transform.warp_affine(X, EYE[:, :2], n)),
        ("dsize", lambda n: transform.warp_perspective(X, EYE, n)),
        ("dsize", lambda n: transform.homography_warp(X, EYE, n)),
        ("dsize", lambda n: transform.warp_polar(X, n)),
        ("kernel_size", lambda n: filters.median_blur(X, n)),
    ],
)
def test_sizes_are_two(name: str, call: Callable) -> None:
    with pytest.raises(ValueError, match=f"{name}: expected 2 numbers, got 3"):
        call((3, 3, 3))
    call([3, 3])
