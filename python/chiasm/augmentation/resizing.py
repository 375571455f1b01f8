"""Resizing as a step of a sequence: masks, boxes and keypoints are resized with their images."""

from typing import Any, Dict, List

import torch
from torch import Tensor

from ..geometry.transform.resize import resize, size_of
from ..primitives.core.modules import shown
from .annotations import moved_mask
from .base import GeometricAugmentationBase2D, Size, as_mode, as_size, identity
from .decisions import check_always
from .settings import number, one_whole


class Resize(GeometricAugmentationBase2D):
    """``geometry.transform.resize`` as a step of a sequence.

    Args:
        size: (height, width) of the result, or one number, the length of ``side``; the other side keeps the
            aspect ratio.
        side: the side whose length one number gives: "short", "long", "vert" or "horz".
        resample: "bilinear", "nearest" or "bicubic".
        align_corners: True maps centres of corner pixels to centres of corner pixels; False maps edges to
            edges. "nearest" always maps edges to edges.
        antialias: True: the filter is as wide as the area that a pixel of the result covers.
        p: must be 1, since the size of the result must not depend on chance.
        keepdim: as in ``AugmentationBase``.

    Example:
        >>> augment = Resize((4, 5))
        >>> augment(torch.rand(2, 3, 8, 10)).shape
        torch.Size([2, 3, 4, 5])
    """

    def __init__(
        self,
        size: Size,
        side: str = "short",
        resample: Any = "bilinear",
        align_corners: bool = True,
        antialias: bool = False,
        p: float = 1.0,
        keepdim: bool = False,
    ) -> None:
        check_always(number("p", p))
        super().__init__(1.0, 1.0, False, keepdim)
        if side not in ("short", "long", "vert", "horz"):
            raise ValueError(f"side: expected 'short', 'long', 'vert' or 'horz', got {side!r}")
        sides = as_size(size, "size")
        # A scripted module has one type of size: two numbers; a single number is repeated.
        self.height, self.width, self.single = sides[0], sides[1], isinstance(size, int)
        self.side, self.resample, self.antialias = side, as_mode(resample), bool(antialias)
        self.align_corners = bool(align_corners) and self.resample != "nearest"

    def output_size(self, shape: List[int]) -> List[int]:
        """Height and width of the result."""
        if not self.single:
            return [self.height, self.width]
        height, width = size_of(shape[2], shape[3], self.height, self.side)
        return [height, width]

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        height, width = self.output_size(list(input.shape))
        antialias = self.antialias and self.resample != "nearest"
        return resize(input, (height, width), self.resample, self.align_corners, "short", antialias)

    @torch.jit.unused
    def transform_mask(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        height, width = self.output_size(list(input.shape))
        return moved_mask(input, lambda values, _: resize(values, (height, width), "nearest"))

    @torch.jit.unused
    def inverse_transform(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return resize(input, (shape[2], shape[3]), self.resample, self.align_corners)

    @torch.jit.unused
    def inverse_mask(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return moved_mask(input, lambda values, _: resize(values, (shape[2], shape[3]), "nearest"))

    def compute_transformation(self, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        height, width = self.output_size(shape)
        matrix = identity(params["batch_prob"], 3).clone()
        for axis, (before, after) in enumerate(((shape[3], width), (shape[2], height))):
            if self.align_corners and after > 1:
                matrix[:, axis, axis] = (after - 1) / max(before - 1, 1)
            else:  # one pixel has no distance between corners: the whole side lies in it
                matrix[:, axis, axis] = after / before
                matrix[:, axis, 2] = 0.5 * after / before - 0.5
        return matrix

    def extra_repr(self) -> str:
        return shown(self, size=self.height if self.single else (self.height, self.width))


class LongestMaxSize(Resize):
    """Resize images so that the longer side has a given length; the aspect ratio stays.

    Args:
        max_size: the longer side of the result, in pixels.
        resample, align_corners: as in ``Resize``.
        p: must be 1, since the size of the result must not depend on chance.

    Example:
        >>> LongestMaxSize(5)(torch.rand(2, 3, 8, 10)).shape
        torch.Size([2, 3, 4, 5])
    """

    def __init__(
        self, max_size: int, resample: Any = "bilinear", align_corners: bool = True, p: float = 1.0
    ) -> None:
        size = as_size(one_whole("max_size", max_size), "max_size")[0]
        super().__init__(size, "long", resample, align_corners, p=p)
        self.max_size = size


class SmallestMaxSize(Resize):
    """Resize images so that the shorter side has a given length; the aspect ratio stays.

    Args:
        max_size: the shorter side of the result, in pixels.
        resample, align_corners: as in ``Resize``.
        p: must be 1, since the size of the result must not depend on chance.

    Example:
        >>> SmallestMaxSize(4)(torch.rand(2, 3, 8, 10)).shape
        torch.Size([2, 3, 4, 5])
    """

    def __init__(
        self, max_size: int, resample: Any = "bilinear", align_corners: bool = True, p: float = 1.0
    ) -> None:
        size = as_size(one_whole("max_size", max_size), "max_size")[0]
        super().__init__(size, "short", resample, align_corners, p=p)
        self.max_size = size
