"""Finds what to install for a missing module: an extra of the package, or the distribution of the ops."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

#: The modules of each extra (pyproject.toml), by the names they are imported by.
EXTRAS = {
    "cli": ("click", "jsonschema", "PIL", "rich"),
    "onnx": ("jsonschema", "onnx", "onnxruntime"),
    "export": ("torch", "onnxscript", "safetensors"),
    "ops": ("torch",),
    "data": ("pyarrow", "simplejpeg"),
    "ray": ("ray",),
    "triton": ("tritonclient",),
}
#: The submodules of chiasm that the distribution chiasm-ops brings. It brings parts of chiasm.export too.
OPS = (
    "augmentation",
    "color",
    "contrib",
    "enhance",
    "feature",
    "filters",
    "geometry",
    "image",
    "io",
    "losses",
    "metrics",
    "morphology",
    "ops",
    "pipelines",
    "primitives",
)


def has_ops() -> bool:
    """Whether chiasm-ops is installed, or this is a source tree."""
    return (Path(__file__).parent / "primitives").is_dir()


def advice(error: ImportError) -> str | None:
    """What to install, in one sentence, if the missing module belongs to an extra; None if it is another."""
    name = error.name or ""
    if _is_missing_op(name):
        return _missing_op(name)
    top = name.partition(".")[0]
    for extra, modules in EXTRAS.items():
        if top in modules:
            return f'this needs {top}, which is not installed: pip install "chiasm[{extra}]"'
    return None


def _is_missing_op(name: str) -> bool:
    package, _, rest = name.partition(".")
    return package == "chiasm" and (rest in OPS or rest.startswith("export.")) and not has_ops()


def _missing_op(name: str) -> str:
    extra = "export" if name.startswith("chiasm.export.") else "ops"
    return (
        f"{name} belongs to the distribution chiasm-ops, which is not installed: pip install"
        f' "chiasm[{extra}]" (bundles run without it: chiasm.runtime)'
    )


class MissingOps:
    """The last entry of sys.meta_path: it is asked for modules that no other entry finds, and says what to
    install for those of chiasm-ops."""

    @staticmethod
    def find_spec(name: str, path: Sequence[str] | None = None, target: ModuleType | None = None) -> None:
        """Raises ModuleNotFoundError if the module belongs to chiasm-ops and that is not installed."""
        if _is_missing_op(name):
            raise ModuleNotFoundError(_missing_op(name), name=name)
