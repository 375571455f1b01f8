"""Photographs and their images under known homographies."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from gallery.photographs import photograph

from .settings import Settings


@dataclass(frozen=True)
class Pair:
    """Two frames (H, W, 3), uint8, BGR, and the homography (3, 3), float64, which maps pixels of the first to
    the second."""

    photograph: str
    reach: float
    src: np.ndarray
    dst: np.ndarray
    homography: np.ndarray


def pairs(settings: Settings) -> list[Pair]:
    """One pair per trial: each reach with each photograph in turn."""
    kinds = [(name, reach) for name in settings.photographs for reach in settings.reaches]
    return [pair(settings, *kinds[k % len(kinds)], settings.seed + k) for k in range(settings.trials)]


def pair(settings: Settings, name: str, reach: float, seed: int) -> Pair:
    """The centre part of a photograph, and a view of the same photograph in which the corners of this part
    are moved by up to `reach` of its sides.

    The photograph continues around this part, so the second view is filled nearly everywhere, like a camera
    image.
    """
    size = np.array([settings.width, settings.height])
    whole, corner = _reduced(photograph(name)[..., ::-1], size, settings.margin)
    corners = corners_of(settings.width, settings.height)
    moved = corners + np.random.default_rng(seed).uniform(-reach, reach, (4, 2)) * size
    homography = cv2.getPerspectiveTransform(corners.astype(np.float32), moved.astype(np.float32))
    away = np.array([[1, 0, -corner[0]], [0, 1, -corner[1]], [0, 0, 1.0]])
    return Pair(
        name,
        reach,
        whole[corner[1] :, corner[0] :][: size[1], : size[0]].copy(),
        _warped(whole, homography @ away, size),
        homography,
    )


def corners_of(width: int, height: int) -> np.ndarray:
    """The centres of an image's corner pixels, (4, 2)."""
    return np.array([[0, 0], [width - 1, 0], [width - 1, height - 1], [0, height - 1]], np.float64)


def corner_error(pair: Pair, back: np.ndarray) -> float:
    """The mean distance, in the source's pixels, of its corners from the same corners mapped by the truth and
    then back to the source by `back` (3, 3); infinite without an estimate."""
    if not np.isfinite(back).all():
        return np.inf
    height, width = pair.src.shape[:2]
    corners = corners_of(width, height)
    return float(
        np.linalg.norm(
            cv2.perspectiveTransform(corners[None], back @ pair.homography)[0] - corners, axis=1
        ).mean()
    )


def _reduced(image: np.ndarray, size: np.ndarray, margin: float) -> tuple[np.ndarray, np.ndarray]:
    """A photograph, reduced so that the margin remains around its centre part of the given size, and the
    upper left corner of this part."""
    whole = np.array(image.shape[1::-1])
    factor = ((1 + 2 * margin) * size / whole).max()
    smaller = np.round(whole * factor).astype(int)
    return cv2.resize(image, tuple(smaller.tolist()), interpolation=cv2.INTER_AREA), (smaller - size) // 2


def _warped(image: np.ndarray, homography: np.ndarray, size: np.ndarray) -> np.ndarray:
    """The warped image without aliasing: rendered at four times the size along each axis, then the mean of
    each 4 x 4 pixels."""
    enlarge = np.array([[4, 0, 1.5], [0, 4, 1.5], [0, 0, 1.0]])  # the centre of pixel x becomes 4 x + 1.5
    large = cv2.warpPerspective(
        image, enlarge @ homography, tuple((4 * size).tolist()), flags=cv2.INTER_CUBIC
    )
    return cv2.resize(large, tuple(size.tolist()), interpolation=cv2.INTER_AREA)
