"""Epipolar lines on photographs."""

from __future__ import annotations

import numpy as np
from PIL import Image, ImageDraw

from gallery.geometric.motorcycle import views

from .model import Panel, Shown
from .tensors import wheel
from .views import lines_of, pair

DOT, LINE = 9, 3


def stereo_views(shown: Shown) -> list[Panel]:
    """Points of the left photograph; their lines in the right one, and its points, which are hollow if the op
    finds that they do not correspond."""
    _, first, second = pair(shown)
    matrix = shown.outputs["fundamental"][0].numpy()
    inliers = shown.outputs["inliers"][0].numpy() if "inliers" in shown.outputs else np.ones(len(first), bool)
    inks = [tuple(int(v) for v in ink) for ink in wheel(first)]
    left, right = (Image.fromarray(v) for v in views())
    pen = ImageDraw.Draw(left)
    for point, ink in zip(first, inks, strict=True):
        dot(pen, point, ink)
    pen = ImageDraw.Draw(right)
    for (a, b, c), ink, inlier in zip(lines_of(matrix, first), inks, inliers, strict=True):
        ends = (
            [(x, -(a * x + c) / b) for x in (0, right.width)]
            if abs(b) > abs(a)
            else [(-(b * y + c) / a, y) for y in (0, right.height)]
        )
        if inlier:
            pen.line(ends, ink, LINE)
    for point, ink, inlier in zip(second, inks, inliers, strict=True):
        dot(pen, point, ink, inlier)
    note = (
        f"{inliers.sum()} of {len(inliers)} are inliers, the others are hollow" if not inliers.all() else ""
    )
    return [
        Panel("left photograph and points1", np.asarray(left), "", True),
        Panel("right photograph, turned: lines and points2", np.asarray(right), note),
    ]


def dot(pen: ImageDraw.ImageDraw, point: np.ndarray, ink: tuple[int, int, int], filled: bool = True) -> None:
    x, y = point
    box = (x - DOT, y - DOT, x + DOT, y + DOT)
    pen.ellipse(box, ink if filled else None, "white" if filled else ink, 2 if filled else 4)
