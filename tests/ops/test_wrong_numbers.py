"""Invalid numbers are rejected with the argument's name: standard deviations of 0, negative factors, sizes of
three."""

from collections.abc import Callable

import pytest
import torch

from chiasm import color, contrib, enhance, feature, filters, geometry, metrics, pipelines
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


VOLUME = torch.rand(1, 1, 4, 5, 6)
EYE_3D = torch.eye(4)[None]
CUBE = torch.rand(1, 8, 3)


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("size", lambda n: pipelines.letterbox(FRAME, n[:2])),
        ("size", lambda n: pipelines.center_crop(FRAME, n[:2])),
        ("size", lambda n: pipelines.crop_boxes(FRAME[0], torch.zeros(1, 4), n[:2])),
        ("size", lambda n: transform.resize(X, n[:2])),
        ("dsize", lambda n: transform.warp_perspective(X, EYE, n[:2])),
        ("dsize", lambda n: transform.warp_affine3d(VOLUME, EYE_3D[:, :3], n)),
        ("dsize", lambda n: transform.warp_perspective3d(VOLUME, EYE_3D, n)),
        ("dsize", lambda n: transform.homography_warp3d(VOLUME, EYE_3D, n)),
        ("out_size", lambda n: transform.crop_by_transform_mat3d(VOLUME, EYE_3D, n)),
        ("size", lambda n: transform.center_crop3d(VOLUME, n)),
        ("size", lambda n: transform.crop_and_resize3d(VOLUME, CUBE, n)),
        ("size", lambda n: transform.crop_by_boxes3d(VOLUME, CUBE, CUBE, size=n)),
        ("kernel_size", lambda n: filters.box_blur(X, n[:2])),
        ("kernel_size", lambda n: filters.median_blur(X, n[:2])),
    ],
)
def test_sizes_are_whole(name: str, call: Callable) -> None:
    with pytest.raises(TypeError, match=rf"^{name}: expected whole numbers, got \(3\.0, 3"):
        call((3.0, 3, 3))


NAN = float("nan")
ONES = (1.0, 1.0, 1.0)
FRAME = torch.zeros(1, 8, 8, 3, dtype=torch.uint8)
BYTES = (X * 255).to(torch.uint8)
GREY = X[:, :1]
AS = (1.0, 1.0)


@pytest.mark.parametrize("sigma", [0.0, -1.0, NAN])
@pytest.mark.parametrize("image", [X, BYTES])
def test_deviations_of_colour_are_positive(image: torch.Tensor, sigma: float) -> None:
    with pytest.raises(ValueError, match=f"sigma_color: expected a positive number, got {sigma}"):
        filters.bilateral_blur(image, 3, sigma, AS)
    with pytest.raises(ValueError, match=f"sigma_color: expected a positive number, got {sigma}"):
        filters.joint_bilateral_blur(image, image, 3, sigma, AS)
    with pytest.raises(TypeError, match=r"sigma_color: expected a number or a tensor, got str"):
        filters.bilateral_blur(image, 3, "1", AS)


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("sigma", lambda: filters.gaussian_blur2d(X, 3, (NAN, NAN))),
        ("sigma", lambda: filters.gaussian_blur2d(BYTES, 3, (1.0, NAN))),
        ("sigma", lambda: filters.gaussian(3, NAN)),
        ("sigma", lambda: filters.get_gaussian_kernel1d(3, NAN)),
        ("sigma", lambda: filters.get_gaussian_kernel3d(3, (1.0, NAN, 1.0))),
        ("sigma_space", lambda: filters.bilateral_blur(X, 3, 1.0, (NAN, 1.0))),
        ("high_sigma", lambda: filters.difference_of_gaussians(X, NAN)),
        ("high_sigma", lambda: filters.difference_of_gaussians(X, 1.0, NAN)),
        ("h", lambda: filters.non_local_means(X, h=NAN)),
        ("percentile", lambda: filters.percentile_filter(X, NAN, 3)),
        ("edge_threshold", lambda: filters.edge_aware_blur_pool2d(X, 3, NAN)),
        ("low_threshold", lambda: filters.canny(X, NAN, 0.2)),
        ("low_threshold", lambda: filters.canny(X, 0.1, NAN)),
        ("max_value", lambda: filters.adaptive_threshold(BYTES, NAN)),
        ("factor", lambda: enhance.adjust_contrast(X, NAN)),
        ("gamma", lambda: enhance.adjust_gamma(X, NAN)),
        ("cutoff", lambda: enhance.autocontrast(X, (NAN, 1.0))),
        ("bandwidth", lambda: enhance.image_histogram2d(X, 0.0, 1.0, 4, NAN)),
        ("max", lambda: enhance.count_histogram(X, 4, 0.0, NAN)),
        ("alpha_val", lambda: color.rgb_to_rgba(BYTES, NAN)),
        ("h", lambda: contrib.distance_transform(GREY, h=NAN)),
        ("eps", lambda: metrics.mean_iou(torch.tensor([[1]]), torch.tensor([[1]]), 2, NAN)),
        ("max_val", lambda: metrics.psnr(X, X, NAN)),
        ("sigma1, sigma2", lambda: feature.dog_response_single(X, 1.0, NAN)),
        ("init_sigma", lambda: feature.detect_keypoints(GREY, 4, init_sigma=NAN)),
        ("temperature", lambda: geometry.subpix.spatial_softmax2d(X, NAN)),
        ("factor", lambda: transform.pyrdown(X, factor=NAN)),
        ("factor", lambda: transform.rescale(X, NAN)),
        ("std", lambda: pipelines.letterbox(FRAME, std=(NAN, 1.0, 1.0))),
        ("std", lambda: pipelines.preprocess(FRAME[0], std=(NAN, 1.0, 1.0))),
    ],
)
def test_not_a_number_is_no_setting(name: str, call: Callable) -> None:
    with pytest.raises(ValueError, match=rf"^{name}: expected .*got .*nan"):
        call()
