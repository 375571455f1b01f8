"""Random changes of the values of volumes."""

from typing import Any, Dict, List, Tuple

import torch
from torch import Tensor

from ..enhance.equalization import equalize3d
from ..filters.correlation import filter3d
from ..filters.motion import get_motion_kernel3d
from ..primitives.core.broadcasting import each
from ..primitives.random.draws import between, uniform
from ..primitives.resampling.volumes import check_volume
from ..primitives.resampling.warping import position_dtype
from .base import AugmentationBase3D, as_mode, select
from .decisions import applied, below, check_bounds, check_chance, drawn, whole_between
from .settings import about, ranges, whole, word


def random_equalize3d(input: Tensor, seed: Tensor, p: float = 0.5) -> Tensor:
    """Equalize the histogram of each channel of some volumes, by ``equalize3d``. A changed sample has no
    gradient.

    Args:
        input: (B, C, D, H, W), floating point in [0, 1].
        seed: (B,), int64, one for each sample.
        p: probability that a sample is changed.

    Returns:
        (B, C, D, H, W), of the input's dtype; in a changed sample the values are multiples of 1 / 255.

    Raises:
        TypeError: if input is not floating point, or seed not int64.
        ValueError: if a shape or p is not as above.

    Example:
        >>> x = (torch.arange(1024.0) // 8).reshape(1, 1, 1, 32, 32) / 255
        >>> random_equalize3d(x, torch.tensor([7]), 1.0)[0, 0, 0, -1, -1]
        tensor(1.)
    """
    check_volume(input, "input")
    check_chance(p)
    return applied(equalize3d(input), input, drawn(seed, 1, input)[:, 0], p)


def random_motion_blur3d(
    input: Tensor,
    seed: Tensor,
    kernel_size: Tuple[int, int],
    angle: List[Tuple[float, float]],
    direction: Tuple[float, float],
    border_type: str = "constant",
    resample: str = "nearest",
    p: float = 0.5,
) -> Tensor:
    """Blur some volumes as if they had moved along a line, by ``motion_blur3d``; each sample has its own
    length, angle and direction.

    Args:
        input: (B, C, D, H, W), floating point.
        seed: (B,), int64, one for each sample.
        kernel_size: (least, greatest) length of the line, odd, at least 3; odd numbers between them are
            equally likely.
        angle: the ranges of the rotation vector's components along x, y and z, in degrees.
        direction: (least, greatest), within [-1, 1]; see ``get_motion_kernel3d``.
        border_type: "reflect", "replicate", "circular" or "constant" (zeros).
        resample: how the line is resampled, "nearest" or "bilinear".
        p: probability that a sample is changed.

    Returns:
        (B, C, D, H, W), of the input's dtype.

    Raises:
        TypeError: if input is not floating point, or seed not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> x, still = torch.ones(1, 1, 3, 4, 5), [(0.0, 0.0)] * 3
        >>> random_motion_blur3d(x, torch.tensor([7]), (3, 3), still, (0.0, 0.0), p=1.0)[0, 0, 0, 0]
        tensor([0.6667, 1.0000, 1.0000, 1.0000, 0.6667])
    """
    check_volume(input, "input")
    least, greatest = kernel_size
    if least < 3 or least % 2 == 0 or greatest % 2 == 0 or least > greatest:
        raise ValueError(
            f"kernel_size: expected odd (least, greatest) of at least 3, got ({least}, {greatest})"
        )
    if len(angle) != 3:
        raise ValueError(f"angle: expected three ranges (least, greatest), got {len(angle)}")
    check_bounds(direction, -1.0, 1.0, "direction")
    check_chance(p)
    u = drawn(seed, 6, input).to(position_dtype(input.dtype))
    turn = torch.stack([between(u[:, 1 + i], angle[i][0], angle[i][1]) for i in range(3)], 1)
    slope = between(u[:, 4], direction[0], direction[1])
    length = least + 2 * whole_between(u[:, 5], (0, (greatest - least) // 2))
    kernel = get_motion_kernel3d(greatest, turn, slope, resample)
    for size in range(least, greatest, 2):
        around: List[int] = [(greatest - size) // 2] * 6
        shorter = torch.nn.functional.pad(get_motion_kernel3d(size, turn, slope, resample), around)
        kernel = torch.where(each(length == size, kernel), shorter, kernel)
    return applied(filter3d(input, kernel.to(input.dtype), border_type), input, u[:, 0], p)


class RandomEqualize3D(AugmentationBase3D):
    """``random_equalize3d`` as a module.

    Args:
        p, same_on_batch, keepdim: as in ``AugmentationBase``.

    Example:
        >>> RandomEqualize3D()(torch.rand(2, 3, 4, 5, 6)).shape
        torch.Size([2, 3, 4, 5, 6])
    """

    def __init__(self, p: float = 0.5, same_on_batch: bool = False, keepdim: bool = False) -> None:
        super().__init__(p, 1.0, same_on_batch, keepdim)

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return select(params, equalize3d(input), input)


class RandomMotionBlur3D(AugmentationBase3D):
    """``random_motion_blur3d`` as a module.

    Args:
        kernel_size: the length of the line, or (least, greatest).
        angle: the ranges of the rotation vector's components along x, y and z in degrees, as ``degrees`` of
            ``RandomAffine3D``.
        direction: the range; a number x means [-x, x].
        border_type, resample: as in ``random_motion_blur3d``.
        same_on_batch, p, keepdim: as in ``AugmentationBase``.

    Example:
        >>> RandomMotionBlur3D(3, 35.0, 0.5)(torch.rand(2, 3, 4, 5, 6)).shape
        torch.Size([2, 3, 4, 5, 6])
    """

    angle: List[Tuple[float, float]]

    def __init__(
        self,
        kernel_size: Any,
        angle: Any,
        direction: Any,
        border_type: Any = "constant",
        resample: Any = "nearest",
        same_on_batch: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None:
        super().__init__(p, 1.0, same_on_batch, keepdim)
        self.kernel_size, self.angle = whole("kernel_size", kernel_size), ranges("angle", angle, 3)
        self.direction = about(0.0, -1.0, 1.0)("direction", direction)
        self.border_type, self.resample = word("border_type", border_type), as_mode(resample)

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        return {"batch_prob": below(uniform(seed, 1)[:, 0], self.p), "draws": seed}

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        blurred = random_motion_blur3d(
            input,
            params["draws"],
            self.kernel_size,
            self.angle,
            self.direction,
            self.border_type,
            self.resample,
            1.0,
        )
        return select(params, blurred, input)
