"""Random flips."""

from typing import Dict, List

import torch
from torch import Tensor

from ..primitives.random.draws import uniform
from ..primitives.resampling.flips import flip
from .base import GeometricAugmentationBase2D, check_batch, identity, select
from .decisions import below


def random_horizontal_flip(input: Tensor, seed: Tensor, p: float = 0.5) -> Tensor:
    """Flip some images horizontally (left to right).

    Args:
        input: (B, C, H, W), floating point or uint8.
        seed: (B,), int64.
        p: the probability of each image.

    Returns:
        (B, C, H, W). Differentiable in input.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape is not as above.

    Example:
        >>> random_horizontal_flip(torch.tensor([[[[1.0, 2.0]]]]), torch.tensor([0]), p=1.0)
        tensor([[[[2., 1.]]]])
    """
    check_batch(input, seed)
    return select({"batch_prob": below(uniform(seed, 1)[:, 0], p)}, flip(input, True, False), input)


def random_vertical_flip(input: Tensor, seed: Tensor, p: float = 0.5) -> Tensor:
    """Flip some images vertically (top to bottom).

    Args:
        input: (B, C, H, W), floating point or uint8.
        seed: (B,), int64.
        p: the probability of each image.

    Returns:
        (B, C, H, W). Differentiable in input.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape is not as above.

    Example:
        >>> random_vertical_flip(torch.tensor([[[[1.0], [2.0]]]]), torch.tensor([0]), p=1.0)
        tensor([[[[2.],
                  [1.]]]])
    """
    check_batch(input, seed)
    return select({"batch_prob": below(uniform(seed, 1)[:, 0], p)}, flip(input, False, True), input)


def _mirror(params: Dict[str, Tensor], size: int, axis: int) -> Tensor:
    """The homography that mirrors an axis of ``size`` pixels."""
    matrix = identity(params["batch_prob"], 3).clone()
    chosen = params["batch_prob"].to(torch.float64)
    matrix[:, axis, axis] = 1.0 - 2.0 * chosen
    matrix[:, axis, 2] = chosen * (size - 1)
    return matrix


class RandomHorizontalFlip(GeometricAugmentationBase2D):
    """``random_horizontal_flip`` as a module; see ``AugmentationBase`` for its arguments.

    Example:
        >>> RandomHorizontalFlip(p=1.0)(torch.tensor([[[[1.0, 2.0]]]]))
        tensor([[[[2., 1.]]]])
    """

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return select(params, flip(input, True, False), input)

    @torch.jit.unused
    def transform_mask(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return self.apply_transform(input, params)

    @torch.jit.unused
    def inverse_transform(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return self.apply_transform(input, params)

    def compute_transformation(self, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return _mirror(params, shape[3], 0)


class RandomVerticalFlip(GeometricAugmentationBase2D):
    """``random_vertical_flip`` as a module; see ``AugmentationBase`` for its arguments.

    Example:
        >>> augment = RandomVerticalFlip(p=1.0)
        >>> augment(torch.rand(2, 3, 8, 10)).shape
        torch.Size([2, 3, 8, 10])
        >>> augment.transform_matrix.shape
        torch.Size([2, 3, 3])
    """

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return select(params, flip(input, False, True), input)

    @torch.jit.unused
    def transform_mask(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return self.apply_transform(input, params)

    @torch.jit.unused
    def inverse_transform(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return self.apply_transform(input, params)

    def compute_transformation(self, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return _mirror(params, shape[2], 1)
