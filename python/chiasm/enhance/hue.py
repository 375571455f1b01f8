"""Changes of hue and saturation in HSV."""

from typing import Union

import torch
from torch import Tensor

from ..color.hsv import saturation_of, sixths_value_chroma
from ..color.hue import from_sixths
from ..primitives.core.broadcasting import per_sample
from ..primitives.images.color_planes import rgb_planes


def adjust_hue(image: Tensor, factor: Union[float, Tensor]) -> Tensor:
    """Rotate the hue of every colour.

    Args:
        image: RGB (*, 3, H, W) in [0, 1], floating point.
        factor: angle in radians, usually in [-pi, pi]: a number, a scalar tensor or (B,), one for each
            sample.

    Returns:
        Tensor of the image's shape and dtype.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not (*, 3, H, W) or factor's shape is not as above.

    Example:
        >>> adjust_hue(torch.tensor([1.0, 0.0, 0.0]).reshape(3, 1, 1), 2.0943951).flatten()
        tensor([0., 1., 0.])
    """
    sixths, value, chroma = sixths_value_chroma(image)
    return from_sixths(sixths + _plane_factor(factor, image) * 0.954929658551372, value, chroma)  # 3 / pi


def adjust_hue_raw(image: Tensor, factor: Union[float, Tensor]) -> Tensor:
    """Rotate the hue of an HSV image; the new hue is in [0, 2 pi) (Kornia keeps the sign of the sum).

    Args:
        image: HSV (*, 3, H, W), floating point, hue in radians.
        factor: angle in radians: a number, a scalar tensor or (B,), one for each sample.

    Returns:
        Tensor of the image's shape and dtype: HSV.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not (*, 3, H, W) or factor's shape is not as above.

    Example:
        >>> adjust_hue_raw(torch.tensor([1.0, 0.5, 0.5]).reshape(3, 1, 1), 0.5).flatten()
        tensor([1.5000, 0.5000, 0.5000])
    """
    hue, saturation, value = rgb_planes(image, "image")
    turned = hue + _plane_factor(factor, image)
    turned = turned - 6.283185307179586 * torch.floor(turned.detach() / 6.283185307179586)
    return torch.stack([turned, saturation, value], -3)


def adjust_saturation(image: Tensor, factor: Union[float, Tensor]) -> Tensor:
    """Multiply the saturation of every colour, in HSV, and limit it to [0, 1].

    Args:
        image: RGB (*, 3, H, W) in [0, 1], floating point.
        factor: not negative; 0 gives grey, 1 changes nothing. A number, a scalar tensor or (B,), one for each
            sample.

    Returns:
        Tensor of the image's shape and dtype.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not (*, 3, H, W) or factor's shape is not as above.

    Example:
        >>> adjust_saturation(torch.tensor([0.8, 0.4, 0.4]).reshape(3, 1, 1), 0.5).flatten()
        tensor([0.8000, 0.6000, 0.6000])
    """
    sixths, value, chroma = sixths_value_chroma(image)
    saturation = saturation_of(value, chroma, 1e-8)
    return from_sixths(sixths, value, value * (saturation * _plane_factor(factor, image)).clamp(0.0, 1.0))


def adjust_saturation_raw(image: Tensor, factor: Union[float, Tensor]) -> Tensor:
    """Multiply the saturation of an HSV image and limit it to [0, 1].

    Args:
        image: HSV (*, 3, H, W), floating point: saturation in [0, 1]; hue and value stay as they are.
        factor: not negative; 0 gives grey, 1 changes nothing. A number, a scalar tensor or (B,), one for each
            sample.

    Returns:
        Tensor of the image's shape and dtype: HSV.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not (*, 3, H, W) or factor's shape is not as above.

    Example:
        >>> adjust_saturation_raw(torch.tensor([1.0, 0.5, 0.5]).reshape(3, 1, 1), 3.0).flatten()
        tensor([1.0000, 1.0000, 0.5000])
    """
    hue, saturation, value = rgb_planes(image, "image")
    return torch.stack([hue, (saturation * _plane_factor(factor, image)).clamp(0.0, 1.0), value], -3)


def _plane_factor(factor: Union[float, Tensor], image: Tensor) -> Tensor:
    """The factor with a shape that broadcasts against one plane."""
    every = per_sample(factor, image, "factor")
    if every.dim() != image.dim():
        return every
    if every.size(-3) != 1:
        raise ValueError(f"factor: expected one for the three channels, got shape {list(every.shape)}")
    return every.squeeze(-3)
