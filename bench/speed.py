"""make bench: chiasm compared with ONNX Runtime and OpenCV, interleaved in one process, medians ->
docs/benchmarks.md.

All are measured twice: in C++ with Debian's OpenCV, and in Python with OpenCV's pip wheel, which has IPP.
chiasm is compared with the faster OpenCV of the two.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import zipfile
from datetime import date

from rich.progress import track

from tools.columns import wrapped

from .machine import ROOT, bundle_path, cores, cpu, export_bundles, notes, program
from .tables import share

PAGE = ROOT / "docs" / "benchmarks.md"
#: the size of a frame from which a network's input is made
FRAME = (480, 640)
SIZES = ((1, 256, 256), (8, 256, 256), (1, 1080, 1920))
#: bundle, sizes, and the aim in times as fast as OpenCV (None: no aim)
SPEED = (
    ("filters.sobel", SIZES, 2.0),
    ("filters.gaussian_blur2d", SIZES, 1.0),
    ("pipelines.edges", SIZES, 2.0),
    ("pipelines.preprocess", ((1, 1080, 1920),), 1.0),
    ("filters.bilateral_blur", SIZES[1:], None),
    ("filters.median_blur", SIZES[1:], None),
    ("morphology.dilation", SIZES[1:], None),
    ("color.rgb_to_grayscale", SIZES[1:], None),
    ("color.rgb_to_hsv", SIZES[1:], None),
    ("geometry.transform.resize.bilinear", SIZES[1:], None),
    ("geometry.transform.warp_perspective.bilinear_zeros", SIZES[1:], None),
)


def main() -> int:
    export_bundles(bundle for bundle, _, _ in SPEED)
    threads = sorted({1, cores()})
    runs = [(bundle, aim, size, n) for bundle, sizes, aim in SPEED for size in sizes for n in threads]
    rows = [speed_row(*run) for run in track(runs, description="speed")]
    loads = [
        (b, program("load", bundle_path("filters.sobel"), b))
        for b in track(("native", "onnx", "torch"), description="load")
    ]
    waits = [
        (n, count, program("latency", bundle_path("pipelines.preprocess"), n, count, *FRAME))
        for n in (0, 1)
        for count in track((1, 2, 8), description="latency")
    ]
    PAGE.write_text(wrapped(page(rows, loads, waits, measure_overhead())))
    print(PAGE.read_text())
    return 0


def speed_row(bundle: str, aim: float | None, size: tuple[int, int, int], threads: int) -> dict:
    debian = program("speed", bundle_path(bundle), threads, *size)
    # In a separate process: a process can set the runtime's thread count only once.
    done = subprocess.run(
        [sys.executable, "-m", "bench.wheel", bundle, str(threads), *map(str, size)],
        capture_output=True,
        text=True,
        cwd=ROOT,
    )
    if done.returncode:
        sys.exit(f"bench.wheel {bundle}: {done.stderr}")
    wheel = json.loads(done.stdout)
    return {
        "bundle": bundle,
        "aim": aim,
        "size": "x".join(map(str, size)),
        "threads": threads,
        "debian": debian,
        "wheel": wheel,
    }


def measure_overhead() -> dict:
    library = ROOT / "build" / "bench-sobel.so"
    with zipfile.ZipFile(bundle_path("filters.sobel") / "forward.float32.x86-64-v3.pt2") as archive:
        library.write_bytes(archive.read("chiasm/op.so"))
    return program("overhead", bundle_path("filters.sobel"), library)


def page(rows: list[dict], loads: list, waits: list, overhead: dict) -> str:
    import cv2

    lines = [
        "# Benchmarks",
        "",
        f"Made by `make bench` on {date.today()}: {cpu()}, {cores()} cores, shared with other work;",
        (
            "chiasm in C++ (native backend, into the caller's buffers) and OpenCV take turns in one process,"
            " on several threads each after a pause and calls that do not count; medians."
        ),
        (
            f"OpenCV is the faster of Debian's {rows[0]['debian']['opencv_version']} (C++) and the wheel"
            f" {cv2.__version__} (with IPP), each measured with"
        ),
        (
            "chiasm in its own process. *Times as fast* is OpenCV's time over chiasm's; a missed aim is"
            " **bold**. *Of copy* is the bandwidth (inputs"
        ),
        (
            "read once, outputs written once) as a share of the bandwidth of one thread's memcpy of as many"
            " bytes in the same run."
        ),
        "",
        "| bundle | size | threads | chiasm ms | of copy | OpenCV ms | times as fast | aim | OpenCV |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        peer = min(("debian", "wheel"), key=lambda k: row[k]["opencv"] / row[k]["native"])
        times, aim = row[peer], row["aim"]
        ratio = times["opencv"] / times["native"]
        shown = f"**{ratio:.2f}**" if aim and ratio < aim else f"{ratio:.2f}"
        lines.append(
            f"| {row['bundle']} | {row['size']} | {row['threads']} | {times['native'] / 1000:.3f} |"
            f" {share(times, 'native')} | {times['opencv'] / 1000:.3f} | {shown} | {aim or ''} | {peer} |"
        )
    lines += onnx_table(rows)
    lines += [
        "",
        "## Time to the first result, and memory without the bare program (sobel, 256 x 256)",
        "",
        "| backend | first result ms | memory MB |",
        "|---|---|---|",
    ]
    lines += [f"| {b} | {r['first_result_ms']:.1f} | {r['memory_mb']:.1f} |" for b, r in loads]
    lines += [
        "",
        "## Latency of concurrent callers (preprocess, a frame of 480 x 640 to 224 x 224, native)",
        "",
        "Several threads call one method. `num_threads` is the method's option: with 1, a call uses no other",
        "thread. The aim: with `num_threads` 1 and two callers, p99 within 2 medians.",
        "",
        "| num_threads | callers | median ms | p99 ms | calls in 10 s |",
        "|---|---|---|---|---|",
    ]
    lines += [
        f"| {n or 'all'} | {count} | {r['median_ms']:.3f} | {r['p99_ms']:.3f} | {r['calls']} |"
        for n, count, r in waits
    ]
    extra = overhead["chiasm_us"] - overhead["engine_us"]
    lines += [
        "",
        "## The runtime's own cost (native sobel, 1x3x16x16, one thread)",
        "",
        (
            f"`run_into` {overhead['chiasm_us']:.2f} us, the artifact's own call {overhead['engine_us']:.2f}"
            f" us: {extra:.2f} us for validation and dispatch (aim: under 5)."
        ),
        "",
    ]
    return "\n".join(lines) + notes(PAGE)


def onnx_table(rows: list[dict]) -> list[str]:
    """Inside ONNX Runtime: the stock graph, and the fused node, which should take at most 10 % or 30 us more
    than native code."""
    lines = [
        "",
        "## Inside ONNX Runtime",
        "",
        (
            "The same ONNX files in the same run: the graph of standard operators (*stock*), and the fused"
            " node with the plug-in."
        ),
        (
            "Aims: fused within 10 % or 30 us of native, and not slower than OpenCV in the geometric mean."
            " Missed aims are **bold**."
        ),
        "",
        (
            "| bundle | size | threads | stock ms | fused ms | of copy | native ms | stock / fused | OpenCV /"
            " fused |"
        ),
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for place, title in (("debian", "in C++"), ("wheel", "in Python")):
        for row in rows:
            t = row[place]
            near = t["fused"] <= max(1.1 * t["native"], t["native"] + 30)
            fused = f"{t['fused'] / 1000:.3f}"
            lines.append(
                f"| {row['bundle']} {title} | {row['size']} | {row['threads']} | {t['stock'] / 1000:.3f} |"
                f" {fused if near else f'**{fused}**'} | {share(t, 'fused')} | {t['native'] / 1000:.3f} |"
                f" {t['stock'] / t['fused']:.1f} | {t['opencv'] / t['fused']:.2f} |"
            )
    for place, title in (("debian", "C++"), ("wheel", "Python")):
        means = {
            k: statistics.geometric_mean(r[place][k] / r[place]["fused"] for r in rows)
            for k in ("opencv", "stock", "native")
        }
        lines.append("")
        lines.append(
            f"{title}: in the geometric mean the fused node is {means['stock']:.1f} times as fast as the"
            f" stock graph, {means['opencv']:.2f} times as fast as OpenCV, {means['native']:.2f} times as"
            " fast as the native backend."
        )
    return lines


if __name__ == "__main__":
    raise SystemExit(main())
