"""One measurement in Python, in turns: chiasm's native backend, ONNX Runtime (fused, stock) and OpenCV's pip wheel.

    python -m bench.wheel BUNDLE THREADS B H W     -> JSON, microseconds
"""

from __future__ import annotations

import json
import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import onnxruntime

import chiasm.onnx
import chiasm.runtime

BUNDLES = Path(__file__).resolve().parents[1] / "build" / "bundles"
SIZES = {"C": 3, "N": 64}


def main(bundle: str, threads: int, batch: int, height: int, width: int) -> dict:
    chiasm.runtime.set_num_threads(threads)
    cv2.setNumThreads(threads)
    folder = BUNDLES / f"{bundle}.chiasm"
    opened = chiasm.runtime.open(folder)
    method = opened.method("forward", backend="native")
    signature = opened.info["methods"]["forward"]
    frames = signature["inputs"][0]["layout"] == "HWC"
    sizes = SIZES | {"B": 1 if frames else batch, "H": height, "W": width, "OH": height * 3 // 4, "OW": width * 3 // 4}
    inputs = [make(t, sizes) for t in signature["inputs"]]
    result = method(*inputs)
    outputs = [np.empty_like(r) for r in (result if isinstance(result, tuple) else (result,))]
    calls = batch if frames else 1
    contenders = {
        "native": lambda: method.run_into(inputs, outputs),
        "fused": onnx_call(folder, True, threads, inputs, outputs),
        "stock": onnx_call(folder, False, threads, inputs, outputs),
        "opencv": opencv(bundle, inputs),
    }
    times = interleaved([lambda call=call: [call() for _ in range(calls)] for call in contenders.values()])
    return dict(zip(contenders, times, strict=True)) | {"opencv_version": cv2.__version__}


def onnx_call(folder: Path, fused: bool, threads: int, inputs: list[np.ndarray], outputs: list[np.ndarray]) -> Callable[[], None]:
    """A run into the caller's memory. The pool's threads sleep between runs, else they would take the others' cores."""
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_ENABLE_EXTENDED
    session = chiasm.onnx.session(folder, fused=fused, options=options)
    binding = session.io_binding()
    kept = [(t.name, onnxruntime.OrtValue.ortvalue_from_numpy(x)) for t, x in zip(session.get_inputs(), inputs, strict=True)]
    for name, value in kept:
        binding.bind_ortvalue_input(name, value)
    for tensor, output in zip(session.get_outputs(), outputs, strict=True):
        binding.bind_output(tensor.name, "cpu", 0, output.dtype, output.shape, output.ctypes.data)
    return lambda: session.run_with_iobinding(binding)


def make(tensor: dict, sizes: dict[str, int]) -> np.ndarray:
    random = np.random.default_rng(1)
    shape = [sizes[d] if isinstance(d, str) else d for d in tensor["shape"]]
    if tensor["dtype"] == "uint8":
        return random.integers(0, 256, shape, np.uint8)
    if tensor["name"] == "sigma":
        return np.full(shape, 1.1, np.float32)
    return random.random(shape, np.float32)


def interleaved(contenders: list[Callable], seconds: float = 1.5) -> list[float]:
    """Median microseconds of each, taking turns."""
    for call in contenders:
        for _ in range(3):
            call()
    times: list[list[float]] = [[] for _ in contenders]
    start = time.perf_counter()
    while len(times[0]) < 7 or (time.perf_counter() - start < seconds and len(times[0]) < 1000):
        for call, taken in zip(contenders, times, strict=True):
            begin = time.perf_counter()
            call()
            taken.append((time.perf_counter() - begin) * 1e6)
    return [statistics.median(t) for t in times]


def opencv(bundle: str, inputs: list[np.ndarray]) -> Callable:
    """The wheel's version of bench/opencv_peers.cpp, with results written into matrices that are kept."""
    images = [np.ascontiguousarray(i.transpose(1, 2, 0)) for i in inputs[0]] if inputs[0].ndim == 4 else [inputs[0]]
    kept: dict[tuple, np.ndarray] = {}

    def into(key: str, index: int, function: Callable, *arguments, **options) -> np.ndarray:
        kept[key, index] = function(*arguments, dst=kept.get((key, index)), **options)
        return kept[key, index]

    def sobel(image, i, border=cv2.BORDER_REPLICATE, scale=1 / 8):
        dx = into("dx", i, cv2.Sobel, image, cv2.CV_32F, 1, 0, ksize=3, scale=scale, borderType=border)
        dy = into("dy", i, cv2.Sobel, image, cv2.CV_32F, 0, 1, ksize=3, scale=scale, borderType=border)
        flat = dx.reshape(dx.shape[0], -1), dy.reshape(dy.shape[0], -1)
        kept["m", i] = cv2.magnitude(*flat, magnitude=kept.get(("m", i)))
        return kept["m", i]

    def edges(image, i):
        grey = into("grey", i, cv2.cvtColor, image, cv2.COLOR_BGR2GRAY)
        magnitude = sobel(into("blur", i, cv2.GaussianBlur, grey, (5, 5), 1.0), i, cv2.BORDER_DEFAULT, 1.0)
        return cv2.convertScaleAbs(magnitude, kept.get(("out", i)))

    def preprocess(image, i):
        small = into("small", i, cv2.resize, image, (224, 224), interpolation=cv2.INTER_LINEAR)
        return cv2.dnn.blobFromImage(small, 1 / (255 * 0.226), None, (123.675, 116.28, 103.53), True) if hasattr(cv2, "dnn") else small

    size = inputs[-1].shape[::-1] if inputs[-1].dtype == np.uint8 and inputs[-1].ndim == 2 else None
    cross = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    calls = {
        "filters.sobel": sobel,
        "filters.gaussian_blur2d": lambda m, i: into("out", i, cv2.GaussianBlur, m, (5, 5), 1.1, sigmaY=1.1),
        "pipelines.edges": edges,
        "pipelines.preprocess": preprocess,
        "filters.bilateral_blur": lambda m, i: into("out", i, cv2.bilateralFilter, m, 5, 0.1, 1.5),
        "filters.median_blur": lambda m, i: into("out", i, cv2.medianBlur, m, 3),
        "morphology.dilation": lambda m, i: into("out", i, cv2.dilate, m, cross),
        "color.rgb_to_grayscale": lambda m, i: into("out", i, cv2.cvtColor, m, cv2.COLOR_RGB2GRAY),
        "color.rgb_to_hsv": lambda m, i: into("out", i, cv2.cvtColor, m, cv2.COLOR_RGB2HSV),
        "geometry.transform.resize.bilinear": lambda m, i: into("out", i, cv2.resize, m, size),
        "geometry.transform.warp_perspective.bilinear_zeros": lambda m, i: into("out", i, cv2.warpPerspective, m, inputs[1][0], size),
    }
    return lambda: [calls[bundle](m, i) for i, m in enumerate(images)]


if __name__ == "__main__":
    print(json.dumps(main(sys.argv[1], *map(int, sys.argv[2:]))))
