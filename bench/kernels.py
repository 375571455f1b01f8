"""The kernels alone, on one thread, each beside a copy of as many bytes -> docs/benchmarks_kernels.md.

    make bench WHAT=kernels
    python -m bench kernels OTHER    # OTHER: the program kernels_bench of another tree, before a change

The second form prints how many times as fast this tree's kernels are as the other's, which take turns with
them; it writes no page. The measured calls are the benchmarks in tests/kernels/*_test.cpp.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
from datetime import date
from pathlib import Path

from rich.progress import track

from tools.columns import wrapped

from .machine import ROOT, cores, cpu, notes, said

PAGE = ROOT / "docs" / "benchmarks_kernels.md"
PROGRAM = ROOT / "build" / "release" / "bin" / "kernels_bench"
TURNS = 3


def measured(program: Path, name: str, seconds: float = 0.3) -> dict[str, float]:
    """The counters of one benchmark: ms, GB/s, of_copy_%."""
    options = (f"--benchmark_filter=^{name}$", f"--benchmark_min_time={seconds}", "--benchmark_format=json")
    return said(program, *options)["benchmarks"][0]


def names(program: Path) -> list[str]:
    call = [program, "--benchmark_list_tests"]
    return subprocess.run(call, capture_output=True, text=True, check=True).stdout.split()


def median(results: list[dict[str, float]]) -> dict[str, float]:
    """The result with the median time."""
    return sorted(results, key=lambda result: result["real_time"])[len(results) // 2]


def row(name: str, result: dict[str, float]) -> str:
    kernel, *size = name.removesuffix("/manual_time").split("/")
    share = f"{result['of_copy_%']:.0f}%"
    return f"| {kernel} | {'x'.join(size)} | {result['ms']:.3f} | {result['GB/s']:.1f} | {share} |"


def page() -> str:
    results = {
        name: median([measured(PROGRAM, name) for _ in range(TURNS)])
        for name in track(names(PROGRAM), "kernels")
    }
    order = sorted(results, key=lambda name: results[name]["of_copy_%"])
    lines = [
        "# Benchmarks of kernels",
        "",
        f"Made by `make bench WHAT=kernels` on {date.today()}: {cpu()}, {cores()} cores,",
        "shared with other work; one thread, medians of CPU time. *Of copy* is the bandwidth (inputs read",
        "once, outputs written once; all that the call holds, where a row has no size) as a share of a",
        "copy's of as many bytes, which takes turns with the kernel. Calls without a size are described in",
        "`tests/kernels`. Kernels that compute a lot for each byte have a small share.",
        "",
        "| benchmark | planes x height x width | ms | GB/s | of copy |",
        "|---|---|---|---|---|",
        *(row(name, results[name]) for name in order),
    ]
    return "\n".join(lines) + "\n" + notes(PAGE)


def compare(other: Path) -> None:
    """Print the other program's time over this one's, for each benchmark that both have."""
    ratios, known = {}, set(names(other))
    for name in track([name for name in names(PROGRAM) if name in known], "kernels"):
        turns = [(measured(other, name, 0.1), measured(PROGRAM, name, 0.1)) for _ in range(TURNS)]
        before, now = (median(list(results))["real_time"] for results in zip(*turns))
        ratios[name] = before / now
        print(f"{ratios[name]:6.2f}  {before:9.3f} -> {now:9.3f} ms  {name.removesuffix('/manual_time')}")
    slower = [name for name, ratio in ratios.items() if ratio < 0.97]
    print(f"geometric mean {statistics.geometric_mean(ratios.values()):.2f}; under 0.97: {len(slower)}")


if __name__ == "__main__":
    build = ["cmake", "--build", "--preset", "release", "--target", "kernels_bench"]
    subprocess.run(build, cwd=ROOT, check=True)
    if len(sys.argv) > 1:
        compare(Path(sys.argv[1]))
    else:
        PAGE.write_text(wrapped(page()))
        print(PAGE)
