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


_LOW, _HIGH = np.float32([20, 30, 40]), np.float32([200, 190, 180])


def _in_range(into: Into, m: np.ndarray, x: list[np.ndarray], other: np.ndarray) -> np.ndarray:
    inside = into("inside", cv2.inRange, m, _LOW, _HIGH)
    return into("out", cv2.copyTo, m, inside)


def _weighted(into: Into, m: np.ndarray, x: list[np.ndarray], other: np.ndarray) -> np.ndarray:
    return into("out", cv2.addWeighted, m, 0.3, m, 0.6, 5.0)


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


_BILINEAR = "geometry.transform.resize.bilinear.frames"
_EXACT = _resize(cv2.INTER_LINEAR_EXACT)
CASES = (
    Case("color.rgb_to_grayscale.frames", plain(cv2.cvtColor, cv2.COLOR_RGB2GRAY)),
    Case("color.bgr_to_grayscale.frames", plain(cv2.cvtColor, cv2.COLOR_BGR2GRAY)),
    Case("color.bgr_to_rgb.frames", plain(cv2.cvtColor, cv2.COLOR_BGR2RGB)),
    Case("color.rgb_to_rgba.frames", plain(cv2.cvtColor, cv2.COLOR_RGB2RGBA)),
    Case("color.bgr_to_rgba.frames", plain(cv2.cvtColor, cv2.COLOR_BGR2RGBA)),
    Case("color.rgb_to_ycbcr.frames", plain(cv2.cvtColor, cv2.COLOR_RGB2YCrCb), apart=_ycrcb_apart),
    Case("color.rgb_to_yuv.frames", plain(cv2.cvtColor, cv2.COLOR_RGB2YUV)),
    Case("color.yuv_to_rgb.frames", plain(cv2.cvtColor, cv2.COLOR_YUV2RGB)),
    Case("color.rgb_to_xyz.frames", plain(cv2.cvtColor, cv2.COLOR_RGB2XYZ)),
    Case("color.xyz_to_rgb.frames", plain(cv2.cvtColor, cv2.COLOR_XYZ2RGB)),
    Case("color.rgb_to_hsv.frames", plain(cv2.cvtColor, cv2.COLOR_RGB2HSV), allowed=1, apart=_hsv_apart),
    Case("color.hsv_to_rgb.frames", plain(cv2.cvtColor, cv2.COLOR_HSV2RGB), allowed=1),
    Case("color.rgb_to_hls.frames", plain(cv2.cvtColor, cv2.COLOR_RGB2HLS), allowed=1, apart=_hsv_apart),
    Case("color.hls_to_rgb.frames", plain(cv2.cvtColor, cv2.COLOR_HLS2RGB), allowed=1),
    # OpenCV's tables are coarser.
    Case("color.rgb_to_lab.frames", plain(cv2.cvtColor, cv2.COLOR_RGB2Lab), allowed=3),
    Case("color.lab_to_rgb.frames", plain(cv2.cvtColor, cv2.COLOR_Lab2RGB), allowed=4),
    Case(
        "enhance.add_weighted.frames", _weighted, others=_numbers(alpha=0.3, beta=0.6, gamma=5.0), allowed=1
    ),
    Case("filters.in_range.frames", _in_range, others=lambda b, h, w: {"lower": _LOW, "upper": _HIGH}),
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
    Case("geometry.transform.resize.nearest.frames", _resize(cv2.INTER_NEAREST), "to 1/2", _scaled(0.5)),
)
