"""docs/benchmarks_images.md: a table for each question, every number of it from the run."""

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
#: how many times as fast as OpenCV, as Kornia, as Kornia's ONNX files: in the geometric mean, and at least
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
            "*Of copy* is the bandwidth, of inputs read once and outputs written once, as a share of that of"
            " one thread's copy of as many bytes in the same race."
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
    return [f"Left out, because native code of it needs libtorch: {', '.join(named)}.", ""] if named else []


def opencv_table(rows: list[dict]) -> list[str]:
    types = {op.bundle: op.opencv_type for op in OPS}
    lines = [
        "## Is it as fast as OpenCV?",
        "",
        (
            "chiasm's native backend into the caller's buffers, and OpenCV into matrices that are kept; its"
            " HWC matrices are made"
        ),
        (
            "beforehand. OpenCV's data are float32 as chiasm's; where it has the op for bytes only (`uint8"
            " inside`), converting there and back"
        ),
        "is part of its time. clahe has bytes in and out in both.",
        f"Aims: {OPENCV[0]} times as fast in the geometric mean, no op under {OPENCV[1]}.",
        f"Where OpenCV is faster the number is **bold**, under {OPENCV[1]} ***bold and slanted***.",
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
            "`Method.run_into` on arrays of NumPy, and Kornia on tensors with the same values, eager, in"
            " `torch.inference_mode()`."
        ),
        "Before each turn on two threads both rest until the other's threads sleep, and warm up.",
        f"Aim: {EAGER[0]:g} times as fast in the geometric mean. Where Kornia is faster the number is"
        " ***bold***." + (f" Kornia has no {', '.join(without)}." if without else ""),
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
            "Kornia's ops by `torch.onnx.export(dynamo=True)`, their parameters constants; chiasm's flat file"
            " of standard operators, and the fused one"
        ),
        (
            f"with the plug-in. The same sessions' options. Aims: {ONNX[0]:g} times as fast in the geometric"
            " mean, no op slower (***bold***)."
        ),
    ]
    if constant := [op.bundle for op in OPS if op.constant]:
        lines.append(
            f"chiasm's numbers are inputs, one for each image, but constants in {', '.join(constant)}."
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
            "`python -m bench.images.check`: what the peers make of the photographs at"
            f" {'x'.join(map(str, SIZE))}, against chiasm's values."
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
