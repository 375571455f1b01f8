"""Plain plots with Pillow: bars, scattered points."""

from __future__ import annotations

import colorsys

import numpy as np
from PIL import Image, ImageDraw, ImageFont

FONT = ImageFont.load_default(11)
INK, PAPER, FAINT = (40, 40, 40), (250, 250, 250), (200, 200, 200)
#: The colours of channels, and of the samples of a batch.
RGB = ((215, 50, 45), (40, 150, 60), (50, 90, 215))
SERIES = ((31, 119, 180), (214, 90, 10), (44, 140, 44), (150, 80, 180))


def blank(size: tuple[int, int]) -> tuple[Image.Image, ImageDraw.ImageDraw]:
    canvas = Image.new("RGB", size, PAPER)
    return canvas, ImageDraw.Draw(canvas)


def bars(series: list[np.ndarray], colors: tuple, labels: list[str], size: tuple[int, int]) -> np.ndarray:
    """Groups of bars from 0, one colour per series, with the axis at the left."""
    canvas, pen = blank(size)
    left, top, right, bottom = 42, 16 if labels else 6, size[0] - 4, size[1] - 6
    low, high = min(0.0, *(float(s.min()) for s in series)), max(float(s.max()) for s in series)
    scale = (bottom - top) / max(high - low, 1e-12)
    zero = bottom + low * scale
    for value in sorted({low, 0.0, high}):
        y = bottom - (value - low) * scale
        pen.line((left, y, right, y), fill=FAINT)
        pen.text((left - 3, y), short(value), fill=INK, font=FONT, anchor="rm")
    slot = (right - left) / len(series[0])
    width = slot * (0.8 if slot > 6 else 1) / len(series)
    for k, values in enumerate(series):
        for i, value in enumerate(values.tolist()):
            x, end = left + i * slot + k * width, zero - value * scale
            pen.rectangle((x, min(zero, end), max(x, x + width - 1), max(zero, end)), fill=colors[k])
    x = left
    for text, ink in zip(labels, colors, strict=False):
        pen.text((x, 2), text, fill=ink, font=FONT)
        x += pen.textlength(text, font=FONT) + 10
    return np.asarray(canvas)


def short(value: float) -> str:
    """Three digits, without an exponent if that is short."""
    return f"{value:.0f}" if 100 <= abs(value) < 1e5 else f"{value:.2g}"


def scatter(points: np.ndarray, inks: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Points (N, 2) in their colours, with equal scales on both axes."""
    canvas, pen = blank(size)
    low, high = points.min(0), points.max(0)
    scale = min((np.array(size) - 24) / np.maximum(high - low, 1e-12))
    shift = np.array(size) / 2 - (low + high) / 2 * scale * (1, -1)
    ends = [
        np.array([low[0], 0.0]),
        np.array([high[0], 0.0]),
        np.array([0.0, low[1]]),
        np.array([0.0, high[1]]),
    ]
    ends = [e * scale * (1, -1) + shift for e in ends]
    pen.line((*ends[0], *ends[1]), fill=FAINT)
    pen.line((*ends[2], *ends[3]), fill=FAINT)
    for (x, y), ink in zip(points * scale * (1, -1) + shift, inks, strict=True):
        pen.ellipse((x - 1, y - 1, x + 1, y + 1), fill=tuple(int(v) for v in ink))
    return np.asarray(canvas)


def hues(count: int) -> np.ndarray:
    """Distinct colours."""
    return (np.array([colorsys.hsv_to_rgb(i / count, 0.9, 0.85) for i in range(count)]) * 255).astype(int)
