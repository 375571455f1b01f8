"""OpenCV's registration by intensities, on grey images and with its default settings.

G. Evangelidis, E. Psarakis, Parametric Image Alignment using Enhanced Correlation Coefficient Maximization,
PAMI 30(10), 2008.
"""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np


def ecc(src: np.ndarray, dst: np.ndarray) -> np.ndarray:
    """By findTransformECC: the homography (3, 3) from dst's pixels to src's; NaN if it fails."""
    return _ecc(lambda a, b, start: cv2.findTransformECC(a, b, start, cv2.MOTION_HOMOGRAPHY)[1], src, dst)


def ecc_multi_scale(src: np.ndarray, dst: np.ndarray) -> np.ndarray:
    """By findTransformECCMultiScale, with its own pyramid; result as for `ecc`."""
    parameters = cv2.ECCParameters()
    parameters.motionType = cv2.MOTION_HOMOGRAPHY
    return _ecc(lambda a, b, start: cv2.findTransformECCMultiScale(a, b, start, parameters)[1], src, dst)


def _ecc(find: Callable[..., np.ndarray], src: np.ndarray, dst: np.ndarray) -> np.ndarray:
    try:
        grey = [cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY) for frame in (dst, src)]
        return find(*grey, np.eye(3, dtype=np.float32)).astype(np.float64)
    except cv2.error:  # "Iterations do not converge"
        return np.full((3, 3), np.nan)
