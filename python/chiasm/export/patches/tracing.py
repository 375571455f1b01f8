# What is patched is private, and most of it without types.
# pyright: reportPrivateUsage=false, reportPrivateImportUsage=false, reportUnknownMemberType=false
"""torch.export, faster, and with what its errors need."""

from __future__ import annotations

import logging
import traceback
from collections.abc import Generator
from contextlib import contextmanager
from typing import Any

import sympy
import torch

from ..errors import own_line
from . import replaced

#: A trace's assumption about sizes, and the op's line that caused it.
Guard = tuple[sympy.Basic, str]


@contextmanager
def fast_tracing() -> Generator[None]:
    """Fake tensors without their cache: with symbolic sizes a hit costs more than computing the result's
    metadata again. And without checking each operand for channels_last, which takes more symbolic arithmetic
    than everything else; the fallback for other layouts gives the same results.
    """
    import torch._dynamo.config
    from torch._subclasses import fake_impls

    is_contiguous = fake_impls.is_contiguous_for_memory_format_or_false

    def is_plain(tensor: torch.Tensor, memory_format: torch.memory_format) -> bool:
        return memory_format is torch.contiguous_format and is_contiguous(tensor, memory_format=memory_format)

    with (
        torch._dynamo.config.patch(fake_tensor_cache_enabled=False),
        replaced({"torch._subclasses.fake_impls:is_contiguous_for_memory_format_or_false": is_plain}),
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
