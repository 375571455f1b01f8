"""Image files in and out of a bundle, for `chiasm run`."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from .manifest import BundleError, read_manifest


def run_on_image(bundle: Path, source: Path, target: Path, backend: str, settings: dict[str, str]) -> str:
    """Run `forward` on an image file and write the first image among its outputs; returns a line that says what was done."""
    import chiasm.runtime

    manifest = read_manifest(bundle)
    method = manifest["methods"]["forward"]
    takes_image = [t for t in method["inputs"] if t["layout"] in ("NCHW", "HWC")]
    gives_image = [i for i, t in enumerate(method["outputs"]) if t["layout"] in ("NCHW", "HWC", "HW")]
    if not takes_image or not gives_image:
        raise BundleError(f"{manifest['name']} does not map an image to an image: use chiasm.runtime from Python or C++")
    unknown = set(settings) - {t["name"] for t in method["inputs"]}
    if unknown:
        raise BundleError(f"{manifest['name']} has no input {sorted(unknown)[0]!r}: it has {', '.join(t['name'] for t in method['inputs'])}")
    picture = read_image(source)
    inputs = [to_array(t, picture) if t in takes_image else _setting(t, settings, picture) for t in method["inputs"]]
    try:
        loaded = chiasm.runtime.open(bundle).method("forward", backend=backend)
        result = loaded(*inputs)
    except chiasm.runtime.ChiasmError as error:
        raise BundleError(str(error)) from error
    results = result if isinstance(result, tuple) else (result,)
    index = gives_image[0]
    write_image(target, results[index], method["outputs"][index])
    return f"{source} -> {manifest['name']} ({loaded.backend}) -> {target}"


def read_image(path: Path) -> np.ndarray:
    """An RGB uint8 array (H, W, 3)."""
    try:
        return np.asarray(Image.open(path).convert("RGB"))
    except OSError as error:
        raise BundleError(f"{path}: not an image that can be read: {error}") from error


def to_array(tensor: dict[str, Any], picture: np.ndarray) -> np.ndarray:
    """The picture in the layout, colour order and dtype that an input asks for."""
    if tensor["layout"] == "HWC":
        return np.ascontiguousarray(picture[..., ::-1] if tensor["color"] == "BGR" else picture)
    planes = picture.astype(np.float32).transpose(2, 0, 1) / 255.0
    if tensor["shape"][1] == 1:
        planes = np.tensordot(np.array([0.299, 0.587, 0.114], np.float32), planes, 1)[None]
    return np.ascontiguousarray(planes[None])


def _setting(tensor: dict[str, Any], settings: dict[str, str], picture: np.ndarray) -> np.ndarray:
    name, dtype = tensor["name"], "float32" if tensor["dtype"] == "T" else tensor["dtype"]
    if name not in settings:
        raise BundleError(f"input {name!r} ({tensor['description']}; shape {tuple(tensor['shape'])}) is needed: --set {name}=VALUE")
    value = settings[name]
    if size := re.fullmatch(r"(\d+)x(\d+)", value):
        return np.zeros((int(size[1]), int(size[2])), dtype)
    try:
        return np.asarray(json.loads(value), dtype)
    except ValueError as error:
        raise BundleError(f"input {name!r}: {value!r} is neither JSON nor HEIGHTxWIDTH: {error}") from error


def write_image(path: Path, array: np.ndarray, tensor: dict[str, Any]) -> None:
    """Write the first image of an output. Float values are taken as 0 to 1 where they lie there, else stretched to it."""
    if tensor["layout"] == "NCHW":
        array = array[0].transpose(1, 2, 0)
    if array.dtype != np.uint8:
        low, high = float(array.min()), float(array.max())
        if low < -1e-3 or high > 1.0 + 1e-3:
            array = (array - low) / max(high - low, 1e-12)
        array = (np.clip(array, 0.0, 1.0) * 255.0 + 0.5).astype(np.uint8)
    if array.ndim == 3 and array.shape[2] not in (3, 4):
        array = array[..., 0]
    Image.fromarray(np.ascontiguousarray(array)).save(path)
