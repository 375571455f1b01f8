"""The parity matrix: every bundle x method x dtype x backend x shape against eager Python.

    python tests/parity/matrix.py             every bundle in build/bundles
    python tests/parity/matrix.py PATTERN...  these ops, whose bundles must exist

Backends are the C++ runtime's (native, torch, onnx) and ONNX Runtime in Python. Each ONNX artifact is run in
its flat form, and in its fused form as the body and as the native kernel. Some backend must run every
artifact of a bundle; otherwise this is a failure. Several ops are checked in parallel. Writes
build/parity.json (with a PATTERN it replaces those ops' rows); the last line printed is `parity: N checks of
K ops, M failed`, and the exit status is 1 if something failed.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import re
import sys
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from fnmatch import fnmatch
from pathlib import Path

import torch
from rich.console import Console
from rich.progress import track
from rich.table import Column, Table

import chiasm.runtime
from chiasm.export import example_inputs
from chiasm.export.catalog import Entry, catalog
from chiasm.export.comparison import compare, onnx_session
from chiasm.export.job import run_eager, with_cotangents
from chiasm.export.manifest import read_manifest
from chiasm.export.spec import TensorSpec
from chiasm.export.tracing.gradient import vjp_module
from chiasm.export.tracing.module import bind_spec

ROOT = Path(__file__).resolve().parents[2]
BUNDLES = ROOT / "build" / "bundles"
RESULT = ROOT / "build" / "parity.json"

#: So large that float32 sums over the pixels, added one after the other, miss the tolerance.
FRAME = {"B": 1, "C": 3, "H": 600, "W": 803, "N": 8}
#: The most ops that a process checks: two that checked all of the catalog would hold more than 20 GB.
PER_WORKER = 24

Runner = Callable[[dict[str, torch.Tensor]], tuple[torch.Tensor, ...]]


@dataclass
class Check:
    """One comparison; `error` is the largest absolute difference, `message` is empty if it passed."""

    op: str
    method: str
    dtype: str
    backend: str
    artifact: str
    shape: str
    error: float
    message: str


def main(patterns: list[str]) -> int:
    warnings.simplefilter("ignore")
    entries = [
        n
        for n in catalog()
        if (any(fnmatch(n, p) for p in patterns) if patterns else (BUNDLES / f"{n}.chiasm").is_dir())
    ]
    console = Console(width=None if sys.stdout.isatty() else 140)
    done = track(checked(entries), "parity", total=len(entries), console=console, transient=True)
    checks = [check for some in done for check in some]
    RESULT.parent.mkdir(exist_ok=True)
    others = json.loads(RESULT.read_text()) if patterns and RESULT.exists() else []
    rows = [row for row in others if row["op"] not in entries] + [asdict(c) for c in checks]
    RESULT.write_text(json.dumps(rows, indent=0) + "\n")
    console.print(summary(checks))
    failed = [c for c in checks if c.message]
    for c in failed[:40]:
        console.print(
            f"[red]FAIL[/] {c.op} {c.method} {c.dtype} {c.backend} {c.shape}: {c.message}", highlight=False
        )
    print(f"parity: {len(checks)} checks of {len(entries)} ops, {len(failed)} failed")
    return 1 if failed or not checks else 0


def checked(names: list[str]) -> Iterator[list[Check]]:
    """Each op's checks."""
    # Spawned, not forked: engines do not survive a fork.
    context, workers = multiprocessing.get_context("spawn"), len(os.sched_getaffinity(0))
    for start in range(0, len(names), workers * PER_WORKER):
        with ProcessPoolExecutor(workers, context) as pool:
            yield from pool.map(check_op, names[start : start + workers * PER_WORKER])


def reduces(outputs: list[TensorSpec]) -> bool:
    """Whether no output is as large as an image, so that its values may be sums over all pixels."""
    return not any(re.search(r"\b[HW]\b", str(size)) for output in outputs for size in output.shape)


def check_op(name: str) -> list[Check]:
    """All checks of one op, in a process of the pool."""
    warnings.simplefilter("ignore")
    _loaded.clear()
    return list(check_bundle(name, catalog()[name]))


def check_bundle(name: str, entry: Entry) -> Iterator[Check]:
    folder = BUNDLES / f"{name}.chiasm"
    manifest = read_manifest(folder)
    spec = entry.spec
    op = bind_spec(entry.function(), spec)
    outputs = [
        TensorSpec(t["name"], tuple(t["shape"]), t["dtype"])
        for t in manifest["methods"]["forward"]["outputs"]
    ]
    eager = {"forward": op, "vjp": vjp_module(op, spec, outputs)}
    for method, signature in manifest["methods"].items():
        for variant in spec.variants():
            run = set()
            for sizes in (
                *example_inputs.TESTS,
                *([FRAME] if method == "forward" and reduces(outputs) else []),
            ):
                fitted = example_inputs.fit(spec, sizes)
                tensors = [TensorSpec(t["name"], tuple(t["shape"]), t["dtype"]) for t in signature["inputs"]]
                inputs = with_cotangents(op, spec, fitted, variant, tensors)
                expected = run_eager(eager[method], inputs)
                shape = " ".join(f"{k}{v}" for k, v in fitted.items())
                for backend, artifact, runner in runners(folder, manifest, method, variant):
                    run.add(artifact)
                    error, message = judged(runner, inputs, expected, signature)
                    yield Check(name, method, variant or "", backend, artifact, shape, error, message)
            for artifact in signature["artifacts"]:
                serves = not artifact["dtypes"] or variant in artifact["dtypes"]
                if serves and artifact["file"] not in run and artifact.get("isa") != "x86-64-v4":
                    yield Check(
                        name,
                        method,
                        variant or "",
                        artifact["backend"],
                        artifact["file"],
                        "",
                        float("inf"),
                        "no backend ran this artifact",
                    )


_loaded: dict[tuple, Runner] = {}  # for one op: check_op clears it, because engines hold memory


def runners(
    folder: Path, manifest: dict, method: str, variant: str | None
) -> Iterator[tuple[str, str, Runner]]:
    """(backend, artifact, run) for everything that serves this method and dtype; engines are loaded once."""
    artifacts = [
        a for a in manifest["methods"][method]["artifacts"] if not a["dtypes"] or variant in a["dtypes"]
    ]
    forms = {backend: [False] for backend in dict.fromkeys(a["backend"] for a in artifacts)}
    is_native = "native" in forms
    if is_native and "onnx" in forms:
        forms["onnx"] = [False, True]
    for backend, fused in [(b, f) for b in forms for f in forms[b]]:
        key = (folder, method, variant, backend, fused)
        if key not in _loaded:
            _loaded[key] = chiasm.runtime.open(folder).method(
                method, backend=backend, dtype=variant, fused=fused
            )
        loaded = _loaded[key]
        yield (
            f"C++ {backend}{' fused' * fused}",
            loaded.artifact,
            lambda inputs, m=loaded: as_tuple(m(*inputs.values())),
        )
    for artifact in (a for a in artifacts if a["format"] == "onnx"):
        for column in (
            ["Python onnx"]
            if "function" not in artifact
            else ["Python onnx body", "Python onnx fused"][: 1 + is_native]
        ):
            key = (folder, method, variant, artifact["file"], column)
            if key not in _loaded:
                _loaded[key] = onnx_session(
                    folder / artifact["file"], folder if column.endswith("fused") else None
                )
            yield column, artifact["file"], _loaded[key]


def as_tuple(result) -> tuple[torch.Tensor, ...]:
    return result if isinstance(result, tuple) else (result,)


def judged(runner: Runner, inputs, expected, method) -> tuple[float, str]:
    try:
        results = runner(inputs)
    except Exception as error:
        return float("inf"), f"{type(error).__name__}: {str(error).splitlines()[0]}"
    return compare(method, results, expected)


def summary(checks: list[Check]) -> Table:
    """A table of the largest error per op and method, with one column per backend."""
    backends = list(dict.fromkeys(c.backend for c in checks))
    table = Table(
        Column("op", no_wrap=True),
        "method",
        "dtype",
        *backends,
        title="parity: largest difference from eager Python",
        box=None,
    )
    by_row: dict[tuple, dict[str, list[Check]]] = {}
    for c in checks:
        by_row.setdefault((c.op, c.method, c.dtype), {}).setdefault(c.backend, []).append(c)
    for key, row in by_row.items():
        cells = []
        for backend in backends:
            some = row.get(backend, [])
            worst = max((c.error for c in some), default=0.0)
            cells.append(
                "" if not some else f"[{'red' if any(c.message for c in some) else 'green'}]{worst:.1e}[/]"
            )
        table.add_row(*key, *cells)
    return table


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
