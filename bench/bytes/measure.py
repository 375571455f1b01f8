"""What is measured, for one number of threads, which a process can set once.

    python -m bench.bytes.measure THREADS SECONDS [OP...]    -> a line of JSON, in microseconds, for each case
    and size

Results are compared before they are timed. Then chiasm's native backend, OpenCV's pip wheel and a copy of as
many bytes take turns.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping

import cv2
import numpy as np

import chiasm.runtime

from ..images.data import photograph
from ..machine import bundle_path
from ..opencv import Peer, peer
from ..wheel import PAUSE, copy_of, interleaved, room
from .cases import CASES, SIZES, Case


def main(threads: int, seconds: float, names: list[str]) -> None:
    chiasm.runtime.set_num_threads(threads)
    cv2.setNumThreads(threads)
    for size in SIZES:
        pixels = np.ascontiguousarray(photograph(*size).transpose(0, 2, 3, 1))
        for case in chosen(names):
            row = {"bundle": case.name, "size": "x".join(map(str, size)), "threads": threads}
            print(json.dumps(row | measured(case, pixels, threads, seconds)), flush=True)


def chosen(names: list[str]) -> list[Case]:
    """The cases whose bundle has one of the names in it; all where there is none."""
    return [c for c in CASES if not names or any(n in c.bundle for n in names)]


def measured(case: Case, pixels: np.ndarray, threads: int, seconds: float) -> dict:
    opened = chiasm.runtime.open(bundle_path(case.bundle))
    method = opened.method("forward", backend="native", dtype="uint8")
    given = inputs(case, opened.info["methods"]["forward"], pixels)
    outputs = room(method, given)
    theirs = peer(list, case.peer, given)
    method.run_into(given, outputs)
    difference = compared(case, outputs[0], theirs)
    contenders = {
        "native": lambda: method.run_into(given, outputs),
        "opencv": theirs.call,
        "copy": copy_of([pixels, *outputs]),
    }
    times = interleaved(list(contenders.values()), seconds, PAUSE if threads > 1 else 0.0)
    return {"difference": difference, "wheel": dict(zip(contenders, times, strict=True))}


def inputs(case: Case, signature: Mapping, pixels: np.ndarray) -> list[np.ndarray]:
    """The method's inputs in its order."""
    others = case.others(*pixels.shape[:3])
    made = []
    for tensor in signature["inputs"]:
        if tensor["layout"] == "NHWC":
            made.append(pixels)
        else:
            value = np.asarray(others[tensor["name"]], tensor["dtype"])
            made.append(value if value.ndim else np.full(len(pixels), value))
    return made


def compared(case: Case, ours: np.ndarray, theirs: Peer) -> int:
    """By how many levels the results differ at most; the process ends where they may not."""
    theirs.call()
    result = theirs.results()
    if ours.shape != result.shape:
        sys.exit(f"{case.name}: shapes {ours.shape} and {result.shape}")
    apart = case.apart(ours, result)
    inside = slice(case.edge, -case.edge or None)
    most = int(apart[:, inside, inside].max())
    if most > case.allowed:
        sys.exit(f"{case.name}: OpenCV's result differs by {most} levels, {case.allowed} are allowed")
    return most


if __name__ == "__main__":
    main(int(sys.argv[1]), float(sys.argv[2]), sys.argv[3:])
