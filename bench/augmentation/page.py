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
#: by name: how many times as fast as the fastest of these contenders the native pipeline should be, on two
#: threads
AIMS: dict[str, tuple[float, tuple[Contender, ...]]] = {
    "Kornia, compiled": (3.0, (COMPILED,)),
    "torchvision v2, the faster": (1.5, (BYTES, FLOAT)),
    "Albumentations": (1.0, (ALBUMENTATIONS,)),
    "DALI's CPU pipeline": (1.0, (DALI,)),
}


def page(found: dict[str, Any]) -> str:
    """``found``: the results, as collected in __main__.py."""
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
            f"A batch of {S.batch} photographs of {size}, bytes, becomes {S.batch} x {size} float32. Each"
            " image has its own parameters, uniform in the same ranges for all contenders:"
        ),
        "",
        "| step | drawn for each image |",
        "|---|---|",
        f"| flip | horizontal, with a probability of {S.flip:g} |",
        f"| crop | a box of {S.area[0]:g} to {S.area[1]:g} of the area, width / height {S.ratio[0]:.2f} to"
        f" {S.ratio[1]:.2f}, resized to {S.side} x {S.side}, bilinear |",
        f"| affine | angle up to +-{S.degrees:g} degrees, shift up to +-{S.shift:g} of the side,"
        f" scale {S.scale[0]:g} to {S.scale[1]:g}, bilinear |",
        f"| jitter | brightness, contrast, saturation {least:g} to {most:g}, hue up to +-{S.hue:g} turns,"
        " in random order |",
        f"| blur | Gaussian, {S.taps} x {S.taps} taps, sigma {S.sigma[0]:g} to {S.sigma[1]:g} pixels |",
        "| normalise | ImageNet's mean and standard deviation |",
        "",
        paragraph(
            "Each contender is a separate process. They take turns: one call that does not count, then one or"
            " two timed calls; medians, in milliseconds per batch. *Times as fast* is the contender's time"
            " divided by that of chiasm's native code; *of CPU* is the CPU time of all its threads together,"
            " in milliseconds, which other work on the machine disturbs less. Before timing, the contenders'"
            " results are compared: the mean"
            f" of {several} results in {found['side']} x {found['side']} parts, and the standard deviation of"
            " all values."
        ),
        "",
        paragraph(
            "chiasm's images stay bytes in the geometric steps, and are float32 from the jitter on. Kornia"
            " takes float32 in [0, 1]; the conversion is part of its time, and it draws one order of the"
            " colour changes per batch. torchvision and Albumentations take one image per call, and Python"
            " threads share the batch; *one draw a batch* gives all images the same parameters, which is less"
            " work. DALI prepares no batch ahead. Its colour changes have a fixed order, its operator that"
            " normalises also flips, and its result is valid until its next run."
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
        f"How many times as fast chiasm is on {threads} threads; a missed aim is **bold**:",
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
            "Each step alone, on the same batch and one thread, in milliseconds of CPU time. As in its"
            " pipeline, chiasm's blur and normalise take and return float32, and its jitter takes bytes and"
            " returns float32. The other contenders' steps return bytes, except normalise."
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
