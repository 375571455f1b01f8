"""Finds the extra of the package that installs a missing module."""

from __future__ import annotations

#: The modules of each extra (pyproject.toml), by the names they are imported by.
EXTRAS = {
    "cli": ("click", "jsonschema", "PIL", "rich"),
    "onnx": ("jsonschema", "onnx", "onnxruntime"),
    "export": ("torch", "onnxscript", "safetensors"),
    "data": ("pyarrow", "simplejpeg"),
    "ray": ("ray",),
    "triton": ("tritonclient",),
}


def advice(error: ImportError) -> str | None:
    """What to install, in one sentence, if the missing module belongs to an extra; None if it is another."""
    top = (error.name or "").partition(".")[0]
    for extra, modules in EXTRAS.items():
        if top in modules:
            return f'this needs {top}, which is not installed: pip install "chiasm[{extra}]"'
    return None
