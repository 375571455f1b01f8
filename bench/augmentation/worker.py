"""One contender in its own process:

    python -m bench.augmentation.worker MODULE FUNCTION IMAGES THREADS STEP...

It reads commands from its standard input, one per line, and answers each with a line of JSON:

    N         calls the contender once, then N times with timing: [seconds, seconds of CPU time] of each
    look N    statistics of N batches: their mean image, its variance (the mean over its values), and the
              deviation of all values
"""

from __future__ import annotations

import ctypes
import importlib
import json
import os
import sys
import time
import warnings
from typing import Any

import numpy as np

from .settings import Call

#: Height and width of a mean image, in parts of the batch's images.
LOOK = 7


def main(module: str, function: str, images: str, threads: str, *steps: str) -> None:
    # Only answers go to standard output: redirect what libraries print there.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    warnings.simplefilter("ignore")
    keep_memory()
    make = getattr(importlib.import_module(f".{module}", __package__), function)
    try:
        call: Call = make(np.load(images), steps, int(threads))
        call()
        ready = {"ready": True}
    except Exception as error:  # the page reports a contender's failure
        call, ready = (lambda: None), {"error": f"{type(error).__name__}: {error}".splitlines()[0]}
    print(json.dumps(ready), file=answers, flush=True)
    for line in sys.stdin:
        word, _, count = line.strip().rpartition(" ")
        answer = look(call, int(count)) if word else turn(call, int(count))
        print(json.dumps(answer), file=answers, flush=True)


def turn(call: Call, count: int) -> list[tuple[float, float]]:
    """Time `count` calls after one that does not count."""
    call()
    taken = []
    for _ in range(count):
        begin, before = time.perf_counter(), time.process_time()
        call()
        taken.append((time.perf_counter() - begin, time.process_time() - before))
    return taken


def look(call: Call, count: int) -> dict[str, Any]:
    """Statistics of `count` batches, by which the contenders' results are compared."""
    pictures, squares = [], []
    for _ in range(count):
        batch = np.asarray(call(), np.float64)
        b, c, h, w = batch.shape
        pictures.append(batch.reshape(b, c, LOOK, h // LOOK, LOOK, w // LOOK).mean((0, 3, 5)))
        squares.append((batch**2).mean())
    picture = np.mean(pictures, 0)
    return {
        "picture": picture.tolist(),
        "variance": float(np.var(pictures, 0, ddof=1).mean() / count),
        "deviation": float(np.sqrt(np.mean(squares) - picture.mean() ** 2)),
    }


def keep_memory() -> None:
    """Make malloc reuse freed memory. Otherwise large results are in new memory from the system, whose first
    use takes longer than many steps."""
    mmap_threshold, trim_threshold = -3, -1
    for parameter in (mmap_threshold, trim_threshold):
        ctypes.CDLL(None).mallopt(parameter, 1 << 30)


if __name__ == "__main__":
    main(*sys.argv[1:])
