"""Cases for the C++ program demo_runner: a bundle's inputs and eager Python's results as raw files, and the
program's results."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import torch

from chiasm.export.catalog import Entry
from chiasm.export.job import run_eager
from chiasm.export.manifest import read_manifest
from chiasm.export.tracing.module import bind_spec

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build"
RUNNER = BUILD / "release" / "bin" / "demo_runner"

Scene = tuple[str, dict[str, torch.Tensor]]


def write_cases(entry: Entry, bundle: Path, scenes: list[Scene], folder: Path) -> list[dict]:
    """Write scenes (label, inputs) and eager's results, with an index for the C++ program; returns the
    index."""
    folder.mkdir(parents=True)
    spec, method = entry.spec, read_manifest(bundle)["methods"]["forward"]
    op, cases = bind_spec(entry.function(), spec), []
    for index, (label, inputs) in enumerate(scenes):
        case = {"shape": label, "inputs": [], "outputs": []}
        for position, tensor in enumerate(inputs.values()):
            case["inputs"].append(write(folder, f"{index}.in{position}", tensor))
        for position, (described, tensor) in enumerate(
            zip(method["outputs"], run_eager(op, inputs), strict=True)
        ):
            dtype = str(tensor.dtype).removeprefix("torch.")
            tolerance = method["tolerances"].get(dtype, {"atol": 0, "rtol": 0})
            case["outputs"].append(
                write(folder, f"{index}.out{position}", tensor)
                | tolerance
                | {k: described[k] for k in ("name", "layout", "color")}
            )
        cases.append(case)
    about = {"name": spec.name, "bundle": str(bundle), "dtype": spec.variants()[0] or "", "cases": cases}
    (folder / "cases.json").write_text(json.dumps(about))
    return cases


def write(folder: Path, file: str, tensor: torch.Tensor) -> dict:
    (folder / file).write_bytes(np.ascontiguousarray(tensor.numpy()).tobytes())
    return {"file": file, "dtype": str(tensor.dtype).removeprefix("torch."), "shape": list(tensor.shape)}


def run(cases: Path, backend: str) -> dict:
    """The report of demo_runner, or {"problem": ...} if it failed."""
    done = subprocess.run([RUNNER, cases, backend], capture_output=True, text=True)
    return (
        json.loads(done.stdout)
        if done.returncode == 0
        else {"problem": done.stderr.strip() or f"exit status {done.returncode}", "cases": []}
    )


def read_results(folder: Path, outputs: list[dict], backend: str) -> list[torch.Tensor]:
    """The outputs of a case as the C++ program wrote them."""
    return [
        torch.from_numpy(np.fromfile(folder / f"{backend}.{o['file']}", o["dtype"]).reshape(o["shape"]))
        for o in outputs
    ]
