"""Proof on the machine where a bundle is: golden vectors replayed on every backend that is present."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch

from .bundle import read_file, read_golden, read_manifest


@dataclass(frozen=True)
class Row:
    """One golden case on one backend; `passed` is None where it could not be run, `message` says why."""

    method: str
    dtype: str
    backend: str
    artifact: str
    passed: bool | None
    error: float
    message: str = ""


def difference(result: torch.Tensor, expected: torch.Tensor, tolerance: dict[str, float] | None) -> tuple[float, str]:
    """The largest absolute difference, and "" or what is wrong. Without a tolerance, equality is asked for; NaN equals NaN."""
    if result.shape != expected.shape or result.dtype != expected.dtype:
        return float("inf"), f"expected {tuple(expected.shape)} {expected.dtype}, got {tuple(result.shape)} {result.dtype}"
    if expected.numel() == 0:
        return 0.0, ""
    a, b = result.double(), expected.double()
    same = (a == b) | (a.isnan() & b.isnan())
    gap = torch.where(same, 0.0, (a - b).abs().nan_to_num(nan=float("inf")))
    allowed = torch.zeros_like(b) if tolerance is None else tolerance["atol"] + tolerance["rtol"] * b.abs().nan_to_num()
    worst, wrong = float(gap.max()), int((gap > allowed).sum())
    return worst, "" if wrong == 0 else f"{wrong} of {b.numel()} values differ by up to {worst:.3g}"


def verify(bundle: str | Path) -> list[Row]:
    """Replay a bundle's golden vectors: by the C++ runtime on each of its backends, and by ONNX Runtime in Python.

    Raises:
        BundleError: the bundle is damaged.
    """
    folder = Path(bundle)
    manifest = read_manifest(folder)
    for method in manifest["methods"].values():
        for artifact in method["artifacts"]:
            read_file(folder, artifact)
    golden = read_golden(folder, manifest)
    rows = [_python_onnx(folder, manifest, golden, case) for case in manifest["golden"]["cases"]]
    return _runtime(folder) + [row for row in rows if row is not None]


def _runtime(folder: Path) -> list[Row]:
    import chiasm.runtime

    return [
        Row(r.method, r.dtype, r.backend, r.artifact, {1: True, 0: False}.get(r.passed), r.max_error, r.message)
        for r in chiasm.runtime.open(folder).self_test()
    ]


def _python_onnx(folder: Path, manifest: dict, golden: dict[str, torch.Tensor], case: dict) -> Row | None:
    method = manifest["methods"][case["method"]]
    dtype = case["dtype"]
    artifact = next((a for a in method["artifacts"] if a["format"] == "onnx" and (dtype is None or dtype in a["dtypes"])), None)
    if artifact is None:
        return None
    expected = [golden[f"{case['prefix']}/{t['name']}"] for t in method["outputs"]]
    inputs = {t["name"]: golden[f"{case['prefix']}/{t['name']}"] for t in method["inputs"]}
    results = onnx_session(folder / artifact["file"])(inputs)
    worst, message = 0.0, ""
    for tensor, result, want in zip(method["outputs"], results, expected, strict=True):
        error, wrong = difference(result, want, method["tolerances"].get(str(want.dtype).removeprefix("torch.")))
        worst, message = max(worst, error), message or (wrong and f"output {tensor['name']!r}: {wrong}")
    return Row(case["method"], dtype or "", "onnx (python)", artifact["file"], not message, worst, message)


def onnx_session(file: Path) -> Callable[[dict[str, torch.Tensor]], tuple[torch.Tensor, ...]]:
    """Load a `.onnx` in ONNX Runtime's Python package; returns a function from named inputs to outputs."""
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_ENABLE_EXTENDED
    options.log_severity_level = 3
    session = onnxruntime.InferenceSession(str(file), options, providers=["CPUExecutionProvider"])
    wanted = {i.name for i in session.get_inputs()}

    def run(inputs: dict[str, torch.Tensor]) -> tuple[torch.Tensor, ...]:
        results = session.run(None, {n: np.ascontiguousarray(t.numpy()) for n, t in inputs.items() if n in wanted})
        return tuple(torch.from_numpy(np.asarray(r)) for r in results)

    return run
