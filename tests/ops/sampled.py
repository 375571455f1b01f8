"""Sampling by definition, in float64 and one tap at a time: a reference for warps, in addition to SciPy and
OpenCV."""

import numpy as np
from scipy.ndimage import map_coordinates

#: SciPy's names of our paddings, for pixel centres at integers.
SCIPY_BORDER = {"zeros": "grid-constant", "border": "nearest", "reflection": "mirror"}


def by_scipy(image: np.ndarray, positions: list[np.ndarray], padding: str, order: int = 1) -> np.ndarray:
    """One sample (C, *size) at `positions`, one array per axis of size (slowest first)."""
    return np.stack(
        [map_coordinates(plane, positions, order=order, mode=SCIPY_BORDER[padding]) for plane in image]
    )


def pulled(matrix: np.ndarray, height: int, width: int) -> tuple[np.ndarray, np.ndarray]:
    """The source's rows and columns for an output's pixels, for a 3 x 3 matrix from the source to the
    output."""
    grid = np.stack([*np.meshgrid(np.arange(width), np.arange(height)), np.ones((height, width))])
    x, y, w = np.einsum("ij,jhw->ihw", np.linalg.inv(matrix), grid)
    return y / w, x / w


def by_keys(image: np.ndarray, rows: np.ndarray, columns: np.ndarray, padding: str) -> np.ndarray:
    """One sample (C, H, W) by Keys' cubic convolution with a = -0.75; borders as in `by_scipy`."""
    height, width = image.shape[1:]
    out = np.zeros((len(image), *rows.shape))
    top, left = np.floor(rows).astype(int), np.floor(columns).astype(int)
    for i in range(-1, 3):
        for j in range(-1, 3):
            weight = keys(np.abs(rows - top - i)) * keys(np.abs(columns - left - j))
            y, x = top + i, left + j
            inside = (y >= 0) & (y < height) & (x >= 0) & (x < width)
            if padding == "reflection":
                y, x = mirrored(y, height), mirrored(x, width)
            values = image[:, np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)]
            out += values * weight * (inside if padding == "zeros" else 1.0)
    return out


def keys(d: np.ndarray) -> np.ndarray:
    """R. Keys' kernel at nonnegative distances."""
    a = -0.75
    near = (a + 2) * d**3 - (a + 3) * d**2 + 1
    far = a * d**3 - 5 * a * d**2 + 8 * a * d - 4 * a
    return np.where(d <= 1, near, np.where(d < 2, far, 0.0))


def mirrored(i: np.ndarray, size: int) -> np.ndarray:
    """Indices mirrored at the first and last pixel's centre."""
    i = np.abs(i) % max(2 * (size - 1), 1)
    return np.where(i >= size, 2 * (size - 1) - i, i)
