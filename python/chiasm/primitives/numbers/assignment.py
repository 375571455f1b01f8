"""Linear assignment by shortest augmenting paths."""

import torch
from torch import Tensor

from ..core.loops import until_stable
from ..core.lowering import primitive
from ..kernels import operators as kernels


@primitive
def linear_sum_assignment(costs: Tensor, alone: Tensor) -> Tensor:
    """(B, N), int64: the column of each row in an assignment with the least sum of costs, -1 for none.

    A row may stay without a column. See ``ops.linear_assignment`` for the algorithm and the choice between
    equals.

    Args:
        costs: (B, N, M), float64: less than ``alone``, or infinite; N and M are not 0.
        alone: (B, 1), float64: the cost of a row without a column.

    >>> linear_sum_assignment(torch.tensor([[[0.4], [0.3]]]).double(), torch.tensor([[1.0]]).double())
    tensor([[-1,  0]])
    """
    n = costs.size(1)
    rows = torch.arange(n, dtype=torch.float64, device=costs.device)
    columns = torch.arange(costs.size(2), dtype=torch.float64, device=costs.device)
    state = _augmented(_greedy(costs, alone, rows, columns), 2 * n * n, costs, alone, rows, columns)
    return state[:, 1, :n].clamp(min=-1.0).to(torch.int64)


linear_sum_assignment.lowering("native", when=kernels.has_kernel)(kernels.linear_sum_assignment)


def _greedy(costs: Tensor, alone: Tensor, rows: Tensor, columns: Tensor) -> Tensor:
    """The initial state: each row has its cheapest column unless an earlier row has the same one; rows
    without a possible column are left alone.

    A state is (B, 7, N + M), float64, first for the rows, then for the columns. For both: the dual values (0)
    and the assignment (1), which is a column or row, -1 for none, -2 for rows left alone. For columns: the
    length of the shortest path to the column (2), the row before it on this path (3), and 1 if the path is
    final (4). The row part holds scalars, repeated N times: the current row, -1 between paths (2); the length
    of the path to it (3); the length of the shortest path to a row that would be left alone (4), and this row
    (5); and the column that gets another row, -1 if there is none (6).
    """
    least = costs.amin(2)
    has_any = least < float("inf")
    dual = torch.where(has_any, least, alone)
    best = (costs == dual[:, :, None]).to(torch.float64).argmax(2)
    wanted = (columns == best[:, :, None]) & has_any[:, :, None]
    given = wanted & (wanted.to(torch.int64).cumsum(1) == 1)
    no, zero, far = torch.full_like(dual, -1.0), torch.zeros_like(dual), torch.full_like(dual, float("inf"))
    match = torch.where(given.any(2), best.to(torch.float64), torch.where(has_any, no, 2.0 * no))
    owner = torch.where(given, rows[:, None], -torch.ones_like(costs)).amax(1)
    free, nothing = torch.full_like(owner, -1.0), torch.zeros_like(owner)
    unknown = torch.full_like(owner, float("inf"))
    of_rows = torch.stack([dual, match, no, zero, far, no, no], 1)
    of_columns = torch.stack([nothing, owner, unknown, free, nothing, nothing, nothing], 1)
    return torch.cat([of_rows, of_columns], 2)


@until_stable
def _augmented(
    state: Tensor, k: Tensor, costs: Tensor, alone: Tensor, rows: Tensor, columns: Tensor
) -> Tensor:
    """The state after one more row is processed, or one more column of a found path has its new row. The
    numbers of rows and columns are arguments: if the loop asked for the size of the costs, tracing could turn
    this into a stride, which ONNX does not have.
    """
    n = rows.size(0)
    dual, match, nows, reacheds, leavings, leavers, givings = state[:, :, :n].unbind(1)
    price, owner, length, before, final, unused, _ = state[:, :, n:].unbind(1)
    now, reached, leaving = nows[:, :1], reacheds[:, :1], leavings[:, :1]
    leaver, giving = leavers[:, :1], givings[:, :1]
    minus_one, infinite = torch.full_like(now, -1.0), torch.full_like(length, float("inf"))

    # A path begins at the first row that is not assigned yet.
    waits = (match == -1.0).to(torch.float64)
    root = waits.argmax(1, keepdim=True).to(torch.float64)
    looks = (giving < 0.0) & (waits.amax(1, keepdim=True) > 0.0)
    row = torch.where(now < 0.0, root, now)

    # Paths through the row, to columns and to being alone
    index = row.to(torch.int64)
    own = dual.gather(1, index)
    place = index + torch.zeros_like(price).to(torch.int64)
    through = reached + (costs.gather(1, place[:, None])[:, 0] - own - price)
    is_final = final > 0.0
    shorter = looks & (through < length) & ~is_final
    lengths = torch.where(shorter, through, length)
    befores = torch.where(shorter, row, before)
    alone_here = reached + (alone - own)
    leaves_here = looks & (alone_here < leaving)
    leaving = torch.where(leaves_here, alone_here, leaving)
    leaver = torch.where(leaves_here, row, leaver)

    # The nearest column; a free column comes before others
    open = torch.where(is_final, infinite, lengths)
    nearest = open.amin(1, keepdim=True)
    preference = torch.where(owner < 0.0, torch.full_like(owner, 2.0), torch.ones_like(owner))
    preference = torch.where(open == nearest, preference, torch.zeros_like(owner))
    column = preference.argmax(1, keepdim=True)
    owners = owner.gather(1, column)
    gives_up = leaving < nearest
    ends = looks & (gives_up | (owners < 0.0))
    goes_on = looks & ~ends

    # At the end of a path all dual values change, so that its pairs have reduced cost zero.
    total = torch.minimum(leaving, nearest)
    matched = match.clamp(min=0.0).to(torch.int64)
    in_tree = (match >= 0.0) & (final.gather(1, matched) > 0.0)
    nothing = torch.zeros_like(dual)
    rise = torch.where(in_tree, total - lengths.gather(1, matched), nothing)
    rise = torch.where(rows == root, total, rise)
    duals = torch.where(ends, dual + rise, dual)
    prices = torch.where(ends & is_final, price - (total - lengths), price)

    # A row that is left alone releases its column; a found column gets its row, and the old column of this
    # row is next.
    left = ends & gives_up & (rows == leaver)
    old = match.gather(1, leaver.clamp(min=0.0).to(torch.int64))
    giving = torch.where(ends, torch.where(gives_up, minus_one, column.to(torch.float64)), giving)
    matches = torch.where(left, torch.full_like(match, -2.0), match)
    gives = giving >= 0.0
    getter = befores.gather(1, giving.clamp(min=0.0).to(torch.int64))
    following = matches.gather(1, getter.clamp(min=0.0).to(torch.int64))
    owners_after = torch.where(gives & (columns == giving), getter, owner)
    matches = torch.where(gives & (rows == getter), giving, matches)
    giving = torch.where(gives, following, torch.where(ends & gives_up, old, giving))

    here = goes_on & (columns == column)
    final = torch.where(ends, torch.zeros_like(final), torch.where(here, torch.ones_like(final), final))
    now = torch.where(goes_on, owners, torch.where(ends, minus_one, now))
    reached = torch.where(goes_on, nearest, torch.where(ends, torch.zeros_like(reached), reached))
    leaving = torch.where(ends, infinite[:, :1], leaving)
    of_rows = [duals, matches] + [v.expand_as(dual) for v in [now, reached, leaving, leaver, giving]]
    of_columns = [prices, owners_after, torch.where(ends, infinite, lengths), befores, final, unused, unused]
    return torch.cat([torch.stack(of_rows, 1), torch.stack(of_columns, 1)], 2)
