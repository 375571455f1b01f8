"""Crops of volumes, at random or fixed positions."""

from typing import Any, Dict, List, Optional, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_choice, check_six_sides, check_size3d
from ..primitives.random.draws import check_seed, words
from ..primitives.resampling.volumes import check_voxels
from .base import AugmentationBase3D, as_mode, identity
from .cut import beginning, inside
from .decisions import check_always, fitting
from .settings import number, whole_numbers


def cut3d(
    input: Tensor, corner: Tensor, size: Tuple[int, int, int], padding_mode: str, fill: float
) -> Tensor:
    """Crops (B, C, depth, height, width) of volumes, which begin at corners (B, 3), int64, (x, y, z); a
    corner may lie outside."""
    depth, height, width = input.size(2), input.size(3), input.size(4)
    z = (corner[:, 2:] + torch.arange(size[0], device=input.device))[:, :, None, None]
    y = (corner[:, 1:2] + torch.arange(size[1], device=input.device))[:, None, :, None]
    x = (corner[:, :1] + torch.arange(size[2], device=input.device))[:, None, None, :]
    row = inside(z, depth, padding_mode) * height + inside(y, height, padding_mode)
    voxel = (row * width + inside(x, width, padding_mode)).flatten(1)[:, None]
    part = torch.gather(input.flatten(2), 2, voxel.expand(-1, input.size(1), -1))
    part = part.reshape(-1, input.size(1), size[0], size[1], size[2])
    if padding_mode != "constant":
        return part
    seen = (z >= 0) & (z < depth) & (y >= 0) & (y < height) & (x >= 0) & (x < width)
    return torch.where(seen[:, None], part, torch.full_like(part, fitting(fill, part)))


def _drawn_corner(
    seed: Tensor, shape: List[int], size: Tuple[int, int, int], padding: List[int], pad_if_needed: bool
) -> Tensor:
    """The corners (B, 3), in coordinates of the volumes without padding."""
    drawn = words(seed, 3)
    x = beginning(drawn[:, 0], shape[4], size[2], padding[0], padding[1], pad_if_needed)
    y = beginning(drawn[:, 1], shape[3], size[1], padding[2], padding[3], pad_if_needed)
    z = beginning(drawn[:, 2], shape[2], size[0], padding[4], padding[5], pad_if_needed)
    return torch.stack([x, y, z], -1)


def random_crop3d(
    input: Tensor,
    seed: Tensor,
    size: Tuple[int, int, int],
    padding: Tuple[int, int, int, int, int, int] = (0, 0, 0, 0, 0, 0),
    pad_if_needed: bool = False,
    fill: float = 0.0,
    padding_mode: str = "constant",
) -> Tensor:
    """Crop a box of one size out of each volume, at a random position; all positions are equally likely.

    Args:
        input: (B, C, D, H, W), floating point or uint8.
        seed: (B,), int64.
        size: (depth, height, width) of the result.
        padding: how many voxels are added before the crop: (left, right, top, bottom, front, back).
        pad_if_needed: True pads a volume that is smaller than the box, on either side by the missing number
            of voxels.
        fill: the value of added voxels, in the units of the volume.
        padding_mode: the values of added voxels: "constant" (``fill``), "reflect" (about the centres of the
            border voxels), "replicate" or "circular".

    Returns:
        (B, C, depth, height, width). Differentiable in input.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a choice is not as above, or the box is larger than the padded volume.

    Example:
        >>> random_crop3d(torch.rand(1, 1, 3, 4, 5), torch.tensor([1]), (2, 2, 3)).shape
        torch.Size([1, 1, 2, 2, 3])
    """
    check_voxels(input, "input")
    check_seed(seed, input.size(0))
    check_choice(padding_mode, ["constant", "reflect", "replicate", "circular"], "padding_mode")
    check_size3d(size, "size")
    check_six_sides(padding, "padding")
    margins = [padding[0], padding[1], padding[2], padding[3], padding[4], padding[5]]
    corner = _drawn_corner(seed, list(input.shape), size, margins, pad_if_needed)
    return cut3d(input, corner, size, padding_mode, fill)


class Cut3D(AugmentationBase3D):
    """An augmentation that crops at whole voxels. A subclass draws the corners, "corner" (B, 3), int64.

    Args:
        size: (depth, height, width) of the result, or a number for all.
        padding_mode, fill: the values outside the volume, as in ``random_crop3d``.
        p: must be 1, since the size of the result must not depend on chance.
        same_on_batch, keepdim: as in ``AugmentationBase``.
    """

    def __init__(
        self, size: Any, padding_mode: str, fill: float, p: float, same_on_batch: bool, keepdim: bool
    ) -> None:
        check_always(number("p", p))
        super().__init__(1.0, 1.0, same_on_batch, keepdim)
        check_choice(padding_mode, ["constant", "reflect", "replicate", "circular"], "padding_mode")
        sides = whole_numbers("size", size)
        sides = sides * 3 if len(sides) == 1 else sides
        if len(sides) != 3 or min(sides) < 1:
            raise ValueError(f"size: expected a positive number, or (depth, height, width), got {size}")
        self.size = (sides[0], sides[1], sides[2])
        self.padding_mode, self.fill = padding_mode, number("fill", fill)

    def corner(self, seed: Tensor, shape: List[int]) -> Tensor:
        """The first corners of the crops, (B, 3), int64, (x, y, z)."""
        return torch.zeros_like(seed)[:, None].expand(-1, 3)

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        return {"batch_prob": torch.ones_like(seed, dtype=torch.bool), "corner": self.corner(seed, shape)}

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return cut3d(input, params["corner"], self.size, self.padding_mode, self.fill)

    @torch.jit.unused
    def transform_mask(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return cut3d(input, params["corner"], self.size, self.padding_mode, 0.0)

    @torch.jit.unused
    def inverse_transform(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return cut3d(input, -params["corner"], (shape[2], shape[3], shape[4]), "constant", self.fill)

    @torch.jit.unused
    def inverse_mask(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return cut3d(input, -params["corner"], (shape[2], shape[3], shape[4]), "constant", 0.0)

    def compute_transformation(self, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        matrix = identity(params["batch_prob"], 4).clone()
        matrix[:, :3, 3] = -params["corner"].to(torch.float64)
        return matrix


class RandomCrop3D(Cut3D):
    """``random_crop3d`` as a module.

    Args:
        size: (depth, height, width) of the result, or a number for all.
        padding: how many voxels are added before the crop: a number, (left and right, top and bottom, front
            and back), or (left, right, top, bottom, front, back).
        pad_if_needed, fill, padding_mode: as in ``random_crop3d``.
        resample, align_corners: for compatibility with Kornia; they have no effect, since a box begins at a
            whole voxel.
        p: must be 1, since the size of the result must not depend on chance.
        same_on_batch, keepdim: as in ``AugmentationBase``.

    Example:
        >>> RandomCrop3D((2, 4, 6), padding=1)(torch.rand(2, 3, 4, 8, 10)).shape
        torch.Size([2, 3, 2, 4, 6])
    """

    def __init__(
        self,
        size: Any,
        padding: Optional[Any] = None,
        pad_if_needed: Optional[bool] = False,
        fill: float = 0,
        padding_mode: str = "constant",
        resample: Any = "bilinear",
        same_on_batch: bool = False,
        align_corners: bool = True,
        p: float = 1.0,
        keepdim: bool = False,
    ) -> None:
        super().__init__(size, padding_mode, fill, p, same_on_batch, keepdim)
        as_mode(resample)
        margins = whole_numbers("padding", 0 if padding is None else padding)
        if len(margins) not in (1, 3, 6) or min(margins) < 0:
            raise ValueError(f"padding: expected 1, 3 or 6 numbers that are not negative, got {padding}")
        if len(margins) < 6:
            margins = [n for n in (margins * 3)[:3] for _ in range(2)]
        self.padding, self.pad_if_needed = margins, bool(pad_if_needed)

    def corner(self, seed: Tensor, shape: List[int]) -> Tensor:
        return _drawn_corner(seed, shape, self.size, self.padding, self.pad_if_needed)


class CenterCrop3D(Cut3D):
    """Crop the centre of volumes at whole voxels; if the centre lies between two positions, take the first
    one. Voxels outside a smaller volume are black.

    Args:
        size: (depth, height, width) of the result, or a number for all.
        align_corners, resample: for compatibility with Kornia; they have no effect, since a box begins at a
            whole voxel.
        p: must be 1, since the size of the result must not depend on chance.
        keepdim: as in ``AugmentationBase``.

    Example:
        >>> CenterCrop3D((1, 2, 2))(torch.arange(16.0).reshape(1, 1, 1, 4, 4))[0, 0, 0]
        tensor([[ 5.,  6.],
                [ 9., 10.]])
    """

    def __init__(
        self,
        size: Any,
        align_corners: bool = True,
        resample: Any = "bilinear",
        p: float = 1.0,
        keepdim: bool = False,
    ) -> None:
        super().__init__(size, "constant", 0.0, p, False, keepdim)
        as_mode(resample)

    def corner(self, seed: Tensor, shape: List[int]) -> Tensor:
        zero = torch.zeros_like(seed)
        x, y = zero + (shape[4] - self.size[2]) // 2, zero + (shape[3] - self.size[1]) // 2
        return torch.stack([x, y, zero + (shape[2] - self.size[0]) // 2], -1)
