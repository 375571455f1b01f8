"""Bundles on this machine's CPU and, under qemu, on aarch64: the same results.

    make build-aarch64                            # the runtime and the libraries of native code for aarch64
    python tests/parity/aarch64.py                # the ops below
    python tests/parity/aarch64.py 'filters.*'    # other ops

Each op is exported to one bundle with native code for both. `replay` (tests/runtime/replay.cpp), compiled
for both, self-tests it against eager Python's golden values within the manifest's tolerances. The results of
the ops below must have the same bits. Exceptions are listed with the reason, and an exception that no longer
differs is a failure. For other ops, differences are only reported. The results are added to
build/aarch64.json, which `make coverage` reads. The last line printed is `aarch64: N results of K ops, M
differ, L failed`; the exit status is 1 if something failed.
"""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
from fnmatch import fnmatch
from pathlib import Path

from rich.console import Console

from chiasm.export.catalog import catalog
from chiasm.export.workers import export_names

ROOT = Path(__file__).resolve().parents[2]
BUNDLES = ROOT / "build" / "aarch64" / "bundles"
REPORT = ROOT / "build" / "aarch64.json"
QEMU = ("qemu-aarch64", "-L", "/usr/aarch64-linux-gnu")
SECONDS = 1800

#: One op of each family, and special cases: kernels of bytes, an index from data, loops, draws.
OPS = (
    "augmentation.random_affine",
    "color.rgb_to_hsv.frames",
    "contrib.histogram_matching",
    "enhance.equalize",
    "feature.harris_response",
    "filters.gaussian_blur2d.frames",
    "filters.sobel",
    "geometry.transform.warp_affine.bilinear_zeros",
    "image.draw_line",
    "losses.ssim_loss",
    "losses.total_variation",
    "metrics.psnr",
    "morphology.dilation",
    "ops.soft_nms",
    "pipelines.edges",
)

#: Ops whose results differ in their last bits, and why.
DIFFERS = {"losses.total_variation": "a sum is made of as many parts as a vector has numbers: eight, or four"}


def main(patterns: list[str]) -> int:
    console = Console(width=None if sys.stdout.isatty() else 140)
    names = [n for n in catalog() if any(fnmatch(n, p) for p in patterns or OPS)]
    if not names:
        console.print(f"no op of the catalog is like {' '.join(patterns)}")
        return 1
    isas = ("x86-64-v3", "armv8.2-a")
    jobs = len(os.sched_getaffinity(0))
    export_names(names, BUNDLES, ("native",), isas=isas, methods=("forward",), jobs=jobs)
    here = replay(names, ROOT / "build" / "release", ())
    there = replay(names, ROOT / "build" / "aarch64", QEMU)
    failures = [*here.failures, *(f"aarch64: {line}" for line in there.failures)]
    if here.results.keys() != there.results.keys():
        failures.append(f"results of one CPU alone: {sorted(here.results.keys() ^ there.results.keys())}")
    differing = {key[0] for key, bits in there.results.items() if here.results.get(key) != bits}
    for name in names:
        reason = DIFFERS.get(name)
        if name in differing and reason is None:
            if name in OPS:
                failures.append(f"{name}: other bits than on {platform.machine()}")
            else:
                console.print(f"{name}: other bits than on {platform.machine()}", highlight=False)
        if name not in differing and reason is not None:
            failures.append(f"{name}: the same bits, though DIFFERS says otherwise: {reason}")
    for failure in failures:
        console.print(f"[red]FAIL[/] {failure}", highlight=False)
    found = {
        name: {
            "error": there.errors.get(name),  # None: no self-test passed
            "same_bits": name not in differing,
            "message": next((line for line in there.failures if line.startswith(f"{name}: ")), ""),
        }
        for name in names
    }
    before = json.loads(REPORT.read_text()) if REPORT.exists() else {}
    REPORT.write_text(json.dumps(before | found, indent=1))
    results, ops = len(there.results), len({key[0] for key in there.results})
    print(f"aarch64: {results} results of {ops} ops, {len(differing)} differ, {len(failures)} failed")
    return 1 if failures or not results else 0


class Replayed:
    """What `replay` printed: the hash of each result by op, method, dtype, case and output; the largest error
    of each op's self-test; and failures."""

    def __init__(self, output: str) -> None:
        lines = output.splitlines()
        self.failures = [line.removeprefix("FAIL ") for line in lines if line.startswith("FAIL ")]
        words = [line.split() for line in lines if not line.startswith(("FAIL ", "replay: "))]
        self.errors: dict[str, float] = {}
        for word in words:
            if word[0] == "TEST":
                self.errors[word[1]] = max(float(word[3]), self.errors.get(word[1], 0))
        self.results = {tuple(word[:-1]): word[-1] for word in words if word[0] != "TEST"}


def replay(names: list[str], build: Path, emulator: tuple[str, ...]) -> Replayed:
    environment = os.environ | {"CHIASM_BACKEND_PATH": str(build / "lib"), "OMP_NUM_THREADS": "1"}
    done = subprocess.run(
        [*emulator, str(build / "bin" / "replay"), *(str(BUNDLES / f"{name}.chiasm") for name in names)],
        env=environment,
        capture_output=True,
        text=True,
        timeout=SECONDS,
    )
    replayed = Replayed(done.stdout)
    if done.returncode not in (0, 1) or (done.returncode and not replayed.failures):
        replayed.failures.append(f"replay ended with status {done.returncode}: {done.stderr.strip()[-400:]}")
    return replayed


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
