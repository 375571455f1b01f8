"""Model repositories of Triton Inference Server, made of bundles: what `chiasm triton` writes.

* `write` puts bundles, and networks in ONNX files, into a repository;
* `Part` names one of them.

docs/triton.md shows the server's side. Nothing of Triton is imported.

Examples
--------
>>> import tempfile
>>> from pathlib import Path
>>> import chiasm.triton
>>> part = chiasm.triton.Part("sobel", Path("build/bundles/filters.sobel.chiasm"))
>>> with tempfile.TemporaryDirectory() as folder:
...     [model] = chiasm.triton.write(Path(folder) / "models", [part])
...     print(model.name, (model / "config.pbtxt").read_text())
sobel backend: "chiasm"
<BLANKLINE>
"""

from .parts import Part, RepositoryError
from .repository import write

__all__ = ["Part", "RepositoryError", "write"]


def __dir__() -> list[str]:
    return __all__
