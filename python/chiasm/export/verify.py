"""Replays a bundle's golden vectors on every backend that this machine has."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from ..extras import has_ops
from .manifest import BundleError, read_file, read_manifest


@dataclass(frozen=True)
class Row:
    """One golden case on one backend; `passed` is None if it could not be run; `message` says why."""

    method: str
    dtype: str
    backend: str
    passed: bool | None
    error: float
    message: str = ""


def verify(bundle: str | Path) -> list[Row]:
    """Replay a bundle's golden vectors: by the C++ runtime on each of its backends; and by ONNX Runtime in
    Python, if the exporter's packages are installed.

    Raises:
        BundleError: the bundle is damaged.
    """
    folder = Path(bundle)
    manifest = read_manifest(folder)
    for method in manifest["methods"].values():
        for artifact in method["artifacts"]:
            read_file(folder, artifact)
    for document in manifest.get("documents", {}).values():
        read_file(folder, document)
    found = _runtime(folder)
    engines = "torch", "safetensors", "onnx", "onnxruntime"
    if has_ops() and all(find_spec(package) for package in engines):
        from . import comparison

        found.extend(comparison.rows(folder, manifest))
    return found


def _runtime(folder: Path) -> list[Row]:
    import chiasm.runtime

    try:
        rows = chiasm.runtime.open(folder).self_test()
    except (chiasm.runtime.ChiasmError, ValueError) as error:  # ValueError: a path that is not UTF-8
        raise BundleError(str(error)) from error
    return [Row(r.method, r.dtype, r.backend, r.passed, r.max_error, r.message) for r in rows]
