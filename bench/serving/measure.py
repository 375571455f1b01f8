"""One measurement: perf_analyzer sends requests to a model by gRPC, with frames and results in shared
memory."""

from __future__ import annotations

import csv
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from tests.serving.server import VENV, Server

#: one result: (1, 3, 224, 224) float32
OUTPUT_BYTES = 3 * 224 * 224 * 4
#: the length of a window; perf_analyzer uses three
MILLISECONDS = 2000
#: percent by which the windows may differ: practically any, because the median of repeats is reported
STABILITY = 1000


@dataclass(frozen=True)
class Measured:
    """Requests per second; in microseconds, the latency that a client sees, and the server's time outside the
    model's own computation."""

    rate: float
    p50: float
    p99: float
    outside: float


def measure(server: Server, model: str, size: tuple[int, int], concurrency: int) -> Measured:
    before = _counted(server, model)
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.csv"
        command = [VENV / "bin" / "perf_analyzer", "-m", model, "-i", "grpc"]
        command += ["-u", f"127.0.0.1:{server.grpc_port}", "--shared-memory", "system"]
        command += ["--output-shared-memory-size", OUTPUT_BYTES, "--shape", f"frame:{size[0]},{size[1]},3"]
        command += ["--concurrency-range", concurrency, "-p", MILLISECONDS, "-s", STABILITY]
        done = subprocess.run(
            [*map(str, command), "-f", str(report)],
            env=os.environ | {"LD_LIBRARY_PATH": str(VENV / "lib" / "perf_analyzer")},
            capture_output=True,
            text=True,
        )
        if not report.exists():
            raise RuntimeError(f"perf_analyzer: {(done.stdout + done.stderr).strip()[-1000:]}")
        with report.open() as file:
            row = next(csv.DictReader(file))
    after = _counted(server, model)
    count = after["count"] - before["count"]
    outside = (after["success"] - before["success"] - after["infer"] + before["infer"]) / count / 1000
    return Measured(
        float(row["Inferences/Second"]), float(row["p50 latency"]), float(row["p99 latency"]), outside
    )


def _counted(server: Server, model: str) -> dict[str, int]:
    statistics = server.statistics(model)["inference_stats"]
    success, infer = statistics["success"], statistics["compute_infer"]
    return {"count": int(success["count"]), "success": int(success["ns"]), "infer": int(infer["ns"])}


@contextmanager
def busy_core() -> Iterator[None]:
    """Runs another process that keeps a core busy."""
    process = subprocess.Popen([sys.executable, "-c", "while True: pass"])
    try:
        yield
    finally:
        process.kill()
        process.wait()
