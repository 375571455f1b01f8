"""Gaussian and Laplacian pyramids.

P. Burt, E. Adelson, The Laplacian Pyramid as a Compact Image Code, IEEE Trans. Communications 31(4), 1983.
"""

import math
from typing import List, Tuple

import torch
from torch import Tensor

from ...filters.gaussian import gaussian_blur2d
from ...primitives.core.checks import check_choice, check_image, check_pixels
from ...primitives.core.modules import Module
from ...primitives.core.window_sizes import as_ratio
from ...primitives.filters.padding import check_border
from ...primitives.resampling.pyramids import blurred_and_thinned, spread_and_blurred
from ...primitives.resampling.resizing import blurred_and_resized, resized_and_blurred
from .resize import resize


def pyrdown(
    input: Tensor,
    border_type: str = "reflect",
    align_corners: bool = False,
    factor: float = 2.0,
    sampling: str = "bilinear",
) -> Tensor:
    """Blur with the binomial kernel (1, 4, 6, 4, 1) / 16 along both axes, then downsample. With sampling
    "bilinear", as in Kornia, an even size is halved by the mean of 2 x 2 blurred pixels. With "alternate",
    every other blurred pixel is kept, beginning with the first, which is a shift by half a pixel: this is
    ``cv2.pyrDown``, identical for uint8, which is rounded (halves up).

    Args:
        input: (B, C, H, W), floating point, or with sampling "alternate" also uint8.
        border_type: "reflect" (border pixel not repeated), "replicate", "circular" or "constant" (zeros).
        align_corners: as in :func:`resize`; not used with sampling "alternate".
        factor: the downsampling factor, 2 with sampling "alternate".
        sampling: "bilinear", or "alternate" for every other pixel.

    Returns:
        (B, C, floor(H / factor), floor(W / factor)); with sampling "alternate" (B, C, ceil(H / 2), ceil(W /
        2)).

    Raises:
        TypeError: if input is not of a type as above.
        ValueError: if input is not 4-D, factor is not positive, no pixel is left, or the border or the
            sampling is not as above.

    Example:
        >>> pyrdown(torch.ones(1, 1, 8, 9))[0, 0, 0]
        tensor([1., 1., 1., 1.])
        >>> pyrdown(torch.arange(0, 90, 10, dtype=torch.uint8).expand(1, 1, 9, 9), sampling="alternate")[
        ...     0, 0, 0
        ... ]
        tensor([ 8, 20, 40, 60, 73], dtype=torch.uint8)
    """
    check_border(border_type)
    _check_sampled(input, sampling)
    if sampling == "alternate":
        if factor != 2.0:
            raise ValueError(f"factor: expected 2 with sampling 'alternate', got {factor}")
        return blurred_and_thinned(input, border_type)
    if not factor > 0.0:
        raise ValueError(f"factor: expected a positive number, got {factor}")
    over, under = as_ratio(factor)
    if over < 1:
        raise ValueError(f"factor: expected at least 1 / 65536, got {factor}")
    size = (input.size(2) * under // over, input.size(3) * under // over)
    if size[0] < 1 or size[1] < 1:
        least = (over + under - 1) // under
        raise ValueError(
            f"input: expected at least {least} x {least} pixels for a factor of {factor}, got"
            f" {list(input.shape)}"
        )
    return blurred_and_resized(input, size[0], size[1], align_corners, _binomial(), border_type)


def pyrup(
    input: Tensor,
    border_type: str = "reflect",
    align_corners: bool = False,
    sampling: str = "bilinear",
) -> Tensor:
    """Upsample to twice the size, then blur with the binomial kernel (1, 4, 6, 4, 1) / 16 along both axes.
    Sampling "bilinear" is as in Kornia. "alternate" inserts a zero after each pixel and blurs with four times
    the kernel: this is ``cv2.pyrUp``, identical for uint8, which is rounded (halves up).

    Args:
        input: (B, C, H, W), floating point, or with sampling "alternate" also uint8.
        border_type: "reflect" (border pixel not repeated), "replicate", "circular" or "constant" (zeros);
            with sampling "alternate" only "reflect", of the enlarged image.
        align_corners: as in :func:`resize`; not used with sampling "alternate".
        sampling: "bilinear", or "alternate" for zeros between the pixels.

    Returns:
        (B, C, 2 H, 2 W).

    Raises:
        TypeError: if input is not of a type as above.
        ValueError: if input is not 4-D or the border or the sampling is not as above.

    Example:
        >>> pyrup(torch.ones(1, 1, 4, 5)).shape
        torch.Size([1, 1, 8, 10])
        >>> pyrup(torch.tensor([[[[8, 16]]]], dtype=torch.uint8), sampling="alternate")[0, 0, 0]
        tensor([10, 12, 15, 16], dtype=torch.uint8)
    """
    check_border(border_type)
    _check_sampled(input, sampling)
    if sampling == "alternate":
        if border_type != "reflect":
            raise ValueError(
                f"border_type: expected 'reflect' with sampling 'alternate', got '{border_type}'"
            )
        return spread_and_blurred(input)
    return resized_and_blurred(
        input, 2 * input.size(2), 2 * input.size(3), align_corners, _binomial(), border_type
    )


def _check_sampled(input: Tensor, sampling: str) -> None:
    """Raise unless ``sampling`` is known, and ``input`` is an image that it takes."""
    check_choice(sampling, ["bilinear", "alternate"], "sampling")
    if sampling == "alternate":
        check_pixels(input, "input")
    else:
        check_image(input, "input")


def build_pyramid(
    input: Tensor,
    max_level: int,
    border_type: str = "reflect",
    align_corners: bool = False,
    sampling: str = "bilinear",
) -> List[Tensor]:
    """Gaussian pyramid: the image, and the results of repeated ``pyrdown``. With sampling "alternate" it is
    OpenCV's ``buildPyramid``, identical for uint8.

    Args:
        input: (B, C, H, W), floating point, or with sampling "alternate" also uint8.
        max_level: number of images.
        border_type, align_corners, sampling: as in :func:`pyrdown`.

    Returns:
        max_level images (B, C, H, W), (B, C, H // 2, W // 2), ...; with sampling "alternate", halves are
        rounded up.

    Raises:
        TypeError: if input is not of a type as above.
        ValueError: if input is not 4-D, max_level is not positive, the border or the sampling is not as
            above, or the image is too small.

    Example:
        >>> [list(level.shape[2:]) for level in build_pyramid(torch.ones(1, 3, 24, 32), 3)]
        [[24, 32], [12, 16], [6, 8]]
    """
    _check_sampled(input, sampling)
    check_border(border_type)
    if max_level < 1:
        raise ValueError(f"max_level: expected a positive number, got {max_level}")
    levels = [input.clone()]  # a clone, since ONNX has one name for a value and the input already has its own
    for i in range(max_level - 1):
        levels.append(pyrdown(levels[i], border_type, align_corners, 2.0, sampling))
    return levels


def build_laplacian_pyramid(
    input: Tensor, max_level: int, border_type: str = "reflect", align_corners: bool = False
) -> List[Tensor]:
    """Laplacian pyramid: the difference of each Gaussian level and the upsampled next one; the last level as
    it is. A level is upsampled to the size of the level before and then blurred, so that upsampling, blurring
    and adding from the last level reconstructs the image exactly, whatever its size. (Kornia pads the image
    to powers of two instead, and agrees if the sizes are powers of two.)

    Args:
        input: (B, C, H, W), floating point.
        max_level: number of images.
        border_type, align_corners: as in :func:`pyrdown`.

    Returns:
        max_level images (B, C, H, W), (B, C, H // 2, W // 2), ...

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D, max_level is not positive, the border is not as above or the image is
            too small.

    Example:
        >>> [list(level.shape[2:]) for level in build_laplacian_pyramid(torch.ones(1, 3, 25, 32), 3)]
        [[25, 32], [12, 16], [6, 8]]
    """
    levels = build_pyramid(input, max_level, border_type, align_corners)
    out: List[Tensor] = []
    for i in range(max_level - 1):
        enlarged = resized_and_blurred(
            levels[i + 1], levels[i].size(2), levels[i].size(3), align_corners, _binomial(), border_type
        )
        out.append(levels[i] - enlarged)
    out.append(levels[max_level - 1])
    return out


class ScalePyramid(Module):
    """The scale space of images in octaves, for detectors of features: each octave has half the size of the
    one before, and ``n_levels + extra_levels`` images of increasing blur.

    D. Lowe, Distinctive image features from scale-invariant keypoints, IJCV 60, 2004, section 3.

    Args:
        n_levels: images from one octave to the next, whose blur is twice as large.
        init_sigma: blur of the first image of each octave, in its pixels; images are taken to have 0.5
            (1 if they are doubled) and are not blurred to less.
        min_size: octaves have a shorter side of more than this, but for the first.
        double_image: True begins with the image at twice its size.
        extra_levels: further images of each octave, for what compares neighbours.

    Shape:
        (B, C, H, W), floating point, to three lists with an entry for each octave: images (B, C, L, h, w),
        and their blur in pixels of the octave and the size of such a pixel in pixels of the image, both (B,
        L).

    Raises:
        TypeError, ValueError: if the image is not as above or a number is not positive.

    Example:
        >>> levels, sigmas, sizes = ScalePyramid(3, 1.6, 15)(torch.rand(1, 1, 40, 64))
        >>> [list(octave.shape) for octave in levels], [s[0, 0].item() for s in sizes]
        ([[1, 1, 6, 40, 64], [1, 1, 6, 20, 32]], [1.0, 2.0])
    """

    def __init__(
        self,
        n_levels: int = 3,
        init_sigma: float = 1.6,
        min_size: int = 15,
        double_image: bool = False,
        extra_levels: int = 3,
    ) -> None:
        super().__init__()
        if n_levels < 1 or min_size < 1 or extra_levels < 1:
            raise ValueError(
                f"n_levels, min_size, extra_levels: expected positive numbers, got {n_levels}, {min_size} and"
                f" {extra_levels}"
            )
        self.n_levels, self.init_sigma, self.min_size = n_levels, init_sigma, min_size
        self.double_image, self.extra_levels = double_image, extra_levels

    def forward(self, x: Tensor) -> Tuple[List[Tensor], List[Tensor], List[Tensor]]:
        check_image(x, "x")
        count, pixel, has = self.n_levels + self.extra_levels, 1.0, 0.5
        if self.double_image:
            x, pixel, has = resize(x, (2 * x.size(2), 2 * x.size(3)), align_corners=True), 0.5, 1.0
        first = max(self.init_sigma, has)
        if self.init_sigma > has:
            x = _blurred(x, math.sqrt(self.init_sigma * self.init_sigma - has * has))
        blurs = [first * 2.0 ** (k / self.n_levels) for k in range(count)]
        pyramid: List[Tensor] = []
        sigmas: List[Tensor] = []
        sizes: List[Tensor] = []
        while True:
            levels = [x]
            for k in range(1, count):
                more = math.sqrt(blurs[k] * blurs[k] - blurs[k - 1] * blurs[k - 1])
                levels.append(_blurred(levels[k - 1], more))
            pyramid.append(torch.stack(levels, 2))
            sigmas.append(torch.tensor(blurs, dtype=x.dtype, device=x.device).expand(x.size(0), -1))
            sizes.append(torch.full_like(sigmas[-1], pixel))
            height, width = x.size(2) // 2, x.size(3) // 2
            if min(height, width) <= self.min_size:
                break
            x, pixel = resize(levels[self.n_levels], (height, width), align_corners=True), 2.0 * pixel
        return pyramid, sigmas, sizes


def _blurred(x: Tensor, sigma: float) -> Tensor:
    """Gaussian blur to four sigma, or to what a small image has."""
    least = min(x.size(2), x.size(3))
    size = min(2 * int(4.0 * sigma + 0.5) + 1, least - 1 + least % 2)
    return gaussian_blur2d(x, size, (sigma, sigma))


def _binomial() -> List[float]:
    return [0.0625, 0.25, 0.375, 0.25, 0.0625]
