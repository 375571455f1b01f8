"""Long loops, exported as one loop instead of copies of its body.

A decorator turns a step into a loop: ``repeated`` for a known number of steps, ``until_stable`` until a step
changes nothing. A step is ``step(state, k, *fixed)``, where k is a 0-dimensional int64 tensor that counts the
steps and ``fixed`` are tensors, numbers and lists of numbers. The loop is called with the number of steps in
place of k: ``step(state, count, *fixed)``.

TorchScript and eager Python run a plain ``for``, through which gradients flow. Exported graphs have one
``while_loop``; exported gradients copy the steps, because torch.func.vjp cannot trace a loop.
"""

from typing import Any, Callable, Concatenate, List, ParamSpec, Tuple

import torch
from torch import Tensor
from torch.fx.experimental.proxy_tensor import get_proxy_mode

from .source import function_from, parameters_of, positional

P = ParamSpec("P")

#: How many steps of an ``until_stable`` loop an exported gradient copies, at most.
_COPIED_STEPS = 10


def repeated(
    step: Callable[Concatenate[Tensor, Tensor, P], Tensor],
) -> Callable[Concatenate[Tensor, int, P], Tensor]:
    """The loop that applies the step to ``state`` ``count`` times.

    >>> def add(state: Tensor, k: Tensor, times: int) -> Tensor:
    ...     return state + times * k
    >>> repeated(add)(torch.tensor(0), 4, 2)
    tensor(12)
    """
    lines = [
        "for k in range({count}):",
        "    {state} = step({state}, torch.full([], k, dtype=torch.int64, device={state}.device){fixed})",
    ]
    return _loop(step, "count", lines, _repeat)


def until_stable(
    step: Callable[Concatenate[Tensor, Tensor, P], Tensor],
) -> Callable[Concatenate[Tensor, int, P], Tensor]:
    """The loop that applies the step to ``state`` for k = 0, 1, ... until the state stays the same, at most
    ``count`` times.

    If a step leaves the state the same, all later steps must leave it the same too. Exported gradients
    contain the first 10 steps.

    >>> def rise(state: Tensor, k: Tensor, top: Tensor) -> Tensor:
    ...     return torch.minimum(state + 1, top)
    >>> until_stable(rise)(torch.tensor([0, 7]), 100, torch.tensor([3, 9]))
    tensor([3, 9])
    """
    lines = [
        "for k in range({count}):",
        "    after = step({state}, torch.full([], k, dtype=torch.int64, device={state}.device){fixed})",
        "    if is_same(after, {state}):",
        "        break",
        "    {state} = after",
    ]
    return _loop(step, "limit", lines, _until_stable)


def _loop(
    step: Callable[..., Tensor], count: str, scripted: List[str], otherwise: Callable[..., Tensor]
) -> Callable[..., Tensor]:
    """The function that runs the ``scripted`` lines in TorchScript, where a function cannot be an argument,
    and ``otherwise`` elsewhere."""
    state, _, *fixed = parameters_of(step)
    names = "".join(f", {p.name}" for p in fixed)
    body = [f"    {line.format(state=state.name, count=count, fixed=names)}" for line in scripted]
    body = ["if torch.jit.is_scripting():"] + body + [f"    return {state.name}"]
    body += ["else:", f"    return otherwise(step, {state.name}, {count}{names})"]
    scope = {"torch": torch, "step": step, "is_same": is_same, "otherwise": otherwise}
    return function_from(step, [state, positional(count, int), *fixed], body, scope)


def _until_stable(step: Callable[..., Tensor], state: Tensor, limit: int, *fixed: Any) -> Tensor:
    if torch.compiler.is_exporting():
        return _while_loop(step, state, fixed, limit, True)
    if get_proxy_mode() is not None:
        return _repeat(step, state, min(limit, _COPIED_STEPS), *fixed)
    for k in range(limit):
        moved = step(state, _counter(k, state), *fixed)
        if is_same(moved, state):
            break
        state = moved
    return state


def _repeat(step: Callable[..., Tensor], state: Tensor, count: int, *fixed: Any) -> Tensor:
    if torch.compiler.is_exporting():
        return _while_loop(step, state, fixed, count, False)
    for k in range(count):
        state = step(state, _counter(k, state), *fixed)
    return state


def is_same(after: Tensor, before: Tensor) -> bool:
    """Whether nothing changed. Elements that were NaN are ignored, or a loop would never end.

    >>> is_same(torch.tensor([1.0, torch.nan]), torch.tensor([1.0, torch.nan]))
    True
    """
    return not bool(_changed(after, before))


def _changed(after: Tensor, before: Tensor) -> Tensor:
    return ((after != before) & (before == before)).any()


def _counter(k: int, state: Tensor) -> Tensor:
    return torch.full([], k, dtype=torch.int64, device=state.device)


def _while_loop(
    step: Callable[..., Tensor], state: Tensor, fixed: Tuple[Any, ...], limit: int, may_end: bool
) -> Tensor:
    from torch._higher_order_ops.while_loop import while_loop

    def moving(k: Tensor, moved: Tensor, state: Tensor) -> Tensor:
        return moved & (k < limit)

    def body(k: Tensor, moved: Tensor, state: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
        after = step(state, k, *fixed)
        return k + 1, _changed(after, state) if may_end else moved.clone(), after

    # clone: the initial state of a loop must not be a tensor that the caller owns
    return while_loop(
        moving,
        body,
        (_counter(0, state), torch.ones([], dtype=torch.bool, device=state.device), state.clone()),
    )[2]
