"""Crops without resizing, at random or fixed positions, and padding to a size."""

from typing import Any, Dict, List, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_choice, check_four_sides, check_pair
from ..primitives.core.modules import shown
from ..primitives.random.draws import words
from .base import GeometricAugmentationBase2D, Size, as_size, check_batch, identity
from .decisions import check_always, fitting
from .settings import number, whole_numbers


def inside(position: Tensor, size: int, padding_mode: str) -> Tensor:
    """The index of the pixel, of ``size`` pixels, that padding shows at a position, which may lie outside."""
    if padding_mode == "circular":
        return torch.remainder(position, size)
    if padding_mode == "reflect" and size > 1:  # about the centres of the border pixels
        position = torch.remainder(position, 2 * size - 2)
        position = torch.minimum(position, 2 * size - 2 - position)
    return position.clamp(0, size - 1)


def cut(input: Tensor, corner: Tensor, size: Tuple[int, int], padding_mode: str, fill: float) -> Tensor:
    """Crops (B, C, height, width) of images, which begin at corners (B, 2), int64, (x, y); a corner may lie
    outside."""
    height, width = input.size(2), input.size(3)
    column = corner[:, :1] + torch.arange(size[1], device=input.device)
    row = corner[:, 1:] + torch.arange(size[0], device=input.device)
    part = picked(input, inside(row, height, padding_mode), inside(column, width, padding_mode))
    if padding_mode != "constant":
        return part
    seen = ((row >= 0) & (row < height))[:, None, :, None] & ((column >= 0) & (column < width))[:, None, None]
    return torch.where(seen, part, torch.full_like(part, fitting(fill, part)))


def picked(input: Tensor, row: Tensor, column: Tensor) -> Tensor:
    """The pixels (B, C, h, w) of images in the rows (B, h) and columns (B, w), int64."""
    x, y = column[:, None, None, :], row[:, None, :, None]
    rows = torch.gather(input, 2, y.expand(-1, input.size(1), -1, input.size(3)))
    return torch.gather(rows, 3, x.expand(-1, input.size(1), row.size(1), -1))


def beginning(drawn: Tensor, inside: int, size: int, before: int, after: int, pad_if_needed: bool) -> Tensor:
    """The first position (B,) of a crop of ``size`` pixels along an axis of ``inside`` pixels, padded by
    ``before`` and ``after``, from random words (B,). 0 is the first pixel that is not padding."""
    room, first = inside + before + after, before
    if pad_if_needed and room < size:  # the missing number of pixels on either side
        first, room = first + size - room, 2 * size - room
    if room < size:
        raise ValueError(f"size: expected at most {room} along an axis of {inside}, with padding; got {size}")
    return ((drawn * (room - size + 1)) >> 32) - first


def _drawn_corner(
    seed: Tensor, shape: List[int], size: Tuple[int, int], padding: List[int], pad_if_needed: bool
) -> Tensor:
    """The corners (B, 2), in coordinates of the images without padding."""
    drawn = words(seed, 2)
    x = beginning(drawn[:, 0], shape[3], size[1], padding[0], padding[2], pad_if_needed)
    y = beginning(drawn[:, 1], shape[2], size[0], padding[1], padding[3], pad_if_needed)
    return torch.stack([x, y], -1)


def random_crop(
    input: Tensor,
    seed: Tensor,
    size: Tuple[int, int],
    padding: Tuple[int, int, int, int] = (0, 0, 0, 0),
    pad_if_needed: bool = False,
    fill: float = 0.0,
    padding_mode: str = "constant",
) -> Tensor:
    """Crop a box of one size out of each image, at a random position; all positions are equally likely.

    Args:
        input: (B, C, H, W), floating point or uint8.
        seed: (B,), int64.
        size: (height, width) of the result.
        padding: how many pixels are added before the crop: (left, top, right, bottom).
        pad_if_needed: True pads an image that is smaller than the box, on either side by the missing number
            of pixels.
        fill: the value of added pixels, in the units of the image.
        padding_mode: the values of added pixels: "constant" (``fill``), "reflect" (about the centres of the
            border pixels), "replicate" or "circular".

    Returns:
        (B, C, height, width). Differentiable in input.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a choice is not as above, or the box is larger than the padded image.

    Example:
        >>> random_crop(torch.arange(9.0).reshape(1, 1, 3, 3), torch.tensor([1]), (2, 2)).shape
        torch.Size([1, 1, 2, 2])
    """
    check_batch(input, seed)
    check_pair(size, "size")
    check_choice(padding_mode, ["constant", "reflect", "replicate", "circular"], "padding_mode")
    check_four_sides(padding, "padding")
    margins = [padding[0], padding[1], padding[2], padding[3]]
    corner = _drawn_corner(seed, list(input.shape), size, margins, pad_if_needed)
    return cut(input, corner, size, padding_mode, fill)


class Cut(GeometricAugmentationBase2D):
    """An augmentation that crops at whole pixels. A subclass draws the corners, "corner" (B, 2), int64.

    Args:
        size: (height, width) of the result, or a number for both.
        padding_mode, fill: the values outside the image, as in ``random_crop``.
        p: must be 1, since the size of the result must not depend on chance.
        same_on_batch, keepdim: as in ``AugmentationBase``.
    """

    def __init__(
        self,
        size: Size,
        padding_mode: str = "constant",
        fill: float = 0.0,
        p: float = 1.0,
        same_on_batch: bool = False,
        keepdim: bool = False,
    ) -> None:
        check_always(number("p", p))
        super().__init__(1.0, 1.0, same_on_batch, keepdim)
        check_choice(padding_mode, ["constant", "reflect", "replicate", "circular"], "padding_mode")
        self.size, self.padding_mode, self.fill = as_size(size, "size"), padding_mode, number("fill", fill)

    def corner(self, seed: Tensor, shape: List[int]) -> Tensor:
        """The upper left corners of the crops, (B, 2), int64, (x, y)."""
        return torch.zeros_like(seed)[:, None].expand(-1, 2)

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        return {"batch_prob": torch.ones_like(seed, dtype=torch.bool), "corner": self.corner(seed, shape)}

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return cut(input, params["corner"], self.size, self.padding_mode, self.fill)

    @torch.jit.unused
    def transform_mask(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return cut(input, params["corner"], self.size, self.padding_mode, 0.0)

    @torch.jit.unused
    def inverse_transform(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return cut(input, -params["corner"], (shape[2], shape[3]), "constant", self.fill)

    @torch.jit.unused
    def inverse_mask(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return cut(input, -params["corner"], (shape[2], shape[3]), "constant", 0.0)

    def compute_transformation(self, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        matrix = identity(params["batch_prob"], 3).clone()
        matrix[:, :2, 2] = -params["corner"].to(torch.float64)
        return matrix


def whole_mode(value: str) -> str:
    """Check the name of one of Kornia's two ways to crop, which differ only for positions between pixels."""
    check_choice(value, ["slice", "resample"], "cropping_mode")
    return value


class RandomCrop(Cut):
    """``random_crop`` as a module.

    Args:
        size: (height, width) of the result, or a number for both.
        padding: how many pixels are added before the crop: a number, (left and right, top and bottom), or
            (left, top, right, bottom).
        pad_if_needed, fill, padding_mode: as in ``random_crop``.
        resample, align_corners, cropping_mode: for compatibility with Kornia; they have no effect, since a
            box begins at a whole pixel.
        p: must be 1, since the size of the result must not depend on chance.
        same_on_batch, keepdim: as in ``AugmentationBase``.

    Example:
        >>> augment = RandomCrop((4, 6), padding=1)
        >>> augment(torch.rand(2, 3, 8, 10)).shape
        torch.Size([2, 3, 4, 6])
    """

    def __init__(
        self,
        size: Size,
        padding: Any = None,
        pad_if_needed: bool = False,
        fill: float = 0.0,
        padding_mode: str = "constant",
        resample: Any = "bilinear",
        same_on_batch: bool = False,
        align_corners: bool = True,
        p: float = 1.0,
        keepdim: bool = False,
        cropping_mode: str = "slice",
    ) -> None:
        super().__init__(size, padding_mode, fill, p, same_on_batch, keepdim)
        margins = whole_numbers("padding", 0 if padding is None else padding)
        if len(margins) not in (1, 2, 4) or min(margins) < 0:
            raise ValueError(f"padding: expected 1, 2 or 4 numbers that are not negative, got {padding}")
        self.padding, self.pad_if_needed = (margins * 4)[:4], bool(pad_if_needed)
        self.cropping_mode = whole_mode(cropping_mode)

    def corner(self, seed: Tensor, shape: List[int]) -> Tensor:
        return _drawn_corner(seed, shape, self.size, self.padding, self.pad_if_needed)


class CenterCrop(Cut):
    """Crop the centre of images at whole pixels; if the centre lies between two positions, take the first
    one. Pixels outside a smaller image are black.

    Args:
        size: (height, width) of the result, or a number for both.
        align_corners, resample, cropping_mode: for compatibility with Kornia; they have no effect, since a
            box begins at a whole pixel.
        p: must be 1, since the size of the result must not depend on chance.
        keepdim: as in ``AugmentationBase``.

    Example:
        >>> CenterCrop(2)(torch.arange(16.0).reshape(1, 1, 4, 4))[0, 0]
        tensor([[ 5.,  6.],
                [ 9., 10.]])
    """

    def __init__(
        self,
        size: Size,
        align_corners: bool = True,
        resample: Any = "bilinear",
        p: float = 1.0,
        keepdim: bool = False,
        cropping_mode: str = "slice",
    ) -> None:
        super().__init__(size, p=p, keepdim=keepdim)
        self.cropping_mode = whole_mode(cropping_mode)

    def corner(self, seed: Tensor, shape: List[int]) -> Tensor:
        zero = torch.zeros_like(seed)
        x, y = zero + (shape[3] - self.size[1]) // 2, zero + (shape[2] - self.size[0]) // 2
        return torch.stack([x, y], -1)


class PadTo(Cut):
    """Pad or crop images to a size, at the right and at the bottom.

    Args:
        size: (height, width) of the result.
        pad_mode: the values of added pixels, as ``padding_mode`` of ``random_crop``.
        pad_value: the value for "constant", in the units of the image.
        keepdim: as in ``AugmentationBase``.
        crop_if_exceeds: False raises an error for images that are larger.

    Example:
        >>> PadTo((2, 3), pad_value=7)(torch.ones(1, 1, 1, 2))[0, 0]
        tensor([[1., 1., 7.],
                [7., 7., 7.]])
    """

    def __init__(
        self,
        size: Tuple[int, int],
        pad_mode: str = "constant",
        pad_value: float = 0.0,
        keepdim: bool = False,
        crop_if_exceeds: bool = True,
    ) -> None:
        check_choice(pad_mode, ["constant", "reflect", "replicate", "circular"], "pad_mode")
        super().__init__(size, pad_mode, number("pad_value", pad_value), keepdim=keepdim)
        self.crop_if_exceeds = bool(crop_if_exceeds)

    def corner(self, seed: Tensor, shape: List[int]) -> Tensor:
        if not self.crop_if_exceeds and (shape[2] > self.size[0] or shape[3] > self.size[1]):
            raise ValueError(
                f"input: expected at most {self.size}, crop_if_exceeds is False; got ({shape[2]}, {shape[3]})"
            )
        return torch.zeros_like(seed)[:, None].expand(-1, 2)

    def extra_repr(self) -> str:
        return shown(self, pad_mode=self.padding_mode, pad_value=self.fill)
