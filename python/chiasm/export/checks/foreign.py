"""Rejects operators of other libraries (torchvision's, a user's own) in the formats that cannot run them.

TorchScript and native code call an operator by its name, and a program in C++ that has not loaded its library
does not find it; a compiled call may even end the process. ONNX may have a form of its own for it.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from torch import Tensor
from torch.utils._python_dispatch import TorchDispatchMode

from ..errors import ExportError, own_line
from ..internals import is_operator

#: The libraries of PyTorch that define operators.
_OWN = ("aten", "prim", "prims", "quantized", "_quantized", "mkldnn", "onednn", "mkl", "sparse")
#: The formats that call operators by their names, in words.
_BY_NAME = {"torchscript": "TorchScript", "native": "native code"}


class _Listing(TorchDispatchMode):
    """Finds the first operator of another library, and the line that calls it."""

    supports_higher_order_operators = True

    def __init__(self) -> None:
        super().__init__()  # pyright: ignore[reportUnknownMemberType]
        self.found: tuple[str, str, str | None] | None = None

    def __torch_dispatch__(self, func: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        if self.found is None and is_operator(func) and func.namespace not in _OWN:
            self.found = (func.namespace, str(func), own_line(traceback.extract_stack()))
        return func(*args, **(kwargs or {}))


def check_operators(
    name: str,
    run: Callable[[Mapping[str, Tensor]], object],
    inputs: Mapping[str, Tensor],
    formats: Sequence[str],
) -> None:
    """Run an op, and reject an operator that one of the formats cannot call."""
    unable = [words for format, words in _BY_NAME.items() if format in formats]
    if not unable:
        return
    with _Listing() as listing:
        run({key: t.clone() for key, t in inputs.items()})
    if listing.found:
        library, operator, where = listing.found
        parts = [
            f"{name}: cannot be exported to {' and '.join(unable)}: it calls an operator of {library}, not of"
            " PyTorch, and C++ programs do not have it",
            where and f"  at {where}",
            f"  operator {operator}",
            "  instead: call PyTorch's operators (chiasm.ops has torchvision's functions written in them), or"
            " leave the format out (formats=['onnx'])",
        ]
        raise ExportError("\n".join(p for p in parts if p))
