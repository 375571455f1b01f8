"""A fixed number of slots for candidates whose number depends on data.

A loop can take candidates one after the other, the highest score first. The state of such a loop is one
tensor (B, N + 2 K), float64: the scores of N candidates, minus infinity for those no longer available; and
for each of K slots the number of its candidate, -1 if it is empty, and the score.
"""

from typing import Tuple

import torch
from torch import Tensor


def chosen_first(values: Tensor, chosen: Tensor, slots: int, empty: int) -> Tensor:
    """(B, slots), int64: the chosen ones of values (B, N), at most ``slots``, in their order, and ``empty``
    in unused slots.

    >>> chosen_first(torch.tensor([[7, 8, 9]]), torch.tensor([[True, False, True]]), 4, 0)
    tensor([[7, 9, 0, 0]])
    """
    # A chosen value goes to its slot, all others to an extra slot, which is cut off.
    count = chosen.to(torch.int64).cumsum(1)
    slot = torch.where(chosen, count - 1, torch.full_like(count, slots))
    room = torch.full([values.size(0), slots + 1], empty, dtype=torch.int64, device=values.device)
    return room.scatter(1, slot, values)[:, :slots]


def empty_slots(scores: Tensor, slots: int, threshold: float) -> Tensor:
    """The first state: candidates whose scores (B, N) are NaN or not above the threshold are not available.

    >>> empty_slots(torch.tensor([[0.5, 0.1]]), 1, 0.2)
    tensor([[ 0.5000,    -inf, -1.0000,  0.0000]], dtype=torch.float64)
    """
    values = above_or_nothing(scores.detach().to(torch.float64), threshold)
    index = torch.full([scores.size(0), slots], -1.0, dtype=torch.float64, device=scores.device)
    return torch.cat([values, index, torch.zeros_like(index)], 1)


def above_or_nothing(values: Tensor, threshold: float) -> Tensor:
    """The values above the threshold, and minus infinity in place of the others.

    >>> above_or_nothing(torch.tensor([1.0, 3.0, torch.nan]), 2.0)
    tensor([-inf, 3., -inf])
    """
    return torch.where(values > threshold, values, torch.full_like(values, float("-inf")))


def highest(state: Tensor, count: int) -> Tuple[Tensor, Tensor]:
    """The next of ``count`` candidates, (B, 1), int64, the first among equals, and its score, (B, 1)."""
    values = state[:, :count]
    best = values.argmax(1, keepdim=True)
    return best, values.gather(1, best)


def taken(state: Tensor, values: Tensor, best: Tensor, score: Tensor, k: Tensor, slots: int) -> Tensor:
    """The state with the candidate ``best`` in slot k, and the other candidates' scores replaced by
    ``values`` (B, N). Nothing changes if the score shows that no candidate is left."""
    count = values.size(1)
    is_there = score > float("-inf")
    place = torch.arange(count, device=state.device)
    rest = torch.where(place == best, torch.full_like(values, float("-inf")), values)
    here = torch.arange(slots, device=state.device) == k
    index = torch.where(here, best.to(state.dtype), state[:, count : count + slots])
    scores = torch.where(here, score, state[:, count + slots :])
    return torch.where(is_there, torch.cat([rest, index, scores], 1), state)


def filled_slots(state: Tensor, count: int, slots: int) -> Tuple[Tensor, Tensor]:
    """The numbers (B, slots), int64, of the candidates in the slots, 0 in empty ones, and whether each slot
    is filled."""
    index = state[:, count : count + slots]
    return index.clamp(min=0.0).to(torch.int64), index >= 0.0
