"""One measurement in Python, in turns: chiasm's native backend, a copy, ONNX Runtime (fused, stock) and
OpenCV's pip wheel.

python -m bench.wheel BUNDLE THREADS B H W     -> JSON, microseconds
"""

from __future__ import annotations

import json
import math
import statistics
import sys
import time
from collections.abc import Callable

import cv2
import numpy as np
import onnxruntime

import chiasm.onnx
import chiasm.runtime

from .machine import bundle_path
from .opencv import opencv

SIZES = {"C": 3, "N": 64}
#: seconds until the threads of another contender's pool sleep; OpenMP's threads spin for about this long (in
#: bench/harness.hpp too)
PAUSE = 0.02


def main(bundle: str, threads: int, batch: int, height: int, width: int) -> dict:
    chiasm.runtime.set_num_threads(threads)
    cv2.setNumThreads(threads)
    folder = bundle_path(bundle)
    opened = chiasm.runtime.open(folder)
    method = opened.method("forward", backend="native")
    signature = opened.info["methods"]["forward"]
    frames = signature["inputs"][0]["layout"] == "HWC"
    sizes = SIZES | {
        "B": 1 if frames else batch,
        "H": height,
        "W": width,
        "OH": height * 3 // 4,
        "OW": width * 3 // 4,
    }
    inputs = [make(t, sizes) for t in signature["inputs"]]
    outputs = room(method, inputs)
    calls = batch if frames else 1
    contenders = {
        "native": lambda: method.run_into(inputs, outputs),
        "copy": copy_of([*inputs, *outputs]),
        "fused": onnx_call(chiasm.onnx.session(folder, options=onnx_options(threads)), inputs),
        "stock": onnx_call(chiasm.onnx.session(folder, fused=False, options=onnx_options(threads)), inputs),
        "opencv": opencv(bundle, inputs).call,
    }
    timed = [lambda call=call: [call() for _ in range(calls)] for call in contenders.values()]
    times = interleaved(timed, threads=threads)
    return dict(zip(contenders, times, strict=True)) | {"opencv_version": cv2.__version__}


def room(method: chiasm.runtime.Method, inputs: list[np.ndarray]) -> list[np.ndarray]:
    """Buffers for the method's outputs, at multiples of 64 bytes as OpenCV's own: stores that cross cache
    lines are slower."""
    result = method(*inputs)
    buffers = []
    for r in result if isinstance(result, tuple) else (result,):
        memory = np.empty(r.nbytes + 64, np.uint8)
        start = -memory.ctypes.data % 64
        buffers.append(memory[start : start + r.nbytes].view(r.dtype).reshape(r.shape))
    return buffers


def copy_of(arrays: list[np.ndarray]) -> Callable[[], None]:
    """A copy whose reads and writes together are as many bytes as the arrays."""
    source = np.ones(sum(a.nbytes for a in arrays) // 2, np.uint8)
    target = np.ones_like(source)
    return lambda: np.copyto(target, source)


def onnx_options(threads: int) -> onnxruntime.SessionOptions:
    """Options with which the pool's threads sleep between runs: otherwise they would occupy the other
    contenders' cores."""
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_ENABLE_EXTENDED
    return options


def onnx_call(session: onnxruntime.InferenceSession, inputs: list[np.ndarray]) -> Callable[[], None]:
    """A run with input and output buffers that are reused."""
    binding = session.io_binding()
    outputs = session.run(None, {t.name: x for t, x in zip(session.get_inputs(), inputs, strict=True)})
    kept = [
        (t.name, onnxruntime.OrtValue.ortvalue_from_numpy(x))
        for t, x in zip(session.get_inputs(), inputs, strict=True)
    ]
    for name, value in kept:
        binding.bind_ortvalue_input(name, value)
    for tensor, output in zip(session.get_outputs(), outputs, strict=True):
        binding.bind_output(tensor.name, "cpu", 0, output.dtype, output.shape, output.ctypes.data)

    def call(memory=(kept, outputs)) -> None:
        session.run_with_iobinding(binding)

    return call


def make(tensor: dict, sizes: dict[str, int]) -> np.ndarray:
    random = np.random.default_rng(1)
    shape = [sizes[d] if isinstance(d, str) else d for d in tensor["shape"]]
    if tensor["dtype"] == "uint8":
        return random.integers(0, 256, shape, np.uint8)
    if tensor["name"] == "sigma":
        return np.full(shape, 1.1, np.float32)
    return random.random(shape, np.float32)


def interleaved(contenders: list[Callable], seconds: float = 1.5, *, threads: int) -> list[float]:
    """Median microseconds of each contender on so many threads; they take turns. Short calls are repeated
    within a turn, and long ones have fewer turns.

    If threads are several, a pause before each turn lets those of the last contender's pool fall asleep. Then
    calls that do not count warm up the machine and its caches for half that time; the calls that count run
    equally long.
    """
    pause = PAUSE if threads > 1 else 0.0
    repeats, warming = [], []
    for call in contenders:
        begin = time.perf_counter()
        call()
        if time.perf_counter() - begin < 0.2:
            call()
            begin = time.perf_counter()
            call()
        taken = max(time.perf_counter() - begin, 1e-7)
        repeats.append(min(max(int(max(200e-6, pause / 2) / taken), 1), 2000))
        warming.append(math.ceil(pause / 2 / taken) if taken < 1 else 0)
    times: list[list[float]] = [[] for _ in contenders]
    start = time.perf_counter()
    while (spent := time.perf_counter() - start) < seconds or len(times[0]) < (
        7 if spent < 2 * seconds else 3
    ):
        for call, taken, n, idle in zip(contenders, times, repeats, warming, strict=True):
            time.sleep(pause)
            for _ in range(idle):
                call()
            begin = time.perf_counter()
            for _ in range(n):
                call()
            taken.append((time.perf_counter() - begin) / n * 1e6)
    return [statistics.median(t) for t in times]


if __name__ == "__main__":
    print(json.dumps(main(sys.argv[1], *map(int, sys.argv[2:]))))
