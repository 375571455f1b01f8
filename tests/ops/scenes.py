"""Scenes with known truth: cameras, points in front of them, lenses."""

import cv2
import numpy as np

#: k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4, taux, tauy of a strong lens on a tilted sensor.
LENS = np.array(
    [-0.21, 0.06, 1.5e-3, -2e-3, 0.011, 0.05, -0.02, 0.01, 2e-3, -1e-3, 1.5e-3, 1e-3, 0.03, -0.04]
)
SIZES = (4, 5, 8, 12, 14)


def camera_matrix(seed: int = 0) -> np.ndarray:
    fx, fy, cx, cy = np.array([510.0, 490.0, 321.0, 243.0]) + np.random.default_rng(seed).uniform(-20, 20, 4)
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])


def pose(seed: int = 0, angle: float = 0.3, shift: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """R (3, 3) and t (3, 1): a rotation by `angle` radians and a translation of length `shift`."""
    generator = np.random.default_rng(seed)
    axis, t = generator.normal(size=3), generator.normal(size=3)
    return cv2.Rodrigues(axis / np.linalg.norm(axis) * angle)[0], (t / np.linalg.norm(t) * shift)[:, None]


def points_in_front(count: int, seed: int = 0) -> np.ndarray:
    """(count, 3): points in front of a camera at the origin, and of others near it."""
    generator = np.random.default_rng(seed)
    return np.concatenate([generator.uniform(-2, 2, (count, 2)), generator.uniform(4, 8, (count, 1))], 1)


def project(K: np.ndarray, R: np.ndarray, t: np.ndarray, X: np.ndarray) -> np.ndarray:
    """Pixels (N, 2) of points (N, 3)."""
    x = (X @ R.T + t.T) @ K.T
    return x[:, :2] / x[:, 2:]
