"""Assignment: against SciPy, and against all assignments of small matrices."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np
import pytest
import torch
from scipy.optimize import linear_sum_assignment

from chiasm.ops import LinearAssignment, linear_assignment


def total(cost: np.ndarray, index: torch.Tensor, assigned: torch.Tensor) -> float:
    """The sum of the costs; checks that no column is assigned twice."""
    rows = np.flatnonzero(assigned.numpy())
    columns = index.numpy()[rows]
    assert len(set(columns.tolist())) == len(rows)
    assert not index[~assigned].any()
    return float(cost[rows, columns].sum())


@pytest.mark.parametrize("scripted", [False, True])
@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (7, 1), (12, 12), (9, 30), (30, 9), (40, 40)])
def test_scipy(shape: tuple[int, int], scripted: bool) -> None:
    call = torch.jit.script(linear_assignment) if scripted else linear_assignment
    costs = np.random.default_rng(sum(shape)).normal(size=(5, *shape))
    index, assigned = call(torch.from_numpy(costs))
    for cost, columns, has_one in zip(costs, index, assigned, strict=True):
        expected_rows, expected = linear_sum_assignment(cost)
        assert np.flatnonzero(has_one).tolist() == expected_rows.tolist()
        assert columns[has_one].tolist() == expected.tolist()


@pytest.mark.parametrize("seed", range(20))
def test_equal_costs(seed: int) -> None:
    """Integer costs, for which many assignments have the same sum."""
    random = np.random.default_rng(seed)
    cost = random.integers(-3, 4, random.integers(2, 25, 2)).astype(float)
    index, assigned = linear_assignment(torch.from_numpy(cost)[None])
    rows, columns = linear_sum_assignment(cost)
    assert int(assigned.sum()) == len(rows)
    assert total(cost, index[0], assigned[0]) == cost[rows, columns].sum()


def test_of_equals_the_lowest_column_comes_first() -> None:
    for n, m in [(4, 4), (3, 6), (6, 3)]:
        index, assigned = linear_assignment(torch.full((1, n, m), 2.5))
        pairs = min(n, m)
        assert index[0, :pairs].tolist() == list(range(pairs)) and assigned[0].tolist() == [
            i < pairs for i in range(n)
        ]


@pytest.mark.parametrize("seed", range(30))
def test_pairs_that_cannot_be(seed: int) -> None:
    """The result has as many pairs as possible at the lowest cost. The reference is a search of all
    assignments, and SciPy with impossible pairs that cost more than all others together."""
    random = np.random.default_rng(seed)
    n, m = random.integers(1, 5, 2)
    cost, cannot = random.normal(size=(n, m)), random.random((n, m)) < 0.6
    index, assigned = linear_assignment(
        torch.from_numpy(np.where(cannot, random.choice([np.inf, np.nan, -np.inf], (n, m)), cost))[None]
    )
    best = (0, 0.0)
    for columns in product(range(-1, m), repeat=int(n)):
        pairs = [(i, j) for i, j in enumerate(columns) if j >= 0]
        if len({j for _, j in pairs}) == len(pairs) and not any(cannot[pair] for pair in pairs):
            best = min(best, (-len(pairs), sum(cost[pair] for pair in pairs)))
    assert int(assigned.sum()) == -best[0]
    assert not cannot[assigned[0].numpy(), index[0][assigned[0]].numpy()].any()
    assert total(cost, index[0], assigned[0]) == pytest.approx(best[1], abs=1e-12)

    cost, cannot = random.random((20, 16)), random.random((20, 16)) < 0.85
    index, assigned = linear_assignment(torch.from_numpy(np.where(cannot, np.inf, cost))[None])
    rows, columns = linear_sum_assignment(np.where(cannot, 1e4, cost))
    kept = ~cannot[rows, columns]
    assert int(assigned.sum()) == kept.sum()
    expected = cost[rows[kept], columns[kept]].sum()
    assert total(cost, index[0], assigned[0]) == pytest.approx(expected, abs=1e-9)


def test_rows_and_columns_that_take_part() -> None:
    random = np.random.default_rng(0)
    cost, rows, columns = random.random((3, 9, 11)), random.random((3, 9)) < 0.7, random.random((3, 11)) < 0.6
    index, assigned = linear_assignment(*(torch.from_numpy(part) for part in (cost, rows, columns)))
    for b in range(3):
        i, j = linear_sum_assignment(cost[b][rows[b]][:, columns[b]])
        expected = np.stack([np.flatnonzero(rows[b])[i], np.flatnonzero(columns[b])[j]])
        found = np.flatnonzero(assigned[b])
        assert np.stack([found, index[b].numpy()[found]]).tolist() == expected.tolist()


def test_the_greatest_cost() -> None:
    cost = torch.tensor([[[0.8, 0.3], [0.5, 0.9]]])
    assert linear_assignment(cost, max_cost=0.5)[0].tolist() == [[1, 0]]
    index, assigned = LinearAssignment(max_cost=0.4)(cost)
    assert index.tolist() == [[1, 0]] and assigned.tolist() == [[True, False]]


def test_many_steps() -> None:
    """Costs for which each augmenting path visits all previous columns: R. E. Machol and M. Wien, A Hard
    Assignment Problem, Operations Research 24, 1976."""
    number = np.arange(1.0, 41.0)
    cost = np.outer(number, number)
    index, _ = linear_assignment(torch.from_numpy(cost)[None])
    assert index[0].tolist() == linear_sum_assignment(cost)[1].tolist() == list(range(39, -1, -1))


def test_huge_costs() -> None:
    """Each column is given once, also where the sum of all costs would be infinite."""
    index, assigned = linear_assignment(
        torch.tensor([[[1e308, torch.inf], [2.0, torch.inf]]], dtype=torch.float64)
    )
    assert index[0, 1] == 0 and assigned.tolist() == [[False, True]]
    index, assigned = linear_assignment(
        torch.tensor([[[1e308, -1e308], [-1e308, 1e308]]], dtype=torch.float64)
    )
    assert index.tolist() == [[1, 0]] and assigned.all()


def test_nothing_to_assign() -> None:
    for shape in [(2, 0, 3), (2, 3, 0), (0, 2, 2)]:
        index, assigned = linear_assignment(torch.zeros(shape))
        assert index.shape == assigned.shape == shape[:2] and not assigned.any()
    assert not linear_assignment(torch.full((1, 3, 2), torch.inf))[1].any()


X, R, C = torch.rand(1, 3, 4), torch.ones(1, 3, dtype=torch.bool), torch.ones(1, 4, dtype=torch.bool)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: linear_assignment(X[0]), ValueError, r"cost: expected shape \(B, N, M\)"),
        (lambda: linear_assignment(X.int()), TypeError, "cost: expected a floating-point"),
        (lambda: linear_assignment(X, C), ValueError, r"rows: expected shape \[1, 3\], got \[1, 4\]"),
        (lambda: linear_assignment(X, R, R), ValueError, r"columns: expected shape \[1, 4\]"),
        (lambda: linear_assignment(X, R.int()), TypeError, "rows: expected dtype bool"),
    ],
)
def test_errors(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
