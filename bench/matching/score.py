"""How well key points, matches and homographies agree with the truth.

Repeatability and matching score are K. Mikolajczyk, C. Schmid et al.'s (A comparison of affine region
detectors, IJCV 2005), by positions only.
"""

from __future__ import annotations

import cv2
import numpy as np
from scipy.spatial import KDTree

#: the largest distance, in pixels, that counts as the same position
NEAR = 3.0


def score(found: dict, homography: np.ndarray, shape: tuple[int, int]) -> dict:
    """The scores of one contender's result for one pair."""
    first, second = (np.array(found[k], float).reshape(-1, 2) for k in ("keypoints1", "keypoints2"))
    first = first[_inside(_moved(first, homography), shape)]
    second = second[_inside(_moved(second, np.linalg.inv(homography)), shape)]
    common = max(min(len(first), len(second)), 1)
    matches = np.array(found["matches"], float).reshape(-1, 4)
    right = np.linalg.norm(_moved(matches[:, :2], homography) - matches[:, 2:], axis=1) <= NEAR
    return {
        "keypoints": min(len(found["keypoints1"]), len(found["keypoints2"])),
        "repeatability": _correspondences(_moved(first, homography), second) / common,
        "matching_score": right.sum() / common,
        "precision": right.mean() if len(right) else 0.0,
        "error": corner_error(found["homography"], homography, shape),
        "ms": found["ms"],
    }


def corner_error(estimated: list[float] | None, homography: np.ndarray, shape: tuple[int, int]) -> float:
    """The mean distance, in pixels, between the image's corners mapped by the estimate and by the truth;
    infinite without an estimate."""
    if estimated is None or not np.isfinite(estimated).all():
        return np.inf
    height, width = shape
    corners = np.array([[0, 0], [width - 1, 0], [width - 1, height - 1], [0, height - 1.0]])
    return float(
        np.linalg.norm(
            _moved(corners, np.reshape(estimated, (3, 3))) - _moved(corners, homography), axis=1
        ).mean()
    )


def _moved(points: np.ndarray, homography: np.ndarray) -> np.ndarray:
    return cv2.perspectiveTransform(points[None], homography)[0] if len(points) else points


def _inside(points: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    return ((points >= 0) & (points <= np.array(shape[::-1]) - 1)).all(1)


def _correspondences(first: np.ndarray, second: np.ndarray) -> int:
    """The number of pairs of near points. Pairs are chosen greedily, the nearest first, and each point is in
    at most one pair."""
    if not len(first) or not len(second):
        return 0
    distances = KDTree(first).sparse_distance_matrix(KDTree(second), NEAR, output_type="coo_matrix")
    taken_first, taken_second, count = np.zeros(len(first), bool), np.zeros(len(second), bool), 0
    for k in np.argsort(distances.data, kind="stable"):
        i, j = distances.row[k], distances.col[k]
        if not taken_first[i] and not taken_second[j]:
            taken_first[i] = taken_second[j] = True
            count += 1
    return count
