"""make demo: every bundle of the catalog on real photographs, from C++, on every backend.

The inputs and eager Python's results are written to build/demo; the C++ program demo_runner runs each bundle in a process a
backend and says how far it is from eager, how long loading and running took, and how much memory; OpenCV does the same work
beside it. Then the tables are printed and the pictures written.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import torch
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Column, Table

from chiasm.export.catalog import Entry, catalog
from chiasm.export.exporter import run_eager
from chiasm.export.manifest import read_manifest
from chiasm.export.module import bind

from .pictures import contact_sheet, draw
from .scenes import scenes

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build"
DEMO = BUILD / "demo"
RUNNER = BUILD / "release" / "bin" / "demo_runner"
BACKENDS = ("native", "torch", "onnx")


def main() -> int:
    warnings.simplefilter("ignore")
    console = Console(width=None if sys.stdout.isatty() else 170)
    for stale in ("cases", "pictures"):
        shutil.rmtree(DEMO / stale, ignore_errors=True)
    reports: dict[str, dict] = {}
    pictures: list[Path] = []
    columns = TextColumn("{task.description:56}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    with Progress(*columns, console=console) as progress:
        entries = catalog()
        for name in progress.track(entries, description="running every bundle from C++"):
            folder = DEMO / "cases" / name
            cases, first = write_cases(name, entries[name], folder)
            reports[name] = {b: run(folder / "cases.json", b) for b in (*BACKENDS, "opencv")}
            picture = DEMO / "pictures" / f"{name}.png"
            if draw(entries[name].spec, cases[0]["outputs"], first, read_results(folder, cases[0]["outputs"], reports[name]), picture):
                pictures.append(picture)
                console.print(f"wrote {picture.relative_to(ROOT)}", highlight=False)
            if not sys.stdout.isatty():
                console.print(f"ran {name}", highlight=False)
    (DEMO / "report.json").write_text(json.dumps(reports, indent=1))
    contact_sheet(pictures, DEMO / "pictures.png")
    checks, failed = print_parity(console, reports)
    print_cost(console, reports)
    console.print(f"{len(pictures)} pictures in {(DEMO / 'pictures').relative_to(ROOT)}/, all on one page: {(DEMO / 'pictures.png').relative_to(ROOT)}", highlight=False)
    print(f"demo: {checks} checks from C++, {failed} failed")
    return 1 if failed else 0


def write_cases(name: str, entry: Entry, folder: Path) -> tuple[list[dict], dict[str, torch.Tensor]]:
    """Inputs and eager results as raw files, with an index that the C++ program reads."""
    folder.mkdir(parents=True)
    bundle = DEMO / "bundles" / f"{name}.chiasm"
    manifest = read_manifest(bundle)
    op = bind(entry.function(), [t.name for t in entry.spec.inputs], entry.spec.config, name)
    method, cases, first = manifest["methods"]["forward"], [], None
    for index, (label, inputs) in enumerate(scenes(entry.spec)):
        first = first or inputs
        results = run_eager(op, inputs)
        shapes = label if any(t.layout for t in entry.spec.inputs) else "x".join(map(str, next(iter(inputs.values())).shape))
        case = {"shape": shapes, "inputs": [], "outputs": []}
        for position, tensor in enumerate(inputs.values()):
            case["inputs"].append(write(folder, f"{index}.in{position}", tensor))
        for position, (described, tensor) in enumerate(zip(method["outputs"], results, strict=True)):
            dtype = str(tensor.dtype).removeprefix("torch.")
            tolerance = method["tolerances"].get(dtype, {"atol": 0, "rtol": 0})
            case["outputs"].append(write(folder, f"{index}.out{position}", tensor) | tolerance | {k: described[k] for k in ("name", "layout", "color")})
        cases.append(case)
    (folder / "cases.json").write_text(json.dumps({"name": name, "bundle": str(bundle), "cases": cases}))
    return cases, first


def write(folder: Path, file: str, tensor: torch.Tensor) -> dict:
    (folder / file).write_bytes(np.ascontiguousarray(tensor.numpy()).tobytes())
    return {"file": file, "dtype": str(tensor.dtype).removeprefix("torch."), "shape": list(tensor.shape)}


def run(cases: Path, backend: str) -> dict:
    """What demo_runner reports; {"problem": ...} where it failed."""
    done = subprocess.run([RUNNER, cases, backend], capture_output=True, text=True)
    return json.loads(done.stdout) if done.returncode == 0 else {"problem": done.stderr.strip() or f"exit status {done.returncode}", "cases": []}


def read_results(folder: Path, outputs: list[dict], report: dict) -> list[torch.Tensor]:
    """The outputs of the first case as the C++ program wrote them, on the first backend that ran."""
    backend = next(b for b in BACKENDS if report[b]["cases"])
    return [torch.from_numpy(np.fromfile(folder / f"{backend}.{o['file']}", o["dtype"]).reshape(o["shape"])) for o in outputs]


def print_parity(console: Console, reports: dict[str, dict]) -> tuple[int, int]:
    table = Table("op", "input", *BACKENDS, title="Parity: C++ against eager Python, largest difference", box=None, header_style="bold")
    checks = failed = 0
    for name, report in reports.items():
        labels = [c["shape"] for b in BACKENDS for c in report[b]["cases"]]
        for row, label in enumerate(dict.fromkeys(labels) if len(set(labels)) > 1 else labels[:1]):
            cells = []
            for backend in BACKENDS:
                case = next(iter(report[backend]["cases"][row : row + 1]), None)
                bad = case is None or case["wrong"] > 0
                checks, failed = checks + 1, failed + bad
                text = report[backend].get("problem", "not run") if case is None else f"{case['error']:.1e} {'FAIL' if bad else 'pass'}"
                cells.append(f"[{'red' if bad else 'green'}]{text}[/]")
            table.add_row(name if row == 0 else "", label, *cells)
    console.print(table)
    return checks, failed


def print_cost(console: Console, reports: dict[str, dict]) -> None:
    """Load time, memory, time per run on the first input, OpenCV beside."""
    title = "Cost: load ms / memory MB / run ms, one process each; OpenCV (Debian's) on the same threads"
    table = Table(Column("op", no_wrap=True), *BACKENDS, "OpenCV run ms", "native vs OpenCV", title=title, box=None, header_style="bold")
    for name, report in reports.items():
        cells = []
        for backend in BACKENDS:
            r = report[backend]
            cells.append(f"{r['load_ms']:6.1f} /{r['memory_mb']:6.1f} /{r['cases'][0]['ms']:8.3f}" if r["cases"] else "-")
        peer = report["opencv"]["cases"][0]["ms"] if report["opencv"]["cases"] else None
        native = report["native"]["cases"][0]["ms"] if report["native"]["cases"] else None
        ratio = f"{peer / native:.2f}x" if peer and native else ""
        table.add_row(name, *cells, f"{peer:.3f}" if peer else "-", ratio)
    console.print(table)


if __name__ == "__main__":
    raise SystemExit(main())
