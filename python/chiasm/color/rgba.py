"""The alpha channel."""

from typing import List, Optional, Tuple, Union

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_number, check_rgb, check_triple
from ..primitives.core.pixels import check_pixel_value
from ..primitives.images.color_planes import arranged, check_channels


def rgb_to_rgba(image: Tensor, alpha_val: Union[float, Tensor]) -> Tensor:
    """Append an alpha channel.

    Args:
        image: RGB image (*, 3, H, W), any dtype.
        alpha_val: one value for all pixels, which an integer dtype of the image must be able to hold, or a
            tensor (*, 1, H, W).

    Returns:
        (*, 4, H, W): red, green, blue, alpha.

    Raises:
        ValueError: if image is not (*, 3, H, W), or alpha_val does not fit its shape or dtype.

    Example:
        >>> rgb_to_rgba(torch.zeros(1, 3, 1, 1), 0.5).flatten()
        tensor([0.0000, 0.0000, 0.0000, 0.5000])
    """
    check_rgb(image, "image")
    return _with_alpha(image, [0, 1, 2], alpha_val)


def bgr_to_rgba(image: Tensor, alpha_val: Union[float, Tensor]) -> Tensor:
    """Bring the channels into the order red, green, blue and append an alpha channel.

    Args:
        image: BGR image (*, 3, H, W), any dtype.
        alpha_val: one value for all pixels, which an integer dtype of the image must be able to hold, or a
            tensor (*, 1, H, W).

    Returns:
        (*, 4, H, W): red, green, blue, alpha.

    Raises:
        ValueError: if image is not (*, 3, H, W), or alpha_val does not fit its shape or dtype.

    Example:
        >>> bgr_to_rgba(torch.tensor([1.0, 0.0, 0.0]).reshape(1, 3, 1, 1), 0.5).flatten()
        tensor([0.0000, 0.0000, 1.0000, 0.5000])
    """
    check_rgb(image, "image")
    return _with_alpha(image, [2, 1, 0], alpha_val)


def rgba_to_rgb(
    image: Tensor, background_color: Optional[Union[Tensor, Tuple[float, float, float]]] = None
) -> Tensor:
    """Drop the alpha channel, or blend with a background: alpha C + (1 - alpha) background.

    T. Porter, T. Duff, Compositing digital images, SIGGRAPH 1984 ("over", alpha not premultiplied).

    Args:
        image: RGBA image (*, 4, H, W), any dtype; with a background, floating point with alpha in [0, 1].
        background_color: red, green, blue: three numbers, (3,), or an image (*, 3, H, W) or (*, 3, 1, 1).
            Without it alpha is ignored, as in OpenCV.

    Returns:
        (*, 3, H, W): red, green, blue.

    Raises:
        TypeError: if there is a background and image is not floating point.
        ValueError: if image is not (*, 4, H, W) or background_color is not as above.

    Example:
        >>> red = torch.tensor([1.0, 0.0, 0.0, 0.25]).reshape(1, 4, 1, 1)
        >>> rgba_to_rgb(red, (1.0, 1.0, 1.0)).flatten()
        tensor([1.0000, 0.7500, 0.7500])
    """
    check_channels(image, 4, "image")
    if background_color is None:
        return arranged(image, [0, 1, 2], 0.0)
    check_floating(image, "image")
    alpha = image.select(-3, 3)
    if isinstance(background_color, Tensor):
        back = background_color.to(image.dtype)
        back = back[:, None, None] if back.dim() == 1 else back
        check_channels(back, 3, "background_color")
        planes = [back.select(-3, i) for i in range(3)]
    else:
        check_triple(background_color, "background_color")
        red, green, blue = background_color
        planes = [torch.full_like(alpha, red), torch.full_like(alpha, green), torch.full_like(alpha, blue)]
    return torch.stack([p + alpha * (image.select(-3, i) - p) for i, p in enumerate(planes)], -3)


def rgba_to_bgr(image: Tensor) -> Tensor:
    """Drop the alpha channel and bring the others into the order blue, green, red.

    Args:
        image: RGBA image (*, 4, H, W), any dtype.

    Returns:
        (*, 3, H, W): blue, green, red.

    Raises:
        ValueError: if image is not (*, 4, H, W).

    Example:
        >>> rgba_to_bgr(torch.arange(4.0).reshape(1, 4, 1, 1)).flatten()
        tensor([2., 1., 0.])
    """
    check_channels(image, 4, "image")
    return arranged(image, [2, 1, 0], 0.0)


def _with_alpha(image: Tensor, order: List[int], alpha_val: Union[float, Tensor]) -> Tensor:
    """The three channels in an order, and alpha."""
    if not isinstance(alpha_val, Tensor):
        check_pixel_value(alpha_val, image, "alpha_val")
        check_number(alpha_val, "alpha_val")
        return arranged(image, order + [3], alpha_val)
    check_channels(alpha_val, 1, "alpha_val")
    alpha = alpha_val.select(-3, 0).to(image.dtype)
    if alpha.shape != image.select(-3, 0).shape:
        raise ValueError(
            f"alpha_val: expected (*, 1, H, W) of the image {list(image.shape)}, got {list(alpha_val.shape)}"
        )
    return torch.stack([image.select(-3, i) for i in order] + [alpha], -3)
