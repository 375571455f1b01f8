"""Loops whose length depends on the data, exported as one loop instead of copies of its body.

TorchScript cannot take a function as an argument, so an op writes its loop twice: a plain ``for`` under
``torch.jit.is_scripting()``, and a call of ``until_stable`` with the same step otherwise.
"""

from typing import Callable, Tuple

import torch
from torch import Tensor

from .target import current_target, tracing_vjp

#: Steps of a loop while a gradient is traced: there is no way to trace a loop through torch.func.vjp, so they are copied.
_TRACED_STEPS = 10


def until_stable(step: Callable[..., Tensor], state: Tensor, fixed: Tuple[Tensor, ...], limit: int) -> Tensor:
    """Replace ``state`` by ``step(state, k, *fixed)`` for k = 0, 1, ... until it stays the same, at most ``limit`` times.

    k is a 0-dimensional int64 tensor. The step must be such that a state which stays the same once stays so for good. Gradients
    flow through the steps in eager code; exported gradients see the first 10 of them.

    >>> until_stable(lambda x, k, top: torch.minimum(x + 1, top), torch.tensor([0, 7]), (torch.tensor([3, 9]),), 100)
    tensor([3, 9])
    """
    if tracing_vjp():
        for k in range(min(limit, _TRACED_STEPS)):
            state = step(state, torch.full([], k, dtype=torch.int64, device=state.device), *fixed)
        return state
    if current_target() == "eager":
        for k in range(limit):
            moved = step(state, torch.full([], k, dtype=torch.int64, device=state.device), *fixed)
            if torch.equal(moved, state):
                break
            state = moved
        return state
    return _while_loop(step, state, fixed, limit)


def _while_loop(step: Callable[..., Tensor], state: Tensor, fixed: Tuple[Tensor, ...], limit: int) -> Tensor:
    from torch._higher_order_ops.while_loop import while_loop

    def moving(k: Tensor, moved: Tensor, state: Tensor) -> Tensor:
        return moved & (k < limit)

    def body(k: Tensor, moved: Tensor, state: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
        after = step(state, k, *fixed)
        return k + 1, (after != state).any(), after

    start = torch.zeros([], dtype=torch.int64, device=state.device)
    # clone: a loop may not begin with a tensor that the caller owns
    return while_loop(moving, body, (start, torch.ones([], dtype=torch.bool, device=state.device), state.clone()))[2]
