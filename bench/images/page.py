"""Writes docs/benchmarks_images.md: a table for each question, with all numbers from the run."""

from __future__ import annotations

import json
from datetime import date
from importlib.metadata import version

import cv2

import chiasm

from ..machine import ROOT, cores, cpu, notes
from ..tables import compared, table
from .check import REPORT, SIZE
from .chiasm_ops import measured
from .data import SIZES
from .kornia_peers import kornia, onnx_file
from .ops import OPS

PAGE = ROOT / "docs" / "benchmarks_images.md"
#: the aims, in times as fast as OpenCV, Kornia and Kornia's ONNX files: the geometric mean, and the minimum
OPENCV, EAGER, ONNX = (1.3, 0.7), (10.0, 0.0), (2.0, 1.0)


def page(rows: list[dict]) -> str:
    debian = rows[0]["debian"]["opencv_version"]
    lines = [
        "# Benchmarks of image ops",
        "",
        (
            f"Made by `make bench WHAT=images` on {date.today()}: {cpu()}, {cores()} cores. Contenders take"
            " turns in one process; medians."
        ),
        (
            f"chiasm {chiasm.__version__}, OpenCV {debian} (Debian, in C++) and {cv2.__version__} (wheel with"
            f" IPP, in Python), Kornia {kornia.__version__} on PyTorch {version('torch')}, ONNX Runtime"
            f" {version('onnxruntime')}."
        ),
        (
            "*Of copy* is the bandwidth (inputs read once, outputs written once) as a share of the bandwidth"
            " of one thread's copy of as many bytes in the same race."
        ),
        (
            "The inputs are photographs, three channels; [benchmarks.md](benchmarks.md) has pipelines,"
            " geometry and the runtime's own cost."
        ),
        "",
        *left_out(),
        *opencv_table(rows),
        *kornia_table(rows),
        *onnx_table(rows),
        *check_table({row["bundle"] for row in rows}),
    ]
    return "\n".join(lines) + "\n" + notes(PAGE)


def left_out() -> list[str]:
    named = [op.bundle for op in OPS if op not in measured()]
    return [f"Omitted, because their native code needs libtorch: {', '.join(named)}.", ""] if named else []


def opencv_table(rows: list[dict]) -> list[str]:
    types = {op.bundle: op.opencv_type for op in OPS}
    lines = [
        "## Is it as fast as OpenCV?",
        "",
        (
            "chiasm's native backend writes into the caller's buffers, and OpenCV into matrices that are"
            " reused; its HWC matrices are prepared"
        ),
        (
            "beforehand. OpenCV's data are float32 like chiasm's; if it has the op for bytes only (`uint8"
            " inside`), the conversion to bytes and back"
        ),
        "is part of its time. clahe takes and returns bytes in both.",
        f"Aims: {OPENCV[0]} times as fast in the geometric mean, no op under {OPENCV[1]}.",
        f"Numbers are **bold** if OpenCV is faster, and ***bold and slanted*** under {OPENCV[1]}.",
    ]
    for peer, title in (
        ("debian", "In C++, Debian's OpenCV"),
        ("wheel", "From Python, OpenCV's wheel, which has IPP"),
    ):
        lines += [
            "",
            f"### {title}",
            "",
            *table(
                rows,
                "OpenCV ms",
                compared(peer, "native", "opencv", 1.0, OPENCV[1]),
                OPENCV,
                lambda row: [types[row["bundle"]]],
                ["OpenCV's data"],
            ),
        ]
    return lines


def kornia_table(rows: list[dict]) -> list[str]:
    without = [op.bundle for op in OPS if not op.kornia]
    return [
        "",
        "## Is it faster than Kornia, from Python?",
        "",
        (
            "`Method.run_into` on NumPy arrays, and eager Kornia on tensors with the same values, in"
            " `torch.inference_mode()`."
        ),
        "Before each turn on two threads, a contender waits until the other's threads sleep, then warms up.",
        f"Aim: {EAGER[0]:g} times as fast in the geometric mean. Numbers are ***bold*** if Kornia is"
        " faster." + (f" Kornia has no {', '.join(without)}." if without else ""),
        "",
        *table(
            [r for r in rows if "kornia" in r],
            "Kornia ms",
            compared("kornia", "native", "kornia", 1.0, 1.0),
            EAGER,
        ),
    ]


def onnx_table(rows: list[dict]) -> list[str]:
    sizes = {"x".join(map(str, s)): s for s in SIZES}
    exported = [r for r in rows if "kornia" in r["onnx"]]
    by_name = {op.bundle: op for op in OPS if op.kornia}
    missing = sorted({r["bundle"] for r in rows if r["bundle"] in by_name} - {r["bundle"] for r in exported})
    fixed = sorted(
        {
            r["bundle"]
            for r in exported
            if str(onnx_file(by_name[r["bundle"]], sizes[r["size"]])).endswith(f".{sizes[r['size']][1]}.onnx")
        }
    )

    lines = [
        "",
        "## In ONNX Runtime, is it faster than Kornia's own export?",
        "",
        (
            "Kornia's ops, exported by `torch.onnx.export(dynamo=True)` with constant parameters; chiasm's"
            " flat file of standard operators, and its fused file"
        ),
        (
            f"with the plug-in. All sessions have the same options. Aims: {ONNX[0]:g} times as fast in the"
            " geometric mean, no op slower (***bold***)."
        ),
    ]
    if constant := [op.bundle for op in OPS if op.constant]:
        lines.append(
            f"chiasm's parameters are inputs, one per image, except in {', '.join(constant)}: constants."
        )
    if fixed:
        lines.append(f"Exported for one size, because the export for any size fails: {', '.join(fixed)}.")
    for form, title in (("flat", "Flat"), ("fused", "Fused, with the plug-in")):
        lines += [
            "",
            f"### {title}",
            "",
            *table(exported, "Kornia ms", compared("onnx", form, "kornia", *(ONNX[1],) * 2), ONNX),
        ]
    if missing:
        lines += ["", "Kornia's ops that cannot be exported:", ""]
        lines += [f"* {name}: {onnx_file(by_name[name], next(iter(sizes.values())))}" for name in missing]
    return lines


def check_table(bundles: set[str]) -> list[str]:
    report = json.loads(REPORT.read_text()) if REPORT.exists() else {}
    lines = [
        "",
        "## Is it the same work?",
        "",
        (
            "`python -m bench.images.check` compares the peers' results for photographs of"
            f" {'x'.join(map(str, SIZE))} with chiasm's."
        ),
        "",
        "| op | Debian's OpenCV | wheel | OpenCV differs in | Kornia | Kornia differs in |",
        "|---|---|---|---|---|---|",
    ]
    for op in OPS:
        if op.bundle in bundles & report.keys():
            text = {peer: row["text"] for peer, row in report[op.bundle].items()}
            cells = (
                op.bundle,
                text["debian"],
                text["wheel"],
                op.opencv_agrees.note,
                text.get("kornia", "no such op"),
                op.kornia_agrees.note,
            )
            lines.append(f"| {' | '.join(cells)} |")
    return lines
