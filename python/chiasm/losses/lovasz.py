"""Surrogates of the Jaccard index (intersection over union) that are convex in the pixels' errors."""

from typing import Optional

import torch
from torch import Tensor

from ..primitives.core.checks import check_one_channel, check_tensor
from ..primitives.numbers.loss_reduction import narrowed, widened
from ..primitives.numbers.ranking import stable_topk
from .labels import check_prediction, class_planes, class_weights


def lovasz_hinge_loss(pred: Tensor, target: Tensor) -> Tensor:
    """Lovász extension of 1 - Jaccard index at the hinge errors max(0, 1 - s pred), s = 1 in the foreground
    and -1 elsewhere.

    M. Berman, A. R. Triki, M. B. Blaschko, The Lovász-softmax loss, CVPR 2018. The result is the mean over
    the images of a batch.

    Args:
        pred: (B, 1, H, W) logits of the foreground, floating point.
        target: (B, H, W), of any dtype: above 0 in the foreground.

    Returns:
        A scalar.

    Raises:
        TypeError: if pred is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> lovasz_hinge_loss(torch.tensor([[[[2.0, -2.0, 0.0]]]]), torch.tensor([[[1, 0, 1]]]))
        tensor(0.5000)
    """
    check_one_channel(pred, "pred")
    check_tensor(target, "target")
    if target.dim() != 3 or target.size(0) != pred.size(0) or target.shape[1:] != pred.shape[2:]:
        raise ValueError(
            f"target: expected shape (B, H, W) for pred {list(pred.shape)}, got {list(target.shape)}"
        )
    foreground = target.flatten(1) > 0
    logits = widened(pred).flatten(1)
    errors = torch.relu(1.0 - torch.where(foreground, logits, -logits))
    return narrowed(_extension(errors, foreground).mean(), pred)


def lovasz_softmax_loss(pred: Tensor, target: Tensor, weight: Optional[Tensor] = None) -> Tensor:
    """Lovász extension of 1 - Jaccard index for each class, at the errors \\|y - p\\| of the softmax p; the
    mean over classes and images.

    M. Berman, A. R. Triki, M. B. Blaschko, The Lovász-softmax loss, CVPR 2018, equation 10. A class that is
    not in an image also counts, with its largest error.

    Args:
        pred: (B, C, *) logits, floating point.
        target: (B, *) integer labels, 0 to C - 1.
        weight: (C,), factors of the classes' terms; ones by default. The mean still divides by C, as in
            Kornia.

    Returns:
        A scalar.

    Raises:
        TypeError: if pred is not floating point or target not of integers.
        ValueError: if a shape is not as above.

    Example:
        >>> lovasz_softmax_loss(torch.zeros(1, 2, 2), torch.tensor([[0, 1]]))
        tensor(0.5000)
    """
    check_prediction(pred, target, 3)
    logits = widened(pred)
    weights = class_weights(weight, logits, "weight")
    probability = torch.softmax(logits, 1).flatten(2)
    own = class_planes(target.flatten(1), pred.size(1))
    losses = _extension(torch.where(own, 1.0 - probability, probability), own)
    return narrowed((losses * weights).mean(), pred)


def _extension(errors: Tensor, foreground: Tensor) -> Tensor:
    """The extension along the last axis: (*, N) errors >= 0 to (*).

    It is a weighted sum of errors. The weights depend only on the order of the errors: a weight is the growth
    of 1 - Jaccard index if one more pixel is wrong, beginning with the largest error. The order has no
    gradient, so only the sum is differentiated.
    """
    weights = _growth(errors.detach(), foreground).to(errors.dtype)
    return (errors * weights).sum(-1)


def _growth(errors: Tensor, foreground: Tensor) -> Tensor:
    count = errors.size(-1)
    order = stable_topk(errors, count)[1]
    ranked = foreground.to(torch.float64).gather(-1, order)
    found = ranked.cumsum(-1)
    position = torch.arange(count, device=errors.device).to(torch.float64) + 1.0
    intersection = found[..., count - 1 :] - found
    union = found[..., count - 1 :] + (position - found)
    # Differences of successive indices in closed form: a subtraction would lose all digits for large images.
    # In an image without foreground, the first pixel has the whole weight.
    missed = torch.where(
        union > 1.0, intersection / (union * (union - 1.0).clamp(min=1.0)), torch.ones_like(union)
    )
    growth = torch.where(ranked > 0, 1.0 / union, missed)
    return torch.zeros_like(growth).scatter(-1, order, growth)
