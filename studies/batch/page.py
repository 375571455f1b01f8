"""The section's content: tables of times, and comparisons of chiasm with the others."""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from .in_cpp import CHIASM, OPENCV
from .ours import NATIVE
from .works import WORKS

#: contenders whose result differs, so that their times are not compared
OTHER_RESULT = ("OpenCV on bytes",)
AIM = 3.0


@dataclass
class Measured:
    """The measurements of a run."""

    #: by work and number of threads: contender -> batch size -> (milliseconds of a batch, repeats)
    times: dict[tuple[str, int], dict[str, dict[int, tuple[float, int]]]] = field(default_factory=dict)
    #: by work: contender -> the differences of its results from eager ones
    agreement: dict[str, dict[str, dict]] = field(default_factory=dict)
    #: by work: contender -> megabytes per image
    memory: dict[str, dict[str, float]] = field(default_factory=dict)

    def add(self, row: Mapping) -> None:
        """Add a row of a race, or a row of agreement, from either language."""
        if "agreement" in row:
            self.agreement.setdefault(row["work"], {}).update(row["agreement"])
            return
        times = self.times.setdefault((row["work"], row["threads"]), {})
        for name, time in row["times"].items():
            times.setdefault(name, {})[row["batch"]] = (time["ms"], time["repeats"])


def ours(name: str) -> bool:
    return name.startswith("chiasm")


def threads_text(count: int) -> str:
    return f"{count} thread{'s' * (count > 1)}"


def table(measured: Measured, work: str, threads: int, repeats: int) -> list[str]:
    """A table of milliseconds per image, sorted from the slowest to the fastest at the largest batch; the
    fastest of each size is bold."""
    times = measured.times[work, threads]
    sizes = sorted(next(iter(times.values())))
    memory = measured.memory.get(work)
    columns = [
        threads_text(threads),
        *map(str, sizes),
        "fewest repeats",
        *(["MB an image"] if memory else []),
    ]
    lines = [f"| {' | '.join(columns)} |", "|---" * len(columns) + "|"]
    fastest = {size: min(times, key=lambda name: times[name][size][0]) for size in sizes}
    for name in sorted(times, key=lambda name: -times[name][sizes[-1]][0]):
        cells = [f"{times[name][size][0] / size:.3g}" for size in sizes]
        cells = [
            f"**{cell}**" if fastest[size] == name else cell for cell, size in zip(cells, sizes, strict=True)
        ]
        few = min(count for _, count in times[name].values())
        cells.append("" if few == repeats else str(few))
        if memory:
            cells.append(f"{memory[name]:.2f}")
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return [*lines, ""]


def standing(measured: Measured, work: str, threads: int) -> str:
    """A sentence on how many times as fast as its peers native code is, and the batch sizes at which it is
    behind; for each language separately."""
    times, said = measured.times[work, threads], []
    for mine, peers in (
        (NATIVE, [n for n in times if not ours(n) and n != OPENCV and n not in OTHER_RESULT]),
        (CHIASM, [OPENCV]),
    ):
        ratios = {}
        for size, (ms, _) in times[mine].items():
            peer = min(peers, key=lambda name, size=size: times[name][size][0])
            ratios[size] = (times[peer][size][0] / ms, peer)
        behind = {size: r for size, r in ratios.items() if r[0] < 1}
        least, most = min(r for r, _ in ratios.values()), max(r for r, _ in ratios.values())
        names = "the fastest peer" if len(peers) > 1 else OPENCV
        text = (
            f"{mine}, is {least:.2f} to {most:.2f} times as fast as {names}"
            if mine == CHIASM
            else f"{mine} is {least:.2f} to {most:.2f} times as fast as {names}"
        )
        if behind:
            text += ", **behind** at " + ", ".join(
                f"{size} ({peer}, {ratio:.2f})" for size, (ratio, peer) in behind.items()
            )
        else:
            text += ": ahead at every batch size"
        said.append(text)
    return f"On {threads_text(threads)} " + "; ".join(said) + "."


def aim(measured: Measured, work: str, threads: int) -> str:
    """A sentence that compares the pipeline with the aim of three times OpenCV."""
    times = measured.times[work, threads]
    said = []
    for mine, peer in ((NATIVE, "OpenCV"), (CHIASM, OPENCV)):
        mean = statistics.geometric_mean([times[peer][size][0] / ms for size, (ms, _) in times[mine].items()])
        verdict = "reached" if mean >= AIM else f"**not reached**, {AIM / mean:.1f} times short of it"
        said.append(f"{mean:.2f} times {peer} ({verdict})")
    return (
        f"The aim is {AIM:g} times OpenCV. On {threads_text(threads)}, geometric mean of the batch sizes:"
        f" {'; '.join(said)}."
    )


def differences(measured: Measured, work: str) -> list[str]:
    """A table of the differences of results from chiasm's eager ones, over three photographs, with the
    reasons."""
    lines = ["| contender | mean difference | greatest | reason |", "|---|---|---|---|"]
    for name, found in measured.agreement[work].items():
        lines.append(f"| {name} | {found['mean']:.2g} | {found['most']:.2g} | {found['note']} |")
    return [*lines, ""]


def section(
    measured: Measured, settings: object, threads: Iterable[int], versions: Mapping[str, str], minutes: float
) -> list[str]:
    """The lines of docs/use_cases.md."""
    height, width = settings.size
    lines = [
        (
            f"Batches of scikit-image's photographs, RGB, {height} x {width}: the paper's measurement (4.1)"
            " and three pipelines. Every contender does the same work, which is"
        ),
        (
            "checked before timing; the tables after the times have the differences of results. Times are"
            " milliseconds *per image*, medians of"
        ),
        (
            f"{settings.repeats} repeats, or as many as fit into {settings.seconds:g} s (at least 3); the"
            " contenders take turns. A contender that takes one image per call processes a batch in a loop;"
        ),
        (
            "several threads share the images. Inputs are converted to the contender's form (NCHW, HWC,"
            " bytes) outside the measured time; results are allocated inside."
        ),
        (
            "Memory is the most that a batch adds to a process, with results and without inputs. torchvision"
            " is not a peer, because it has no Sobel. The paper's GPU was not available."
        ),
        (
            "The C++ rows are the program [batch.cpp](../studies/batch/batch.cpp) with the same bundles."
            f" The run took {minutes:.0f} minutes."
        ),
        "",
        f"Versions: {', '.join(f'{name} {version}' for name, version in versions.items())}.",
        "",
        "![photographs and results](use_cases/batch.png)",
        "",
    ]
    for name, work in WORKS.items():
        lines += [f"### {work.title}", "", work.said, "", f"![times](use_cases/batch_{name}.png)", ""]
        for count in threads:
            lines += [*table(measured, name, count, settings.repeats), standing(measured, name, count), ""]
            if name == "prepare":
                lines += [aim(measured, name, count), ""]
        lines += differences(measured, name)
    return lines
