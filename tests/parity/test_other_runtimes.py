"""The verdicts of other_runtimes.py: its list of known failures stays correct, and nothing is skipped
silently."""

import json
from pathlib import Path

import numpy as np
import other_runtimes
import other_runtimes_worker
import pytest

METHOD = {"outputs": [{"name": "y"}], "tolerances": {"float32": {"atol": 0.1, "rtol": 0.0}}}


@pytest.mark.parametrize(
    ("result", "message"),
    [
        (np.array([1, 2.05, np.nan], np.float32), ""),
        (np.array([1, 2.5, np.nan], np.float32), "output 'y': 1 of 3 values differ by up to 0.5"),
        (np.array([np.nan, 2, np.nan], np.float32), "output 'y': 1 of 3 values differ by up to inf"),
        (np.array([1, 2, np.nan]), "output 'y': expected (3,) float32, got (3,) float64"),
    ],
)
def test_values_are_compared_within_the_tolerance(result: np.ndarray, message: str) -> None:
    assert (
        other_runtimes_worker.compare([result], [np.array([1, 2, np.nan], np.float32)], METHOD)[1] == message
    )


def test_what_is_known_must_go_on_failing() -> None:
    row = {
        "op": "filters.sobel",
        "file": "forward.float64.onnx",
        "form": "flat",
        "error": 0.0,
        "seconds": 0.0,
    }
    fails, passes = ({**row, "message": m} for m in ("1 value differs", ""))
    assert other_runtimes.judge("OpenVINO", fails)["known"]
    judged = other_runtimes.judge("OpenVINO", passes)
    assert not judged["known"] and "take it off the list" in judged["message"]
    assert not other_runtimes.judge("ONNX Runtime 1.17", {**row, "message": "1 value differs"})["known"]
    assert other_runtimes.judge(
        "OpenVINO", {**row, "file": "any.fused.onnx", "form": "body", "message": "refused"}
    )["known"]


def test_an_artifact_that_was_not_run_is_a_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / ".deps" / "openvino" / "bin").mkdir(parents=True)
    python = tmp_path / ".deps" / "openvino" / "bin" / "python"
    python.write_text("#!/bin/sh\necho the engine died >&2\nexit 3\n")
    python.chmod(0o755)
    artifacts = [{"format": "onnx", "file": "forward.onnx"}, {"format": "torchscript", "file": "forward.pt"}]
    (tmp_path / "manifest.json").write_text(
        json.dumps({"name": "my.op", "methods": {"forward": {"artifacts": artifacts}}})
    )
    monkeypatch.setattr(other_runtimes, "ROOT", tmp_path)
    [row] = other_runtimes.run("OpenVINO", [tmp_path])
    assert not row["known"] and row["message"] == "was not run; the process ended with 3: the engine died"
