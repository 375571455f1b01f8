"""Tensors other than photographs, as pictures: classes, their probabilities, masks, flows, depths,
volumes."""

from __future__ import annotations

import colorsys

import numpy as np
import torch

from chiasm.export.spec import TensorSpec
from gallery.pictures import rgb_of, visible
from gallery.plots import short
from gallery.sheets import Photo

from .solid import montage
from .tensors import shades

#: The colours of classes 0, 1, ...: a sky, a horse, a meadow, the sun, a cloud, a hill.
CLASSES = np.array(
    [(150, 190, 235), (140, 80, 40), (120, 175, 75), (250, 205, 60), (240, 240, 245), (85, 120, 110)]
)
UNSEEN, HIDDEN = (60, 60, 60), (205, 210, 220)
#: Non-negative quantities without a fixed maximum; the largest is drawn yellow.
DEPTHS = ("disparity", "depth")
ARROWS = 14


def picture(
    described: TensorSpec, value: torch.Tensor, limits: tuple[float, float]
) -> tuple[np.ndarray, str]:
    """The first entry of a batch as RGB (H, W, 3), and the meaning of its colours; ``limits`` are for
    depths."""
    array, about = value[0].numpy(), f"{described.name} {described.description}"
    volume = array.ndim == 4 or "D" in described.shape
    if value.dtype == torch.bool or value.dtype == torch.int64:
        flat = array[0] if array.ndim > 2 + volume else array
        pixels = classes(flat) if value.dtype == torch.int64 else flat[..., None] * np.full(3, 255)
        return (montage(pixels.transpose(3, 0, 1, 2) / 255) if volume else pixels.astype(np.uint8)), (
            "dark: ignored" if flat.min() < 0 else ""
        )
    if array.shape[-1] == 2:
        return flow(array), "colours are directions"
    if "logits" in about or "probabilities" in about:
        pixels = mixed(shares(value[0], "logits" in about))
        return (montage(pixels.transpose(3, 0, 1, 2)) if volume else (pixels * 255).astype(np.uint8)), ""
    if volume:
        return montage(array if array.ndim == 4 else array[None]), ""
    if any(word in about for word in DEPTHS):
        return heat(array[0], limits), heat_note(limits)
    pixels, note = visible(array.transpose(1, 2, 0))
    return rgb_of(pixels), note if array.shape[0] == 3 and "heatmaps" in about else ""


def classes(labels: np.ndarray) -> np.ndarray:
    """The colours (..., 3) of labels."""
    return np.where(labels[..., None] < 0, UNSEEN, CLASSES[labels.clip(0) % len(CLASSES)])


def shares(value: torch.Tensor, logits: bool) -> np.ndarray:
    """The probability of each class at each place, (C, ...); with one channel, class 0 has the rest."""
    if len(value) == 1:
        one = torch.sigmoid(value) if logits else value
        return torch.cat([1 - one, one]).numpy()
    return (torch.softmax(value, 0) if logits else value).numpy()


def mixed(parts: np.ndarray) -> np.ndarray:
    """The classes' colours, mixed, (..., 3) from 0 to 1."""
    return np.moveaxis(parts, 0, -1) @ CLASSES[: len(parts)] / 255


def heat(values: np.ndarray, limits: tuple[float, float]) -> np.ndarray:
    """Values (H, W) from dark blue to yellow."""
    return shades(values, limits).round().astype(np.uint8)


def heat_note(limits: tuple[float, float]) -> str:
    return f"from {short(limits[0])} (dark) to {short(limits[1])} (yellow)"


def limits_of(values: list[torch.Tensor]) -> tuple[float, float]:
    """The lower limit, 0 or less, and the highest value without outliers."""
    everything = torch.cat([v.flatten() for v in values]).double().numpy()
    return min(0.0, float(everything.min())), max(float(np.percentile(everything, 99.8)), 1e-12)


def flow(vectors: np.ndarray) -> np.ndarray:
    """Vectors (H, W, 2): the hue shows the direction, short ones are paler, with arrows on top."""
    length = np.hypot(vectors[..., 0], vectors[..., 1])
    wheel = np.array([colorsys.hsv_to_rgb(t / 64, 0.9, 1) for t in range(64)])
    turn = np.arctan2(vectors[..., 1], vectors[..., 0]) / (2 * np.pi) % 1
    strong = (length / length.max())[..., None]
    sheet = Photo(
        ((1 - strong * (1 - wheel[(turn * 64).astype(int) % 64])) * 255).astype(np.uint8), vectors.shape[1]
    )
    step = max(vectors.shape[:2]) // ARROWS
    for y in range(step // 2, vectors.shape[0], step):
        for x in range(step // 2, vectors.shape[1], step):
            arrow(sheet, np.array([x, y], float), vectors[y, x])
    return sheet.pixels()


def arrow(sheet: Photo, start: np.ndarray, vector: np.ndarray) -> None:
    """Draw an arrow; its head is omitted if it is too short."""
    across = np.array([-vector[1], vector[0]])
    end = start + vector
    sheet.path(np.stack([start, end]), UNSEEN)
    if np.hypot(*vector) > 3:
        sheet.path(
            np.stack([end - 0.35 * vector + 0.2 * across, end, end - 0.35 * vector - 0.2 * across]), UNSEEN
        )
