"""Export of ops and pipelines to bundles.

    from chiasm.export import Spec, export, image
    export(my_function, Spec("my.op", [image()]), "bundles")

Names load on first use, so that reading a bundle (``chiasm.export.manifest``) does not import torch.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .errors import ExportError
    from .manifest import FORMATS, BundleError
    from .pipeline import export
    from .spec import Frames, Spec, TensorSpec, Tolerance, frame, image, like

__all__ = [
    "FORMATS",
    "BundleError",
    "ExportError",
    "Frames",
    "Spec",
    "TensorSpec",
    "Tolerance",
    "export",
    "frame",
    "image",
    "like",
]

_HOMES = {"BundleError": "manifest", "ExportError": "errors", "FORMATS": "manifest", "export": "pipeline"}


def __getattr__(name: str) -> Any:
    if name in __all__:
        return getattr(importlib.import_module(f"{__name__}.{_HOMES.get(name, 'spec')}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
