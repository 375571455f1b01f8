"""One table of calls for the tests that hold for every op: scripting, target forms, gradients, dtypes.

Each case is a plain function with the static arguments fixed, as an exported op has, and a maker of its
inputs.
"""

from dataclasses import dataclass
from typing import Callable, Tuple

import torch
from photos import frame, photo
from torch import Tensor

import chiasm.color as color
import chiasm.enhance as enhance
import chiasm.feature as feature
import chiasm.filters as filters
import chiasm.geometry.conversions as conversions
import chiasm.geometry.homography as homography
import chiasm.geometry.subpix as subpix
import chiasm.geometry.transform as transform
import chiasm.losses as losses
import chiasm.metrics as metrics
import chiasm.morphology as morphology
import chiasm.pipelines as pipelines


@dataclass(frozen=True)
class Case:
    function: Callable
    make: Callable[[int, int, int, int, torch.dtype], Tuple[Tensor, ...]]
    differentiable: Tuple[int, ...] = (0,)
    channels: Tuple[int, ...] = (1, 3, 5)
    pure_image: bool = True  # values in half precision may be compared with float32

    @property
    def name(self) -> str:
        return self.function.__name__


def image(b: int, c: int, h: int, w: int, dtype: torch.dtype) -> Tuple[Tensor, ...]:
    return (photo(b, c, h, w, dtype),)


def with_sigma(b: int, c: int, h: int, w: int, dtype: torch.dtype) -> Tuple[Tensor, ...]:
    sigma = torch.stack(
        [0.6 + 0.3 * torch.arange(b, dtype=dtype), 1.4 - 0.2 * torch.arange(b, dtype=dtype)], 1
    )
    return photo(b, c, h, w, dtype), sigma


def with_two_sigmas(b: int, c: int, h: int, w: int, dtype: torch.dtype) -> Tuple[Tensor, ...]:
    x, space = with_sigma(b, c, h, w, dtype)
    return x, 0.2 + 0.1 * torch.arange(b, dtype=dtype), space


def with_moments(b: int, c: int, h: int, w: int, dtype: torch.dtype) -> Tuple[Tensor, ...]:
    return (
        photo(b, c, h, w, dtype),
        torch.linspace(0.3, 0.6, c, dtype=dtype),
        torch.linspace(0.2, 0.4, c, dtype=dtype),
    )


def with_weights(b: int, c: int, h: int, w: int, dtype: torch.dtype) -> Tuple[Tensor, ...]:
    return photo(b, c, h, w, dtype), torch.tensor([0.2, 0.5, 0.3], dtype=dtype)


def with_element(b: int, c: int, h: int, w: int, dtype: torch.dtype) -> Tuple[Tensor, ...]:
    kernel = torch.tensor([[0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 1.0]], dtype=dtype)
    return photo(b, c, h, w, dtype), kernel, torch.arange(9, dtype=dtype).reshape(3, 3) * 0.013


def with_homography(b: int, c: int, h: int, w: int, dtype: torch.dtype) -> Tuple[Tensor, ...]:
    # No pixel comes from within 1e-4 of a whole position, where bilinear reading has a kink.
    m = torch.tensor([[1.1, 0.13, -1.33], [-0.08, 0.93, 0.7], [1.1e-3, -7e-4, 1.0]], dtype=dtype)
    return photo(b, c, h, w, dtype), torch.stack([m + 0.01 * k for k in range(b)])


def with_shifted_homography(b: int, c: int, h: int, w: int, dtype: torch.dtype) -> Tuple[Tensor, ...]:
    """Of the others one position is on a pixel's centre, where a mirrored image has no derivative."""
    x, m = with_homography(b, c, h, w, dtype)
    return x, m + torch.tensor([[0.0, 0.0, 0.05], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]], dtype=dtype)


def with_fill(b: int, c: int, h: int, w: int, dtype: torch.dtype) -> Tuple[Tensor, ...]:
    return (*with_homography(b, c, h, w, dtype), torch.linspace(0.1, 0.9, c, dtype=dtype))


def two_images(b: int, c: int, h: int, w: int, dtype: torch.dtype) -> Tuple[Tensor, ...]:
    x = photo(b, c, h, w, dtype)
    return x, (0.8 * x + 0.1 + 0.1 * torch.sin(torch.arange(w, dtype=dtype)))


def correspondences(b: int, c: int, h: int, w: int, dtype: torch.dtype) -> Tuple[Tensor, ...]:
    generator = torch.Generator().manual_seed(b * 100 + h)
    p = torch.rand(b, 4 + h % 5, 2, generator=generator, dtype=dtype) * 100.0
    noise = torch.rand(p.shape, generator=generator, dtype=dtype) * 0.2
    q = torch.stack([p[..., 0] * 1.1 + p[..., 1] * 0.2 + 3.0, p[..., 1] * 0.9 - 5.0], -1)
    q = q / (1.0 + 1e-3 * p[..., 0:1]) + noise
    return p, q, 0.5 + torch.rand(p.shape[:2], generator=generator, dtype=dtype)


def rotation_vectors(b: int, c: int, h: int, w: int, dtype: torch.dtype) -> Tuple[Tensor, ...]:
    generator = torch.Generator().manual_seed(h)
    return (torch.randn(b, c, 3, generator=generator, dtype=dtype),)


def quaternions(b: int, c: int, h: int, w: int, dtype: torch.dtype) -> Tuple[Tensor, ...]:
    generator = torch.Generator().manual_seed(h)
    q = torch.randn(b, c, 4, generator=generator, dtype=dtype)
    return (q / q.norm(dim=-1, keepdim=True),)


def rotations(b: int, c: int, h: int, w: int, dtype: torch.dtype) -> Tuple[Tensor, ...]:
    return (torch.linalg.matrix_exp(_skew(rotation_vectors(b, c, h, w, dtype)[0])),)


def _skew(v: Tensor) -> Tensor:
    x, y, z = v.unbind(-1)
    o = torch.zeros_like(x)
    return torch.stack([o, -z, y, z, o, -x, -y, x, o], -1).reshape(*v.shape[:-1], 3, 3)


def camera_frame(b: int, c: int, h: int, w: int, dtype: torch.dtype) -> Tuple[Tensor, ...]:
    return (frame(h, w),)


def gray(image: Tensor) -> Tensor:
    return color.rgb_to_grayscale(image)


def gray_weights(image: Tensor, weights: Tensor) -> Tensor:
    return color.rgb_to_grayscale(image, weights)


def hsv(image: Tensor) -> Tensor:
    return color.rgb_to_hsv(image)


def bgr(image: Tensor) -> Tensor:
    return color.bgr_to_rgb(image)


def standardise(data: Tensor, mean: Tensor, std: Tensor) -> Tensor:
    return enhance.normalize(data, mean, std)


def gaussian(input: Tensor) -> Tensor:
    return filters.gaussian_blur2d(input, (5, 3), (1.0, 0.7))


def gaussian_reflect(input: Tensor, sigma: Tensor) -> Tensor:
    return filters.gaussian_blur2d(input, (3, 5), sigma, "reflect")


def gaussian_replicate(input: Tensor, sigma: Tensor) -> Tensor:
    return filters.gaussian_blur2d(input, 5, sigma, "replicate")


def gaussian_circular(input: Tensor) -> Tensor:
    return filters.gaussian_blur2d(input, 5, (1.2, 0.8), "circular")


def gaussian_constant(input: Tensor) -> Tensor:
    return filters.gaussian_blur2d(input, 5, (1.2, 0.8), "constant")


def gaussian_one_pass(input: Tensor, sigma: Tensor) -> Tensor:
    return filters.gaussian_blur2d(input, (3, 5), sigma, "constant", False)


def sobel(input: Tensor) -> Tensor:
    return filters.sobel(input)


def gradient_sobel(input: Tensor) -> Tensor:
    return filters.spatial_gradient(input)


def gradient_diff(input: Tensor) -> Tensor:
    return filters.spatial_gradient(input, "diff", 1, False)


def gradient_sobel_2(input: Tensor) -> Tensor:
    return filters.spatial_gradient(input, "sobel", 2)


def gradient_diff_2(input: Tensor) -> Tensor:
    return filters.spatial_gradient(input, "diff", 2)


def median_3(input: Tensor) -> Tensor:
    return filters.median_blur(input, 3)


def median_5(input: Tensor) -> Tensor:
    return filters.median_blur(input, (5, 5), "replicate")


def median_3x5(input: Tensor) -> Tensor:
    return filters.median_blur(input, (3, 5), "constant")


def bilateral(input: Tensor) -> Tensor:
    return filters.bilateral_blur(input, (5, 5), 0.1, (1.5, 1.5))


def bilateral_l2(input: Tensor, sigma_color: Tensor, sigma_space: Tensor) -> Tensor:
    return filters.bilateral_blur(input, (3, 5), sigma_color, sigma_space, "replicate", "l2")


def dilate_flat(tensor: Tensor, kernel: Tensor, heights: Tensor) -> Tensor:
    return morphology.dilation(tensor, kernel)


def dilate(tensor: Tensor, kernel: Tensor, heights: Tensor) -> Tensor:
    return morphology.dilation(tensor, kernel, heights, border_type="reflect")


def dilate_off_centre(tensor: Tensor, kernel: Tensor, heights: Tensor) -> Tensor:
    return morphology.dilation(tensor, kernel[:2], heights[:2], [0, 2], "constant", 0.25)


def resize_bilinear(input: Tensor) -> Tensor:
    return transform.resize(input, (13, 30))


def resize_bicubic(input: Tensor) -> Tensor:
    return transform.resize(input, (30, 13), "bicubic")


def resize_nearest(input: Tensor) -> Tensor:
    return transform.resize(input, (13, 30), "nearest")


def resize_corners(input: Tensor) -> Tensor:
    return transform.resize(input, (30, 7), "bilinear", True)


def resize_antialias(input: Tensor) -> Tensor:
    return transform.resize(input, (5, 30), antialias=True)


def resize_antialias_bicubic(input: Tensor) -> Tensor:
    return transform.resize(input, (5, 6), "bicubic", antialias=True)


def resize_like(input: Tensor) -> Tensor:
    like = input[..., 3:, ::2]
    return transform.resize(input, (like.shape[-2], like.shape[-1]))


def resize_short(input: Tensor) -> Tensor:
    return transform.resize(input, 8)


def warp_zeros(src: Tensor, M: Tensor) -> Tensor:
    return transform.warp_perspective(src, M, (15, 18))


def warp_border(src: Tensor, M: Tensor) -> Tensor:
    return transform.warp_perspective(src, M, (src.shape[-2], src.shape[-1]), "bilinear", "border")


def warp_reflection(src: Tensor, M: Tensor) -> Tensor:
    return transform.warp_perspective(src, M, (15, 18), "bilinear", "reflection", False)


def warp_fill(src: Tensor, M: Tensor, fill: Tensor) -> Tensor:
    return transform.warp_perspective(src, M, (15, 18), "bilinear", "fill", True, fill)


def warp_nearest(src: Tensor, M: Tensor) -> Tensor:
    return transform.warp_perspective(src, M, (15, 18), "nearest")


def find_homography(points1: Tensor, points2: Tensor, weights: Tensor) -> Tensor:
    return homography.find_homography_dlt(points1, points2, weights)


def nms(input: Tensor) -> Tensor:
    return subpix.nms2d(input, 5)


def nms_mask(input: Tensor) -> Tensor:
    return subpix.nms2d(input, (3, 5), True)


def harris(input: Tensor) -> Tensor:
    return feature.harris_response(input)


def harris_keypoints(input: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    return feature.harris_keypoints(input, 12)


def ssim(img1: Tensor, img2: Tensor) -> Tensor:
    return metrics.ssim(img1, img2, 5)


def ssim_loss(img1: Tensor, img2: Tensor) -> Tensor:
    return losses.ssim_loss(img1, img2, 7)


def ssim_loss_valid(img1: Tensor, img2: Tensor) -> Tensor:
    return losses.ssim_loss(img1, img2, 5, reduction="none", padding="valid")


def preprocess(frame: Tensor) -> Tensor:
    return pipelines.preprocess(frame)


def edges(frame: Tensor) -> Tensor:
    return pipelines.edges(frame)


CASES = [
    Case(gray, image, channels=(3,)),
    Case(gray_weights, with_weights, (0, 1), (3,)),
    Case(hsv, image, channels=(3,)),
    Case(bgr, image, channels=(3,)),
    Case(standardise, with_moments, (0, 1, 2)),
    Case(gaussian, image),
    Case(gaussian_reflect, with_sigma, (0, 1)),
    Case(gaussian_replicate, with_sigma, (0, 1)),
    Case(gaussian_circular, image),
    Case(gaussian_constant, image),
    Case(gaussian_one_pass, with_sigma, (0, 1)),
    Case(sobel, image),
    Case(gradient_sobel, image),
    Case(gradient_diff, image),
    Case(gradient_sobel_2, image),
    Case(gradient_diff_2, image),
    Case(median_3, image),
    Case(median_5, image),
    Case(median_3x5, image),
    Case(bilateral, image),
    Case(bilateral_l2, with_two_sigmas, (0, 1, 2)),
    Case(dilate_flat, with_element),
    Case(dilate, with_element, (0, 2)),
    Case(dilate_off_centre, with_element, (0, 2)),
    Case(resize_bilinear, image),
    Case(resize_bicubic, image),
    Case(resize_nearest, image),
    Case(resize_corners, image),
    Case(resize_antialias, image),
    Case(resize_antialias_bicubic, image),
    Case(resize_like, image),
    Case(resize_short, image),
    Case(warp_zeros, with_homography, (0, 1)),
    Case(warp_border, with_homography, (0, 1)),
    Case(warp_reflection, with_shifted_homography, (0, 1)),
    Case(warp_fill, with_fill, (0, 1, 2)),
    Case(warp_nearest, with_homography),
    Case(find_homography, correspondences, (0, 1, 2), (1,), False),
    Case(conversions.axis_angle_to_quaternion, rotation_vectors, pure_image=False),
    Case(conversions.axis_angle_to_rotation_matrix, rotation_vectors, pure_image=False),
    Case(conversions.quaternion_to_axis_angle, quaternions, pure_image=False),
    Case(conversions.quaternion_to_rotation_matrix, quaternions, pure_image=False),
    Case(conversions.normalize_quaternion, quaternions, pure_image=False),
    Case(conversions.rotation_matrix_to_quaternion, rotations, pure_image=False),
    Case(conversions.rotation_matrix_to_axis_angle, rotations, pure_image=False),
    Case(nms, image),
    Case(nms_mask, image, (), pure_image=False),
    Case(harris, image),
    Case(harris_keypoints, image, (0,), (1,), False),
    Case(ssim, two_images, (0, 1)),
    Case(ssim_loss, two_images, (0, 1)),
    Case(ssim_loss_valid, two_images, (0, 1)),
    Case(preprocess, camera_frame, (), (3,), False),
    Case(edges, camera_frame, (), (3,), False),
]
