"""Random turns by multiples of 90 degrees."""

from typing import Any, Dict, List, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_pair
from ..primitives.random.draws import integers, uniform
from .base import check_batch
from .decisions import below
from .settings import whole
from .warps import Warp, chosen, warped


def _draw(seed: Tensor, times: Tuple[int, int], p: float) -> Dict[str, Tensor]:
    turns = integers(seed, times[1] - times[0] + 1, 1, 1)[:, 0] + times[0]
    return {"batch_prob": below(uniform(seed, 1)[:, 0], p), "times": turns}


def _matrix(params: Dict[str, Tensor], height: int, width: int) -> Tensor:
    """A counterclockwise rotation, as seen, about the centre; its sines and cosines are exact whole
    numbers."""
    turns = torch.remainder(params["times"], 4)
    zero = torch.zeros_like(turns, dtype=torch.float64)
    one = zero + 1.0
    c = torch.where(turns == 0, one, torch.where(turns == 2, -one, zero))
    s = torch.where(turns == 1, one, torch.where(turns == 3, -one, zero))
    x, y = one * ((width - 1) * 0.5), one * ((height - 1) * 0.5)
    rows = [c, s, x - c * x - s * y, -s, c, y + s * x - c * y, zero, zero, one]
    return chosen(torch.stack(rows, -1).reshape(-1, 3, 3), params)


def random_rotation90(
    input: Tensor,
    seed: Tensor,
    times: Tuple[int, int],
    resample: str = "bilinear",
    align_corners: bool = True,
    p: float = 0.5,
) -> Tensor:
    """Rotate some images by multiples of 90 degrees about their centres.

    The size stays the same: if an image is not square, content that leaves the image is lost, and the rest is
    black.

    Args:
        input: (B, C, H, W), floating point or uint8.
        seed: (B,), int64.
        times: the least and the greatest number of quarter turns, counterclockwise as seen; all numbers in
            this range are equally likely.
        resample: "bilinear", "nearest" or "bicubic"; this matters only if one side is even and the other one
            odd, because then positions lie between pixels.
        align_corners: for compatibility with Kornia; it has no effect, since pixels outside the image are
            black.
        p: the probability of each image.

    Returns:
        (B, C, H, W). Differentiable in input.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> x = torch.tensor([[[[1.0, 2.0], [3.0, 4.0]]]])
        >>> random_rotation90(x, torch.tensor([0]), (1, 1), p=1.0)[0, 0]
        tensor([[2., 4.],
                [1., 3.]])
    """
    check_batch(input, seed)
    check_pair(times, "times")
    if times[0] > times[1]:
        raise ValueError(f"times: expected (least, greatest), got {times}")
    height, width = input.size(2), input.size(3)
    return warped(
        input, _matrix(_draw(seed, times, p), height, width), height, width, resample, "zeros", align_corners
    )


class RandomRotation90(Warp):
    """``random_rotation90`` as a module.

    Args:
        times: the least and the greatest number of quarter turns, counterclockwise as seen; one number stands
            for both.
        resample, align_corners: as in ``random_rotation90``.
        same_on_batch, p, keepdim: as in ``AugmentationBase``.

    Example:
        >>> RandomRotation90((1, 3), p=1.0)(torch.rand(2, 3, 8, 8)).shape
        torch.Size([2, 3, 8, 8])
    """

    def __init__(
        self,
        times: Any,
        resample: Any = "bilinear",
        same_on_batch: bool = False,
        align_corners: bool = True,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None:
        super().__init__(resample, "zeros", align_corners, p, same_on_batch, keepdim)
        self.times = whole("times", times)
        if self.times[0] > self.times[1]:
            raise ValueError(f"times: expected (least, greatest), got {times}")

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        return _draw(seed, self.times, self.p)

    def compute_transformation(self, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return _matrix(params, shape[2], shape[3])
