"""Errors of depth against the truth, and differences from another depth."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from torch import Tensor

from .scenes import BASELINE, Scene, pixels
from .settings import Settings
from .step import enlarge

NEAR_ENOUGH = 0.05


@dataclass(frozen=True)
class Score:
    """Scores over all pixels with a known depth, and over those that every view sees.

    error: mean of |d - truth| / truth. within: share of the pixels with an error below NEAR_ENOUGH.
    """

    error: float
    within: float
    seen_error: float
    seen_within: float


def depth_at_full_size(inverse_depth: Tensor, scene: Scene) -> np.ndarray:
    """The depth (H, W) of a scale's inverse depth (1, 1, h, w), enlarged as in the optimisation."""
    return 1 / enlarge(inverse_depth, scene.images)[0, 0].double().numpy()


def score(depth: np.ndarray, scene: Scene) -> Score:
    """The score of a depth (H, W); NaN counts as wrong in the shares, and is ignored in the means."""
    error = np.abs(depth - scene.depth) / scene.depth
    known = np.isfinite(scene.depth)
    seen = known & scene.seen
    within = error < NEAR_ENOUGH
    return Score(
        float(np.nanmean(error[known])),
        float(within[known].mean()),
        float(np.nanmean(error[seen])),
        float(within[seen].mean()),
    )


@dataclass(frozen=True)
class Difference:
    """The difference of two depths, relative to the second."""

    mean: float
    median: float
    most: float
    within: float


def difference(depth: np.ndarray, other: np.ndarray) -> Difference:
    """The difference between depths (H, W): mean, median, the 99th percentile, and the share of pixels that
    differ by less than 1%."""
    relative = np.abs(depth - other) / other
    return Difference(
        float(relative.mean()),
        float(np.median(relative)),
        float(np.quantile(relative, 0.99)),
        float((relative < 0.01).mean()),
    )


def semi_global(scene: Scene, settings: Settings) -> tuple[np.ndarray, float]:
    """OpenCV's semi-global matching, a reference for the stereo pair.

    Returns:
        The depth (H, W), NaN where it finds none, and the share of pixels with a depth.
    """
    near, far = settings.depths
    focal, offset = float(scene.cameras[0, 0, 0]), float(scene.cameras[1, 0, 2] - scene.cameras[0, 0, 2])
    low, high = int(np.floor(BASELINE * focal / far - offset)), BASELINE * focal / near - offset
    count, block = 16 * int(np.ceil((high - low) / 16)), 5
    smoothness = {"P1": 8 * 3 * block**2, "P2": 32 * 3 * block**2}  # as recommended in its documentation
    matcher = cv2.StereoSGBM_create(
        low, count, block, **smoothness, disp12MaxDiff=1, uniquenessRatio=10, mode=cv2.STEREO_SGBM_MODE_HH
    )
    # It omits as many columns as there are disparities.
    margin = count + max(low, 0)
    padded = [
        cv2.copyMakeBorder(pixels(image), 0, 0, margin, margin, cv2.BORDER_REPLICATE)
        for image in scene.images
    ]
    disparity = matcher.compute(*padded)[:, margin:-margin] / 16.0
    found = disparity >= low
    return np.where(found, BASELINE * focal / np.where(found, disparity + offset, 1), np.nan), float(
        found.mean()
    )
