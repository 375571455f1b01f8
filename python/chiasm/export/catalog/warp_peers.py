"""Peers of geometric transforms: OpenCV's warps of images, SciPy's of volumes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..peer import BORDERS, NEAR_BYTES, WAYS, Call, Peer, opencv, warped

#: How far warps may be apart: as `warped`.
_NEAR: dict[str, Any] = {"atol": 1e-3, "share": 1e-3}
_NEAR_OF_BYTES: dict[str, Any] = {"atol": NEAR_BYTES, "share": 2e-3}
#: As in `warped`.
_LARGE: dict[str, Any] = {"sizes": {"C": 3, "H": 80, "W": 80}}


def of_matrix(name: str, mode: str, padding: str, of_bytes: bool = False) -> Peer:
    """OpenCV's warp of the name of chiasm's."""
    if name != "remap":
        return warped("warpAffine" if name == "warp_affine" else "warpPerspective", mode, padding, of_bytes)
    return opencv(
        lambda cv2, x, columns, rows: cv2.remap(
            x, columns, rows, getattr(cv2, WAYS[mode]), borderMode=getattr(cv2, BORDERS[padding])
        ),
        sizes={"C": 3},
        **(_NEAR_OF_BYTES if of_bytes else _NEAR),
    )


def in_place(
    matrix: Callable[..., np.ndarray], mode: str = "bilinear", padding: str = "zeros", of_bytes: bool = False
) -> Peer:
    """OpenCV's warpAffine to the image's own size, by the matrix (2, 3) that `matrix` makes of an image's
    width and height and of the op's other arguments."""

    def call(cv2: Any, x: np.ndarray, m: np.ndarray) -> np.ndarray:
        options = {"flags": getattr(cv2, WAYS[mode]), "borderMode": getattr(cv2, BORDERS[padding])}
        return cv2.warpAffine(x, m, x.shape[1::-1], **options)

    def before(x: np.ndarray, *rest: Any) -> tuple[Any, ...]:
        return x, matrix(*x.shape[1::-1], *rest)

    return opencv(
        call,
        before=before,
        **(_NEAR_OF_BYTES if of_bytes else _NEAR),
        **_LARGE,
    )


def rotation(width: int, height: int, angle: float) -> np.ndarray:
    """About the image's centre, by degrees, counterclockwise."""
    c, s = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
    turn, centre = np.array([[c, s], [-s, c]]), np.array([width - 1, height - 1]) / 2
    return np.column_stack([turn, centre - turn @ centre])


def scaling(width: int, height: int, factors: np.ndarray, centre: np.ndarray) -> np.ndarray:
    return np.column_stack([np.eye(2) * factors, (1 - factors) * centre])


def given(width: int, height: int, matrix: np.ndarray) -> np.ndarray:
    """The matrix that the op gets."""
    return matrix


def translation(width: int, height: int, shift: np.ndarray) -> np.ndarray:
    return np.column_stack([np.eye(2), shift])


def _filled(cv2: Any, x: np.ndarray, m: np.ndarray, size: tuple[int, int], fill: np.ndarray) -> np.ndarray:
    return cv2.warpAffine(x, m, size, borderValue=fill.tolist())


def filled(of_bytes: bool = False) -> Peer:
    """OpenCV's warpAffine with a colour outside of the image."""
    return opencv(
        _filled,
        before=lambda x, m, like, fill: (x, m, like.shape[::-1], fill),
        **(_NEAR_OF_BYTES if of_bytes else _NEAR),
        **_LARGE,
    )


def between_boxes(before: Call, of_bytes: bool = False) -> Peer:
    """OpenCV's warpPerspective by getPerspectiveTransform; `before` makes an image, four points of it, where
    they go, and a size."""

    def call(cv2: Any, x: np.ndarray, source: np.ndarray, target: np.ndarray, size: tuple[int, int]) -> Any:
        return cv2.warpPerspective(x, cv2.getPerspectiveTransform(source, target), size)

    return opencv(call, before=before, **(_NEAR_OF_BYTES if of_bytes else _NEAR), **_LARGE)


def corners(width: int, height: int) -> np.ndarray:
    """The corner pixels of an image."""
    right, lower = width - 1, height - 1
    return np.array([[0, 0], [right, 0], [right, lower], [0, lower]], np.float32)


def _to_pixels(width: int, height: int) -> np.ndarray:
    """From coordinates in [-1, 1], which are the outer edges."""
    return np.array([[width / 2, 0, (width - 1) / 2], [0, height / 2, (height - 1) / 2], [0, 0, 1]])


def _normalized(x: np.ndarray, m: np.ndarray, like: np.ndarray) -> tuple[Any, ...]:
    size = like.shape[::-1]
    return x, _to_pixels(*size) @ np.linalg.inv(_to_pixels(*x.shape[1::-1]) @ m), size


#: OpenCV's warpPerspective by a homography from the output to the image, in coordinates in [-1, 1].
NORMALIZED = opencv(
    lambda cv2, x, m, size: cv2.warpPerspective(x, m, size), before=_normalized, **_NEAR, **_LARGE
)


def polar(flag: str, of_bytes: bool = False) -> Peer:
    """OpenCV's warpPolar."""

    def call(cv2: Any, x: np.ndarray, centre: np.ndarray, radius: float, size: tuple[int, int]) -> np.ndarray:
        flags = cv2.INTER_LINEAR | cv2.WARP_FILL_OUTLIERS | getattr(cv2, flag)
        return cv2.warpPolar(x, size, centre, radius, flags)

    return opencv(
        call,
        before=lambda x, centre, radius, like: (x, centre.tolist(), radius, like.shape[::-1]),
        **(_NEAR_OF_BYTES if of_bytes else _NEAR),
        **_LARGE,
    )


#: SciPy's names of border modes, of volumes whose corner voxels are its corners.
_SCIPYS = {"border": "nearest", "reflection": "mirror"}


def of_volumes(mode: str, padding: str) -> Peer:
    """SciPy's affine_transform, by the inverse of a matrix (3, 4), to the size of a tensor."""

    def call(ndimage: Any, x: np.ndarray, m: np.ndarray, shift: np.ndarray, shape: tuple[int, ...]) -> Any:
        options = {"order": 1 if mode == "bilinear" else 0, "mode": _SCIPYS[padding]}
        return np.stack([ndimage.affine_transform(c, m, shift, shape, **options) for c in x])

    def before(x: np.ndarray, m: np.ndarray, like: np.ndarray) -> tuple[Any, ...]:
        back = np.linalg.inv(m[:, :3].astype(np.float64))
        shift = -back @ m[:, 3]
        return x, back[::-1, ::-1], shift[::-1], like.shape

    return Peer("scipy.ndimage", call, "samples", atol=1e-3, share=1e-3, before=before)
