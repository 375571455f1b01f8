"""Mutual information of images."""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_tensor
from .joint_histogram import entropies


def mutual_information_loss(
    input: Tensor,
    target: Tensor,
    input_mask: Optional[Tensor] = None,
    target_mask: Optional[Tensor] = None,
    kernel_function: str = "xu",
    num_bins: int = 64,
    window_radius: float = 1.0,
) -> Tensor:
    """Negative mutual information of two signals: -(H(input) + H(target) - H(input, target)), in nats.

    W. M. Wells et al., Multi-modal volume registration by maximization of mutual information, 1996; the
    entropies H by a joint histogram as in R. Xu et al., Parzen-window based normalized mutual information for
    medical image registration, IEICE 2008. The first bin is at the least value, the last at the greatest.
    Each value is split between the bins within window_radius, by a kernel of the distance d over the radius
    (in bins):

    * "xu": the paper's polynomial, 1 - 0.1 d - 1.8 d^2 up to 1/2, above it 1.9 - 3.7 d + 1.8 d^2; for a
      radius of 1 the shares sum to 1;
    * "rectangular": 1;
    * "truncated_gaussian": exp(-d^2 / 2) of the distance in bins.

    Args:
        input: (*, N), floating point.
        target: like input.
        input_mask: bool, like input: the values to use; all by default.
        target_mask: the same for target; a pair is used if both values are.
        kernel_function: "xu", "rectangular" (whose gradient is zero) or "truncated_gaussian".
        num_bins: number of bins, at least 2.
        window_radius: radius of the kernel in bins; more than 0.5.

    Returns:
        (*), a number for each signal; 0 where one is constant.

    Raises:
        TypeError: if input or target is not floating point, or a mask not bool.
        ValueError: if a shape or choice is not as above.

    Example:
        >>> x = torch.tensor([0.0, 1.0, 0.0, 1.0])
        >>> (
        ...     mutual_information_loss(x, x, num_bins=2),
        ...     mutual_information_loss(x, torch.tensor([0.0, 0.0, 1.0, 1.0]), num_bins=2),
        ... )
        (tensor(-0.6931), tensor(0.))
    """
    first, second, joint = entropies(
        input, target, input_mask, target_mask, kernel_function, num_bins, window_radius
    )
    return (joint - first - second).to(input.dtype)


def mutual_information_loss_2d(
    input: Tensor,
    target: Tensor,
    input_mask: Optional[Tensor] = None,
    target_mask: Optional[Tensor] = None,
    kernel_function: str = "xu",
    num_bins: int = 64,
    window_radius: float = 1.0,
) -> Tensor:
    """``mutual_information_loss`` for the planes of images.

    Args:
        input: (*, H, W), floating point.
        target: like input.
        input_mask: bool, like input: the pixels to use; all by default.
        target_mask: the same for target; a pixel is used if both masks are True.
        kernel_function: "xu", "rectangular" or "truncated_gaussian".
        num_bins: number of bins, at least 2.
        window_radius: radius of the kernel in bins; more than 0.5.

    Returns:
        (*), a number for each plane.

    Raises:
        TypeError: if input or target is not floating point, or a mask not bool.
        ValueError: if a shape or choice is not as above.

    Example:
        >>> x = torch.tensor([[0.0, 1.0], [0.0, 1.0]])
        >>> mutual_information_loss_2d(x, 5.0 - x, num_bins=2)
        tensor(-0.6931)
    """
    masks = _flat_masks(input_mask, target_mask, 2)
    return mutual_information_loss(
        _flat(input, 2, "input"),
        _flat(target, 2, "target"),
        masks[0],
        masks[1],
        kernel_function,
        num_bins,
        window_radius,
    )


def mutual_information_loss_3d(
    input: Tensor,
    target: Tensor,
    input_mask: Optional[Tensor] = None,
    target_mask: Optional[Tensor] = None,
    kernel_function: str = "xu",
    num_bins: int = 64,
    window_radius: float = 1.0,
) -> Tensor:
    """``mutual_information_loss`` for volumes.

    Args:
        input: (*, D, H, W), floating point.
        target: like input.
        input_mask: bool, like input: the voxels to use; all by default.
        target_mask: the same for target; a voxel is used if both masks are True.
        kernel_function: "xu", "rectangular" or "truncated_gaussian".
        num_bins: number of bins, at least 2.
        window_radius: radius of the kernel in bins; more than 0.5.

    Returns:
        (*), a number for each volume.

    Raises:
        TypeError: if input or target is not floating point, or a mask not bool.
        ValueError: if a shape or choice is not as above.

    Example:
        >>> x = torch.tensor([[[0.0, 1.0], [0.0, 1.0]]])
        >>> mutual_information_loss_3d(x, 5.0 - x, num_bins=2)
        tensor(-0.6931)
    """
    masks = _flat_masks(input_mask, target_mask, 3)
    return mutual_information_loss(
        _flat(input, 3, "input"),
        _flat(target, 3, "target"),
        masks[0],
        masks[1],
        kernel_function,
        num_bins,
        window_radius,
    )


def normalized_mutual_information_loss(
    input: Tensor,
    target: Tensor,
    input_mask: Optional[Tensor] = None,
    target_mask: Optional[Tensor] = None,
    kernel_function: str = "xu",
    num_bins: int = 64,
    window_radius: float = 1.0,
) -> Tensor:
    """Negative normalized mutual information, -(H(input) + H(target)) / H(input, target). It is from -1
    (independent) to -2 (one signal determines the other).

    C. Studholme, D. L. G. Hill, D. J. Hawkes, An overlap invariant entropy measure of 3D medical image
    alignment, Pattern Recognition 32,
    1999. The entropies are those of ``mutual_information_loss``.

    Args:
        input: (*, N), floating point.
        target: like input.
        input_mask: bool, like input: the values to use; all by default.
        target_mask: the same for target; a pair is used if both values are.
        kernel_function: "xu", "rectangular" or "truncated_gaussian".
        num_bins: number of bins, at least 2.
        window_radius: radius of the kernel in bins; more than 0.5.

    Returns:
        (*), a number for each signal; -1 where both are constant.

    Raises:
        TypeError: if input or target is not floating point, or a mask not bool.
        ValueError: if a shape or choice is not as above.

    Example:
        >>> x = torch.tensor([0.0, 1.0, 0.0, 1.0])
        >>> normalized_mutual_information_loss(x, x, num_bins=2)
        tensor(-2.)
    """
    first, second, joint = entropies(
        input, target, input_mask, target_mask, kernel_function, num_bins, window_radius
    )
    known = joint <= 0
    ratio = (first + second) / torch.where(known, torch.ones_like(joint), joint)
    return -torch.where(known, torch.ones_like(joint), ratio).to(input.dtype)


def normalized_mutual_information_loss_2d(
    input: Tensor,
    target: Tensor,
    input_mask: Optional[Tensor] = None,
    target_mask: Optional[Tensor] = None,
    kernel_function: str = "xu",
    num_bins: int = 64,
    window_radius: float = 1.0,
) -> Tensor:
    """``normalized_mutual_information_loss`` for the planes of images.

    Args:
        input: (*, H, W), floating point.
        target: like input.
        input_mask: bool, like input: the pixels to use; all by default.
        target_mask: the same for target; a pixel is used if both masks are True.
        kernel_function: "xu", "rectangular" or "truncated_gaussian".
        num_bins: number of bins, at least 2.
        window_radius: radius of the kernel in bins; more than 0.5.

    Returns:
        (*), a number for each plane.

    Raises:
        TypeError: if input or target is not floating point, or a mask not bool.
        ValueError: if a shape or choice is not as above.

    Example:
        >>> x = torch.tensor([[0.0, 1.0], [0.0, 1.0]])
        >>> normalized_mutual_information_loss_2d(x, 5.0 - x, num_bins=2)
        tensor(-2.)
    """
    masks = _flat_masks(input_mask, target_mask, 2)
    return normalized_mutual_information_loss(
        _flat(input, 2, "input"),
        _flat(target, 2, "target"),
        masks[0],
        masks[1],
        kernel_function,
        num_bins,
        window_radius,
    )


def normalized_mutual_information_loss_3d(
    input: Tensor,
    target: Tensor,
    input_mask: Optional[Tensor] = None,
    target_mask: Optional[Tensor] = None,
    kernel_function: str = "xu",
    num_bins: int = 64,
    window_radius: float = 1.0,
) -> Tensor:
    """``normalized_mutual_information_loss`` for volumes.

    Args:
        input: (*, D, H, W), floating point.
        target: like input.
        input_mask: bool, like input: the voxels to use; all by default.
        target_mask: the same for target; a voxel is used if both masks are True.
        kernel_function: "xu", "rectangular" or "truncated_gaussian".
        num_bins: number of bins, at least 2.
        window_radius: radius of the kernel in bins; more than 0.5.

    Returns:
        (*), a number for each volume.

    Raises:
        TypeError: if input or target is not floating point, or a mask not bool.
        ValueError: if a shape or choice is not as above.

    Example:
        >>> x = torch.tensor([[[0.0, 1.0], [0.0, 1.0]]])
        >>> normalized_mutual_information_loss_3d(x, 5.0 - x, num_bins=2)
        tensor(-2.)
    """
    masks = _flat_masks(input_mask, target_mask, 3)
    return normalized_mutual_information_loss(
        _flat(input, 3, "input"),
        _flat(target, 3, "target"),
        masks[0],
        masks[1],
        kernel_function,
        num_bins,
        window_radius,
    )


def _flat(x: Tensor, dims: int, name: str) -> Tensor:
    check_tensor(x, name)
    if x.dim() < dims:
        raise ValueError(f"{name}: expected at least {dims} dimensions, got {list(x.shape)}")
    return x.flatten(-dims)


def _flat_masks(
    input_mask: Optional[Tensor], target_mask: Optional[Tensor], dims: int
) -> Tuple[Optional[Tensor], Optional[Tensor]]:
    first, second = input_mask, target_mask
    if first is not None:
        first = _flat(first, dims, "input_mask")
    if second is not None:
        second = _flat(second, dims, "target_mask")
    return first, second
