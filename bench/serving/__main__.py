"""make bench WHAT=serving: a bundle in Triton's C++ backend, compared with the same work in its Python
backend -> docs/benchmarks_serving.md."""

from __future__ import annotations

import sys
import tempfile
from datetime import date
from pathlib import Path
from statistics import median
from textwrap import fill

from rich.progress import Progress

import chiasm
from tools.columns import wrapped

from ..machine import ROOT, bundle_path, cores, cpu, export_bundles, notes

sys.path.append(str(next((ROOT / ".deps" / "triton").glob("lib/*/site-packages"))))

from tests.serving.server import Server, write_model

from . import measure
from .measure import Measured

PAGE = ROOT / "docs" / "benchmarks_serving.md"
BUNDLE = "pipelines.preprocess"
SIZES = ((480, 640), (1080, 1920))
CONCURRENCY = (1, 2, 4)
REPEATS = 3
MODELS = {
    "chiasm": "the backend chiasm",
    "runtime": "Python backend, chiasm.runtime",
    "opencv": "Python backend, OpenCV",
}
Rows = dict[tuple[str, tuple[int, int], int], list[Measured]]


def main() -> int:
    export_bundles([BUNDLE])
    with tempfile.TemporaryDirectory() as folder:
        write_models(Path(folder) / "models")
        with Server(Path(folder)) as server:
            rows, busy = everything(server)
    PAGE.write_text(wrapped(page(rows, busy)))
    print("\n".join([*table(rows), "", *busy_table(busy)]))
    return 0


def write_models(repository: Path) -> None:
    write_model(repository / "chiasm", bundle_path(BUNDLE))
    config = f"""
input {{ name: "frame" data_type: TYPE_UINT8 dims: [-1, -1, 3] }}
output {{ name: "output" data_type: TYPE_FP32 dims: [1, 3, 224, 224] }}
instance_group {{ kind: KIND_CPU count: {cores()} }}
"""
    for name in ("runtime", "opencv"):
        version = write_model(repository / name)
        code = (Path(__file__).parent / "models" / f"{name}.py").read_text()
        code = code.replace("@SOURCES@", str(ROOT / "python")).replace("@BUNDLE@", str(bundle_path(BUNDLE)))
        (version / "model.py").write_text(code)
        (version.parent / "config.pbtxt").write_text('backend: "python"' + config)


def everything(server: Server) -> tuple[Rows, Rows]:
    """Measure the models in turns, in each of the repeats."""
    rows: Rows = {}
    busy: Rows = {}
    with Progress() as progress:
        task = progress.add_task("", total=REPEATS * len(SIZES) * len(MODELS) * (len(CONCURRENCY) + 1))
        for _ in range(REPEATS):
            for size in SIZES:
                for concurrency in CONCURRENCY:
                    for model in MODELS:
                        progress.update(task, advance=1, description=f"{model} {size} {concurrency}")
                        found = measure.measure(server, model, size, concurrency)
                        rows.setdefault((model, size, concurrency), []).append(found)
                for model in MODELS:
                    progress.update(task, advance=1, description=f"{model} {size} with a busy process")
                    with measure.busy_core():
                        found = measure.measure(server, model, size, 1)
                    busy.setdefault((model, size, 1), []).append(found)
    return rows, busy


def page(rows: Rows, busy: Rows) -> str:
    lines = [
        "# Benchmark of serving",
        "",
        fill(
            f"Made by `make bench WHAT=serving` on {date.today()}: {cpu()}, {cores()} cores, which the server"
            f" and the clients share. chiasm {chiasm.__version__}'s bundle `{BUNDLE}` converts a frame to a"
            f" normalised image of 224 x 224, in Triton 2.51, with {cores()} instances of each model, one"
            " thread each. perf_analyzer sends requests by gRPC, with frames and results in system shared"
            f" memory. The models take turns; figures are medians of {REPEATS} repeats. *Outside* is the"
            " server's time for a request without the model's own computation, from Triton's statistics.",
            110,
        ),
        "",
        *table(rows),
        "",
        "While another process keeps a core busy, one request at a time:",
        "",
        *busy_table(busy),
    ]
    return "\n".join(lines) + "\n" + notes(PAGE)


def middle(measured: list[Measured], field: str) -> float:
    return median(getattr(each, field) for each in measured)


def table(rows: Rows) -> list[str]:
    lines = [
        (
            "| frame | requests at once | model | requests/s | p50 ms | p99 ms | outside us | chiasm: times"
            " the requests | of the p99 |"
        ),
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for size in SIZES:
        for concurrency in CONCURRENCY:
            ours = rows["chiasm", size, concurrency]
            for model, title in MODELS.items():
                each = rows[model, size, concurrency]
                rate, p50, p99, outside = (middle(each, f) for f in ("rate", "p50", "p99", "outside"))
                ratios = (
                    ["", ""]
                    if model == "chiasm"
                    else [f"{middle(ours, 'rate') / rate:.2f}", f"{middle(ours, 'p99') / p99:.2f}"]
                )
                cells = [f"{size[1]} x {size[0]}", str(concurrency), title, f"{rate:.0f}"]
                cells += [f"{p50 / 1000:.2f}", f"{p99 / 1000:.2f}", f"{outside:.0f}", *ratios]
                lines.append(f"| {' | '.join(cells)} |")
    return lines


def busy_table(busy: Rows) -> list[str]:
    lines = [
        "| frame | model | requests/s | p50 ms | p99 ms | p99 / p50 |",
        "|---|---|---|---|---|---|",
    ]
    for size in SIZES:
        for model, title in MODELS.items():
            rate, p50, p99 = (middle(busy[model, size, 1], f) for f in ("rate", "p50", "p99"))
            lines.append(
                f"| {size[1]} x {size[0]} | {title} | {rate:.0f} | {p50 / 1000:.2f} | {p99 / 1000:.2f} |"
                f" {p99 / p50:.1f} |"
            )
    return lines


if __name__ == "__main__":
    raise SystemExit(main())
