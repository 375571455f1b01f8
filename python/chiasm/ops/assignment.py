"""Linear assignment: pairs of rows and columns with the least total cost."""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_rank, check_tensor
from ..primitives.numbers.assignment import linear_sum_assignment


def linear_assignment(
    cost: Tensor,
    rows: Optional[Tensor] = None,
    columns: Optional[Tensor] = None,
    max_cost: Optional[float] = None,
) -> Tuple[Tensor, Tensor]:
    """Assign to each row a different column with the least sum of costs, like SciPy's
    ``linear_sum_assignment``.

    The algorithm is that of shortest augmenting paths: D. F. Crouse, On implementing 2D rectangular
    assignment algorithms, IEEE Transactions on Aerospace and Electronic Systems 52 (4), 2016; R. Jonker and
    A. Volgenant, Computing 38, 1987. It is exact except for rounding in float64, and deterministic: among
    paths of equal length, a path to a free column comes first, then the path to the lowest column. For each
    matrix it takes at most 2 N^2 steps, and each step reads N + M numbers.

    The result has the largest possible number of pairs and, among such assignments, the least cost. If a row
    or column has no possible partner, it stays unassigned; SciPy raises an error.

    Args:
        cost: (B, N, M), floating point; infinity or NaN for a forbidden pair.
        rows: (B, N), bool: the rows that take part; all by default.
        columns: (B, M), bool: the columns that take part; all by default.
        max_cost: pairs that cost more are forbidden.

    Returns:
        (B, N), int64, the column of each row, 0 for rows without one; and (B, N), bool, a mask of the rows
        that have a column.

    Raises:
        TypeError: if cost is not floating point, or rows or columns not bool.
        ValueError: if a shape is not as above.

    Example:
        >>> cost = torch.tensor([[[4.0, 1.0, 3.0], [2.0, 0.0, 5.0], [3.0, 2.0, 2.0]]])
        >>> linear_assignment(cost)
        (tensor([[1, 0, 2]]), tensor([[True, True, True]]))
        >>> linear_assignment(cost, max_cost=1.5)
        (tensor([[0, 1, 0]]), tensor([[False,  True, False]]))
    """
    check_rank(cost, 3, "(B, N, M)", "cost")
    check_floating(cost, "cost")
    batch, n, m = cost.size(0), cost.size(1), cost.size(2)
    values = cost.detach().to(torch.float64)
    can_be = values.abs() < float("inf")
    if max_cost is not None:
        can_be = can_be & (values <= max_cost)
    if rows is not None:
        check_mask(rows, batch, n, "rows")
        can_be = can_be & rows[:, :, None]
    if columns is not None:
        check_mask(columns, batch, m, "columns")
        can_be = can_be & columns[:, None]
    if n == 0 or m == 0:
        nothing = torch.zeros([batch, n], dtype=torch.int64, device=cost.device)
        return nothing, nothing > 0
    # Huge costs by a power of two, so that the cost of a row without a column is finite.
    size = torch.where(can_be, values.abs(), torch.zeros_like(values)).flatten(1).amax(1)[:, None, None]
    values = torch.where(size > 1e250, values * 2.0**-40, values)
    costs = torch.where(can_be, values, torch.full_like(values, float("inf")))
    return cheapest(costs, _cost_alone(values, can_be))


def cheapest(costs: Tensor, alone: Tensor) -> Tuple[Tensor, Tensor]:
    """The assignment of least cost if a row may also stay without a column.

    Args:
        costs: (B, N, M), float64: less than ``alone``, or infinite; N and M are not 0.
        alone: (B, 1), float64: the cost of a row without a column.

    Returns:
        As ``linear_assignment``.

    >>> cheapest(torch.tensor([[[0.4], [0.3]]]).double(), torch.tensor([[1.0]]).double())
    (tensor([[0, 0]]), tensor([[False,  True]]))
    """
    found = linear_sum_assignment(costs, alone)
    return found.clamp(min=0), found >= 0


def check_mask(mask: Tensor, batch: int, size: int, name: str) -> None:
    """Raise unless ``mask`` is a bool tensor (batch, size)."""
    check_tensor(mask, name)
    if mask.dtype != torch.bool:
        raise TypeError(f"{name}: expected dtype bool, got {mask.dtype}")
    if mask.dim() != 2 or mask.size(0) != batch or mask.size(1) != size:
        raise ValueError(f"{name}: expected shape [{batch}, {size}], got {list(mask.shape)}")


def _cost_alone(values: Tensor, can_be: Tensor) -> Tensor:
    """(B, 1): a cost for a row without a column that is so high that no exchange of other pairs compensates
    it."""
    nothing = torch.zeros_like(values)
    size = torch.where(can_be, values.abs(), nothing).flatten(1).amax(1, keepdim=True)
    scale = size[:, :, None]
    most = torch.where(can_be, values, -scale).flatten(1).amax(1, keepdim=True)
    least = torch.where(can_be, values, scale).flatten(1).amin(1, keepdim=True)
    spread = (most - least).clamp(min=0.0)
    return most + spread * (values.size(1) + 1) + torch.where(size > 0.0, size, torch.ones_like(size))
