"""Random erasing."""

import math
from typing import Any, Dict, List, Tuple

import torch
from torch import Tensor

from ..primitives.random.draws import between, uniform
from ..primitives.resampling.warping import pixel_axes
from .base import IntensityAugmentationBase2D, check_batch, select
from .decisions import below, check_bounds, check_positive_bounds, fitting
from .settings import number, symmetric


def _draw(
    seed: Tensor, shape: List[int], scale: Tuple[float, float], ratio: Tuple[float, float], p: float
) -> Dict[str, Tensor]:
    check_bounds(scale, 0.0, math.inf, "scale")
    check_positive_bounds(ratio, "ratio")
    height, width = shape[2], shape[3]
    u = uniform(seed, 5).to(torch.float64)
    area = between(u[:, 1], scale[0], scale[1]) * (height * width)
    aspect = torch.exp(between(u[:, 2], math.log(ratio[0]), math.log(ratio[1])))
    one = torch.ones_like(area)
    high = torch.minimum(torch.clamp(torch.round(torch.sqrt(area * aspect)), min=1.0), one * height)
    wide = torch.minimum(torch.clamp(torch.round(torch.sqrt(area / aspect)), min=1.0), one * width)
    return {
        "batch_prob": below(u[:, 0], p),
        "widths": wide,
        "heights": high,
        "xs": torch.floor(u[:, 3] * (width - wide + 1.0)),
        "ys": torch.floor(u[:, 4] * (height - high + 1.0)),
    }


def _erased(input: Tensor, params: Dict[str, Tensor], value: float) -> Tensor:
    column, row = pixel_axes(input.size(2), input.size(3), torch.float64, input.device)
    left, top = params["xs"][:, None, None], params["ys"][:, None, None]
    right, bottom = left + params["widths"][:, None, None], top + params["heights"][:, None, None]
    inside = (column >= left) & (column < right) & (row >= top) & (row < bottom)
    return select(
        params, torch.where(inside[:, None], torch.full_like(input, fitting(value, input)), input), input
    )


def random_erasing(
    input: Tensor,
    seed: Tensor,
    scale: Tuple[float, float] = (0.02, 0.33),
    ratio: Tuple[float, float] = (0.3, 3.3),
    value: float = 0.0,
    p: float = 0.5,
) -> Tensor:
    """Fill a random rectangle of some images: Z. Zhong et al., Random erasing data augmentation, AAAI 2020.

    Args:
        input: (B, C, H, W), floating point or uint8.
        seed: (B,), int64.
        scale: the range of the rectangle's area, as a fraction of the image area.
        ratio: the range of height / width, uniform in the logarithm. Sides that are too long are cut.
        value: the value that fills the rectangle.
        p: the probability of each image.

    Returns:
        (B, C, H, W). Differentiable in input.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape is not as above.

    Example:
        >>> random_erasing(torch.ones(1, 1, 10, 10), torch.tensor([0]), (0.5, 0.5), (2.0, 2.0), p=1.0).sum()
        tensor(50.)
    """
    check_batch(input, seed)
    return _erased(input, _draw(seed, list(input.shape), scale, ratio, p), value)


class RandomErasing(IntensityAugmentationBase2D):
    """``random_erasing`` as a module.

    Args:
        scale, ratio, value: as in ``random_erasing``.
        same_on_batch, p, keepdim: as in ``AugmentationBase``.

    Example:
        >>> RandomErasing(p=1.0)(torch.rand(2, 3, 8, 10)).shape
        torch.Size([2, 3, 8, 10])
    """

    def __init__(
        self,
        scale: Any = (0.02, 0.33),
        ratio: Any = (0.3, 3.3),
        value: float = 0.0,
        same_on_batch: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None:
        super().__init__(p, 1.0, same_on_batch, keepdim)
        self.scale, self.ratio, self.value = (
            symmetric("scale", scale),
            symmetric("ratio", ratio),
            number("value", value),
        )
        if self.scale[0] <= 0.0 or self.ratio[0] <= 0.0:
            raise ValueError(f"scale, ratio: expected positive ranges, got {scale} and {ratio}")

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        return _draw(seed, shape, self.scale, self.ratio, self.p)

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return _erased(input, params, self.value)

    @torch.jit.unused
    def transform_mask(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return _erased(input, params, 0.0)
