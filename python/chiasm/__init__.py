"""chiasm: computer-vision ops written once in typed, scriptable Python and run everywhere with the same
numbers.

Submodules load on first use, so that ``import chiasm.runtime`` and ``import chiasm.onnx`` (which run exported
bundles) do not import torch. The ops and parts of ``chiasm.export`` are in a distribution of their own,
chiasm-ops; without it, an import of them says what to install.
"""

import importlib
import sys
from types import ModuleType
from typing import TYPE_CHECKING

from .extras import OPS, MissingOps

if TYPE_CHECKING:  # an editor completes chiasm.filters.GaussianBlur2d
    from . import (  # noqa: F401
        augmentation,
        color,
        constants,
        contrib,
        data,
        doctor,
        enhance,
        export,
        feature,
        filters,
        geometry,
        image,
        io,
        losses,
        metrics,
        morphology,
        onnx,
        ops,
        pipelines,
        primitives,
        runtime,
        triton,
    )

__version__ = "0.1.0"

_SUBMODULES = (*OPS, "constants", "data", "doctor", "export", "onnx", "runtime", "triton")

sys.meta_path.append(MissingOps)


def __getattr__(name: str) -> ModuleType:
    if name in _SUBMODULES:
        return importlib.import_module(f"{__name__}.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return ["__version__", *_SUBMODULES]
