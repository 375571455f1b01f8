"""Distributions of values: histograms, densities, whitened samples."""

from __future__ import annotations

import numpy as np

from gallery import plots

from .images import input_panels, kernel_panel
from .model import HALF, THIRD, Panel, Shown


def histogram(shown: Shown) -> list[Panel]:
    """Bars; an image's histogram has one colour per channel."""
    given = input_panels(shown) or [Panel("x: brightness of its pixels", shown.photo, given=True)]
    counts = shown.first[0].reshape(-1, shown.first.shape[-1]).numpy()
    names = ["red", "green", "blue"] if len(counts) == 3 else []
    return [
        *given,
        Panel(
            next(iter(shown.outputs)),
            plots.bars(list(counts), plots.RGB if names else plots.SERIES, names, HALF),
        ),
    ]


def joint_density(shown: Shown) -> list[Panel]:
    x1, x2 = (shown.inputs[n][0].numpy()[::7] for n in ("x1", "x2"))
    inks = np.stack([x1, x2, np.zeros_like(x1)], 1) * 200
    density = shown.first[0].flip(0).sqrt()
    return [
        Panel("x1 (red), x2 (green): pixels", plots.scatter(np.stack([x2, x1], 1), inks, HALF), given=True),
        Panel("density", kernel_panel("", density).image, "its square root is shown"),
    ]


def whitening(shown: Shown) -> list[Panel]:
    """Features 0 and 1 of each sample before and after."""
    before, after = shown.inputs["inp"].numpy(), shown.first.numpy()
    inks = (before[:, :3] * 230).clip(0, 230)
    return [
        Panel(
            "inp: red and green of pixels",
            plots.scatter(before[:, :2] - before[:, :2].mean(0), inks, HALF),
            given=True,
        ),
        Panel("output: the same samples", plots.scatter(after[:, :2], inks, HALF)),
    ]


def matrices(shown: Shown) -> list[Panel]:
    before = shown.inputs["inp"].numpy()
    points = plots.scatter(before[:, :2], (before[:, :3] * 230).clip(0, 230), THIRD)
    return [
        Panel("inp: pixels", points, given=True),
        *(kernel_panel(n, shown.outputs[n]) for n in ("transform_matrix", "inverse")),
    ]
