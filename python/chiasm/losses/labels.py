"""Labels of classes as masks."""

from typing import Optional

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_tensor


def one_hot(
    labels: Tensor,
    num_classes: int,
    device: Optional[torch.device] = None,
    dtype: torch.dtype = torch.float32,
    eps: float = 0.0,
) -> Tensor:
    """One-hot encoding: a plane for each class with 1 + eps where the label is this class, eps elsewhere.

    Args:
        labels: (B, *), integers from 0 to num_classes - 1; other labels are in no plane.
        num_classes: C.
        device: the device of the result, by default that of labels.
        dtype: the dtype of the result.
        eps: added everywhere.

    Returns:
        (B, C, *).

    Raises:
        TypeError: if labels are not integers.
        ValueError: if labels is a scalar, or num_classes not positive.

    Example:
        >>> one_hot(torch.tensor([[2, 0]]), 3)
        tensor([[[0., 1.],
                 [0., 0.],
                 [1., 0.]]])
    """
    check_tensor(labels, "labels")
    if labels.dim() < 1:
        raise ValueError("labels: expected shape (B, *), got a scalar")
    if num_classes < 1:
        raise ValueError(f"num_classes: expected a positive number, got {num_classes}")
    check_labels(labels, "labels")
    planes = class_planes(labels, num_classes).to(dtype) + eps
    return planes if device is None else planes.to(device)


def class_planes(labels: Tensor, num_classes: int) -> Tensor:
    """Masks of the classes, bool (B, C, *), of labels (B, *). A comparison accepts labels out of range,
    unlike an index, and has no gradient to scatter.
    """
    classes = torch.arange(num_classes, device=labels.device)
    return labels.to(torch.int64)[:, None] == classes.reshape([-1] + [1] * (labels.dim() - 1))


def check_labels(value: Tensor, name: str) -> None:
    """Raise TypeError unless ``value`` are integers."""
    check_tensor(value, name)
    if value.is_floating_point() or value.dtype == torch.bool or value.is_complex():
        raise TypeError(f"{name}: expected integer labels, got dtype {value.dtype}")


def check_prediction(pred: Tensor, target: Tensor, least: int) -> None:
    """Raise unless pred is floating point (B, C, *) of ``least`` dimensions at the least, and target integers
    (B, *)."""
    check_floating(pred, "pred")
    if pred.dim() < least:
        raise ValueError(
            f"pred: expected shape (B, C, *) of {least} dimensions or more, got {list(pred.shape)}"
        )
    check_labels(target, "target")
    if target.dim() != pred.dim() - 1 or target.size(0) != pred.size(0) or target.shape[1:] != pred.shape[2:]:
        raise ValueError(
            f"target: expected shape (B, *) for pred (B, C, *) {list(pred.shape)}, got {list(target.shape)}"
        )


def class_weights(weight: Optional[Tensor], pred: Tensor, name: str) -> Tensor:
    """The classes' weights in pred's dtype, ones by default; raise ValueError unless they are (C,)."""
    if weight is None:
        return torch.ones([pred.size(1)], dtype=pred.dtype, device=pred.device)
    check_tensor(weight, name)
    while weight.dim() > 1 and weight.size(-1) == 1:
        weight = weight.squeeze(-1)  # (C, 1, 1), as PyTorch's own losses take them
    if weight.dim() != 1 or weight.size(0) != pred.size(1):
        raise ValueError(
            f"{name}: expected shape ({pred.size(1)},), one number for each class, got {list(weight.shape)}"
        )
    return weight.to(pred.dtype)
