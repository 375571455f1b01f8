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

from chiasm.export.images import is_turned, pixels_of, read_image, to_array

from .errors import DataError
from .running import channels

_JPEG = b"\xff\xd8\xff"


def decode(tensor: Any, data: Any) -> np.ndarray:
    """The bytes of an image file, or an image of Pillow, in the layout, colour order and dtype of an input,
    or a DataError."""
    name = f"input {tensor.name!r}"
    count = channels(tensor)
    if count is None:
        what = "an image" if isinstance(data, Image.Image) else f"{len(data)} bytes"
        raise DataError(f"{name}: expected an array, got {what}: it takes no image")
    try:
        if tensor.dtypes[0] == "uint8" and tensor.layout == "HWC" and count == "3":
            picture = _read(name, data, "BGR" if tensor.color == "BGR" else "RGB")
            return picture if picture.shape[2] == 3 else np.repeat((picture >> 8).astype(np.uint8), 3, 2)
        described = {
            "name": tensor.name,
            "dtype": tensor.dtypes[0],
            "layout": tensor.layout,
            "shape": [int(d) if d.isdigit() else d for d in tensor.shape],
            "color": tensor.color,
        }
        return to_array(described, _read(name, data, "RGB"), tensor.dtypes)
    except RuntimeError as error:  # BundleError: the file's, not the bundle's
        raise DataError(str(error)) from error


def _read(name: str, data: Any, color: str) -> np.ndarray:
    if isinstance(data, Image.Image):
        return pixels_of(name, data, color)
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


def decodes_by_turbo() -> bool:
    """Whether simplejpeg decodes plain JPEGs here."""
    return _turbo() is not None


@cache
def _turbo() -> Any:
    try:
        import simplejpeg
    except ImportError:
        return None
    return simplejpeg
