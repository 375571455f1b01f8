"""make bench WHAT=matching: two views of a scene matched by one bundle, compared with OpenCV's SIFT, in C++
-> docs/benchmarks_matching.md."""

from __future__ import annotations

from dataclasses import replace
from datetime import date
from statistics import mean, median

import cv2
from rich.console import Console
from rich.progress import track

import chiasm
from chiasm.export import export
from chiasm.export.catalog import catalog
from tools.columns import wrapped

from ..machine import ROOT, cores, cpu, notes, said
from .pairs import CHANGES, Pair, pairs
from .score import score

PAGE = ROOT / "docs" / "benchmarks_matching.md"
PROGRAM = ROOT / "build" / "release" / "bin" / "bench_matching"
FOLDER = ROOT / "build" / "bench-matching"
PIPELINE, DETECTOR = "pipelines.two_view_homography", "feature.detect_keypoints.dog"
#: the options of the pipeline and of the detector, which needs the pipeline's default response and threshold
#: too. LIMITS: in the fourth octave, 27 taps must fit twice
OPTIONS = {"max_keypoints": 2500}
DETECTION = OPTIONS | {"response": "dog", "threshold": 0.005}
LIMITS = {"H": (210, 32768), "W": (218, 32768), "OH": (210, 32768), "OW": (218, 32768)}
TURNS = 5
#: the aim is for pairs in which OpenCV finds at least so many key points in both images
MANY = 2000


def main() -> int:
    with Console(stderr=True).status("exporting the bundles: takes minutes unless they are cached"):
        for name, options in ((PIPELINE, OPTIONS), (DETECTOR, DETECTION)):
            _export(name, options)
    made = pairs(FOLDER)
    rows = [
        row(pair, threads)
        for threads in sorted({1, cores()})
        for pair in track(made, f"{threads} thread{'s' * (threads > 1)}")
    ]
    PAGE.write_text(wrapped(page(rows)))
    print("\n".join(accuracy(rows) + [""] + speed(rows)))
    return 0


def _export(name: str, options: dict) -> None:
    """Export the catalog's op with the benchmark's options, native only."""
    entry = catalog()[name]
    symbols = entry.spec.symbols | {k: v for k, v in LIMITS.items() if k in entry.spec.symbols}
    export(
        entry.function(),
        replace(entry.spec, config=options, symbols=symbols),
        FOLDER,
        formats=("native",),
        methods=("forward",),
    )


def row(pair: Pair, threads: int) -> dict:
    found = said(
        PROGRAM,
        FOLDER / f"{PIPELINE}.chiasm",
        FOLDER / f"{DETECTOR}.chiasm",
        threads,
        TURNS,
        pair.first,
        pair.second,
    )
    shape = cv2.imread(str(pair.first), cv2.IMREAD_GRAYSCALE).shape
    scores = {name: score(found[name], pair.homography, shape) for name in ("chiasm", "OpenCV")}
    return {"pair": pair, "threads": threads, "version": found["opencv_version"]} | scores


def page(rows: list[dict]) -> str:
    lines = [
        "# Benchmark of matching",
        "",
        (
            f"Made by `make bench WHAT=matching` on {date.today()}: {cpu()}, {cores()} cores. chiasm"
            f" {chiasm.__version__}'s bundle `{PIPELINE}`, of 2500 slots, native, and Debian's OpenCV"
        ),
        (
            f"{rows[0]['version']} (SIFT of at most 2500 features, BFMatcher with the ratio test,"
            " findHomography with RANSAC), in C++, in turns in one process."
        ),
        (
            "Ten photographs of scikit-image, each warped by six homographies, one for each change of the"
            " table (bench/matching/pairs.py)."
        ),
        "",
        (
            "*Repeatability*: share of the key points in the common part of both images that have a key point"
            " of the other image within 3 pixels; *matching score*: correct"
        ),
        (
            "matches as a share of the same key points; *precision*: share of correct matches; *corner"
            " error*: mean distance between the four corners as mapped by the homography and by the truth."
        ),
        "",
        *accuracy(rows),
        "",
        "Time per pair, from bytes to the homography, median over the pairs:",
        "",
        *speed(rows),
    ]
    return "\n".join(lines) + "\n" + notes(PAGE)


def accuracy(rows: list[dict]) -> list[str]:
    """A table by kind of change, from the runs on one thread: the number of threads does not affect
    results."""
    lines = [
        (
            "| change | by | key points | repeatability | matching score | precision | median corner error |"
            " within 1 px | within 3 px |"
        ),
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for change in (*CHANGES, "all"):
        for name in ("chiasm", "OpenCV"):
            of = [r[name] for r in rows if r["threads"] == 1 and change in (r["pair"].change, "all")]
            means = [
                f"{mean(s[k] for s in of):.3f}" for k in ("repeatability", "matching_score", "precision")
            ]
            errors = [s["error"] for s in of]
            within = [f"{sum(e <= limit for e in errors)} of {len(errors)}" for limit in (1, 3)]
            lines.append(
                f"| {change} | {name} | {mean(s['keypoints'] for s in of):.0f} | {' | '.join(means)} |"
                f" {median(errors):.3f} | {' | '.join(within)} |"
            )
    return lines


def speed(rows: list[dict]) -> list[str]:
    lines = [
        "| pairs | threads | number | chiasm ms | OpenCV ms | times as fast |",
        "|---|---|---|---|---|---|",
    ]
    for title, least in (("all", 0), (f"{MANY} or more key points by OpenCV", MANY)):
        for threads in sorted({r["threads"] for r in rows}):
            of = [r for r in rows if r["threads"] == threads and r["OpenCV"]["keypoints"] >= least]
            ours, theirs = (median(r[name]["ms"] for r in of) for name in ("chiasm", "OpenCV"))
            lines.append(
                f"| {title} | {threads} | {len(of)} | {ours:.1f} | {theirs:.1f} |"
                f" {median(r['OpenCV']['ms'] / r['chiasm']['ms'] for r in of):.2f} |"
            )
    return lines


if __name__ == "__main__":
    raise SystemExit(main())
