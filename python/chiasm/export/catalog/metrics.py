"""Metrics."""

import math

from ..spec import Spec, TensorSpec, Tolerance, image
from . import add, rejected

add(
    Spec(
        "metrics.psnr",
        [image("image"), image("target")],
        [TensorSpec("psnr", description="decibels")],
        config={"max_val": 1.0},
        reference="scikit-image peak_signal_noise_ratio",
        picture="comparison",
        errors=rejected("max_val", "a positive number", math.nan),
    )
)

add(
    Spec(
        "metrics.ssim",
        [image("img1"), image("img2")],
        [TensorSpec("similarity", layout="NCHW")],
        config={"window_size": 11},
        symbols={"H": (12, 32768), "W": (12, 32768)},
        # In flat parts, variances are only rounding errors, 1e-7 of the values' squares, divided by 0.03^2.
        tolerances={"float32": Tolerance(2e-4, 1e-4)},
        reference="scikit-image structural_similarity (gaussian weights)",
        picture="comparison",
        errors=rejected("window_size", "a positive odd size", 4),
    )
)


def _volume(name: str):
    return TensorSpec(
        name, ("B", "C", "D", "H", "W"), layout="NCDHW", range=(0.0, 1.0), description="volumes"
    )


add(
    Spec(
        "metrics.ssim3d",
        [_volume("img1"), _volume("img2")],
        [TensorSpec("similarity", layout="NCDHW")],
        config={"window_size": 5},
        symbols={"D": (8, 4096), "H": (8, 32768), "W": (8, 32768)},
        reference="scikit-image structural_similarity (gaussian weights)",
        picture="comparison",
    )
)
