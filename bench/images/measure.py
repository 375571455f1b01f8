"""The measurements in Python, for one number of threads, which a process can set only once.

    python -m bench.images.measure THREADS SECONDS [OP...]    -> a line of JSON, in microseconds, for each op
    and size

In each of three races, the contenders and a copy of as many bytes take turns: chiasm's native backend and
OpenCV's pip wheel; the native backend and eager Kornia; in ONNX Runtime, the fused form, the flat form and
Kornia's own file.
"""

from __future__ import annotations

import json
import sys
import warnings
from collections.abc import Callable

import cv2
import onnxruntime
import torch

import chiasm.onnx
import chiasm.runtime

from ..machine import bundle_path
from ..opencv import opencv
from ..wheel import copy_of, interleaved, onnx_call, onnx_options
from . import kornia_peers
from .chiasm_ops import Native, measured, native
from .data import SIZES
from .ops import Op


def main(threads: int, seconds: float, names: list[str]) -> None:
    warnings.simplefilter("ignore")
    chiasm.runtime.set_num_threads(threads)
    cv2.setNumThreads(threads)
    torch.set_num_threads(threads)

    def race(made: Native, contenders: dict[str, Callable]) -> dict[str, float]:
        contenders = contenders | {"copy": copy_of([*made.inputs.values(), *made.outputs])}
        times = interleaved(list(contenders.values()), seconds, threads=threads)
        return dict(zip(contenders, times, strict=True))

    for op in measured(names):
        for size in SIZES:
            made = native(op, size)
            row = {"bundle": op.bundle, "size": "x".join(map(str, size)), "threads": threads}
            row["wheel"] = race(
                made, {"native": made.call, "opencv": opencv(op.bundle, list(made.inputs.values())).call}
            )
            if op.kornia:
                row["kornia"] = race(
                    made, {"native": made.call, "kornia": kornia_peers.eager(op, made.inputs)}
                )
            row["onnx"] = race(made, onnx_calls(op, size, made, threads))
            print(json.dumps(row), flush=True)


def onnx_calls(op: Op, size: tuple[int, int, int], made: Native, threads: int) -> dict[str, Callable]:
    folder = bundle_path(op.constant) if op.constant else made.folder
    given = kornia_peers.images(made.inputs) if op.constant else list(made.inputs.values())
    calls = {
        "fused": onnx_call(chiasm.onnx.session(folder, options=onnx_options(threads)), given),
        "flat": onnx_call(chiasm.onnx.session(folder, fused=False, options=onnx_options(threads)), given),
    }
    file = kornia_peers.onnx_file(op, size) if op.kornia else ""
    if not isinstance(file, str):
        session = onnxruntime.InferenceSession(
            str(file), onnx_options(threads), providers=["CPUExecutionProvider"]
        )
        calls["kornia"] = onnx_call(session, kornia_peers.images(made.inputs))
    return calls


if __name__ == "__main__":
    main(int(sys.argv[1]), float(sys.argv[2]), sys.argv[3:])
