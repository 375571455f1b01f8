"""docs/benchmarks_augmentation.md."""

from __future__ import annotations

from datetime import date
from textwrap import fill
from typing import Any

from ..machine import ROOT, cores, cpu, notes
from .race import ALBUMENTATIONS, BYTES, COMPILED, DALI, FLOAT, NATIVE, Contender
from .settings import SETTINGS as S
from .settings import STEPS

PAGE = ROOT / "docs" / "benchmarks_augmentation.md"
#: how many times as fast as the faster of each the native pipeline should be, on two threads
AIMS: dict[str, tuple[float, tuple[Contender, ...]]] = {
    "Kornia, compiled": (3.0, (COMPILED,)),
    "torchvision v2, the faster": (1.5, (BYTES, FLOAT)),
    "Albumentations": (1.0, (ALBUMENTATIONS,)),
    "DALI's CPU pipeline": (1.0, (DALI,)),
}


def page(found: dict[str, Any]) -> str:
    """``found``: as __main__.py gathers it."""
    versions = ", ".join(f"{name} {version}" for name, version in found["versions"].items())
    size, several = f"3 x {S.side} x {S.side}", found["batches"] * S.batch
    columns = [f"{n} thread{'s' * (n != '1')}: ms | of CPU | times as fast" for n in found["times"]]
    least, most = 1 - S.colours, 1 + S.colours
    lines = [
        "# Benchmark of augmentation",
        "",
        paragraph(
            f"Made by `make bench WHAT=augmentation` on {date.today()}: {cpu()}, {cores()} cores, shared with"
            f" other work (a load of {found['load']:.1f} before the run). {versions}."
        ),
        "",
        paragraph(
            f"{S.batch} photographs of {size}, bytes, become a batch of {S.batch} x {size} float32. Each"
            " image has parameters of its own, uniform in the same ranges for all contenders:"
        ),
        "",
        "| step | drawn for each image |",
        "|---|---|",
        f"| flip | left and right, with a probability of {S.flip:g} |",
        f"| crop | a box of {S.area[0]:g} to {S.area[1]:g} of the area, width / height {S.ratio[0]:.2f} to"
        f" {S.ratio[1]:.2f}, resized to {S.side} x {S.side}, bilinear |",
        f"| affine | {S.degrees:g} degrees and {S.shift:g} of the side to either side,"
        f" factor {S.scale[0]:g} to {S.scale[1]:g}, bilinear |",
        f"| jitter | brightness, contrast, saturation {least:g} to {most:g}, hue {S.hue:g} turns to either"
        " side, in an order drawn too |",
        f"| blur | Gaussian, {S.taps} x {S.taps} taps, deviation {S.sigma[0]:g} to {S.sigma[1]:g} pixels |",
        "| normalise | ImageNet's mean and deviation |",
        "",
        paragraph(
            "Each contender is a process of its own. They take turns: a call or two by the clock after one"
            " that does not count; medians, in milliseconds a batch. *Times as fast* is the contender's time"
            " over that of chiasm's native code; *of CPU* are the milliseconds of all its threads together,"
            " which other work on the machine disturbs less. Before the times, what contenders make is"
            " compared: the mean"
            f" of {several} results in {found['side']} x {found['side']} parts, and the deviation of all"
            " values."
        ),
        "",
        paragraph(
            "chiasm's images stay bytes while they are moved, and are float32 from the jitter on. Kornia"
            " takes float32 in [0, 1], made of the bytes within the time, and draws one order of the colours"
            " for a batch. torchvision and Albumentations take one image a call, and the batch is shared"
            " among as many Python threads as there are; *one draw a batch* gives all images the same"
            " parameters, which is less work. DALI makes no batch ahead; its colours have one order, its"
            " mirror image is taken by the operator that normalises, and its result is valid until its next"
            " run."
        ),
        "",
        f"| contender | {' | '.join(columns)} |",
        "|---" * (1 + 3 * len(columns)) + "|",
    ]
    for name in found["names"]:
        cells = []
        for times in found["times"].values():
            if name not in times:
                cells += [""] * 3
                continue
            took, busy = times[name]
            cells += [
                f"{took:.0f}",
                "" if busy is None else f"{busy:.0f}",
                f"{took / times[NATIVE.name][0]:.2f}",
            ]
        lines.append(f"| {name} | {' | '.join(cells)} |")
    lines += [f"\n{name} failed: {error}." for name, error in found["errors"].items()]
    lines += ["", *aims(found), "", *step_table(found), ""]
    return "\n".join(lines) + notes(PAGE)


def paragraph(text: str) -> str:
    return fill(text, 108, break_long_words=False, break_on_hyphens=False)


def aims(found: dict[str, Any]) -> list[str]:
    threads, times = list(found["times"].items())[-1]
    lines = [
        f"How many times as fast chiasm is on {threads} threads; **bold** where an aim is missed:",
        "",
        "| than | times as fast | aim |",
        "|---|---|---|",
    ]
    for name, (aim, peers) in AIMS.items():
        there = [times[p.name][0] for p in peers if p.name in times]
        if there:
            ratio = min(there) / times[NATIVE.name][0]
            shown = f"{ratio:.2f}" if ratio >= aim else f"**{ratio:.2f}**"
            lines.append(f"| {name} | {shown} | {aim:g} |")
    return lines


def step_table(found: dict[str, Any]) -> list[str]:
    names = list(next(iter(found["steps"].values())))
    lines = [
        paragraph(
            "Each step alone, of the same batch on one thread, in milliseconds of CPU. With chiasm, blur and"
            " normalise take and give float32, jitter takes bytes and gives float32, as in its pipeline. With"
            " the others steps give bytes but for normalise."
        ),
        "",
        f"| step | {' | '.join(names)} |",
        "|---" * (1 + len(names)) + "|",
    ]
    for step in STEPS:
        times = found["steps"][step]
        lines.append(f"| {step} | " + " | ".join(f"{times[name][1]:.1f}" for name in names) + " |")
    sums = [sum(found["steps"][step][name][1] for step in STEPS) for name in names]
    lines.append("| sum | " + " | ".join(f"{total:.0f}" for total in sums) + " |")
    return lines
