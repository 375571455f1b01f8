"""Frame after frame into the same memory: a run allocates nothing.

usage: video.py BUNDLE FRAMES        BUNDLE: chiasm export pipelines.edges -o bundles; FRAMES: how many
"""

import sys
import time

import numpy as np

from chiasm import runtime

if len(sys.argv) != 3:
    sys.exit(__doc__)
bundle, frames = sys.argv[1], int(sys.argv[2])
edges = runtime.open(bundle).method("forward", warm_up=True)
frame = np.empty((720, 1280, 3), np.uint8)  # where a camera would write
[(shape, dtype)] = edges.output_shapes(frame)
result, total = np.empty(shape, dtype), 0
started = time.perf_counter()
for number in range(frames):
    frame[:] = 0
    left = 10 * number % 1180
    frame[:, left : left + 100] = 255  # a bar that moves
    edges.run_into(frame, [result])
    total += int(result.sum())
milliseconds = (time.perf_counter() - started) * 1000 / frames
print(f"{edges.backend}: {milliseconds:.1f} ms a frame", file=sys.stderr)
print(total)
