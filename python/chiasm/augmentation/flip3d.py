"""Random flips of volumes."""

from typing import Dict, List

import torch
from torch import Tensor

from ..primitives.random.draws import check_seed, uniform
from ..primitives.resampling.flips import flip
from ..primitives.resampling.volumes import check_voxels
from .base import AugmentationBase3D, identity, select
from .decisions import below


def random_horizontal_flip3d(input: Tensor, seed: Tensor, p: float = 0.5) -> Tensor:
    """Flip some volumes horizontally (left to right).

    Args:
        input: (B, C, D, H, W), floating point or uint8.
        seed: (B,), int64.
        p: the probability of each volume.

    Returns:
        (B, C, D, H, W). Differentiable in input.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape is not as above.

    Example:
        >>> random_horizontal_flip3d(torch.tensor([[[[[1.0, 2.0]]]]]), torch.tensor([0]), p=1.0)
        tensor([[[[[2., 1.]]]]])
    """
    return _flipped(input, seed, 0, p)


def random_vertical_flip3d(input: Tensor, seed: Tensor, p: float = 0.5) -> Tensor:
    """Flip some volumes vertically (top to bottom).

    Args:
        input: (B, C, D, H, W), floating point or uint8.
        seed: (B,), int64.
        p: the probability of each volume.

    Returns:
        (B, C, D, H, W). Differentiable in input.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape is not as above.

    Example:
        >>> x = torch.tensor([1.0, 2.0]).reshape(1, 1, 1, 2, 1)
        >>> random_vertical_flip3d(x, torch.tensor([0]), p=1.0).flatten()
        tensor([2., 1.])
    """
    return _flipped(input, seed, 1, p)


def random_depthical_flip3d(input: Tensor, seed: Tensor, p: float = 0.5) -> Tensor:
    """Flip some volumes along the depth (front to back).

    Args:
        input: (B, C, D, H, W), floating point or uint8.
        seed: (B,), int64.
        p: the probability of each volume.

    Returns:
        (B, C, D, H, W). Differentiable in input.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape is not as above.

    Example:
        >>> x = torch.tensor([1.0, 2.0]).reshape(1, 1, 2, 1, 1)
        >>> random_depthical_flip3d(x, torch.tensor([0]), p=1.0).flatten()
        tensor([2., 1.])
    """
    return _flipped(input, seed, 2, p)


def _flipped(input: Tensor, seed: Tensor, axis: int, p: float) -> Tensor:
    check_voxels(input, "input")
    check_seed(seed, input.size(0))
    return select({"batch_prob": below(uniform(seed, 1)[:, 0], p)}, _mirrored(input, axis), input)


def _mirrored(input: Tensor, axis: int) -> Tensor:
    """The volume, reversed along axis x, y or z (0, 1, 2)."""
    return input.flip([2]) if axis == 2 else flip(input, axis == 0, axis == 1)


class Flip3D(AugmentationBase3D):
    """A random flip along one axis, x, y or z (0, 1, 2)."""

    def __init__(self, axis: int, same_on_batch: bool, p: float, keepdim: bool) -> None:
        super().__init__(p, 1.0, same_on_batch, keepdim)
        self.axis = axis

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return select(params, _mirrored(input, self.axis), input)

    @torch.jit.unused
    def transform_mask(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return self.apply_transform(input, params)

    @torch.jit.unused
    def inverse_transform(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return self.apply_transform(input, params)

    def compute_transformation(self, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        matrix = identity(params["batch_prob"], 4).clone()
        chosen = params["batch_prob"].to(torch.float64)
        matrix[:, self.axis, self.axis] = 1.0 - 2.0 * chosen
        matrix[:, self.axis, 3] = chosen * (shape[4 - self.axis] - 1)
        return matrix


class RandomHorizontalFlip3D(Flip3D):
    """``random_horizontal_flip3d`` as a module.

    Args:
        same_on_batch, p, keepdim: as in ``AugmentationBase``.

    Example:
        >>> RandomHorizontalFlip3D(p=1.0)(torch.tensor([[[[[1.0, 2.0]]]]]))
        tensor([[[[[2., 1.]]]]])
    """

    def __init__(self, same_on_batch: bool = False, p: float = 0.5, keepdim: bool = False) -> None:
        super().__init__(0, same_on_batch, p, keepdim)


class RandomVerticalFlip3D(Flip3D):
    """``random_vertical_flip3d`` as a module.

    Args:
        same_on_batch, p, keepdim: as in ``AugmentationBase``.

    Example:
        >>> augment = RandomVerticalFlip3D(p=1.0)
        >>> augment(torch.rand(2, 3, 4, 5, 6)).shape
        torch.Size([2, 3, 4, 5, 6])
        >>> augment.transform_matrix.shape
        torch.Size([2, 4, 4])
    """

    def __init__(self, same_on_batch: bool = False, p: float = 0.5, keepdim: bool = False) -> None:
        super().__init__(1, same_on_batch, p, keepdim)


class RandomDepthicalFlip3D(Flip3D):
    """``random_depthical_flip3d`` as a module.

    Args:
        same_on_batch, p, keepdim: as in ``AugmentationBase``.

    Example:
        >>> RandomDepthicalFlip3D(p=1.0)(torch.tensor([1.0, 2.0]).reshape(1, 1, 2, 1, 1)).flatten()
        tensor([2., 1.])
    """

    def __init__(self, same_on_batch: bool = False, p: float = 0.5, keepdim: bool = False) -> None:
        super().__init__(2, same_on_batch, p, keepdim)
