"""The names of the borders in other libraries, and plane-wise application of their functions."""

from typing import Callable

import cv2
import numpy as np
from torch import Tensor

CV_BORDER = {
    "reflect": cv2.BORDER_REFLECT_101,
    "replicate": cv2.BORDER_REPLICATE,
    "constant": cv2.BORDER_CONSTANT,
}
SCIPY_MODE = {"reflect": "mirror", "replicate": "nearest", "circular": "wrap", "constant": "constant"}
#: (B, C, H, W) with odd and even sizes, and with other channels than 1 or 3.
SHAPES = [(1, 1, 37, 53), (2, 3, 64, 31), (3, 5, 19, 20), (1, 7, 21, 18)]


def per_plane(x: Tensor, function: Callable[[np.ndarray], np.ndarray], axes: int = 2) -> np.ndarray:
    """``function`` of every image (or volume, for 3 axes) of x."""
    planes = x.numpy().reshape(-1, *x.shape[-axes:])
    results = np.stack([function(p) for p in planes])
    return results.reshape(*x.shape[:-axes], *results.shape[1:])
