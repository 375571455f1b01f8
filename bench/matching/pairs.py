"""Photographs and their images under known homographies: ten photographs of scikit-image, each changed in six
ways."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from skimage import data, io

#: file names inside scikit-image
PHOTOGRAPHS = (
    "astronaut.png",
    "brick.png",
    "camera.png",
    "chelsea.png",
    "coffee.png",
    "coins.png",
    "grass.png",
    "gravel.png",
    "motorcycle_left.png",
    "rocket.jpg",
)
CHANGES = ("viewpoint", "scale", "rotation", "light", "blur", "JPEG")


@dataclass(frozen=True)
class Pair:
    photograph: str
    change: str
    first: Path
    second: Path
    homography: np.ndarray  # maps pixels of the first image to the second


def pairs(folder: Path) -> list[Pair]:
    """All 60 pairs, written as files. The random numbers are the same in every run."""
    folder.mkdir(parents=True, exist_ok=True)
    made = []
    for i, name in enumerate(PHOTOGRAPHS):
        image = io.imread(Path(data.__file__).parent / name)
        grey = cv2.cvtColor(image[..., :3], cv2.COLOR_RGB2GRAY) if image.ndim == 3 else image
        first = folder / f"{Path(name).stem}.png"
        cv2.imwrite(str(first), grey)
        for k, change in enumerate(CHANGES):
            random = np.random.default_rng(100 * i + k)
            homography = _homography(change, grey.shape, random)
            second = folder / f"{Path(name).stem}.{change}.png"
            cv2.imwrite(str(second), _degraded(change, _warped(grey, homography), random))
            made.append(Pair(Path(name).stem, change, first, second, homography))
    return made


def _homography(change: str, shape: tuple[int, int], random: np.random.Generator) -> np.ndarray:
    """A homography about the image's centre: corners moved by up to a fifth of the sides (a tenth for light,
    blur and JPEG), scaled down by 1.3 to 2.5, or rotated by 15 to 180 degrees."""
    height, width = shape
    corners = np.float32([[0, 0], [width - 1, 0], [width - 1, height - 1], [0, height - 1]])
    centre = corners.mean(0)
    share = {"viewpoint": 0.2, "scale": 0.03, "rotation": 0.03}.get(change, 0.1)
    moved = corners + random.uniform(-share, share, (4, 2)).astype(np.float32) * np.float32([width, height])
    if change == "scale":
        moved = centre + (moved - centre) / random.uniform(1.3, 2.5)
    if change == "rotation":
        angle = np.deg2rad(random.uniform(15, 180) * random.choice([-1, 1]))
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        moved = centre + (moved - centre) @ turn.T
    return cv2.getPerspectiveTransform(corners, moved.astype(np.float32))


def _warped(grey: np.ndarray, homography: np.ndarray) -> np.ndarray:
    """The warped image without aliasing: rendered at four times the size along each axis, then the mean of
    each 4 x 4 pixels."""
    # In the enlarged image, the centre of pixel x is at 4 x + 1.5.
    enlarge = np.array([[4, 0, 1.5], [0, 4, 1.5], [0, 0, 1.0]])
    size = (4 * grey.shape[1], 4 * grey.shape[0])
    large = cv2.warpPerspective(grey, enlarge @ homography, size, flags=cv2.INTER_CUBIC)
    return cv2.resize(large, grey.shape[::-1], interpolation=cv2.INTER_AREA)


def _degraded(change: str, image: np.ndarray, random: np.random.Generator) -> np.ndarray:
    if change == "light":
        return (
            np.clip(255 * (image / 255.0) ** random.uniform(1.4, 2.2) * random.uniform(0.5, 0.8), 0, 255)
            .round()
            .astype(np.uint8)
        )
    if change == "blur":
        return cv2.GaussianBlur(image, (0, 0), random.uniform(1.0, 2.5))
    if change == "JPEG":
        return cv2.imdecode(
            cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, int(random.integers(8, 30))])[1],
            cv2.IMREAD_GRAYSCALE,
        )
    return image
