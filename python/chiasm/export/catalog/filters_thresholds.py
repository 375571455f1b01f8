"""Filters: thresholds."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import torch
from torch import Generator, Tensor

from ..peer import Peer, opencv
from ..spec import PIXELS, Frames, Spec, TensorSpec, image
from . import STENCIL, add, rejected
from .filters import SAME

add(
    Spec(
        "filters.in_range",
        [
            image(),
            TensorSpec("lower", ("C",), range=(0.0, 0.3), description="of each channel"),
            TensorSpec("upper", ("C",), range=(0.7, 1.0), description="of each channel"),
        ],
        SAME,
        symbols=STENCIL,
        gradients=("input",),
        peer=opencv(lambda cv2, x, low, high: cv2.copyTo(x, cv2.inRange(x, low, high)), sizes={"C": 3}),
        reference="OpenCV inRange",
        frames=Frames(
            PIXELS,
            ranges={"lower": (0.0, 80.0), "upper": (170.0, 255.0)},
            peer=opencv(
                lambda cv2, x, low, high: cv2.copyTo(x, cv2.inRange(x, low, high)),
                before=lambda x, low, high: (x, np.ceil(low), np.floor(high)),
                sizes={"C": 3},
            ),
        ),
    )
)


def _two_classes(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Dark and bright pixels, so that no rounding decides between two thresholds."""
    import torch

    shape = (sizes["B"], sizes["C"], sizes["H"], sizes["W"])
    noise = torch.rand(shape, generator=generator, dtype=torch.float64)
    bright = torch.rand(shape, generator=generator, dtype=torch.float64) < 0.4
    return {"x": (0.3 * noise + 0.6 * bright).to(dtype)}


def _separated(filters: Any, x: np.ndarray) -> tuple[Any, ...]:
    """The threshold is the middle of a bin, whose pixels are below it."""
    threshold = filters.threshold_otsu(x)
    return np.where(x >= threshold + (x.max() - x.min()) / 512, x, 0), threshold


for _suffix, _differentiable in (("", False), ("_differentiable", True)):
    add(
        Spec(
            f"filters.otsu_threshold{_suffix}",
            [image("x")],
            [TensorSpec("output", layout="NCHW"), TensorSpec("threshold", description="of each plane")],
            config={"slow_and_differentiable": _differentiable},
            symbols=STENCIL,
            make_inputs=_two_classes,
            peer=None if _differentiable else Peer("skimage.filters", _separated, "planes"),
            reference="scikit-image threshold_otsu, OpenCV THRESH_OTSU",
            frames=(
                None
                if _differentiable
                else Frames(
                    reference="OpenCV THRESH_OTSU",
                    peer=opencv(
                        lambda cv2, x: cv2.threshold(x, 0, 255, cv2.THRESH_TOZERO | cv2.THRESH_OTSU)[::-1],
                        "planes",
                    ),
                )
            ),
        ),
        fn="filters.otsu_threshold",
    )


def _levels(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    import torch

    shape = (sizes["B"], sizes["C"], sizes["H"], sizes["W"])
    return {"input": torch.randint(0, 256, shape, generator=generator).to(dtype)}


for _suffix, _method, _kind in (
    ("", "mean", "ADAPTIVE_THRESH_MEAN_C"),
    ("_gaussian", "gaussian", "ADAPTIVE_THRESH_GAUSSIAN_C"),
):
    _peer = opencv(
        lambda cv2, x, kind=_kind: cv2.adaptiveThreshold(x, 255, getattr(cv2, kind), cv2.THRESH_BINARY, 5, 2),
        "planes",
        before=lambda x: (x.astype(np.uint8),),
    )
    add(
        Spec(
            f"filters.adaptive_threshold{_suffix}",
            [image(range=(0.0, 255.0))],
            SAME,
            config={"max_value": 255.0, "adaptive_method": _method, "block_size": 5, "c": 2.0},
            symbols=STENCIL,
            gradients=(),
            make_inputs=_levels,
            peer=_peer,
            reference="OpenCV adaptiveThreshold",
            frames=Frames(
                # Gaussian means halfway between two levels are rounded up here, and to even ones by OpenCV.
                peer=replace(_peer, before=None) if _method == "mean" else None,
                errors=rejected("max_value", "a whole number, 0 to 255, for bytes", math.nan),
            ),
        ),
        fn="filters.adaptive_threshold",
    )
