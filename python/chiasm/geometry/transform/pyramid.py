"""Gaussian and Laplacian pyramids.

P. Burt, E. Adelson, The Laplacian Pyramid as a Compact Image Code, IEEE Trans. Communications 31(4), 1983.
"""

from typing import List

from torch import Tensor

from ...primitives.core.checks import check_image
from ...primitives.core.window_sizes import as_ratio
from ...primitives.filters.padding import check_border
from ...primitives.resampling.resizing import blurred_and_resized, resized_and_blurred


def pyrdown(
    input: Tensor, border_type: str = "reflect", align_corners: bool = False, factor: float = 2.0
) -> Tensor:
    """Blur with the binomial kernel (1, 4, 6, 4, 1) / 16 along both axes, then shrink.

    Shrinking is bilinear, as in Kornia: half of an even size takes the mean of two by two blurred pixels.
    ``cv2.pyrDown`` takes every other blurred pixel instead, which differs by half a pixel, and rounds odd
    sizes up.

    Args:
        input: (B, C, H, W), floating point.
        border_type: "reflect" (edge pixel not repeated), "replicate", "circular" or "constant" (zeros).
        align_corners: as in :func:`resize`.
        factor: by how much to shrink.

    Returns:
        (B, C, floor(H / factor), floor(W / factor)).

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D, factor is not positive, no pixel is left, or the border is not as
            above.

    Example:
        >>> pyrdown(torch.ones(1, 1, 8, 9))[0, 0, 0]
        tensor([1., 1., 1., 1.])
    """
    check_image(input, "input")
    check_border(border_type)
    if factor <= 0.0:
        raise ValueError(f"factor: expected a positive number, got {factor}")
    over, under = as_ratio(factor)
    size = (input.size(2) * under // over, input.size(3) * under // over)
    if size[0] < 1 or size[1] < 1:
        raise ValueError(f"size: expected positive sizes, got ({size[0]}, {size[1]})")
    return blurred_and_resized(input, size[0], size[1], align_corners, _binomial(), border_type)


def pyrup(input: Tensor, border_type: str = "reflect", align_corners: bool = False) -> Tensor:
    """Enlarge to twice the size, then blur with the binomial kernel (1, 4, 6, 4, 1) / 16 along both axes.

    Enlarging is bilinear, as in Kornia. ``cv2.pyrUp`` puts zeros between the pixels and blurs with four times
    the kernel.

    Args:
        input: (B, C, H, W), floating point.
        border_type: "reflect" (edge pixel not repeated), "replicate", "circular" or "constant" (zeros).
        align_corners: as in :func:`resize`.

    Returns:
        (B, C, 2 H, 2 W).

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D or the border is not as above.

    Example:
        >>> pyrup(torch.ones(1, 1, 4, 5)).shape
        torch.Size([1, 1, 8, 10])
    """
    check_image(input, "input")
    check_border(border_type)
    return resized_and_blurred(
        input, 2 * input.size(2), 2 * input.size(3), align_corners, _binomial(), border_type
    )


def build_pyramid(
    input: Tensor, max_level: int, border_type: str = "reflect", align_corners: bool = False
) -> List[Tensor]:
    """Gaussian pyramid: the image, and what ``pyrdown`` makes of it again and again.

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
        >>> [list(level.shape[2:]) for level in build_pyramid(torch.ones(1, 3, 24, 32), 3)]
        [[24, 32], [12, 16], [6, 8]]
    """
    check_image(input, "input")
    check_border(border_type)
    if max_level < 1:
        raise ValueError(f"max_level: expected a positive number, got {max_level}")
    levels = [input.clone()]  # ONNX has one name for a value, and the image's is its own
    for i in range(max_level - 1):
        levels.append(pyrdown(levels[i], border_type, align_corners))
    return levels


def build_laplacian_pyramid(
    input: Tensor, max_level: int, border_type: str = "reflect", align_corners: bool = False
) -> List[Tensor]:
    """Laplacian pyramid: what each level of the Gaussian pyramid has over the next one, enlarged; the last as
    it is.

    A level is enlarged to the size of the one before it and then blurred, so that the image comes back
    exactly from the last level by enlarging, blurring and adding, whatever its size. (Kornia's pads the image
    to powers of two instead, and agrees where the sizes are powers of two.)

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


def _binomial() -> List[float]:
    return [0.0625, 0.25, 0.375, 0.25, 0.0625]
