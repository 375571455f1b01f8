"""Tests every op on every backend with NaN, infinities, zeros and extreme numbers.

    python tests/parity/special_values.py               every bundle in build/bundles
    python tests/parity/special_values.py PATTERN...    these ops
    --seconds 60                                        some cases of each op, as many as fit into that time
    --bundles FOLDER OP --case "input=nan, all"         one case

Each value of special_cases.py is put into each input: into all of it, one element, a row. Calls run in child
processes. None may end by a signal, take longer than 10 s of CPU time, or use more than 4 times the memory of
a normal call (plus 64 MiB). Unless eager Python's result depends on rounding, every backend must give the
same within the spec's tolerance, NaN for NaN and infinity for infinity; a spec's `special_values` lists
exceptions and their reasons. The last line printed is `special values: N calls of K of L ops, M failed`; the
exit status is 1 if something failed.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from fnmatch import fnmatch
from pathlib import Path

from rich.console import Console
from rich.progress import track
from selection import lot

from chiasm.export.catalog import catalog

ROOT = Path(__file__).resolve().parents[2]
WORKER = Path(__file__).with_name("special_values_worker.py")
#: The most CPU time of one call, and the most wall-clock time, for a machine that is busy with other work.
PROCESSOR_SECONDS, CLOCK_SECONDS = 10.0, 90.0
#: After so many child processes of one op have died, its other cases are skipped.
DEATHS = 6
#: Ops whose results are not compared, with the reason; their calls must only end normally.
_ROUNDING = "with such numbers among others the result is what rounding left of these"
_NO_MODEL = "of such points there is no model, or any"
_DOCUMENTED = "documented for values well below 1e4, which stands for what a structuring element leaves out"
_SINGULAR = "a matrix that such numbers make singular has an inverse by rounding alone"
_OVERFLOW = "squares of such numbers overflow"
NOT_COMPARED = {
    "augmentation.random_jpeg": _ROUNDING,
    "contrib.interp": "documented for positions that increase",
    "contrib.kmeans": _ROUNDING,
    "feature.detect_keypoints.gftt": _ROUNDING,
    "feature.detect_keypoints.hessian": _ROUNDING,
    "feature.get_laf_descriptors.sift": "a constant image of such numbers has gradients by rounding alone",
    "filters.adaptive_threshold": "in a constant image rounding decides what is above its mean",
    "filters.fast_guided_blur": _OVERFLOW,
    "filters.get_gaussian_erf_kernel1d": "the differences of such a sigma's edges are lost to underflow",
    "filters.guided_blur": _OVERFLOW,
    "geometry.calibration.solve_pnp_dlt": _ROUNDING,
    "geometry.conversions.euler_from_quaternion": _OVERFLOW,
    "geometry.epipolar.essential_from_Rt": _ROUNDING,
    "geometry.epipolar.find_essential": _NO_MODEL,
    "geometry.epipolar.find_fundamental_7point": _NO_MODEL,
    "geometry.homography.find_homography_dlt_iterated": _NO_MODEL,
    "geometry.homography.find_homography_lines_dlt": _NO_MODEL,
    "geometry.homography.find_homography_lines_dlt_iterated": _NO_MODEL,
    "geometry.ransac.ransac_essential": _NO_MODEL,
    "ops.kalman_update": _OVERFLOW,
    "ops.ps_roi_pool": "documented for finite values, none of them 1e10 times others",
    **{
        f"geometry.transform.{name}": _SINGULAR
        for name in (
            "crop_and_resize3d",
            "crop_by_boxes3d",
            "crop_by_transform_mat3d",
            "get_tps_transform",
            "warp_perspective3d",
        )
    },
    **{
        f"morphology.{name}": _DOCUMENTED
        for name in (
            "bottom_hat",
            "closing",
            "dilation",
            "erosion",
            "gradient",
            "opening",
            "reconstruction",
            "top_hat",
        )
    },
}
#: The most seconds for an op's cases if the time is limited.
OP_SECONDS = 2.0


@dataclass
class Report:
    """The results of one op."""

    op: str
    calls: int = 0
    failures: list[dict] = field(default_factory=list)


class Child:
    """A worker process that is restarted after it has died."""

    def __init__(self) -> None:
        self.process: subprocess.Popen | None = None
        self.buffer = b""

    def start(self) -> subprocess.Popen:
        if self.process is None:
            environment = os.environ | {"OMP_NUM_THREADS": "1"}
            self.process = subprocess.Popen(
                [sys.executable, str(WORKER)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env=environment,
            )
            self.buffer = b""
        return self.process

    def stop(self) -> int:
        """End the process; its exit status."""
        assert self.process is not None
        self.process.kill()
        status = self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            assert pipe is not None
            pipe.close()
        self.process = None
        return status

    def lines(self) -> Iterator[str | None]:
        """The worker's lines, with None at intervals while there is no line. Ends with the process."""
        assert self.process is not None and self.process.stdout is not None
        pipe = self.process.stdout.fileno()
        while True:
            while b"\n" in self.buffer:
                line, _, self.buffer = self.buffer.partition(b"\n")
                yield line.decode()
            if select.select([pipe], [], [], 0.5)[0]:
                data = os.read(pipe, 1 << 16)
                if not data:
                    return
                self.buffer += data
            else:
                yield None

    def is_late(self, step: str, since: float, used: float) -> bool:
        """Whether a step has used its time; large graphs may take longer to load."""
        times = 10.0 if " load " in f" {step}" else 1.0
        return (
            self.processor_seconds() - used > times * PROCESSOR_SECONDS
            or time.monotonic() - since > times * CLOCK_SECONDS
        )

    def processor_seconds(self) -> float:
        assert self.process is not None
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def check(self, job: dict) -> Report:
        """Run an op's cases, in as many processes as necessary."""
        report = Report(job["op"])
        for _ in range(DEATHS):
            process = self.start()
            assert process.stdin is not None
            with contextlib.suppress(BrokenPipeError):  # it has died already; watch will notice
                process.stdin.write(json.dumps(job).encode() + b"\n")
                process.stdin.flush()
            fatal = self.watch(report)
            if fatal is None:
                return report
            step, message = fatal
            label, _, what = step.partition(" ")
            backend, _, case = what.partition(": ")
            report.failures.append(
                {"op": job["op"], "method": label, "backend": backend, "case": case, "message": message}
            )
            job["skipped"].append(step)
        report.failures.append(
            {
                "op": job["op"],
                "method": "",
                "backend": "",
                "case": "",
                "message": f"{DEATHS} processes have died: the rest is left out",
            }
        )
        return report

    def watch(self, report: Report) -> tuple[str, str] | None:
        """Read one op's answers. Returns (the step, the event) if the process died or had to be stopped."""
        step, since, used = "", 0.0, 0.0
        for line in self.lines():
            word, _, rest = (line or "").partition(" ")
            if word == "begin":
                step, since, used = rest, time.monotonic(), self.processor_seconds()
            elif word == "end":
                report.calls += 1
                step = ""
            elif word == "fail":
                report.failures.append(json.loads(rest))
            elif word == "done":
                return None
            elif line is None and step and self.is_late(step, since, used):
                self.stop()
                return step, f"did not end in {PROCESSOR_SECONDS:g} s"
        status = self.process.wait() if self.process else 0
        self.stop()
        return step, (
            f"ended by {signal.Signals(-status).name}" if status < 0 else f"ended with status {status}"
        )


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("patterns", nargs="*", default=["*"])
    parser.add_argument("--bundles", type=Path, default=ROOT / "build" / "bundles")
    parser.add_argument(
        "--seconds", type=float, default=0.0, help="stop after so long; 0: all cases, in all dtypes"
    )
    parser.add_argument("--case", action="append", default=[], help="only this case, as the table names it")
    parser.add_argument("--result", type=Path, default=ROOT / "build" / "special_values.json")
    chosen = parser.parse_args()
    names = [
        n
        for n in catalog()
        if any(fnmatch(n, p) for p in chosen.patterns) and (chosen.bundles / f"{n}.chiasm").is_dir()
    ]
    if chosen.seconds:
        names.sort(key=lambda n: (not has_native(chosen.bundles / f"{n}.chiasm"), lot(n)))
    common = {
        "bundles": str(chosen.bundles),
        "seconds": OP_SECONDS if chosen.seconds else 1e9,
        "mixed": bool(chosen.seconds),
        "cases": chosen.case,
    }
    console = Console(width=None if sys.stdout.isatty() else 180)
    reports = []
    jobs = [common | {"op": n, "skipped": [], "compared": n not in NOT_COMPARED} for n in names]
    for report in run(jobs, chosen.seconds or 1e9, console):
        reports.append(report)
        show(report, console)
    failures = [f for r in reports for f in r.failures]
    chosen.result.parent.mkdir(parents=True, exist_ok=True)
    chosen.result.write_text(json.dumps(failures, indent=0) + "\n")
    calls = sum(r.calls for r in reports)
    print(f"special values: {calls} calls of {len(reports)} of {len(names)} ops, {len(failures)} failed")
    return 1 if failures or not calls else 0


def show(report: Report, console: Console) -> None:
    """Print an op's failures, the first four of each backend."""
    shown: dict[tuple, int] = {}
    for f in report.failures:
        key = (f["method"], f["backend"])
        shown[key] = shown.get(key, 0) + 1
        if shown[key] <= 4:
            console.print(
                f"FAIL {f['op']} {f['method']} {f['backend']}: {f['case']}: {f['message']}",
                style="red",
                highlight=False,
                markup=False,
            )
    for (method, backend), count in shown.items():
        if count > 4:
            console.print(f"     {report.op} {method} {backend}: and {count - 4} more", highlight=False)


def has_native(bundle: Path) -> bool:
    return any(bundle.glob("forward.*.pt2"))


def run(jobs: list[dict], seconds: float, console: Console) -> Iterator[Report]:
    """The reports of as many jobs as fit into the time."""
    workers = len(os.sched_getaffinity(0))
    children = [Child() for _ in range(workers)]
    idle = list(children)
    end = time.monotonic() + seconds

    def one(job: dict) -> Report | None:
        if time.monotonic() > end:
            return None
        child = idle.pop()
        try:
            return child.check(job)
        finally:
            idle.append(child)

    with ThreadPoolExecutor(workers) as pool:
        reports = track(
            pool.map(one, jobs), "special values", total=len(jobs), console=console, transient=True
        )
        yield from (r for r in reports if r is not None)
    for child in children:
        if child.process is not None:
            child.stop()


if __name__ == "__main__":
    raise SystemExit(main())
