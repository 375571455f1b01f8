"""The one list of cases: a bundle, OpenCV's call on the same frame, the other inputs, and how far the results
may be apart."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from ..opencv import CROSS, REFLECT, SQUARE, Into, gaussian, plain

#: (batch, height, width), of three channels
SIZES = ((8, 256, 256), (1, 1080, 1920))


def _levels_apart(ours: np.ndarray, theirs: np.ndarray) -> np.ndarray:
    return np.abs(ours.astype(int) - theirs)


@dataclass(frozen=True)
class Case:
    bundle: str
    #: the peer's work on one frame, as in bench/opencv.py
    peer: Callable[..., np.ndarray]
    what: str = ""
    #: the inputs that are no frames, by name, for a size; a number is that of each image
    others: Callable[[int, int, int], dict[str, float | np.ndarray]] = lambda b, h, w: {}
    #: levels that the results may differ by
    allowed: int = 0
    #: pixels along the border that are not compared
    edge: int = 0
    #: how many levels (B, H, W, C) of ours and theirs are apart
    apart: Callable[[np.ndarray, np.ndarray], np.ndarray] = _levels_apart

    @property
    def name(self) -> str:
        return f"{self.bundle} {self.what}".strip()


def _numbers(**values: float) -> Callable[[int, int, int], dict[str, float | np.ndarray]]:
    return lambda b, h, w: dict(values)


# --- colours ------------------------------------------------------------------------------------------------


def _ycrcb_apart(ours: np.ndarray, theirs: np.ndarray) -> np.ndarray:
    """OpenCV has the red difference first."""
    return _levels_apart(ours, theirs[..., [0, 2, 1]])


def _hsv_apart(ours: np.ndarray, theirs: np.ndarray) -> np.ndarray:
    """Hues are a circle of 180."""
    apart = _levels_apart(ours, theirs)
    apart[..., 0] = np.minimum(apart[..., 0], 180 - apart[..., 0])
    return apart


# --- tables -------------------------------------------------------------------------------------------------

_LEVELS = np.arange(256.0)


def _table(values: np.ndarray) -> Callable[..., np.ndarray]:
    """OpenCV looks up a table, which is made here, outside of the call."""
    return plain(cv2.LUT, np.rint(np.clip(values, 0, 255)).astype(np.uint8))


def _threshold(kind: int) -> Callable[..., np.ndarray]:
    return plain(cv2.threshold, 99.0, 201.0, kind)


_LIMIT, _LIMITS = _numbers(thresh=99.0), _numbers(thresh=99.0, maxval=201.0)
_BRIGHTENED = np.clip(_LEVELS + 20, 0, 255)
_SOLARIZED = np.where(_BRIGHTENED < 128, _BRIGHTENED, 255 - _BRIGHTENED)

# --- neighbourhoods and sizes -------------------------------------------------------------------------------


def _cross(b: int, h: int, w: int) -> dict[str, float | np.ndarray]:
    return {"kernel": CROSS.astype(np.float32)}


def _morphology(kind: int) -> Callable[..., np.ndarray]:
    return plain(cv2.morphologyEx, kind, CROSS)


def _scaled(factor: float) -> Callable[[int, int, int], dict[str, float | np.ndarray]]:
    return lambda b, h, w: {"like": np.zeros((int(h * factor), int(w * factor)), np.uint8)}


def _to_360(b: int, h: int, w: int) -> dict[str, float | np.ndarray]:
    return {"like": np.zeros((360, 640), np.uint8)}


def _resize(way: int) -> Callable[..., np.ndarray]:
    def call(into: Into, m: np.ndarray, x: list[np.ndarray], other: np.ndarray) -> np.ndarray:
        return into("out", cv2.resize, m, x[1].shape[::-1], interpolation=way)

    return call


def _read(function: Callable[..., np.ndarray]) -> Callable[..., np.ndarray]:
    """A warp to the size of the frame."""

    def call(into: Into, m: np.ndarray, x: list[np.ndarray], other: np.ndarray) -> np.ndarray:
        return into("out", function, m, x[1][0], m.shape[1::-1], flags=cv2.INTER_LINEAR)

    return call


def _matrix(rows: list[list[float]]) -> Callable[[int, int, int], dict[str, float | np.ndarray]]:
    return lambda b, h, w: {
        "M": np.broadcast_to(np.array(rows, np.float32), (b, len(rows), 3)).copy(),
        "like": np.zeros((h, w), np.uint8),
    }


def _waves(b: int, h: int, w: int) -> dict[str, float | np.ndarray]:
    y, x = np.mgrid[:h, :w].astype(np.float32)
    return {
        "map_x": np.broadcast_to(x + 4 * np.sin(y / 40), (b, h, w)).copy(),
        "map_y": np.broadcast_to(y + 4 * np.sin(x / 40), (b, h, w)).copy(),
    }


def _remap(into: Into, m: np.ndarray, x: list[np.ndarray], other: np.ndarray) -> np.ndarray:
    return into("out", cv2.remap, m, x[1][0], x[2][0], cv2.INTER_LINEAR)


def _taps(b: int, h: int, w: int) -> dict[str, float | np.ndarray]:
    return {"kernel": np.array([[0.1, 0.2, -0.3], [0.4, 0.2, 0.1], [-0.1, 0.3, 0.1]], np.float32)}


def _filter2d(into: Into, m: np.ndarray, x: list[np.ndarray], other: np.ndarray) -> np.ndarray:
    return into("out", cv2.filter2D, m, -1, x[1], borderType=REFLECT)


def _unsharp_mask(into: Into, m: np.ndarray, x: list[np.ndarray], other: np.ndarray) -> np.ndarray:
    blurred = into("blurred", cv2.GaussianBlur, m, (5, 5), 1.5, sigmaY=1.5, borderType=REFLECT)
    return into("out", cv2.addWeighted, m, 2.0, blurred, -1.0, 0.0)


_BILINEAR = "geometry.transform.resize.bilinear.frames"
_EXACT = _resize(cv2.INTER_LINEAR_EXACT)
CASES = (
    Case("color.rgb_to_grayscale.frames", plain(cv2.cvtColor, cv2.COLOR_RGB2GRAY)),
    Case("color.bgr_to_grayscale.frames", plain(cv2.cvtColor, cv2.COLOR_BGR2GRAY)),
    Case(
        "color.rgb_to_ycbcr.frames", plain(cv2.cvtColor, cv2.COLOR_RGB2YCrCb), allowed=1, apart=_ycrcb_apart
    ),
    Case("color.rgb_to_hsv.frames", plain(cv2.cvtColor, cv2.COLOR_RGB2HSV), allowed=1, apart=_hsv_apart),
    Case("enhance.invert.frames", plain(cv2.bitwise_not)),
    Case("enhance.threshold.binary.frames", _threshold(cv2.THRESH_BINARY), others=_LIMITS),
    Case("enhance.threshold.binary_inv.frames", _threshold(cv2.THRESH_BINARY_INV), others=_LIMITS),
    Case("enhance.threshold.trunc.frames", _threshold(cv2.THRESH_TRUNC), others=_LIMIT),
    Case("enhance.threshold.tozero.frames", _threshold(cv2.THRESH_TOZERO), others=_LIMIT),
    Case("enhance.threshold.tozero_inv.frames", _threshold(cv2.THRESH_TOZERO_INV), others=_LIMIT),
    Case(
        "enhance.adjust_gamma.frames",
        _table(255 * 1.1 * (_LEVELS / 255) ** 0.45),
        others=_numbers(gamma=0.45, gain=1.1),
        allowed=1,
    ),
    Case("enhance.adjust_brightness.frames", _table(_LEVELS + 30), others=_numbers(factor=30.0)),
    Case(
        "enhance.adjust_brightness_accumulative.frames", _table(_LEVELS * 1.25), others=_numbers(factor=1.25)
    ),
    Case("enhance.adjust_contrast.frames", _table(_LEVELS * 0.75), others=_numbers(factor=0.75)),
    Case("enhance.posterize.frames", _table(_LEVELS // 32 * 32), others=_numbers(bits=3)),
    Case("enhance.solarize.frames", _table(_SOLARIZED), others=_numbers(thresholds=128.0, additions=20.0)),
    Case(
        "filters.gaussian_blur2d.constant.frames",
        plain(cv2.GaussianBlur, (5, 5), 1.1, sigmaY=1.1, borderType=REFLECT),
    ),
    Case(
        "filters.gaussian_blur2d.frames",
        gaussian,
        others=lambda b, h, w: {"sigma": np.full((b, 2), 1.1, np.float32)},
    ),
    # OpenCV repeats the border's pixels, chiasm reflects.
    Case("filters.median_blur.frames", plain(cv2.medianBlur, 3), edge=1),
    Case("morphology.dilation.frames", plain(cv2.dilate, CROSS), others=_cross),
    Case("morphology.erosion.frames", plain(cv2.erode, CROSS), others=_cross),
    Case("morphology.opening.frames", _morphology(cv2.MORPH_OPEN), others=_cross),
    Case("morphology.closing.frames", _morphology(cv2.MORPH_CLOSE), others=_cross),
    Case("morphology.gradient.frames", _morphology(cv2.MORPH_GRADIENT), others=_cross),
    Case("morphology.top_hat.frames", _morphology(cv2.MORPH_TOPHAT), others=_cross),
    Case("morphology.bottom_hat.frames", _morphology(cv2.MORPH_BLACKHAT), others=_cross),
    Case("morphology.max_filter2d.frames", plain(cv2.dilate, SQUARE)),
    Case("morphology.min_filter2d.frames", plain(cv2.erode, SQUARE)),
    Case(_BILINEAR, _EXACT, "to 1/2", _scaled(0.5)),
    Case(_BILINEAR, _EXACT, "to 3/2", _scaled(1.5)),
    Case(_BILINEAR, _EXACT, "to 360x640", _to_360),
    Case("filters.filter2d.frames", _filter2d, "3x3", _taps, allowed=1),
    Case("filters.unsharp_mask.frames", _unsharp_mask),
    Case("geometry.transform.hflip.frames", plain(cv2.flip, 1)),
    Case("geometry.transform.vflip.frames", plain(cv2.flip, 0)),
    Case("geometry.transform.rot180.frames", plain(cv2.flip, -1)),
    Case("geometry.transform.pyrdown.by_2.frames", plain(cv2.pyrDown)),
    Case("geometry.transform.pyrup.frames", plain(cv2.pyrUp)),
    # OpenCV 5 does not round positions to 1/32 pixel: noise is up to 255 / 32 levels apart.
    Case(
        "geometry.transform.warp_affine.bilinear_zeros.frames",
        _read(cv2.warpAffine),
        "11 degrees",
        _matrix([[0.98, 0.19, -9.0], [-0.19, 0.98, 21.0]]),
        allowed=9,
    ),
    Case(
        "geometry.transform.warp_perspective.bilinear_zeros.frames",
        _read(cv2.warpPerspective),
        "",
        _matrix([[0.98, 0.05, 3.0], [-0.04, 1.02, 2.0], [1e-5, 2e-5, 1.0]]),
        allowed=9,
    ),
    Case("geometry.transform.remap.bilinear_zeros.frames", _remap, "waves", _waves, allowed=9),
    Case("geometry.transform.resize.nearest.frames", _resize(cv2.INTER_NEAREST), "to 1/2", _scaled(0.5)),
)
