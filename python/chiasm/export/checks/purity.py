"""Rejects ops that are not functions of their inputs: that write into memory of others, keep state, or draw
random numbers.

Compiled code would write into its caller's memory, and every engine would keep its own state and draw its own
numbers. An op runs in eager mode under a dispatch mode that sees each operator before it runs; so does a
traced graph, which may behave differently. TorchScript also has the branches that no run takes:
script_purity.py reads it.
"""

from __future__ import annotations

import random
import traceback
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import copy
from typing import Any, cast

import numpy as np
import torch
from torch import Tensor, nn
from torch.export import ExportedProgram
from torch.utils._python_dispatch import TorchDispatchMode
from torch.utils._pytree import tree_iter, tree_map

from ..errors import ExportError, own_line
from ..internals import is_operator, schema_of
from ..text import one_line
from .process_state import changed, line_of_change, restore, settings
from .quotients import safe

_STATE = (
    "instead: make the state an input and an output of the op (of a module that learns, such as BatchNorm:"
    " call .eval() first)"
)
_RANDOM = (
    "instead: make the random numbers an input of the op (of Dropout: call .eval() first, or pass"
    " training=False)"
)
#: Operators whose schema says that they write, but which change no value and no shape.
MARKERS = ("aten::detach_", "aten::requires_grad_", "aten::retain_grad")
#: Operators that write into arguments which their schemas do not mark.
_RUNNING = {torch.ops.aten.native_batch_norm.default: ("running_mean", "running_var")}


class Impure(ExportError):
    """An op is not a function of its inputs."""


def impure(name: str, what: str, where: str | None, operator: str | None, remedy: str) -> Impure:
    """The error: what the op does, where, by which operator, and what to write instead."""
    parts = [
        f"{name}: {what}",
        where and f"  at {where}",
        operator and f"  operator {operator}",
        f"  {remedy}",
    ]
    return Impure("\n".join(p for p in parts if p))


def write_error(name: str, target: str | None, where: str | None, operator: str | None) -> Impure:
    """The error for a write: into the input called `target`, or else into a state."""
    if target is not None:
        remedy = f"instead: change a copy: {target} = {target}.clone()" + (
            "" if where else " (a module that does so is made with inplace=False)"
        )
        return impure(
            name, f"it changes its input {target!r}, which is the caller's", where, operator, remedy
        )
    return impure(name, "it changes a tensor that it keeps between calls", where, operator, _STATE)


def draw_error(name: str, where: str | None, operator: str | None) -> Impure:
    """The error for random numbers."""
    return impure(name, "it draws random numbers, which are others in every engine", where, operator, _RANDOM)


def is_random(operator: Any) -> bool:
    """Whether an operator may draw random numbers."""
    return torch.Tag.nondeterministic_seeded in getattr(operator, "tags", ())


class _Watch(TorchDispatchMode):
    """Raises before an operator writes into memory that no operator of this run has allocated, and after one
    has drawn random numbers."""

    supports_higher_order_operators = True

    def __init__(self, name: str, inputs: Mapping[str, Tensor]) -> None:
        super().__init__()  # pyright: ignore[reportUnknownMemberType]
        self.name = name
        self.inputs = {_memory(t): key for key, t in inputs.items()}
        self.made: set[int] = set()
        self.found: Impure | None = None  # raised again at the end, because an op may catch exceptions

    def __torch_dispatch__(self, func: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        kwargs = kwargs or {}
        for tensor in _written(func, args, kwargs):
            memory = _memory(tensor)
            if memory and memory not in self.made:
                self.found = write_error(
                    self.name, self.inputs.get(memory), own_line(traceback.extract_stack()), str(func)
                )
                raise self.found
        drawing = is_random(func)
        before = torch.get_rng_state()
        result = (
            safe(func, kwargs)(*args, **kwargs)
            if getattr(func, "namespace", "") != "chiasm"
            else _shaped(func, args, kwargs)
        )
        if drawing and (
            kwargs.get("generator") is not None or not torch.equal(before, torch.get_rng_state())
        ):
            self.found = draw_error(self.name, own_line(traceback.extract_stack()), str(func))
            raise self.found
        given = {_memory(t) for t in tree_iter((args, kwargs)) if isinstance(t, Tensor)}
        made = {_memory(t) for t in tree_iter(result) if isinstance(t, Tensor)}
        # lift_fresh returns a tensor that was made from numbers
        self.made |= made if func is torch.ops.aten.lift_fresh.default else made - given
        return result


def _shaped(func: Any, args: Any, kwargs: Any) -> Any:
    """Zeros of the shape of a kernel's result: kernels exist only in native code, not in eager mode."""

    def without_values(value: Any) -> Any:
        return value.to("meta") if isinstance(value, Tensor) else value

    def zeros(result: Tensor) -> Tensor:
        return torch.zeros(result.shape, dtype=result.dtype)

    args, kwargs = tree_map(without_values, (args, kwargs))
    return tree_map(zeros, func(*args, **kwargs))


def _written(func: Any, args: Sequence[Any], kwargs: Mapping[str, Any]) -> Iterator[Tensor]:
    if not is_operator(func) or schema_of(func).name in MARKERS:
        return
    hidden = _RUNNING.get(func, ())
    for i, argument in enumerate(schema_of(func).arguments):
        value = args[i] if i < len(args) else kwargs.get(argument.name)
        if (argument.alias_info is not None and argument.alias_info.is_write) or (
            argument.name in hidden and args[5]
        ):
            yield from (t for t in tree_iter(value) if isinstance(t, Tensor))


def _memory(tensor: Tensor) -> int:
    """The address of the memory that a tensor and its views share; 0 if it has none."""
    try:
        return tensor.untyped_storage().data_ptr()
    except (NotImplementedError, RuntimeError):  # sparse tensors, and tensors of other kinds
        return 0


def check_op(
    name: str,
    run: Callable[[Mapping[str, Tensor]], Sequence[Tensor]],
    inputs: Mapping[str, Tensor],
    state: nn.Module,
) -> list[bool]:
    """Run an op under the watch, and once more: it must not change its inputs or its state, and must give the
    same results again.

    Returns for each result whether it is itself an input or an earlier result.
    """
    process = settings()
    first, taken = _watched(name, run, inputs)
    _check_process(name, run, inputs, process)
    before = _state(state)
    second = run({key: t.clone() for key, t in inputs.items()})
    kept = [key for key, value in _state(state).items() if key not in before or not _same(value, before[key])]
    if not all(map(_same, first, second)):
        what = (
            f"it keeps state in {kept[0]!r}: the same inputs give other results"
            if kept
            else "the same inputs give other results when it is called again"
        )
        raise impure(
            name,
            what,
            None,
            None,
            (
                _STATE
                if kept
                else (
                    "instead: make what changes between calls (random numbers, a counter, the time) an input"
                    " of the op"
                )
            ),
        )
    if any(key in dict(state.named_buffers()) for key in kept):
        raise impure(name, f"it changes its buffer {kept[0]!r}", None, None, _STATE)
    return taken


def _check_process(
    name: str,
    run: Callable[[Mapping[str, Tensor]], object],
    inputs: Mapping[str, Tensor],
    process: Mapping[str, Any],
) -> None:
    """Reject an op that has changed settings of the process."""
    found = changed(process)
    if found:
        restore(process)
        where = line_of_change(lambda: run({key: t.clone() for key, t in inputs.items()}), found[0])
        raise impure(
            name,
            f"it changes {found[0]}, which is the process's",
            where,
            None,
            "instead: remove the call: pass what depends on it as an argument (dtype=..., device=...), or"
            " change it in a with block that ends in the op",
        )


def _watched(
    name: str, run: Callable[[Mapping[str, Tensor]], Sequence[Tensor]], inputs: Mapping[str, Tensor]
) -> tuple[tuple[Tensor, ...], list[bool]]:
    copies = {key: t.clone() for key, t in inputs.items()}
    with _Watch(name, copies) as watch:
        results = tuple(run(copies))
    if watch.found:
        raise watch.found
    for key, value in copies.items():
        if not _same(value, inputs[key]):  # for example by NumPy, which the watch does not see
            raise write_error(name, key, None, None)
    places = [(_memory(t), t.storage_offset(), t.shape, t.stride()) for t in (*copies.values(), *results)]
    return results, [places[i] in places[:i] for i in range(len(copies), len(places))]


def _state(module: nn.Module) -> dict[str, Any]:
    """What a module could keep between calls: tensors, and plain values among the attributes."""
    modules = cast("Iterator[tuple[str, nn.Module]]", module.named_modules())
    plain = {
        f"{prefix}.{key}".lstrip("."): value
        for prefix, m in modules
        for key, value in vars(m).items()
        if isinstance(value, (bool, int, float, str)) and key != "training"
    }
    return {
        key: t.detach().clone() for key, t in (*module.named_buffers(), *module.named_parameters())
    } | plain


def _same(a: Any, b: Any) -> bool:
    if not isinstance(a, Tensor):
        return type(a) is type(b) and a == b
    if a.shape != b.shape or a.dtype != b.dtype:
        return False
    return torch.equal(a, b) or bool(((a == b) | ((a != a) & (b != b))).all())


def check_program(name: str, program: ExportedProgram, inputs: Mapping[str, Tensor]) -> None:
    """The same for the writes and random numbers of a traced graph, which may differ from the eager op
    (`torch.compiler.is_exporting()`)."""
    # Including the bodies of loops
    graphs = [m.graph for m in program.graph_module.modules() if isinstance(m, torch.fx.GraphModule)]
    targets = {n.target for graph in graphs for n in graph.nodes if is_operator(n.target)}
    if any(
        (schema_of(t).is_mutable and schema_of(t).name not in MARKERS) or is_random(t) or t in _RUNNING
        for t in targets
    ):
        module = program.module()
        try:
            _watched(name, lambda tensors: list(tree_iter(module(*tensors.values()))), inputs)
        except ExportError:
            raise
        except Exception:  # a graph for native code need not run in eager mode: the op itself has run
            return


def _content(value: Any) -> Any:
    """A copy of a container, whose content may change; None for another value."""
    return copy(cast("Any", value)) if isinstance(value, (dict, list, set)) else None


@contextmanager
def preserved(fn: Any) -> Generator[None]:
    """Puts a module into evaluation mode inside the block, and restores it exactly afterwards, as well as the
    process's settings and random number generators."""
    modules = list(fn.modules()) if isinstance(fn, nn.Module) else []
    tensors = [t for m in modules for t in (*m.parameters(recurse=False), *m.buffers(recurse=False))]
    values = [(t, t.detach().clone(), t.requires_grad, t.grad if t.is_leaf else None) for t in tensors]
    training = [m.training for m in modules]
    attributes = [
        (m, {key: (value, _content(value)) for key, value in vars(m).items()})
        for m in modules
        if not isinstance(m, torch.jit.ScriptModule)
    ]
    process = settings()
    numbers = torch.get_rng_state(), random.getstate(), np.random.get_state()
    try:
        try:
            if modules:
                fn.eval()
        except Exception as error:
            raise ExportError(
                f"{type(fn).__name__}.eval() raises {type(error).__name__}: {one_line(error)}: make it work,"
                " since a module is exported in evaluation mode"
            ) from error
        yield
    finally:
        for module, saved in attributes:
            vars(module).clear()
            for key, (value, content) in saved.items():
                vars(module)[key] = value
                if isinstance(value, list):
                    value[:] = content
                elif isinstance(value, (dict, set)):
                    value.clear()
                    cast("Any", value).update(content)
        for module, flag in zip(modules, training, strict=True):
            module.training = flag
        for tensor, value, requires_grad, gradient in values:
            if not _same(tensor.detach(), value):
                tensor.data.copy_(value)
            if tensor.is_leaf:
                tensor.requires_grad_(requires_grad)
                tensor.grad = gradient
        restore(process)
        torch.set_rng_state(numbers[0])
        random.setstate(numbers[1])
        np.random.set_state(numbers[2])
