"""Compares a bundle's ONNX artifacts, in ONNX Runtime's Python package, with its golden vectors; and outputs
in general."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch

from chiasm.onnx import register

from .bundle import read_golden
from .manifest import read_file
from .text import one_line
from .verify import Row


def difference(
    result: torch.Tensor, expected: torch.Tensor, tolerance: dict[str, float] | None
) -> tuple[float, str]:
    """The largest absolute difference, and "" or the problem. Without a tolerance, values must be equal; NaN
    equals NaN."""
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
    method: dict[str, Any], results: Sequence[torch.Tensor], expected: Sequence[torch.Tensor]
) -> tuple[float, str]:
    """The largest absolute difference of a method's outputs, and "" or the problem, by the manifest's
    tolerances."""
    worst, message = 0.0, ""
    for tensor, result, want in zip(method["outputs"], results, expected, strict=True):
        error, wrong = difference(
            result, want, method["tolerances"].get(str(want.dtype).removeprefix("torch."))
        )
        worst, message = max(worst, error), message or (wrong and f"output {tensor['name']!r}: {wrong}")
    return worst, message


def rows(folder: Path, manifest: dict[str, Any]) -> Iterator[Row]:
    """Every golden case on every ONNX artifact that has its dtype."""
    golden = read_golden(folder, manifest)
    for case in manifest["golden"]["cases"]:
        yield from _rows(folder, manifest, golden, case)


def _rows(
    folder: Path, manifest: dict[str, Any], golden: dict[str, torch.Tensor], case: dict[str, Any]
) -> Iterator[Row]:
    """Both forms of the artifact: the flat one, and the fused one without chiasm's plug-in."""
    method = manifest["methods"][case["method"]]
    dtype = case["dtype"]
    expected = [golden[f"{case['prefix']}/{t['name']}"] for t in method["outputs"]]
    inputs = {t["name"]: golden[f"{case['prefix']}/{t['name']}"] for t in method["inputs"]}
    for artifact in method["artifacts"]:
        if artifact["format"] != "onnx" or (dtype is not None and dtype not in artifact["dtypes"]):
            continue
        model = read_file(folder, artifact)  # again, since the file may have changed since it was checked
        try:
            worst, message = compare(method, onnx_session(model)(inputs), expected)
        except Exception as error:  # ONNX Runtime's exceptions have no common class
            worst, message = float("inf"), one_line(error)
        backend = "onnx (python, fused body)" if "function" in artifact else "onnx (python)"
        yield Row(case["method"], dtype or "", backend, not message, worst, message)


def onnx_session(
    model: Path | bytes, bundle: Path | None = None
) -> Callable[[dict[str, torch.Tensor]], tuple[torch.Tensor, ...]]:
    """Load a `.onnx`, or its bytes, in ONNX Runtime's Python package, with the native code of `bundle` if one
    is given; returns a function from named inputs to outputs."""
    import onnxruntime

    options = onnxruntime.SessionOptions()
    if bundle is not None:
        register(options, bundle)
    options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_ENABLE_EXTENDED
    options.log_severity_level = 3
    given = model if isinstance(model, bytes) else str(model)
    session = onnxruntime.InferenceSession(given, options, providers=["CPUExecutionProvider"])
    wanted = {i.name for i in session.get_inputs()}

    def run(inputs: dict[str, torch.Tensor]) -> tuple[torch.Tensor, ...]:
        results = session.run(None, {n: t.contiguous().numpy() for n, t in inputs.items() if n in wanted})
        return tuple(torch.as_tensor(np.asarray(r)) for r in results)

    return run
