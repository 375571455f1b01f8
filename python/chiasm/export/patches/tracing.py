# What is patched is private, and most of it without types.
# pyright: reportPrivateUsage=false, reportPrivateImportUsage=false, reportUnknownMemberType=false
"""torch.export, faster, and with what its errors need."""

from __future__ import annotations

import logging
import traceback
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

import sympy
import torch

from ..errors import own_line
from . import replaced

#: A trace's assumption about sizes, and the op's line that caused it.
Guard = tuple[sympy.Basic, str]


class _Kind(NamedTuple):
    """Of an operand: what the shape, the strides and the type of an elementwise result depend on."""

    dtype: torch.dtype | type
    device: torch.device | None = None
    shape: tuple[Any, ...] = ()
    strides: tuple[Any, ...] = ()


def _kind(value: Any) -> _Kind | None:
    """None for values that are rare."""
    if isinstance(value, (bool, int, float)):
        return _Kind(type(value))
    if not isinstance(value, torch.Tensor) or value.dim() == 0 or value.layout is not torch.strided:
        return None
    sizes: list[list[Any]] = [list(value.shape), list(value.stride())]
    shape, strides = (tuple(s if isinstance(s, int) else s.node._expr for s in each) for each in sizes)
    return _Kind(value.dtype, value.device, shape, strides)


def _with_the_shape(result: torch.Tensor, operands: Sequence[Any]) -> int | None:
    """Which operand has the shape of a dense result, if one has."""
    kind = _kind(result)
    for index, operand in enumerate(operands):
        other = _kind(operand)
        if kind and other and (other.device, other.shape) == (kind.device, kind.shape):
            dense = _kind(torch.empty(operand.shape, device="meta"))
            return index if dense and dense.strides == kind.strides else None
    return None


def _remembering(operator: Callable[..., torch.Tensor]) -> Callable[..., torch.Tensor]:
    """An elementwise operator on fake tensors that computes its result's metadata once for operands of the
    same kinds, as the shifted images of a stencil are, if the result has the shape of one of them and is
    dense."""
    from torch._subclasses import FakeTensor

    known: dict[Any, tuple[int | None, torch.dtype]] = {}

    def remembering(mode: Any, *operands: Any, **options: Any) -> torch.Tensor:
        kinds = [_kind(operand) for operand in operands]
        if options or None in kinds:
            return operator(mode, *operands, **options)
        key = (mode.shape_env, *kinds)
        like, dtype = known.get(key, (None, None))
        if like is not None:
            # with the operand's own sizes, which the tracer knows
            shape, device = operands[like].shape, operands[like].device
            return FakeTensor(mode, torch.empty(shape, dtype=dtype, device="meta"), device=device)
        result = operator(mode, *operands)
        if key not in known:
            known[key] = _with_the_shape(result, operands), result.dtype
        return result

    return remembering


@contextmanager
def fast_tracing() -> Generator[None]:
    """Fake tensors without their cache: with symbolic sizes a hit costs more than computing the result's
    metadata again, except for elementwise operators. And without checking each operand for channels_last,
    which takes more symbolic arithmetic than everything else; the fallback for other layouts gives the same
    results.
    """
    import torch._dynamo.config
    from torch._subclasses import fake_impls

    fast = {
        key: each if key is torch.ops.aten.detach.default else _remembering(each)  # whose result is a view
        for key, each in fake_impls.get_fast_op_impls().items()
    }

    is_contiguous = fake_impls.is_contiguous_for_memory_format_or_false

    def is_plain(tensor: torch.Tensor, memory_format: torch.memory_format) -> bool:
        return memory_format is torch.contiguous_format and is_contiguous(tensor, memory_format=memory_format)

    with (
        torch._dynamo.config.patch(fake_tensor_cache_enabled=False),
        replaced(
            {
                "torch._subclasses.fake_impls:is_contiguous_for_memory_format_or_false": is_plain,
                "torch._subclasses.fake_tensor:get_fast_op_impls": lambda: fast,
            }
        ),
    ):
        yield


@contextmanager
def noted_guards(guards: list[Guard]) -> Generator[None]:
    """Record the trace's assumptions about sizes, and the user's line that causes each."""
    from torch.fx.experimental.symbolic_shapes import ShapeEnv

    log_guard = ShapeEnv._log_guard

    def noting(shapes: ShapeEnv, prefix: str, guard: Any, forcing_spec: bool) -> None:
        if line := own_line(traceback.extract_stack()):
            guards.append((guard, line))
        log_guard(shapes, prefix, guard, forcing_spec)

    with replaced({"torch.fx.experimental.symbolic_shapes:ShapeEnv._log_guard": noting}):
        yield


@contextmanager
def quiet() -> Generator[None]:
    """Without torch's additional reports of errors that it raises: in its log, and as a partial graph on
    standard output."""

    def nothing(*_: Any, **__: Any) -> None: ...

    logger = logging.getLogger("torch")
    level = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        with replaced({"torch.export._trace:print": nothing}):
            yield
    finally:
        logger.setLevel(level)
