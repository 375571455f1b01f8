"""Images in windows, clusters of colours, random heights."""

from __future__ import annotations

import numpy as np

from .images import images
from .model import Panel, Shown

GUTTER = 2
#: Heights: deep water, shallow water, sand, grass, rock, snow.
HEIGHTS = np.array(
    [(20, 50, 120), (70, 140, 200), (225, 210, 150), (90, 150, 70), (120, 105, 90), (250, 250, 250)]
)
STOPS = (0.0, 0.42, 0.46, 0.55, 0.8, 1.0)


def windows(shown: Shown) -> list[Panel]:
    """Windows, separated, and the image from which they are cut or to which they are joined."""
    (given,) = shown.inputs.values()
    made = shown.first
    patches, image = (made, given) if made.dim() == 5 else (given, made)
    right = columns(shown, image.shape[3], patches.shape[4])
    sheet = Panel(
        next(n for n, t in (shown.inputs | shown.outputs).items() if t is patches),
        apart(patches[0].numpy(), right),
        f"{patches.shape[1]} windows",
        patches is given,
    )
    whole = Panel(
        next(n for n, t in (shown.inputs | shown.outputs).items() if t is image),
        colors(image[0].numpy()),
        "",
        image is given,
    )
    return [whole, sheet] if image is given else [sheet, whole]


def columns(shown: Shown, width: int, window: int) -> int:
    """The number of windows in a row."""
    config = shown.spec.config
    if "overlap" in config:  # tiles cover the image
        return int(np.ceil((width - window) / (window - config["overlap"][1]))) + 1
    stride = config["stride"][1]
    padding = (
        2 * config["padding"][1] if "padding" in config else sum(config.get("unpadding", (0, 0, 0, 0))[2:])
    )
    steps = (width + padding - window) / stride
    return int(np.ceil(steps) if config.get("allow_auto_padding") else np.floor(steps)) + 1


def colors(image: np.ndarray) -> np.ndarray:
    return (image.transpose(1, 2, 0).clip(0, 1) * 255 + 0.5).astype(np.uint8)


def apart(patches: np.ndarray, right: int) -> np.ndarray:
    """Patches (N, C, h, w) in rows, with gutters."""
    factor = 3
    cells = [
        np.pad(
            colors(p).repeat(factor, 0).repeat(factor, 1),
            ((0, GUTTER), (0, GUTTER), (0, 0)),
            constant_values=255,
        )
        for p in patches
    ]
    rows = [np.concatenate(cells[i : i + right], 1) for i in range(0, len(cells), right)]
    return np.concatenate(rows)


def posterised(shown: Shown) -> list[Panel]:
    """Each pixel in its cluster's colour; the centres before and after, with widths that show the clusters'
    sizes."""
    labels, means = shown.outputs["labels"].numpy(), shown.outputs["means"].numpy()
    flat = means[labels].reshape(shown.photo.shape)
    share = np.bincount(labels, minlength=len(means)) / len(labels)
    return [
        Panel("x: the photograph's pixels", shown.photo, given=True),
        Panel("means[labels]", colors(flat.transpose(2, 0, 1))),
        Panel(
            "centers",
            swatches(shown.inputs["centers"].numpy(), np.full(len(means), 1 / len(means))),
            given=True,
        ),
        Panel("means; widths: numbers of pixels", swatches(means, share)),
    ]


def swatches(values: np.ndarray, share: np.ndarray) -> np.ndarray:
    width, height = 236, 30
    index = np.searchsorted(share.cumsum() * width, np.arange(width) + 0.5).clip(max=len(values) - 1)
    return np.broadcast_to((values[index] * 255).round().astype(np.uint8), (height, width, 3))


def terrain(shown: Shown) -> list[Panel]:
    """Heights in the colours of a map, from the lowest to the highest."""
    random = next(p for p in images(shown) if p.given)
    rough = shown.inputs["roughness"].tolist() if "roughness" in shown.inputs else []
    made = []
    for i, height in enumerate(shown.first[:, 0].numpy()):
        level = (height - height.min()) / np.ptp(height)
        pixels = np.stack([np.interp(level, STOPS, HEIGHTS[:, k]) for k in range(3)], -1).astype(np.uint8)
        made.append(Panel(f"texture, roughness {rough[i]:.1g}" if rough else "texture", pixels))
    return [Panel(random.label, random.image, given=True), *made]
