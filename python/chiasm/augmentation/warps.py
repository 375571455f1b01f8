"""Shared by random warps: a matrix for each sample, and the sampling of images by these matrices."""

from typing import Any, Callable, Dict, List, Optional

import torch
from torch import Tensor

from ..primitives.linalg.matrices import inverse3x3
from ..primitives.resampling.warping import check_sampling, check_source, resample_affine, resample_projective
from .annotations import moved_mask
from .base import GeometricAugmentationBase2D, as_mode, identity
from .settings import numbers, word


def chosen(matrix: Tensor, params: Dict[str, Tensor]) -> Tensor:
    """The homographies (B, 3, 3) of samples that "batch_prob" chooses, and the identity for other samples. A
    warp by the identity returns the image itself, so that no choice is needed afterwards.
    """
    eye = identity(params["batch_prob"], 3)
    return torch.where(params["batch_prob"][:, None, None], matrix.to(torch.float64), eye)


def warped(
    input: Tensor,
    matrix: Tensor,
    height: int,
    width: int,
    resample: str,
    padding_mode: str,
    align_corners: bool,
    affine: bool = True,
    fill_value: Optional[Tensor] = None,
) -> Tensor:
    """The images, warped to (B, C, height, width) by homographies (B, 3, 3), float64, from input to
    output."""
    check_source(input, resample, padding_mode, "input")
    inverse = inverse3x3(matrix)
    if affine:
        return resample_affine(
            input, inverse[:, :2], height, width, resample, padding_mode, align_corners, fill_value
        )
    return resample_projective(
        input, inverse, height, width, resample, padding_mode, align_corners, fill_value
    )


def middle(like: Tensor, height: int, width: int) -> Tensor:
    """The centres (B, 2), float64, of B images, where B is the batch size of ``like``."""
    one = torch.ones_like(like, dtype=torch.float64)
    return torch.stack([one * ((width - 1) * 0.5), one * ((height - 1) * 0.5)], -1)


class Warp(GeometricAugmentationBase2D):
    """A geometric augmentation that samples images by the matrices of ``compute_transformation``.

    Args:
        resample: "bilinear", "nearest" or "bicubic".
        padding_mode: the values outside the image: "zeros", "border", "reflection" or "fill".
        align_corners: True: "reflection" mirrors at the centres of the border pixels; False: at the image's
            outer edges.
        affine: whether the matrices' last row is (0, 0, 1).
        fill_value: for "fill", a number, also for masks, or one for each channel; black by default.
        p, same_on_batch, keepdim: as in ``AugmentationBase``.
    """

    fill_value: List[float]

    def __init__(
        self,
        resample: Any,
        padding_mode: str,
        align_corners: bool,
        p: float,
        same_on_batch: bool,
        keepdim: bool,
        affine: bool = True,
        fill_value: Optional[Any] = None,
    ) -> None:
        super().__init__(p, 1.0, same_on_batch, keepdim)
        self.resample, self.padding_mode = as_mode(resample), word("padding_mode", padding_mode)
        check_sampling(self.resample, self.padding_mode)
        self.align_corners, self.affine = align_corners, affine
        self.fill_value = [0.0] if fill_value is None else numbers("fill_value", fill_value)

    def output_size(self, shape: List[int]) -> List[int]:
        """Height and width of the result."""
        return shape[2:4]

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return self.sampled(input, params, self.resample, self.fill_value)

    def sampled(
        self, input: Tensor, params: Dict[str, Tensor], resample: str, fill_value: List[float]
    ) -> Tensor:
        """The images, sampled with the given interpolation."""
        shape = list(input.shape)
        height, width = self.output_size(shape)
        matrix = self.compute_transformation(params, shape)
        return self.warped_by(matrix, input, height, width, resample, fill_value)

    def warped_by(
        self, matrix: Tensor, input: Tensor, height: int, width: int, resample: str, fill_value: List[float]
    ) -> Tensor:
        """``warped`` with this module's settings."""
        fill: Optional[Tensor] = None
        if self.padding_mode == "fill":
            if len(fill_value) != 1 and len(fill_value) != input.size(1):
                raise ValueError(
                    f"fill_value: expected a number, or {input.size(1)}, one a channel, got {fill_value}"
                )
            fill = torch.tensor(fill_value, dtype=torch.float64, device=input.device)
        mode, corners = self.padding_mode, self.align_corners
        return warped(input, matrix, height, width, resample, mode, corners, self.affine, fill)

    @torch.jit.unused
    def transform_mask(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return self._moved_mask(input, lambda mask, fill: self.sampled(mask, params, "nearest", fill))

    @torch.jit.unused
    def inverse_transform(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        back = inverse3x3(self.compute_transformation(params, shape))
        return self.warped_by(back, input, shape[2], shape[3], self.resample, self.fill_value)

    @torch.jit.unused
    def inverse_mask(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        back = inverse3x3(self.compute_transformation(params, shape))
        return self._moved_mask(
            input, lambda mask, fill: self.warped_by(back, mask, shape[2], shape[3], "nearest", fill)
        )

    @torch.jit.unused
    def _moved_mask(self, mask: Tensor, move: Callable[[Tensor, List[float]], Tensor]) -> Tensor:
        """A mask, moved by nearest sampling. A colour of images means nothing to a mask; a number does."""
        fill = self.fill_value[0] if self.padding_mode == "fill" and len(self.fill_value) == 1 else 0.0
        return moved_mask(mask, lambda values, outside: move(values, [outside]), fill)
