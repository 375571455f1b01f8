"""Which form of a primitive is being traced: for eager use, for ONNX, or for native (AOTInductor) code.

Scripted code always takes the eager form: the branches below are decided when TorchScript compiles them.
"""

from contextlib import contextmanager
from typing import Iterator

import torch

_TARGETS = ("eager", "onnx", "native")
_target = "eager"
_vjp = False


@contextmanager
def exporting(target: str, vjp: bool = False) -> Iterator[None]:
    """Trace for ``target`` inside the block; ``vjp`` says that the backward pass is traced too.

    >>> with exporting("onnx"):
    ...     current_target()
    'onnx'
    >>> current_target()
    'eager'
    """
    global _target, _vjp
    if target not in _TARGETS:
        raise ValueError(f"target: expected one of {_TARGETS}, got {target!r}")
    saved = (_target, _vjp)
    _target, _vjp = target, vjp
    try:
        yield
    finally:
        _target, _vjp = saved


def current_target() -> str:
    """The target being traced; "eager" in scripted code."""
    if torch.jit.is_scripting():
        return "eager"
    else:
        return _target


def tracing_vjp() -> bool:
    """Whether a backward pass is being traced for export; False in scripted code."""
    if torch.jit.is_scripting():
        return False
    else:
        return _vjp


def native_forward() -> bool:
    """Whether to take the forms that AOTInductor compiles to vectorised loops."""
    return current_target() == "native" and not tracing_vjp()


def onnx_forward() -> bool:
    """Whether to take the forms that map to single ONNX operators (whose backward may have no ONNX form)."""
    return current_target() == "onnx" and not tracing_vjp()
