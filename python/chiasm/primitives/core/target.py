"""The target that is being traced: none (eager use), a forward pass for ONNX or for native code (AOTInductor)
on the CPU or on a GPU, or a backward pass."""

from contextlib import contextmanager
from typing import Iterator

#: "vjp" is a backward pass with the forward pass inside it. One graph serves every engine, so it is a target
#: of its own.
TARGETS = ("eager", "onnx", "native", "cuda", "vjp")
_target = "eager"


@contextmanager
def exporting(target: str) -> Iterator[None]:
    """Trace for ``target`` inside the block.

    >>> with exporting("onnx"):
    ...     current_target()
    'onnx'
    >>> current_target()
    'eager'
    """
    global _target
    if target not in TARGETS:
        raise ValueError(f"target: expected one of {TARGETS}, got {target!r}")
    saved = _target
    _target = target
    try:
        yield
    finally:
        _target = saved


def current_target() -> str:
    """The target being traced."""
    return _target
