"""Selects the ops that a test run compiles natively, and the others that it exports to TorchScript and ONNX.

    python tests/parity/selection.py            list them, with reasons
    python tests/parity/selection.py OUTPUT     export them to OUTPUT

The whole catalog takes hours (`make test-all`). A run compiles the ops that its tests name, those whose
source has changed, and one more of each family. Of the rest it exports those that have changed, and every
thirtieth other one. A gradient takes most of an export's time: only ops that have changed, those whose
gradient a test takes, and every sixteenth of the others have it. The contents of the sources and the number
of commits decide which ones these are, so that each commit takes other ones. tests/changes.py says what the
sources are compared with.
"""

from __future__ import annotations

import hashlib
import os
import re
import sys
from fnmatch import fnmatch
from itertools import groupby
from pathlib import Path

from rich.console import Console

from chiasm.export.catalog import catalog
from chiasm.export.workers import Wanted, export_all

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from tests.changes import changed_files, source_of, turn  # noqa: E402

PER_FAMILY = 1
CHANGED = "has changed"
#: Files that name ops of which they read no bundle here.
APART = (
    "aarch64.py",
    "other_runtimes.py",
    "sanitized_artifacts.py",
    "special_values.py",
    "test_documents.py",
    "test_export.py",
    "test_native_sums.py",
    "test_onnx_docs.py",
    "test_onnx_merging.py",
    Path(__file__).name,
)
#: Ops whose gradient tests take natively.
DIFFERENTIATED = ("filters.sobel",)
#: One of so many ops that are not compiled and have not changed is exported.
EXPORTED = 30
#: One of so many exported ops is exported with its gradient.
GRADIENTS = 16
#: Ops that take minutes to compile and are left to `make test-all`, unless a test names them.
SLOW = (
    "augmentation.*_augment",
    "augmentation.aug_mix",
    "contrib.diamond_square.*",
    "feature.detect_keypoints.*",
    "feature.match_adalam.*",
    "losses.hausdorff_*",
    "ops.*_track",
    "ops.linear_assignment",
    "pipelines.two_view_homography",
    "geometry.epipolar.find_*",
    "geometry.epipolar.motion_from_*",
    "geometry.epipolar.project_to_essential",
    "geometry.homography.find_*",
    "geometry.pnp.*",
    "geometry.quaternion.average_quaternions",
    "geometry.ransac.*",
    "geometry.solvers.solve_cubic",
    "geometry.solvers.solve_quartic",
    "geometry.subpix.conv_*",
    "geometry.subpix.iterative_*",
    "geometry.transform.*3d",
    "losses.*_information_loss_3d*",
)
#: If a commit changes more ops than these, only some of them are compiled and exported, so that a test run
#: does not take hours; the rest waits for `make test-all`.
MOST_COMPILED, MOST_EXPORTED = 8, 48


def lot(name: str) -> bytes:
    """An op's position in an order that depends on the content of its source."""
    source = ROOT / source_of(catalog()[name].function())
    return hashlib.sha256(name.encode() + source.read_bytes()).digest()


def chosen() -> tuple[dict[str, str], list[str]]:
    """The ops to compile, each with the reason; and those to export without compiling."""
    entries = catalog()
    folders = [
        ROOT / "tests" / name
        for name in ("data", "export", "parity", "runtime", "robustness", "consumer", "serving")
    ]
    files = [p for folder in folders for p in folder.rglob("*") if p.suffix in (".py", ".cpp", ".sh", ".c")]
    tests = [p for p in files if p.name not in APART]
    words = re.findall(r"\b[a-z]+(?:\.[a-z0-9_]+)+", " ".join(p.read_text() for p in tests))
    named = {w.removesuffix(".chiasm") for w in words} & set(entries)
    changed = changed_files()
    source = {n: source_of(entry.function()) for n, entry in entries.items()}
    slow = {n for n in entries if any(fnmatch(n, pattern) for pattern in SLOW)}
    differing = [n for n in entries if source[n] in changed]
    touched = sorted((n for n in differing if n not in slow), key=lot)
    result = {n: "a test names it" for n in sorted(named)}
    for name in touched[:MOST_COMPILED]:
        result[name] = f"{source[name]} {CHANGED}"
    for _, family in groupby(entries, key=lambda n: n.partition(".")[0]):
        others = [n for n in family if n not in named]  # named ops are the same in every run
        due = PER_FAMILY - sum(n in result for n in others)
        rest = sorted((n for n in others if n not in result and n not in slow), key=lot)
        for place in range(min(due, len(rest))):
            result[rest[(turn() + place) % len(rest)]] = "one of its family"
    others = sorted((n for n in differing if n not in result), key=lot)
    if len(touched) > MOST_COMPILED or len(others) > MOST_EXPORTED:
        Console(stderr=True).print(
            f"{len(differing)} ops have changed: at most {MOST_COMPILED} of them are compiled and"
            f" {MOST_EXPORTED} exported to the other formats, `make test-all` does all",
            style="yellow",
        )
    same = sorted((n for n in entries if n not in result and n not in differing), key=lot)
    return result, others[:MOST_EXPORTED] + same[turn() % EXPORTED :: EXPORTED]


def main(arguments: list[str]) -> None:
    native, others = chosen()
    if not arguments:
        for name, reason in native.items():
            print(f"{name:56} {reason}")
        print(f"and {len(others)} without native code: {', '.join(others)}")
        return
    without_native = ("torchscript", "onnx")
    every = (*without_native, "native")
    whole = [n for n, reason in native.items() if n in DIFFERENTIATED or reason.endswith(CHANGED)]
    sampled = [n for n in others[::GRADIENTS] if not any(fnmatch(n, pattern) for pattern in SLOW)]
    both, forward = ("forward", "vjp"), ("forward",)
    # those that take longest first
    ops = [Wanted(n, every, methods=both) for n in whole]
    ops += [Wanted(n, every, methods=forward) for n in native if n not in whole]
    ops += [Wanted(n, without_native, methods=both) for n in sampled]
    ops += [Wanted(n, without_native, methods=forward) for n in others if n not in sampled]
    export_all(ops, Path(arguments[0]), jobs=len(os.sched_getaffinity(0)))


if __name__ == "__main__":
    main(sys.argv[1:])
