"""Pictures of what an op did: input on the left, output on the right."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch
from PIL import Image, ImageDraw

from chiasm.export.spec import Spec


def draw(spec: Spec, outputs: list[dict], inputs: dict[str, torch.Tensor], results: list[torch.Tensor], path: Path) -> bool:
    """Write the picture of one op; False where it has no image to show."""
    source = next((as_rgb(inputs[t.name], t.layout, t.color) for t in spec.inputs if t.layout in ("NCHW", "HWC")), None)
    if source is None:
        return False
    names = [o["name"] for o in outputs]
    if "keypoints" in names:
        result = with_points(source, results[names.index("keypoints")][0], results[names.index("valid")][0])
    elif outputs[0]["layout"]:
        result = as_rgb(results[0], outputs[0]["layout"], outputs[0]["color"])
    else:  # a number: show what it compared
        result = as_rgb(inputs[spec.inputs[1].name], "NCHW", "")
    height = max(source.shape[0], result.shape[0])
    canvas = Image.new("RGB", (source.shape[1] + result.shape[1] + 8, height + 22), "white")
    canvas.paste(Image.fromarray(source), (0, 22))
    canvas.paste(Image.fromarray(result), (source.shape[1] + 8, 22))
    label = f"{spec.name}   {float(results[0]):.4f}" if results[0].numel() == 1 else spec.name
    ImageDraw.Draw(canvas).text((4, 5), label, fill="black")
    path.parent.mkdir(parents=True, exist_ok=True)
    canvas.save(path)
    return True


def as_rgb(tensor: torch.Tensor, layout: str, color: str) -> np.ndarray:
    """The first image of a tensor as RGB uint8 (H, W, 3): values outside 0 to 1 are stretched into it, faint ones raised;
    hue, saturation and value are shown as red, green and blue."""
    array = tensor.numpy()
    if layout == "NCHW":
        array = array[0].transpose(1, 2, 0)
    if array.ndim == 2:
        array = array[..., None]
    if color == "HSV":
        array = array / np.array([2 * np.pi, 1, 1], array.dtype)
    if array.dtype != np.uint8:
        low, high = (np.percentile(array, q) for q in (1, 99))
        if array.min() < -0.05 or array.max() > 1.05:
            array = (array - low) / max(high - low, 1e-12)
        elif high < 0.4:
            array = array / max(high, 1e-12)
        array = (array.clip(0, 1) * 255 + 0.5).astype(np.uint8)
    if array.shape[2] == 1:
        array = array.repeat(3, 2)
    return np.ascontiguousarray(array[..., ::-1] if color == "BGR" else array)


def with_points(image: np.ndarray, points: torch.Tensor, valid: torch.Tensor) -> np.ndarray:
    """The image with a ring at each valid point (x, y)."""
    canvas = Image.fromarray(image)
    pen = ImageDraw.Draw(canvas)
    for x, y in points[valid].tolist():
        pen.ellipse((x - 4, y - 4, x + 4, y + 4), outline=(255, 60, 0), width=2)
    return np.asarray(canvas)


def contact_sheet(paths: list[Path], path: Path, columns: int = 3, width: int = 460) -> None:
    """All pictures on one page."""
    tiles = [Image.open(p) for p in paths]
    tiles = [t.resize((width, max(1, round(t.height * width / t.width))), Image.Resampling.LANCZOS) for t in tiles]
    rows = [tiles[i : i + columns] for i in range(0, len(tiles), columns)]
    heights = [max(t.height for t in row) + 6 for row in rows]
    sheet = Image.new("RGB", (columns * (width + 6), sum(heights)), "white")
    top = 0
    for row, height in zip(rows, heights, strict=True):
        for column, tile in enumerate(row):
            sheet.paste(tile, (column * (width + 6), top))
        top += height
    sheet.save(path)
