"""Photographs at the measured sizes, and the inputs made from them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import cv2
import numpy as np
from skimage import data

from ..machine import ROOT
from .ops import Op

FOLDER = ROOT / "build" / "bench-images"
SIZES = ((8, 256, 256), (1, 1080, 1920))
#: scikit-image's colour photographs without a black background
PHOTOGRAPHS = ("astronaut", "coffee", "chelsea", "rocket", "immunohistochemistry", "stereo_motorcycle")


def photograph(batch: int, height: int, width: int) -> np.ndarray:
    """Photographs, resized: (B, 3, H, W), uint8. One image is the motorcycle, which has the most detail."""
    names = ["stereo_motorcycle"] if batch == 1 else [PHOTOGRAPHS[i % len(PHOTOGRAPHS)] for i in range(batch)]
    resized = []
    for name in names:
        image = getattr(data, name)()
        image = image[0] if isinstance(image, tuple) else image
        way = cv2.INTER_AREA if image.shape[0] > height else cv2.INTER_CUBIC
        resized.append(cv2.resize(image, (width, height), interpolation=way).transpose(2, 0, 1))
    return np.ascontiguousarray(resized)


def photograph_file(size: tuple[int, int, int]) -> Path:
    """The file of the photographs' bytes, for C++; written if it is missing."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    path = FOLDER / f"photograph.{'x'.join(map(str, size))}.raw"
    if not path.exists():
        path.write_bytes(photograph(*size).tobytes())
    return path


def inputs(op: Op, signature: Mapping, size: tuple[int, int, int]) -> dict[str, np.ndarray]:
    """The method's inputs by name, as bench.cpp makes them: a second image is the first, rotated by 180
    degrees."""
    pixels = np.frombuffer(photograph_file(size).read_bytes(), np.uint8).reshape(size[0], 3, *size[1:])
    sizes = dict(zip("BHW", size, strict=True)) | {"C": 3}
    made: dict[str, np.ndarray] = {}
    for tensor in signature["inputs"]:
        if tensor["layout"] == "NCHW":
            image = np.ascontiguousarray(pixels.reshape(-1)[::-1].reshape(pixels.shape)) if made else pixels
            made[tensor["name"]] = (
                image if tensor["dtype"] == "uint8" else image * np.float32(tensor["range"][1] / 255)
            )
        else:
            shape = [sizes[d] if isinstance(d, str) else d for d in tensor["shape"]]
            value = np.asarray(op.values[tensor["name"]], np.float32)
            made[tensor["name"]] = value.reshape(shape) if value.ndim else np.full(shape, value, np.float32)
    return made


def bench_arguments(op: Op, size: tuple[int, int, int]) -> list[str]:
    """The arguments of build/release/bin/bench that define the inputs."""
    return [*map(str, size), str(photograph_file(size)), json.dumps(op.values)]
