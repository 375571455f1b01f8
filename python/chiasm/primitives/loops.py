"""Long loops, exported as one loop instead of copies of its body.

TorchScript cannot take a function as an argument, so an op writes its loop twice: a plain ``for`` under
``torch.jit.is_scripting()``, and otherwise a call of a function below with the same step. A step is
``step(state, k, *fixed)`` with k a 0-dimensional int64 tensor; ``fixed`` are tensors and numbers. Gradients flow through the
steps in eager code. Exported gradients copy the steps, for no loop can be traced through torch.func.vjp.
"""

from typing import Any, Callable, Tuple

import torch
from torch import Tensor
from torch.fx.experimental.proxy_tensor import get_proxy_mode

#: The most steps of a loop that ends by itself that an exported gradient copies.
_COPIED_STEPS = 10


def until_stable(step: Callable[..., Tensor], state: Tensor, fixed: Tuple[Any, ...], limit: int) -> Tensor:
    """Replace ``state`` by its step for k = 0, 1, ... until it stays the same, at most ``limit`` times.

    The step must be such that a state which stays the same once stays so for good. Exported gradients see the first 10 steps.

    >>> until_stable(lambda x, k, top: torch.minimum(x + 1, top), torch.tensor([0, 7]), (torch.tensor([3, 9]),), 100)
    tensor([3, 9])
    """
    if torch.compiler.is_exporting():
        return _while_loop(step, state, fixed, limit, True)
    if get_proxy_mode() is not None:
        return repeat(step, state, fixed, min(limit, _COPIED_STEPS))
    for k in range(limit):
        moved = step(state, _counter(k, state), *fixed)
        if is_same(moved, state):
            break
        state = moved
    return state


def repeat(step: Callable[..., Tensor], state: Tensor, fixed: Tuple[Any, ...], count: int) -> Tensor:
    """Replace ``state`` by its step ``count`` times.

    >>> repeat(lambda x, k: x + k, torch.tensor(0), (), 4)
    tensor(6)
    """
    if torch.compiler.is_exporting():
        return _while_loop(step, state, fixed, count, False)
    for k in range(count):
        state = step(state, _counter(k, state), *fixed)
    return state


def is_same(after: Tensor, before: Tensor) -> bool:
    """Whether nothing changed; what was NaN may have become anything, or a loop would never end.

    >>> is_same(torch.tensor([1.0, torch.nan]), torch.tensor([1.0, torch.nan]))
    True
    """
    return not bool(_changed(after, before))


def _changed(after: Tensor, before: Tensor) -> Tensor:
    return ((after != before) & (before == before)).any()


def _counter(k: int, state: Tensor) -> Tensor:
    return torch.full([], k, dtype=torch.int64, device=state.device)


def _while_loop(step: Callable[..., Tensor], state: Tensor, fixed: Tuple[Any, ...], limit: int, may_end: bool) -> Tensor:
    from torch._higher_order_ops.while_loop import while_loop

    def moving(k: Tensor, moved: Tensor, state: Tensor) -> Tensor:
        return moved & (k < limit)

    def body(k: Tensor, moved: Tensor, state: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
        after = step(state, k, *fixed)
        return k + 1, _changed(after, state) if may_end else moved.clone(), after

    # clone: a loop may not begin with a tensor that the caller owns
    return while_loop(moving, body, (_counter(0, state), torch.ones([], dtype=torch.bool, device=state.device), state.clone()))[2]
