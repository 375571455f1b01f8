"""A photographed scene with known geometry: the rectified stereo pair of a motorcycle that ships inside
scikit-image (Middlebury 2014)."""

import functools

import numpy as np
from photos import FOLDER

#: The calibration of the images in their original size, from the documentation of
#: skimage.data.stereo_motorcycle; distances in millimetres.
LEFT = np.array([[994.978, 0, 311.193], [0, 994.978, 254.877], [0, 0, 1]])
OFFSET, BASELINE = 31.086, 193.001
RIGHT = LEFT + np.array([[0, 0, OFFSET], [0, 0, 0], [0, 0, 0]])


@functools.cache
def disparity() -> np.ndarray:
    """(500, 741), x in the left image minus x in the right; NaN or infinite if unknown."""
    with np.load(FOLDER / "motorcycle_disp.npz") as data:
        return data["arr_0"].astype(np.float64)


def matches(count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """(count, 2): pixels of the left image, and the pixels of the same points in the right one."""
    d = disparity()
    rows, columns = np.nonzero(np.isfinite(d))
    pick = np.random.default_rng(seed).choice(len(rows), count, replace=False)
    left = np.stack([columns[pick], rows[pick]], 1).astype(np.float64)
    return left, left - np.stack([d[rows[pick], columns[pick]], np.zeros(count)], 1)


def turned(points: np.ndarray, K: np.ndarray, R: np.ndarray, new_K: np.ndarray) -> np.ndarray:
    """The pixels (N, 2) of a camera with matrix K, as seen by a camera that is rotated by R and has the
    matrix new_K."""
    x = np.c_[points, np.ones(len(points))] @ (new_K @ R @ np.linalg.inv(K)).T
    return x[:, :2] / x[:, 2:]
