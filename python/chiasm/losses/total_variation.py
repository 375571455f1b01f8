"""Total variation."""

import torch
from torch import Tensor

from ..primitives.core.checks import check_choice, check_tensor
from ..primitives.numbers.loss_reduction import narrowed, widened


def total_variation(img: Tensor, reduction: str = "sum") -> Tensor:
    """Anisotropic total variation: the sum of absolute differences of neighbours along rows and columns.

    L. Rudin, S. Osher, E. Fatemi, Nonlinear total variation based noise removal algorithms, Physica D 60,
    1992.

    Args:
        img: (*, H, W), floating point; integer dtypes are converted to float32.
        reduction: "sum", or "mean": the mean difference down the columns plus that along the rows, for which
            H and W are at least 2.

    Returns:
        (*), a number for each plane.

    Raises:
        TypeError: if img is no tensor.
        ValueError: if img has fewer than two dimensions or too few pixels, or reduction is unknown.

    Example:
        >>> total_variation(torch.tensor([[0.0, 1.0], [0.0, 3.0]]))
        tensor(6.)
    """
    check_tensor(img, "img")
    if not img.is_floating_point():
        img = img.to(torch.float32)
    check_choice(reduction, ["sum", "mean"], "reduction")
    if img.dim() < 2:
        raise ValueError(f"img: expected shape (*, H, W), got {list(img.shape)}")
    x = widened(img)
    vertical = (x[..., 1:, :] - x[..., :-1, :]).abs()
    horizontal = (x[..., 1:] - x[..., :-1]).abs()
    if reduction == "sum":
        return narrowed(vertical.sum([-2, -1]) + horizontal.sum([-2, -1]), img)
    if img.size(-2) < 2 or img.size(-1) < 2:
        raise ValueError(f"img: expected at least 2 x 2 pixels for a mean, got {list(img.shape)}")
    return narrowed(vertical.mean([-2, -1]) + horizontal.mean([-2, -1]), img)
