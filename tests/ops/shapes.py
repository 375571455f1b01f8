"""Binary images that are hard for algorithms that follow connected pixels."""

import numpy as np


def spiral(height: int, width: int) -> np.ndarray:
    """A path one pixel wide with gaps of one pixel, from the corner to the centre."""
    image = np.zeros((height, width), np.uint8)
    row = column = 0
    step, turns = (0, 1), 0
    image[0, 0] = 1
    while turns < 2:
        (r, c), (r2, c2) = ((row + k * step[0], column + k * step[1]) for k in (1, 2))
        ahead = 0 <= r2 < height and 0 <= c2 < width and image[r2, c2]
        if 0 <= r < height and 0 <= c < width and not image[r, c] and not ahead:
            row, column, turns = r, c, 0
            image[row, column] = 1
        else:
            step, turns = (step[1], -step[0]), turns + 1
    return image


def hard_masks(height: int, width: int) -> list[np.ndarray]:
    """Spirals, combs whose teeth join in the last row, and noise near the density at which shapes begin to
    span the image."""
    path = spiral(height, width)
    comb = np.ones((height, width), np.uint8)
    comb[:-1, 1::2] = 0
    generator = np.random.default_rng(0)
    noise = [(generator.random((height, width)) < p).astype(np.uint8) for p in (0.3, 0.41, 0.6)]
    return [path, path[::-1], path[:, ::-1], comb, comb[::-1], *noise]
