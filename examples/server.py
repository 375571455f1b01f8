"""Many requests at once, a thread each: a method with one thread wakes no others and waits for none.

usage: server.py BUNDLE REQUESTS        BUNDLE: chiasm export pipelines.edges -o bundles; REQUESTS: how many
"""

import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from chiasm import runtime

if len(sys.argv) != 3:
    sys.exit(__doc__)
bundle, requests = sys.argv[1], int(sys.argv[2])
edges = runtime.open(bundle).method("forward", num_threads=1)  # may run in many threads at once


def answer(number: int) -> int:
    """A request: a frame with a square of its own size; the sum of its edges."""
    frame = np.zeros((240, 320, 3), np.uint8)
    end = 30 + number % 200
    frame[20:end, 20:end] = 200
    return int(edges(frame).sum())


with ThreadPoolExecutor(8) as threads:
    answers = list(threads.map(answer, range(requests)))
print(*answers)
