# simplejpeg is optional, and not in .venv:
# pyright: reportMissingImports=false
"""Decodes image files in memory to an op's inputs."""

from __future__ import annotations

import io
import warnings
from functools import cache
from typing import Any

import numpy as np
from PIL import Image

from chiasm.export.images import is_turned, read_image, to_array

from .errors import DataError
from .running import channels

_JPEG = b"\xff\xd8\xff"


def decode(tensor: Any, data: Any) -> np.ndarray:
    """The bytes of an image file in the layout, colour order and dtype of an input, or a DataError."""
    name = f"input {tensor.name!r}"
    count = channels(tensor)
    if count is None:
        raise DataError(f"{name}: expected an array, got {len(data)} bytes: it takes no image")
    try:
        if tensor.dtypes[0] == "uint8" and tensor.layout == "HWC" and count == "3":
            picture = _read(name, data, tensor.color or "RGB")
            return picture if picture.shape[2] == 3 else np.repeat((picture >> 8).astype(np.uint8), 3, 2)
        planes = tensor.layout == "NCHW"
        described = {
            "name": tensor.name,
            "dtype": tensor.dtypes[0],
            "layout": "NCHW" if planes else "HWC",
            "shape": [int(d) if d.isdigit() else d for d in tensor.shape[0 if planes else -3 :]],
            "color": tensor.color,
        }
        array = to_array(described, _read(name, data, "RGB"), tensor.dtypes)
        return array[None] if tensor.layout == "NHWC" else array
    except RuntimeError as error:  # BundleError: the file's, not the bundle's
        raise DataError(str(error)) from error


def _read(name: str, data: Any, color: str) -> np.ndarray:
    pixels = _by_turbo(data, color)
    return read_image(name, data, color) if pixels is None else pixels


def _by_turbo(data: Any, color: str) -> np.ndarray | None:
    """Decodes a plain JPEG by simplejpeg, if installed: the same bits as Pillow's, in two thirds of the time.

    Both use libjpeg-turbo; simplejpeg writes the wanted colour order directly. Returns None for images that
    Pillow must handle: rotated by EXIF, damaged, too large, not RGB, or not JPEG.
    """
    turbo, data = _turbo(), np.frombuffer(data, np.uint8)  # Arrow's buffers are signed
    if turbo is None or bytes(data[:3]) != _JPEG:
        return None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(io.BytesIO(data)) as image:  # the header alone
                if (image.format, image.mode) != ("JPEG", "RGB") or is_turned(image):
                    return None
        return turbo.decode_jpeg(data, color, strict=True)
    except Exception:  # Pillow says what is wrong, if anything is
        return None


@cache
def _turbo() -> Any:
    try:
        import simplejpeg
    except ImportError:
        return None
    return simplejpeg
