"""Image files in and out of a bundle, for `chiasm run`.

Files are read as OpenCV's `imread` reads them: rotated by EXIF, without transparency, and with 16-bit values
reduced to the upper eight bits if an op takes bytes; if it takes numbers from 0 to 1, or of 16 bits, 16-bit
grey values keep all their bits.
"""

from __future__ import annotations

import io
import json
import re
import struct
import warnings
from pathlib import Path
from typing import Any, cast

import numpy as np
from PIL import Image, ImageOps, UnidentifiedImageError

from ..writing import write_whole
from .constants import in_dtype
from .files import MOST_OF_IMAGE, read_regular
from .manifest import BundleError, read_manifest
from .text import one_line

#: The EXIF tag.
_ORIENTATION = 0x0112
_LAYOUTS = ("NCHW", "NHWC", "HWC", "HW")


def run_on_image(bundle: Path, source: Path, target: Path, backend: str, settings: dict[str, str]) -> str:
    """Run `forward` on an image file and write the first image among its outputs; returns a line that says
    what was done."""
    manifest = read_manifest(bundle)
    method = manifest["methods"]["forward"]
    takes_image = [t for t in method["inputs"] if is_image(t, _LAYOUTS[:3])]
    gives_image = [i for i, t in enumerate(method["outputs"]) if is_image(t, _LAYOUTS)]
    if not takes_image or not gives_image:
        raise BundleError(
            f"{manifest['name']} does not map an image to an image: use chiasm.runtime from Python or C++"
        )
    unknown = set(settings) - {t["name"] for t in method["inputs"]}
    if unknown:
        raise BundleError(
            f"{manifest['name']} has no input {sorted(unknown)[0]!r}: it has"
            f" {', '.join(t['name'] for t in method['inputs'])}"
        )
    check_target(target)
    picture = read_image(source)
    inputs = [
        (
            to_array(t, picture, manifest["dtypes"])
            if t in takes_image and t["name"] not in settings
            else setting(t, settings, manifest["dtypes"])
        )
        for t in method["inputs"]
    ]
    import chiasm.runtime

    try:
        loaded = chiasm.runtime.open(bundle).method("forward", backend=backend)
        result = loaded(*inputs)
    except (chiasm.runtime.ChiasmError, ValueError) as error:  # ValueError: a name that is not UTF-8
        raise BundleError(str(error)) from error
    index = gives_image[0]
    # An only output is no tuple
    array = cast("tuple[Any, ...]", result)[index] if isinstance(result, tuple) else result
    write_image(target, array, method["outputs"][index])
    return f"{source} -> {manifest['name']} ({loaded.backend}) -> {target}"


def is_image(tensor: dict[str, Any], layouts: tuple[str, ...]) -> bool:
    """Whether a tensor has one of the layouts, and its dimensions: a manifest's layout may be any text."""
    return tensor["layout"] in layouts and len(tensor["shape"]) == len(tensor["layout"])


def check_target(path: Path) -> None:
    """Reject a name to which no image can be written, before anything is computed."""
    known = {extension for extension, form in Image.registered_extensions().items() if form in Image.SAVE}
    if path.suffix.lower() not in known:
        what = f"{path.suffix!r} is no extension of an image" if path.suffix else "it has no extension"
        raise BundleError(f"{path}: {what}, which says how to write it: use .png, .jpg, .tif, .bmp or .webp")
    if not path.parent.is_dir():
        raise BundleError(
            f"{path}: the folder {path.parent} does not exist: make it first (mkdir -p {path.parent})"
        )


def read_image(path: Path | str, data: bytes | None = None, color: str = "RGB") -> np.ndarray:
    """An array (H, W, 3) in the colour order, "RGB" or "BGR", or a grey one (H, W, 1) of 16 bits: uint8 or
    uint16. With `data`, the bytes of an image file, `path` is only the name in errors."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # large images: what is far too large is an error
            data = read_regular(path, MOST_OF_IMAGE) if data is None else data
            image = Image.open(io.BytesIO(data))
            with image:
                # By default a decoder gets 64 KiB at a time, and a JPEG of 140 KB takes it twice as long
                image.decodermaxblock = len(data)
                return pixels_of(path, image, color)
    except Image.DecompressionBombError as error:
        raise BundleError(
            f"{path}: too many pixels for an image file that is to be trusted: {one_line(error)}"
        ) from error
    except UnidentifiedImageError as error:  # its text contains a memory address
        raise BundleError(f"{path}: not an image that can be read: of no format that is known") from error
    except (
        OSError,
        SyntaxError,
        ValueError,
        EOFError,
        IndexError,
        TypeError,
        struct.error,
    ) as error:  # any exception of a decoder
        raise BundleError(
            f"{path}: not an image that can be read: {one_line(getattr(error, 'strerror', None) or error)}"
        ) from error


def pixels_of(path: Path | str, image: Image.Image, color: str) -> np.ndarray:
    """The same of an image of Pillow."""
    if image.format == "EPS":  # a program, for which Pillow starts Ghostscript
        raise BundleError(f"{path}: PostScript, which is a program: convert it to an image first")
    deep_pgm = (image.format, image.mode) == ("PPM", "I")  # Pillow's form of 16 bits there
    if image.mode in ("I", "F") and not deep_pgm:
        raise BundleError(
            f"{path}: pixels of 32 bits ({image.mode}): convert the image to 8 or 16 bits, or use"
            " chiasm.runtime from Python"
        )
    turned = _turned(image)
    if deep_pgm or turned.mode.startswith("I;16"):
        return np.asarray(turned).astype(np.uint16)[..., None]
    turned = turned if turned.mode == "RGB" else turned.convert("RGB")
    # Pillow writes both orders equally fast; NumPy takes as long as a decoder to swap them
    pixels = np.frombuffer(turned.tobytes("raw", color), np.uint8)
    return np.reshape(pixels, (turned.height, turned.width, 3))


def is_turned(image: Image.Image) -> bool:
    """Whether EXIF says that an image is not stored as it is to be seen."""
    return image.getexif().get(_ORIENTATION, 1) != 1


def _turned(image: Image.Image) -> Image.Image:
    image.load()
    try:
        # Without an orientation, exif_transpose would only copy
        return ImageOps.exif_transpose(image) if is_turned(image) else image
    except Exception:  # ignore an EXIF entry that cannot be read, as OpenCV does
        return image


def to_array(tensor: dict[str, Any], picture: np.ndarray, dtypes: list[str]) -> np.ndarray:
    """The picture in the layout, colour order and dtype of an input: bytes, numbers of 16 bits, or numbers
    from 0 to 1."""
    dtype = _dtype(tensor, dtypes)
    depth = np.iinfo(picture.dtype).max
    if dtype == "uint8":
        values = picture if depth == 255 else (picture >> 8).astype(np.uint8)
    elif dtype == "uint16":  # 255 becomes 65535, as PNG rescales depths (ISO/IEC 15948, 13.12)
        values = picture if depth == 65535 else picture * np.uint16(257)
    elif np.issubdtype(dtype, np.signedinteger):
        raise BundleError(
            f"input {tensor['name']!r} is {dtype}, which image files do not have: use chiasm.runtime, or a"
            " column of arrays"
        )
    else:
        values = picture.astype(np.float64 if dtype == "float64" else np.float32) / depth
    planes = tensor["layout"] == "NCHW"
    channels = tensor["shape"][1 if planes else -1]
    if channels == 1 and values.shape[2] == 3:
        grey = np.tensordot(
            values, np.array([0.299, 0.587, 0.114], np.float64 if dtype == "float64" else np.float32), 1
        )[..., None]
        values = (grey + 0.5).astype(dtype) if dtype in ("uint8", "uint16") else grey
    elif channels != 1 and values.shape[2] == 1:
        values = np.repeat(values, 3, 2)
    if tensor["color"] == "BGR":
        values = values[..., ::-1]
    if tensor["layout"].startswith("N"):
        values = values[None]
    return np.ascontiguousarray(np.transpose(values, (0, 3, 1, 2)) if planes else values, dtype)


def _dtype(tensor: dict[str, Any], dtypes: list[str]) -> str:
    """The NumPy dtype of an input. A generic input gets float32 if the bundle has it."""
    wanted = tensor["dtype"]
    if wanted == "T":
        wanted = "float32" if "float32" in dtypes else dtypes[0]
    if wanted == "bfloat16":
        raise BundleError(
            f"input {tensor['name']!r} is bfloat16, which NumPy does not have: use chiasm.runtime with torch"
        )
    return wanted


def setting(tensor: dict[str, Any], settings: dict[str, str], dtypes: list[str]) -> np.ndarray:
    """The array for an input that NAME=VALUE specifies: JSON, or HEIGHTxWIDTH for an input of which only the
    size is used."""
    name, dtype = tensor["name"], _dtype(tensor, dtypes)
    if name not in settings:
        raise BundleError(
            f"input {name!r} ({tensor['description']}; shape {tuple(tensor['shape'])}) is needed: --set"
            f" {name}=VALUE"
        )
    value = settings[name]
    try:
        if size := re.fullmatch(r"(\d{1,6})x(\d{1,6})", value):
            return np.zeros((int(size[1]), int(size[2])), dtype)
        parsed = json.loads(value)
        if not all(isinstance(v, (bool, int, float)) for v in _leaves(parsed)):
            raise ValueError("expected numbers, or lists of numbers")
        return in_dtype(parsed, dtype)
    except (ValueError, TypeError, OverflowError, RecursionError, MemoryError) as error:
        raise BundleError(
            f"input {name!r}: {one_line(value, 60)!r} is neither JSON for {dtype} {tuple(tensor['shape'])}"
            f" nor HEIGHTxWIDTH: {one_line(error)}"
        ) from error


def _leaves(value: Any) -> list[Any]:
    if not isinstance(value, list):
        return [value]
    return [leaf for v in cast("list[Any]", value) for leaf in _leaves(v)]


def write_image(path: Path, array: np.ndarray, tensor: dict[str, Any]) -> None:
    """Write the first image of an output atomically. Bytes are kept. Other values are taken as numbers from 0
    to 1 if no finite one is more than 0.001 outside; else the image is stretched, its least to 0 and its
    greatest to 1. Infinity is 1; minus infinity and NaN are 0."""
    if array.size == 0:
        raise BundleError(f"{path}: output {tensor['name']!r} is empty: its shape is {array.shape}")
    if tensor["layout"].startswith("N"):
        array = array[0].transpose(1, 2, 0) if tensor["layout"] == "NCHW" else array[0]
    if array.dtype != np.uint8:
        array = array.astype(np.float64)
        finite = array[np.isfinite(array)]
        low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
        if low < -1e-3 or high > 1.0 + 1e-3:
            array = (array - low) / max(high - low, 1e-12)
        array = (np.nan_to_num(array).clip(0.0, 1.0) * 255.0 + 0.5).astype(np.uint8)
    if array.ndim == 3 and array.shape[2] not in (3, 4):
        array = array[..., 0]
    elif tensor["color"] == "BGR":
        array = array[..., ::-1]
    try:
        encoded = io.BytesIO()  # not directly to the file: Pillow does not report a full disk
        Image.fromarray(np.ascontiguousarray(array)).save(
            encoded, Image.registered_extensions()[path.suffix.lower()]
        )
        write_whole(path, encoded.getbuffer())
    except (OSError, ValueError, KeyError) as error:
        raise BundleError(
            f"{path}: cannot be written: {one_line(getattr(error, 'strerror', None) or error)}"
        ) from error
