"""The list of ops: the values with which each is measured, Kornia's op for the same work, and how much the
peers may differ.

OpenCV's calls have the same names in bench/opencv_peers (C++) and bench/opencv.py.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Agreement:
    """The allowed difference of a peer's values from chiasm's."""

    tolerance: float = 1e-5
    #: the share of the values that must be within the tolerance
    share: float = 1.0
    #: whether the tolerance is relative to the greatest value
    relative: bool = False
    #: the number of pixels at the border that are not compared
    edge: int = 0
    #: the differences in their definitions
    note: str = ""


@dataclass(frozen=True)
class Op:
    bundle: str
    #: `kornia(k, values, *images)` with the module `k`; None if Kornia has no such op
    kornia: Callable | None
    #: the inputs other than images: a number, or all numbers of the tensor
    values: Mapping[str, float | list[float]] = field(default_factory=dict)
    opencv_agrees: Agreement = Agreement()
    kornia_agrees: Agreement = Agreement()
    #: converts OpenCV's result (B, C, H, W) to chiasm's conventions
    aligned: Callable[[np.ndarray], np.ndarray] = lambda x: x
    #: the index of the output that OpenCV computes too
    output: int = 0
    opencv_type: str = "float32"
    #: the bundle in which `values` are constants, as in Kornia's files; this may change the form in ONNX
    constant: str = ""


def _hsv(x: np.ndarray) -> np.ndarray:
    return x * np.array([math.pi / 180, 1, 1], np.float32)[:, None, None]


_NORMAL = {"mean": [0.485, 0.456, 0.406], "std": [0.229, 0.224, 0.225]}
_WEIGHTS = {"alpha": 0.6, "beta": 0.3, "gamma": 0.1}
_SHARPEN = [0.0, -1.0, 0.1, -1.0, 5.0, -1.0, 0.2, -1.0, -0.3]
_CROSS = {"kernel": [0.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0, 1.0, 0.0]}

OPS = (
    Op("color.rgb_to_grayscale", lambda k, v, x: k.color.rgb_to_grayscale(x)),
    Op(
        "color.rgb_to_hsv",
        lambda k, v, x: k.color.rgb_to_hsv(x),
        aligned=_hsv,
        opencv_agrees=Agreement(1e-4, note="hue in degrees"),
        kornia_agrees=Agreement(1e-4, 0.999),
    ),
    Op(
        "color.rgb_to_lab",
        lambda k, v, x: k.color.rgb_to_lab(x),
        opencv_agrees=Agreement(0.5, note="interpolates in a table of colours; L is 0 to 100"),
        kornia_agrees=Agreement(0.05),
    ),
    Op(
        "color.rgb_to_ycbcr",
        lambda k, v, x: k.color.rgb_to_ycbcr(x),
        aligned=lambda x: x[:, [0, 2, 1]],
        opencv_agrees=Agreement(1e-5, note="channels in the order Y, Cr, Cb"),
    ),
    Op(
        "color.rgb_to_yuv",
        lambda k, v, x: k.color.rgb_to_yuv(x),
        aligned=lambda x: x - np.array([0, 0.5, 0.5], np.float32)[:, None, None],
        opencv_agrees=Agreement(2e-3, note="U and V around 0.5; constants with three digits"),
        kornia_agrees=Agreement(2e-3, note="constants with three digits"),
    ),
    Op("filters.box_blur", lambda k, v, x: k.filters.box_blur(x, (5, 5))),
    Op(
        "filters.gaussian_blur2d",
        lambda k, v, x: k.filters.gaussian_blur2d(x, (5, 5), (v["sigma"], v["sigma"])),
        {"sigma": 1.1},
        constant="filters.gaussian_blur2d.constant",
    ),
    Op(
        "filters.median_blur",
        lambda k, v, x: k.filters.median_blur(x, (3, 3)),
        opencv_agrees=Agreement(0, edge=1, note="replicates the border, chiasm mirrors it"),
        kornia_agrees=Agreement(0),
    ),
    Op(
        "filters.bilateral_blur",
        lambda k, v, x: k.filters.bilateral_blur(x, (5, 5), 0.1, (1.5, 1.5)),
        opencv_agrees=Agreement(
            0.03, 0.99, note="sums the disc of 13 pixels, chiasm the square of 25; exp from a table"
        ),
    ),
    Op(
        "filters.sobel",
        lambda k, v, x: k.filters.sobel(x),
        opencv_agrees=Agreement(2e-3, note="chiasm adds 1e-6 to the squared magnitude"),
    ),
    Op("filters.laplacian", lambda k, v, x: k.filters.laplacian(x, 3)),
    Op(
        "filters.canny",
        lambda k, v, x: k.filters.canny(x, 0.5, 0.9, (5, 5), (1.0, 1.0)),
        output=1,
        opencv_type="uint8 inside",
        opencv_agrees=Agreement(
            0,
            0.99,
            note=("grey, blur and gradients in integers, so single pixels differ; no magnitude"),
        ),
        kornia_agrees=Agreement(0, 0.999),
    ),
    Op("filters.unsharp_mask", lambda k, v, x: k.filters.unsharp_mask(x, (5, 5), (1.5, 1.5))),
    Op(
        "filters.filter2d",
        lambda k, v, x: k.filters.filter2d(x, v["kernel"].reshape(1, 3, 3)),
        {"kernel": _SHARPEN},
    ),
    Op("filters.adaptive_threshold", None, opencv_type="uint8 inside", opencv_agrees=Agreement(0)),
    Op(
        "filters.otsu_threshold",
        lambda k, v, x: k.filters.otsu_threshold(x),
        opencv_type="uint8 inside",
        opencv_agrees=Agreement(
            1e-6, 0.99, note="256 levels; chiasm has 256 bins from the smallest to the greatest value"
        ),
        kornia_agrees=Agreement(1e-6, 0.999),
    ),
    Op("enhance.normalize", lambda k, v, x: k.enhance.normalize(x, v["mean"], v["std"]), _NORMAL),
    Op(
        "enhance.add_weighted",
        lambda k, v, x, y: k.enhance.add_weighted(x, v["alpha"], y, v["beta"], v["gamma"]),
        _WEIGHTS,
    ),
    Op(
        "enhance.adjust_gamma",
        lambda k, v, x: k.enhance.adjust_gamma(x, v["gamma"], v["gain"]),
        {"gamma": 0.45, "gain": 1.0},
        opencv_agrees=Agreement(1e-5, note="only the power: the gain is 1, and no value exceeds the limits"),
    ),
    Op(
        "enhance.threshold.binary",
        lambda k, v, x: k.enhance.threshold(x, v["thresh"], v["maxval"]),
        {"thresh": 0.5, "maxval": 1.0},
        opencv_agrees=Agreement(0),
        kornia_agrees=Agreement(0),
    ),
    Op(
        "enhance.equalize",
        lambda k, v, x: k.enhance.equalize(x),
        opencv_type="uint8 inside",
        opencv_agrees=Agreement(
            0.05, 0.85, note="omits the darkest level from the curve; chiasm, like Pillow, the brightest"
        ),
        kornia_agrees=Agreement(1e-6, 0.999),
    ),
    Op(
        "enhance.clahe",
        lambda k, v, x: k.enhance.equalize_clahe(x, 4.0, (3, 4)),
        opencv_type="uint8",
        opencv_agrees=Agreement(0, note="bytes in and out, like chiasm"),
        kornia_agrees=Agreement(8, 0.9, note="float32 in and out; other borders and rounding"),
    ),
    Op(
        "enhance.integral_image",
        lambda k, v, x: k.enhance.integral_image(x),
        aligned=lambda x: x[..., 1:, 1:],
        opencv_agrees=Agreement(1e-5, relative=True, note="has an extra row and column of zeros"),
        kornia_agrees=Agreement(1e-5, relative=True),
    ),
    Op(
        "morphology.dilation",
        lambda k, v, x: k.morphology.dilation(x, v["kernel"].reshape(3, 3)),
        _CROSS,
        opencv_agrees=Agreement(0),
    ),
    Op(
        "morphology.gradient",
        lambda k, v, x: k.morphology.gradient(x, v["kernel"].reshape(3, 3)),
        _CROSS,
        opencv_agrees=Agreement(1e-6),
    ),
    Op(
        "morphology.max_filter2d",
        lambda k, v, x: k.morphology.dilation(x, x.new_ones(5, 5)),
        opencv_agrees=Agreement(0),
    ),
)
