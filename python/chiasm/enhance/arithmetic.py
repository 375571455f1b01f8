"""Sums and differences of images and numbers."""

from typing import Optional, Union

import torch
from torch import Tensor

from ..primitives.core.broadcasting import per_sample
from ..primitives.core.checks import check_floating, check_number, check_rgb, check_tensor, check_values
from ..primitives.core.modules import Module, hold
from ..primitives.core.pixels import weighted_sum
from ..primitives.images.tables import levels, table_entries


def add_weighted(
    src1: Tensor,
    alpha: Union[float, Tensor],
    src2: Tensor,
    beta: Union[float, Tensor],
    gamma: Union[float, Tensor],
) -> Tensor:
    """Weighted sum alpha * src1 + beta * src2 + gamma, like OpenCV's ``addWeighted`` (without saturation).
    For uint8, the sum is computed in float32, with each of its four steps rounded; the result is rounded
    (halves to even) and saturated. It is within one level of OpenCV's, which fuses some steps.

    Args:
        src1: (B, *), floating point or uint8.
        alpha: weight of src1: a number, a scalar tensor, (B,), one for each sample, or a tensor that
            broadcasts against src1.
        src2: like src1.
        beta: weight of src2, like alpha.
        gamma: the number to add, like alpha.

    Returns:
        Tensor of src1's shape and dtype.

    Raises:
        TypeError: if src1 or src2 is neither floating point nor uint8, or one is uint8 and the other one is
            not.
        ValueError: if the shapes of src1 and src2 differ, or that of alpha, beta or gamma is not as above.

    Example:
        >>> add_weighted(torch.ones(1, 2), 0.5, torch.ones(1, 2), 0.25, 1.0)
        tensor([[1.7500, 1.7500]])
    """
    check_values(src1, "src1")
    check_values(src2, "src2")
    if (src1.dtype == torch.uint8) != (src2.dtype == torch.uint8):
        raise TypeError(f"src2: expected src1's dtype {src1.dtype}, got {src2.dtype}")
    if src1.shape != src2.shape:
        raise ValueError(f"src2: expected src1's shape {list(src1.shape)}, got {list(src2.shape)}")
    if src1.dtype == torch.uint8:
        like = torch.empty([1], dtype=torch.float32, device=src1.device).expand(src1.shape)
        return weighted_sum(
            src1,
            src2,
            per_sample(alpha, like, "alpha"),
            per_sample(beta, like, "beta"),
            per_sample(gamma, like, "gamma"),
        )
    weighted = src1 * per_sample(alpha, src1, "alpha") + src2 * per_sample(beta, src1, "beta")
    return weighted + per_sample(gamma, src1, "gamma")


def invert(image: Tensor, max_val: Optional[Tensor] = None) -> Tensor:
    """Invert: max_val - image.

    Args:
        image: (B, *), floating point or uint8.
        max_val: the value of white, 1 by default, for uint8 always 255: a scalar tensor, (B,), one for each
            sample, or a tensor that broadcasts against image.

    Returns:
        Tensor of the image's shape and dtype.

    Raises:
        TypeError: if image is neither floating point nor uint8, or max_val is given for uint8.
        ValueError: if max_val's shape is not as above.

    Example:
        >>> invert(torch.tensor([[0.25, 1.0]]))
        tensor([[0.7500, 0.0000]])
    """
    check_values(image, "image")
    if image.dtype == torch.uint8:
        if max_val is not None:
            raise TypeError("max_val: expected None for an image of bytes, whose white is 255")
        return table_entries(image, levels(image, 255.0).flip([1]).to(torch.uint8))
    if max_val is None:
        return 1.0 - image
    return per_sample(max_val, image, "max_val") - image


def shift_rgb(image: Tensor, r_shift: Tensor, g_shift: Tensor, b_shift: Tensor) -> Tensor:
    """Add a number to each channel and limit the result to [0, 1].

    Args:
        image: RGB (B, 3, H, W) in [0, 1], floating point.
        r_shift: (B,), one for each sample, or a scalar tensor, for red.
        g_shift: the same for green.
        b_shift: the same for blue.

    Returns:
        (B, 3, H, W), in [0, 1].

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not (B, 3, H, W) or the shape of a shift is not as above.

    Example:
        >>> s = torch.tensor([0.5])
        >>> shift_rgb(torch.full((1, 3, 1, 1), 0.25), s, -s, 2 * s).flatten()
        tensor([0.7500, 0.0000, 1.0000])
    """
    check_rgb(image, "image")
    check_floating(image, "image")
    if image.dim() != 4:
        raise ValueError(f"image: expected shape (B, 3, H, W), got {list(image.shape)}")
    red, green, blue = image[:, 0], image[:, 1], image[:, 2]
    red = red + per_sample(r_shift, red, "r_shift")
    green = green + per_sample(g_shift, green, "g_shift")
    blue = blue + per_sample(b_shift, blue, "b_shift")
    return torch.stack([red, green, blue], 1).clamp(0.0, 1.0)


class Rescale(Module):
    """Multiply every value by a factor.

    Args:
        factor: a number, or a tensor without dimensions, which moves with the module.

    ``forward`` takes a tensor of any shape; integers become floating point, unless factor is an integer
    tensor.

    Raises:
        TypeError: if factor is neither.
        ValueError: if factor is a tensor with dimensions, or not finite.

    Example:
        >>> Rescale(2.0)(torch.tensor([0.5, 1.0]))
        tensor([1., 2.])
    """

    def __init__(self, factor: Union[float, Tensor]) -> None:
        super().__init__()
        if not isinstance(factor, Tensor):
            check_number(factor, "factor")
            self.factor = float(factor)
        elif factor.dim() == 0:
            hold(self, "factor", factor)
        else:
            raise ValueError(f"factor: expected a tensor without dimensions, got {list(factor.shape)}")

    def forward(self, input: Tensor) -> Tensor:
        """The product."""
        check_tensor(input, "input")
        return input * self.factor
