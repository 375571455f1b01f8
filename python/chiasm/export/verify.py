"""Proof on the machine where a bundle is: golden vectors replayed on every backend that is present."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch

from chiasm.onnx import register

from .bundle import read_golden
from .manifest import BundleError, read_file, read_manifest
from .text import one_line


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


def difference(
    result: torch.Tensor, expected: torch.Tensor, tolerance: dict[str, float] | None
) -> tuple[float, str]:
    """The largest absolute difference, and "" or what is wrong. Without a tolerance, equality is asked for;
    NaN equals NaN."""
    if result.shape != expected.shape or result.dtype != expected.dtype:
        return (
            float("inf"),
            f"expected {tuple(expected.shape)} {expected.dtype}, got {tuple(result.shape)} {result.dtype}",
        )
    if expected.numel() == 0:
        return 0.0, ""
    a, b = result.double(), expected.double()
    same = (a == b) | (a.isnan() & b.isnan())
    gap = torch.where(same, 0.0, (a - b).abs().nan_to_num(nan=float("inf")))
    allowed = (
        torch.zeros_like(b)
        if tolerance is None
        else tolerance["atol"] + tolerance["rtol"] * b.abs().nan_to_num()
    )
    worst, wrong = float(gap.max()), int((gap > allowed).sum())
    return worst, "" if wrong == 0 else f"{wrong} of {b.numel()} values differ by up to {worst:.3g}"


def compare(
    method: dict, results: Sequence[torch.Tensor], expected: Sequence[torch.Tensor]
) -> tuple[float, str]:
    """The largest absolute difference of a method's outputs, and "" or what is wrong by its manifest's
    tolerances."""
    worst, message = 0.0, ""
    for tensor, result, want in zip(method["outputs"], results, expected, strict=True):
        error, wrong = difference(
            result, want, method["tolerances"].get(str(want.dtype).removeprefix("torch."))
        )
        worst, message = max(worst, error), message or (wrong and f"output {tensor['name']!r}: {wrong}")
    return worst, message


def verify(bundle: str | Path) -> list[Row]:
    """Replay a bundle's golden vectors: by the C++ runtime on each of its backends, and by ONNX Runtime in
    Python.

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
    golden = read_golden(folder, manifest)
    rows = [
        row for case in manifest["golden"]["cases"] for row in _python_onnx(folder, manifest, golden, case)
    ]
    return _runtime(folder) + rows


def _runtime(folder: Path) -> list[Row]:
    import chiasm.runtime

    try:
        rows = chiasm.runtime.open(folder).self_test()
    except chiasm.runtime.ChiasmError as error:
        raise BundleError(str(error)) from error
    return [
        Row(
            r.method,
            r.dtype,
            r.backend,
            r.artifact,
            r.passed,
            r.max_error,
            r.message,
        )
        for r in rows
    ]


def _python_onnx(folder: Path, manifest: dict, golden: dict[str, torch.Tensor], case: dict) -> Iterator[Row]:
    """Both forms of the artifact: the flat one, and the fused one as an engine without chiasm's plug-in runs
    it."""
    method = manifest["methods"][case["method"]]
    dtype = case["dtype"]
    expected = [golden[f"{case['prefix']}/{t['name']}"] for t in method["outputs"]]
    inputs = {t["name"]: golden[f"{case['prefix']}/{t['name']}"] for t in method["inputs"]}
    for artifact in method["artifacts"]:
        if artifact["format"] != "onnx" or (dtype is not None and dtype not in artifact["dtypes"]):
            continue
        try:
            worst, message = compare(method, onnx_session(folder / artifact["file"])(inputs), expected)
        except Exception as error:  # ONNX Runtime's have no common class
            worst, message = float("inf"), one_line(error)
        backend = "onnx (python, fused body)" if "function" in artifact else "onnx (python)"
        yield Row(case["method"], dtype or "", backend, artifact["file"], not message, worst, message)


def onnx_session(
    file: Path, bundle: Path | None = None
) -> Callable[[dict[str, torch.Tensor]], tuple[torch.Tensor, ...]]:
    """Load a `.onnx` in ONNX Runtime's Python package, with the native code of `bundle` where one is given;
    returns a function from named inputs to outputs."""
    import onnxruntime

    options = onnxruntime.SessionOptions()
    if bundle is not None:
        register(options, bundle)
    options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_ENABLE_EXTENDED
    options.log_severity_level = 3
    session = onnxruntime.InferenceSession(str(file), options, providers=["CPUExecutionProvider"])
    wanted = {i.name for i in session.get_inputs()}

    def run(inputs: dict[str, torch.Tensor]) -> tuple[torch.Tensor, ...]:
        results = session.run(None, {n: t.contiguous().numpy() for n, t in inputs.items() if n in wanted})
        return tuple(torch.from_numpy(np.asarray(r)) for r in results)

    return run
