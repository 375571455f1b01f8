"""Tables for the pages: the times of a race and their ratio, for each op, size and number of threads."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterable


def table(
    rows: list[dict],
    peer: str,
    cells: Callable[[dict], tuple[list[str], float]],
    aims: tuple[float, float],
    more: Callable[[dict], list[str]] = lambda row: [],
    titles: Iterable[str] = (),
) -> list[str]:
    """A row for each op and size, with four columns for each number of threads, and the geometric means
    below."""
    threads = sorted({row["threads"] for row in rows})
    columns = ["op", "size", *titles]
    for n in threads:
        columns += [f"{n} thread{'s' * (n > 1)}: chiasm ms", "of copy", peer, "times as fast"]
    lines = [f"| {' | '.join(columns)} |", "|---" * len(columns) + "|"]
    ratios: dict[int, list[float]] = {n: [] for n in threads}
    slow: list[str] = []
    for first in (row for row in rows if row["threads"] == threads[0]):
        line = [first["bundle"], first["size"], *more(first)]
        for n in threads:
            row = next(
                r
                for r in rows
                if (r["bundle"], r["size"], r["threads"]) == (first["bundle"], first["size"], n)
            )
            shown, ratio = cells(row)
            line += shown
            ratios[n].append(ratio)
            if ratio < aims[1]:
                slow.append(row["bundle"])
        lines.append(f"| {' | '.join(line)} |")
    means = [f"{statistics.geometric_mean(r):.2f} on {n} thread{'s' * (n > 1)}" for n, r in ratios.items()]
    everything = statistics.geometric_mean([r for some in ratios.values() for r in some])
    said = f"{everything:.2f}" if everything >= aims[0] else f"**{everything:.2f}**"
    lines += ["", f"Geometric mean: {said} ({', '.join(means)}); the aim is {aims[0]:g}."]
    if aims[1]:
        lines.append(f"Rows under {aims[1]:g}: {', '.join(dict.fromkeys(slow)) or 'none'}.")
    return lines


def compared(
    race: str, ours: str, peer: str, bold: float, slanted: float
) -> Callable[[dict], tuple[list[str], float]]:
    """The cells of a row for one race: both times, our share of a copy's bandwidth, and how many times as
    fast ours is. Also returns this number."""

    def cells(row: dict) -> tuple[list[str], float]:
        ratio = row[race][peer] / row[race][ours]
        return [
            ms(row[race][ours]),
            share(row[race], ours),
            ms(row[race][peer]),
            times(ratio, bold, slanted),
        ], ratio

    return cells


def share(race: dict, ours: str) -> str:
    """Our bandwidth (inputs read once, outputs written once) as a share of a copy's bandwidth in the same
    race."""
    return f"{race['copy'] / race[ours]:.0%}"


def ms(microseconds: float) -> str:
    return f"{microseconds / 1000:.3f}"


def times(ratio: float, bold: float, slanted: float) -> str:
    shown = f"{ratio:.2f}" if ratio < 9.95 else f"{ratio:.0f}"
    return f"***{shown}***" if ratio < slanted else f"**{shown}**" if ratio < bold else shown
