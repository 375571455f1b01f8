"""Tensors as RGB arrays for display."""

from __future__ import annotations

import colorsys

import numpy as np
import torch

from chiasm import color

#: The values that replace the other channels, and the channels that are then shown in colour.
TINTED = {
    "HSV": ((0.0, 1.0, 1.0), (0,)),
    "HLS": ((0.0, 0.5, 1.0), (0,)),
    "HSL": ((0.0, 1.0, 0.5), (0,)),
    "LAB": ((65.0, 0.0, 0.0), (1, 2)),
    "LUV": ((65.0, 0.0, 0.0), (1, 2)),
    "YUV": ((0.5, 0.0, 0.0), (1, 2)),
    "YCbCr": ((0.5, 0.5, 0.5), (1, 2)),
    "XYZ": ((0.0, 0.0, 0.0), ()),
}
NAMES = {
    "HSV": ("hue", "saturation", "value"),
    "HLS": ("hue", "lightness", "saturation"),
    "HSL": ("hue", "saturation", "lightness"),
    "LAB": ("L", "a", "b"),
    "LUV": ("L", "u", "v"),
    "YCbCr": ("Y", "Cb", "Cr"),
}
CHECKS = (0.62, 0.88)


def planes_of(tensor: torch.Tensor, layout: str) -> list[np.ndarray]:
    """The images of a tensor, (H, W, C) each; for a volume the middle slice."""
    array = tensor.numpy()
    if layout == "NCDHW":
        array = array[:, :, array.shape[2] // 2]
    if layout in ("NCHW", "NCDHW"):
        return list(array.transpose(0, 2, 3, 1))
    if layout == "CHW":
        return [array.transpose(1, 2, 0)]
    if layout == "HW":
        return [array[..., None]]
    return list(array) if layout == "NHWC" else [array]


def visible(array: np.ndarray) -> tuple[np.ndarray, str]:
    """Values (H, W, C) as bytes, and a note on the mapping, unless 0 to 1 became black to white."""
    if array.dtype == np.uint8:
        return array, ""
    array = array.astype(np.float64)
    low, high = np.percentile(array, 0.5), np.percentile(array, 99.5)
    reach = max(-low, high)
    note = ""
    if low < -0.3 * reach:
        array = array / (2 * reach) + 0.5
        note = f"grey is 0, black {-reach:.2g}, white {reach:.2g}"
    elif low < -0.03 or high > 1.03 or 0 < high < 0.3 or (0 < high < 0.8 and np.median(array) < 0.2 * high):
        low = min(low, 0.0)
        array = (array - low) / (high - low)
        note = f"black is {low:.2g}, white {high:.3g}"
    return (array.clip(0, 1) * 255 + 0.5).astype(np.uint8), note


def rgb_of(array: np.ndarray) -> np.ndarray:
    """Bytes (H, W, 1, 3 or 4) as RGB; alpha over a chequered background."""
    if array.shape[2] == 1:
        return array.repeat(3, 2)
    if array.shape[2] == 4:
        y, x = np.indices(array.shape[:2]) // 8
        ground = np.where((x + y) % 2, *CHECKS)[..., None] * 255
        alpha = array[..., 3:] / 255
        return (array[..., :3] * alpha + ground * (1 - alpha) + 0.5).astype(np.uint8)
    return array[..., :3]


def channels_of(array: np.ndarray, space: str) -> list[tuple[str, np.ndarray, str]]:
    """(name, RGB, note) of each channel of an image (H, W, 3) in a colour space; hue and chroma in their
    colours."""
    others, tinted = TINTED[space]
    shown = []
    for index, name in enumerate(NAMES.get(space, tuple(space))):
        if index in tinted:
            stand_in = np.broadcast_to(np.asarray(others, np.float32), array.shape).copy()
            stand_in[..., index] = array[..., index]
            planes = torch.from_numpy(stand_in.transpose(2, 0, 1)[None].copy())
            rgb = getattr(color, f"{space.lower()}_to_rgb")(planes)[0].permute(1, 2, 0).numpy()
            shown.append((name, visible(rgb.clip(0, 1))[0], ""))
        else:
            plane, note = visible(array[..., index : index + 1])
            shown.append((name, rgb_of(plane), note))
    return shown


def chroma_of(array: np.ndarray) -> list[tuple[str, np.ndarray, str]]:
    """(name, RGB, note) of U and V (H, W, 2)."""
    array = array / np.float32(255) if array.dtype == np.uint8 else array
    return channels_of(np.concatenate([np.full_like(array[..., :1], 0.5), array], 2), "YUV")[1:]


def labels_of(array: np.ndarray) -> np.ndarray:
    """Labels (H, W, 1) in distinct colours, 0 in black."""
    found, index = np.unique(array, return_inverse=True)
    turn = np.arange(len(found)) * 0.618034
    palette = np.array(
        [
            (0, 0, 0) if label == 0 else colorsys.hsv_to_rgb(t % 1, 0.55 + 0.45 * (i % 2), 1)
            for i, (label, t) in enumerate(zip(found, turn, strict=True))
        ]
    )
    return (palette[index.reshape(array.shape[:2])] * 255).astype(np.uint8)
