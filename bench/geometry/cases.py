"""The list of cases: a bundle, its sizes and its inputs. OpenCV's calls have the bundles' names in
bench/opencv_peers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

IMAGES = ((8, 256, 256), (1, 1080, 1920))
#: The aims, in times as fast as OpenCV: for images, and for thousands of small matrices.
IMAGE_AIM, MATRIX_AIM = 0.8, 2.0


@dataclass(frozen=True)
class Case:
    bundle: str
    what: str
    #: (batch, height, width)
    sizes: tuple[tuple[int, int, int], ...]
    #: for a size: the inputs other than images, and the values of symbols
    values: Callable[[int, int, int], dict]
    aim: float = IMAGE_AIM


def _scaled(factor: float) -> Callable[[int, int, int], dict]:
    return lambda b, h, w: {"OH": int(h * factor), "OW": int(w * factor)}


def _matrix(rows: list[list[float]]) -> Callable[[int, int, int], dict]:
    """The same matrix for each image, and an output of the image's size."""
    return lambda b, h, w: {"M": np.tile(rows, (b, 1, 1)).ravel().tolist(), "OH": h, "OW": w}


def _camera(b: int, h: int, w: int) -> dict:
    matrix = [0.9 * w, 0.0, 0.5 * w, 0.0, 0.9 * w, 0.5 * h, 0.0, 0.0, 1.0]
    return {"K": matrix * b, "dist": [-0.25, 0.08, 1e-3, -5e-4, 0.01] * b}


def _correspondences(count: int) -> Callable[[int, int, int], dict]:
    """Points, and the same points mapped by a homography, with noise of about a tenth of a pixel."""

    def values(b: int, h: int, w: int) -> dict:
        random = np.random.default_rng(1)
        points = random.uniform(0, 500, (b, count, 2))
        mapped = np.concatenate([points, np.ones((b, count, 1))], -1) @ np.transpose(
            [[1.1, 0.1, 9.0], [-0.1, 0.9, 5.0], [1e-4, 2e-4, 1.0]]
        )
        moved = mapped[..., :2] / mapped[..., 2:] + random.normal(0, 0.1, points.shape)
        return {
            "N": count,
            "points1": points.round(2).ravel().tolist(),
            "points2": moved.round(2).ravel().tolist(),
        }

    return values


_SAMPLES = 1000
_POINTS = 2000


def _mostly_wrong(b: int, x1: np.ndarray, x2: np.ndarray, random: np.random.Generator) -> dict:
    """Three of five points of the second image are random. With fewer, OpenCV stops before it has drawn all
    samples."""
    moved = x2 + random.normal(0, 0.5, x2.shape)
    wrong = random.random(len(x2)) < 0.6
    moved[wrong] = random.uniform(0, 500, (wrong.sum(), 2))
    return {
        "S": _SAMPLES,
        "N": len(x1),
        "points1": x1.round(2).ravel().tolist() * b,
        "points2": moved.round(2).ravel().tolist() * b,
    }


def _of_a_plane(b: int, h: int, w: int) -> dict:
    random = np.random.default_rng(4)
    points = random.uniform(0, 500, (_POINTS, 2))
    mapped = np.c_[points, np.ones(_POINTS)] @ np.transpose(
        [[1.1, 0.1, 9.0], [-0.1, 0.9, 5.0], [1e-4, 2e-4, 1.0]]
    )
    return _mostly_wrong(b, points, mapped[:, :2] / mapped[:, 2:], random)


def _of_two_views(b: int, h: int, w: int) -> dict:
    random = np.random.default_rng(5)
    seen = random.uniform([-2, -2, 4], [2, 2, 9], (_POINTS, 3))
    c, s = np.cos(0.1), np.sin(0.1)
    matrix = np.array([[450.0, 0.0, 250.0], [0.0, 450.0, 250.0], [0.0, 0.0, 1.0]])
    views = [
        points @ matrix.T
        for points in (seen, seen @ np.transpose([[c, 0, s], [0, 1, 0], [-s, 0, c]]) + [-1.0, 0.1, 0.2])
    ]
    x1, x2 = (view[:, :2] / view[:, 2:] for view in views)
    return _mostly_wrong(b, x1, x2, random) | {
        "B": b,
        "P": b,
        "K1": matrix.ravel().tolist() * b,
        "K2": matrix.ravel().tolist() * b,
    }


def _quadrilaterals(b: int, h: int, w: int) -> dict:
    corners = np.array([[0, 0], [100, 0], [100, 80], [0, 80]]) + np.random.default_rng(2).uniform(
        -9, 9, (2, b, 4, 2)
    )
    return {
        "points_src": corners[0].round(2).ravel().tolist(),
        "points_dst": corners[1].round(2).ravel().tolist(),
    }


def _essentials(b: int, h: int, w: int) -> dict:
    random = np.random.default_rng(3)
    rotations = np.linalg.qr(random.normal(size=(b, 3, 3)))[0]
    t = random.normal(size=(b, 3))
    skew = np.zeros((b, 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        skew[:, i, j], skew[:, j, i] = -t[:, k], t[:, k]
    return {"E_mat": (skew @ (rotations * np.linalg.det(rotations)[:, None, None])).round(5).ravel().tolist()}


_RESIZE = "geometry.transform.resize"
_ONE, _MANY = ((1, 1, 1),), ((1, 1, 1), (64, 1, 1))
_ROBUST = f"{_POINTS} points, {_SAMPLES} samples"
CASES = (
    Case(f"{_RESIZE}.bilinear", "to 1/2", IMAGES, _scaled(0.5)),
    Case(f"{_RESIZE}.bilinear", "to 3/4", IMAGES, _scaled(0.75)),
    Case(f"{_RESIZE}.bilinear", "to 3/2", IMAGES, _scaled(1.5)),
    Case(f"{_RESIZE}.bicubic", "to 3/4", IMAGES, _scaled(0.75)),
    Case(f"{_RESIZE}.bicubic", "to 3/2", IMAGES, _scaled(1.5)),
    Case(f"{_RESIZE}.nearest", "to 3/4", IMAGES, _scaled(0.75)),
    Case(
        "geometry.transform.warp_affine.bilinear_zeros",
        "11 degrees",
        IMAGES,
        _matrix([[0.98, 0.19, -9.0], [-0.19, 0.98, 21.0]]),
    ),
    Case(
        "geometry.transform.warp_perspective.bilinear_zeros",
        "",
        IMAGES,
        _matrix([[0.98, 0.05, 3.0], [-0.04, 1.02, 2.0], [1e-5, 2e-5, 1.0]]),
    ),
    Case(
        "geometry.transform.warp_perspective.nearest_zeros",
        "",
        IMAGES,
        _matrix([[0.98, 0.05, 3.0], [-0.04, 1.02, 2.0], [1e-5, 2e-5, 1.0]]),
    ),
    Case("geometry.transform.remap.bilinear_zeros", "waves", IMAGES, lambda b, h, w: {"OH": h, "OW": w}),
    Case("geometry.calibration.undistort_image", "5 coefficients", IMAGES, _camera),
    Case("geometry.transform.pyrdown.by_2", "", IMAGES, lambda b, h, w: {}),
    Case("geometry.ransac.ransac_homography", _ROBUST, _ONE, _of_a_plane, MATRIX_AIM),
    Case("geometry.ransac.ransac_fundamental", _ROBUST, _ONE, _of_two_views, MATRIX_AIM),
    Case("geometry.ransac.ransac_essential", _ROBUST, _ONE, _of_two_views, MATRIX_AIM),
    Case("geometry.homography.find_homography_dlt", "30 points", _MANY, _correspondences(30), MATRIX_AIM),
    Case(
        "geometry.transform.get_perspective_transform",
        "",
        ((1, 1, 1), (1000, 1, 1)),
        _quadrilaterals,
        MATRIX_AIM,
    ),
    Case(
        "geometry.epipolar.decompose_essential_matrix", "", ((1, 1, 1), (1000, 1, 1)), _essentials, MATRIX_AIM
    ),
)
