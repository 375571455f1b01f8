"""Metrics."""

import math
from collections.abc import Callable
from typing import Any

from ..peer import Peer
from ..spec import Spec, TensorSpec, Tolerance, image
from . import add, rejected

PSNR = Peer(
    "skimage.metrics",
    lambda metrics, x, y: metrics.peak_signal_noise_ratio(x, y, data_range=1.0),
    "batch",
)


def mean(each: Any) -> Any:
    """What an op gives that reduces what its peer gives by the mean."""
    return each.mean()


def similarity(after: Callable[[Any], Any]) -> Peer:
    """torchmetrics' SSIM of each pixel, and what `after` makes of it."""

    def call(functional: Any, x: Any, y: Any) -> Any:
        return functional.structural_similarity_index_measure(
            x, y, data_range=1.0, reduction="none", return_full_image=True
        )[1]

    return Peer("torchmetrics.functional", call, "tensors", after=after)


add(
    Spec(
        "metrics.psnr",
        [image("image"), image("target")],
        [TensorSpec("psnr", description="decibels")],
        config={"max_val": 1.0},
        peer=PSNR,
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
        peer=similarity(lambda found: found),
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
