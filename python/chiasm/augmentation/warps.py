"""Shared by random warps: a matrix for each sample, and the sampling of images by these matrices."""

from typing import Any, Dict, List

import torch
from torch import Tensor

from ..primitives.linalg.matrices import inverse3x3
from ..primitives.resampling.warping import check_source, sample_affine, sample_projective
from .annotations import moved_mask
from .base import GeometricAugmentationBase2D, as_mode, identity


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
) -> Tensor:
    """The images, warped to (B, C, height, width) by homographies (B, 3, 3), float64, from input to
    output."""
    check_source(input, resample, padding_mode, "input")
    inverse = inverse3x3(matrix)
    if affine:
        return sample_affine(
            input, inverse[:, :2], height, width, resample, padding_mode, align_corners, None
        )
    return sample_projective(input, inverse, height, width, resample, padding_mode, align_corners, None)


def middle(like: Tensor, height: int, width: int) -> Tensor:
    """The centres (B, 2), float64, of B images, where B is the batch size of ``like``."""
    one = torch.ones_like(like, dtype=torch.float64)
    return torch.stack([one * ((width - 1) * 0.5), one * ((height - 1) * 0.5)], -1)


class Warp(GeometricAugmentationBase2D):
    """A geometric augmentation that samples images by the matrices of ``compute_transformation``.

    Args:
        resample: "bilinear", "nearest" or "bicubic".
        padding_mode: the values outside the image: "zeros", "border" or "reflection".
        align_corners: True: "reflection" mirrors at the centres of the border pixels; False: at the image's
            outer edges.
        affine: whether the matrices' last row is (0, 0, 1).
        p, same_on_batch, keepdim: as in ``AugmentationBase``.
    """

    def __init__(
        self,
        resample: Any,
        padding_mode: str,
        align_corners: bool,
        p: float,
        same_on_batch: bool,
        keepdim: bool,
        affine: bool = True,
    ) -> None:
        super().__init__(p, 1.0, same_on_batch, keepdim)
        self.resample, self.padding_mode = as_mode(resample), padding_mode
        self.align_corners, self.affine = align_corners, affine

    def output_size(self, shape: List[int]) -> List[int]:
        """Height and width of the result."""
        return shape[2:4]

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return self.sampled(input, params, self.resample)

    def sampled(self, input: Tensor, params: Dict[str, Tensor], resample: str) -> Tensor:
        """The images, sampled with the given interpolation."""
        shape = list(input.shape)
        height, width = self.output_size(shape)
        matrix = self.compute_transformation(params, shape)
        return warped(
            input, matrix, height, width, resample, self.padding_mode, self.align_corners, self.affine
        )

    @torch.jit.unused
    def transform_mask(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return moved_mask(input, lambda values: self.sampled(values, params, "nearest"))

    @torch.jit.unused
    def inverse_transform(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return self._sampled_back(input, params, shape, self.resample)

    @torch.jit.unused
    def inverse_mask(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return moved_mask(input, lambda values: self._sampled_back(values, params, shape, "nearest"))

    @torch.jit.unused
    def _sampled_back(
        self, input: Tensor, params: Dict[str, Tensor], shape: List[int], resample: str
    ) -> Tensor:
        back = inverse3x3(self.compute_transformation(params, shape))
        padding, corners = self.padding_mode, self.align_corners
        return warped(input, back, shape[2], shape[3], resample, padding, corners, self.affine)
