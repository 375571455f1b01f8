"""Matches between two photographs, as lines."""

from __future__ import annotations

import numpy as np
import torch

from chiasm.geometry import transform
from gallery.judged.matched import key_points, partners, view
from gallery.sheets import Photo

from .model import WHOLE, WIDE, Panel, Shown

GOOD, BAD, UNKNOWN, DOT = (70, 225, 90), (255, 60, 40), (250, 220, 60), (90, 200, 255)
GUTTER, NEAR, AT_MOST = 6, 3.0, 120


def beside(first: np.ndarray, second: np.ndarray) -> tuple[Photo, np.ndarray]:
    """Two photographs side by side, and the position of the second one's first pixel."""
    height = max(len(first), len(second))
    parts = [
        np.pad(p, ((0, height - len(p)), (0, g), (0, 0)), constant_values=255)
        for p, g in ((first, GUTTER), (second, 0))
    ]
    return Photo(np.concatenate(parts, 1), WHOLE[0]), np.array([first.shape[1] + GUTTER, 0])


def bytes_of(image: torch.Tensor) -> np.ndarray:
    """(C, H, W) as (H, W, 3)."""
    return (image.expand(3, -1, -1).permute(1, 2, 0).clamp(0, 1) * 255).round().byte().numpy()


def matches(shown: Shown) -> list[Panel]:
    """The motorcycle's photographs with a line per match, coloured by the pair's true disparity."""
    points = [lafs[0, :, :, 2].double() for lafs, _ in key_points()]
    sheet, shift = beside(bytes_of(view("left")), bytes_of(view("right")))
    for i, (found, move) in enumerate(zip(points, (0 * shift, shift), strict=True), 1):
        mask = shown.inputs.get(f"mask{i}", torch.ones(1, len(found), dtype=torch.bool))[0]
        for pixel, there in zip(sheet.at(found.numpy() + move), mask.tolist(), strict=True):
            sheet.spot(pixel, 1.6, DOT, hollow=not there)
    pairs = shown.outputs["indices"][0][shown.outputs["valid"][0]]
    first, second = points[0][pairs[:, 0]], points[1][pairs[:, 1]]
    off = (partners(first) - second).norm(dim=1)
    inks = [UNKNOWN if np.isnan(d) else GOOD if d < NEAR else BAD for d in off.tolist()]
    for a, b, ink in sorted(
        zip(first.numpy(), second.numpy() + shift, inks, strict=True), key=lambda line: line[2] == BAD
    ):
        sheet.path(np.stack([a, b]), ink, 1)
    count = " / ".join(str(inks.count(ink)) for ink in (GOOD, BAD, UNKNOWN))
    note = (
        f"{len(inks)} matches; by the true disparity right (green) / wrong (red) / not known (yellow):"
        f" {count}"
    )
    return [Panel(label_of(shown), sheet.pixels(), note, weight=WIDE)]


def label_of(shown: Shown) -> str:
    masked = " (rings: masked)" if "mask1" in shown.inputs else ""
    return f"key points of both photographs{masked}, matches"


def two_views(shown: Shown) -> list[Panel]:
    """Matches on both images, green if they fit the homography; and the second image, warped back onto the
    first by it."""
    first, second = (bytes_of(shown.inputs[n][0]) for n in ("image1", "image2"))
    sheet, shift = beside(first, second)
    matched, inliers = (shown.outputs[n][0].numpy() for n in ("matched", "inliers"))
    ends = [shown.outputs[n][0].double().numpy() for n in ("points1", "points2")]
    chosen = np.flatnonzero(matched)
    for i in sorted(chosen[:: max(1, len(chosen) // AT_MOST)], key=lambda i: not inliers[i]):
        sheet.path(np.stack([ends[0][i], ends[1][i] + shift]), GOOD if inliers[i] else BAD, 0.8)
    back = torch.linalg.inv(shown.outputs["homography"].double()).float()
    size = first.shape[:2]
    moved = transform.warp_perspective(shown.inputs["image2"], back, size)[0]
    onto = torch.cat([shown.inputs["image1"][0], moved, moved])
    note = f"{matched.sum()} matches, {(matched & inliers).sum()} of them inliers (green)"
    return [
        Panel("image1, image2, matches", sheet.pixels(), note, weight=WIDE),
        Panel("image2, warped back by the homography", bytes_of(moved)),
        Panel("image1 in red, the other in cyan", bytes_of(onto), "grey where both agree"),
    ]
