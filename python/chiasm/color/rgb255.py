"""Images in [0, 255], and surface normals as colours."""

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_rgb
from ..primitives.images.color_planes import rgb_planes
from ..primitives.numbers.rounding import known_or


def rgb_to_rgb255(image: Tensor) -> Tensor:
    """Convert an image in [0, 1] to uint8: 255 times the value, rounded (halves to even) and saturated. This
    is the conversion of OpenCV's ``convertTo`` with scale 255.

    Args:
        image: RGB image (*, 3, H, W) in [0, 1], floating point.

    Returns:
        (*, 3, H, W), uint8.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> rgb_to_rgb255(torch.tensor([0.0, 0.5, 2.0]).reshape(1, 3, 1, 1)).flatten()
        tensor([  0, 128, 255], dtype=torch.uint8)
    """
    check_rgb(image, "image")
    check_floating(image, "image")
    return known_or(torch.round(image * 255.0), 0.0).clamp(0.0, 255.0).to(torch.uint8)


def rgb255_to_rgb(image: Tensor) -> Tensor:
    """Divide an image in [0, 255] by 255.

    Args:
        image: RGB image (*, 3, H, W) in [0, 255], of an integer or floating-point dtype.

    Returns:
        (*, 3, H, W) in [0, 1]; float32 where the image's dtype is not floating point.

    Raises:
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> rgb255_to_rgb(torch.tensor([0, 51, 255], dtype=torch.uint8).reshape(1, 3, 1, 1)).flatten()
        tensor([0.0000, 0.2000, 1.0000])
    """
    check_rgb(image, "image")
    values = image if image.is_floating_point() else image.to(torch.float32)
    return values / 255.0


def normals_to_rgb255(image: Tensor) -> Tensor:
    """Surface normals as uint8 colours: 255 (n + 1) / 2, rounded and saturated.

    Args:
        image: normals (*, 3, H, W), each component in [-1, 1], floating point.

    Returns:
        (*, 3, H, W), uint8.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> normals_to_rgb255(torch.tensor([0.0, -1.0, 1.0]).reshape(1, 3, 1, 1)).flatten()
        tensor([128,   0, 255], dtype=torch.uint8)
    """
    check_rgb(image, "image")
    check_floating(image, "image")
    return known_or(torch.round((image + 1.0) * 127.5), 0.0).clamp(0.0, 255.0).to(torch.uint8)


def rgb255_to_normals(image: Tensor) -> Tensor:
    """Unit surface normals from colours: 2 c / 255 - 1, divided by its length.

    Args:
        image: RGB image (*, 3, H, W) in [0, 255], of an integer or floating-point dtype.

    Returns:
        (*, 3, H, W), of length 1 along the channels; float32 where the image's dtype is not floating point. A
        vector of length 0 stays 0, with gradient 0.

    Raises:
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> rgb255_to_normals(torch.tensor([127.5, 127.5, 255.0]).reshape(1, 3, 1, 1)).flatten()
        tensor([0., 0., 1.])
    """
    x, y, z = rgb_planes(2.0 * rgb255_to_rgb(image) - 1.0, "image")
    square = x * x + y * y + z * z
    zero = square == 0
    length = torch.sqrt(torch.where(zero, torch.ones_like(square), square))
    scale = torch.where(zero, torch.zeros_like(length), 1.0 / length)
    return torch.stack([x * scale, y * scale, z * scale], -3)
