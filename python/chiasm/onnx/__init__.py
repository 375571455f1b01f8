"""Bundles in ONNX Runtime, and in models of your own.

A bundle's ONNX artifacts come in two forms: flat, standard operators; and fused, one function call in the
domain ``chiasm``. Any ONNX Runtime runs the function's body; a session with which chiasm's plug-in
``libchiasm_ort.so`` is registered runs the bundle's native code instead.

* `session` opens a bundle in ONNX Runtime, `register` adds the plug-in to session options of your own,
  `library` returns its path.
* `prepend` puts a bundle in front of an existing model, `append` one after it.
* `ONNXSequential` joins models and bundles in a row, and runs them.
* `Node` is a bundle within a torch network, `export` writes such a network as ONNX, `embed` completes a model
  that was exported in another way.

Only `Node` and `export` import torch. All obey the process's trust policy (docs/signing.md): a bundle that it
rejects is a `chiasm.runtime.ChiasmError`.

Example:
    >>> import chiasm.onnx, numpy as np
    >>> sobel = chiasm.onnx.session("build/bundles/filters.sobel.chiasm")
    >>> [edges] = sobel.run(None, {"input": np.zeros((1, 3, 32, 48), np.float32)})
    >>> edges.shape
    (1, 3, 32, 48)
"""

import importlib
from typing import TYPE_CHECKING, Any

from ..extras import advice

try:
    from .merging import append, embed, prepend
    from .plugin import library, register
    from .sequence import ONNXSequential
    from .sessions import session
except ModuleNotFoundError as error:
    if advice(error) is None:
        raise
    raise ImportError(f"chiasm.onnx: {advice(error)}", name=error.name) from None

if TYPE_CHECKING:
    from .network import Node, export

__all__ = ["Node", "ONNXSequential", "append", "embed", "export", "library", "prepend", "register", "session"]


def __getattr__(name: str) -> Any:
    if name in ("Node", "export"):
        return getattr(importlib.import_module(f"{__name__}.network"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
