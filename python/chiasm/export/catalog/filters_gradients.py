"""Filters: derivatives and edges."""

import math
from typing import Any

import numpy as np

from ..peer import Call, Peer, opencv
from ..spec import ErrorInput, Frames, Spec, TensorSpec, image
from . import STENCIL, add, rejected, rejected_words
from .filters import DEEP, SAME, VOLUME
from .filters_kernels import NOT_SIGMAS

_ZERO_TAPS = (
    "ONNX Runtime multiplies by the taps that are 0, which eager code leaves out: NaN of what is not finite"
)

# --- derivatives --------------------------------------------------------------------------------------------


def _gradient_magnitude(cv2: Any, x: Any):
    dx, dy = (
        cv2.Sobel(x, cv2.CV_32F, d, 1 - d, ksize=3, scale=1 / 8, borderType=cv2.BORDER_REPLICATE)
        for d in (1, 0)
    )
    return cv2.magnitude(dx, dy)


def _rounded_magnitude(cv2: Any, x: Any):
    return cv2.convertScaleAbs(_gradient_magnitude(cv2, x))


add(
    Spec(
        "filters.sobel",
        [image()],
        [TensorSpec("output", layout="NCHW", description="gradient magnitude")],
        config={"normalized": True, "eps": 1e-6},
        symbols=STENCIL,
        dtypes=("float32", "float64"),
        special_values=_ZERO_TAPS,
        peer=opencv(_gradient_magnitude, "planes", atol=2e-3),
        reference="OpenCV Sobel(BORDER_REPLICATE)",
        frames=Frames(peer=opencv(_rounded_magnitude, "planes", atol=1)),
    )
)


def _derivatives(operator: str, scale: float, depth: str = "CV_32F") -> Peer:
    def call(cv2: Any, x: Any):
        options = {"scale": scale, "borderType": cv2.BORDER_REPLICATE}
        return [getattr(cv2, operator)(x, getattr(cv2, depth), d, 1 - d, **options) for d in (1, 0)]

    return opencv(call, "planes")


for _name, _operator, _scale, _also in (
    (
        "spatial_gradient",
        "Sobel",
        1 / 8,
        ({"mode": "diff", "normalized": False}, {"order": 2}, {"mode": "diff", "order": 2}),
    ),
    ("spatial_gradient_scharr", "Scharr", 1 / 32, ({"mode": "prewitt"},)),
):
    add(
        Spec(
            f"filters.{_name}",
            [image()],
            [TensorSpec("output", description="d/dx and d/dy")],
            config={"mode": _operator.lower(), "order": 1, "normalized": True},
            symbols=STENCIL,
            special_values=_ZERO_TAPS,
            peer=_derivatives(_operator, _scale),
            also=_also,
            reference=f"OpenCV {_operator}(BORDER_REPLICATE)",
            frames=Frames(config={"normalized": False}, peer=_derivatives(_operator, 1, "CV_16S")),
            picture="derivatives",
            errors=(*rejected_words("mode"), *rejected("order", "1 or 2", 3)),
        ),
        fn="filters.spatial_gradient",
    )


def _differences(ndimage: Any, x: np.ndarray) -> np.ndarray:
    axes = (4, 3, 2)
    return np.stack([ndimage.correlate1d(x, [-0.5, 0, 0.5], axis, mode="nearest") for axis in axes], 2)


add(
    Spec(
        "filters.spatial_gradient3d",
        [VOLUME],
        [TensorSpec("output", description="d/dx, d/dy and d/dz")],
        config={"mode": "diff", "order": 1},
        symbols=DEEP,
        peer=Peer("scipy.ndimage", _differences, "batch"),
        reference="NumPy gradient, SciPy ndimage.correlate",
        picture="derivatives",
    )
)

_EIGHT_NEIGHBOURS = np.array([[1, 1, 1], [1, -8, 1], [1, 1, 1]], np.float32)


def _laplacian(scale: float, depth: str = "CV_32F") -> Call:
    return lambda cv2, x: cv2.filter2D(
        x, getattr(cv2, depth), _EIGHT_NEIGHBOURS * scale, borderType=cv2.BORDER_REFLECT_101
    )


add(
    Spec(
        "filters.laplacian",
        [image()],
        SAME,
        config={"kernel_size": (3, 3)},
        symbols=STENCIL,
        peer=opencv(_laplacian(1 / 16)),
        reference="OpenCV filter2D",
        frames=Frames(config={"normalized": False}, peer=opencv(_laplacian(1, "CV_16S"))),
    )
)

# --- edges --------------------------------------------------------------------------------------------------


def _scikit(operator: str, scale: float, of_bytes: bool = False) -> Peer:
    return Peer(
        "skimage.filters",
        lambda filters, x: getattr(filters, operator)(x),
        "planes",
        edge=1,
        atol=0 if of_bytes else 2e-3,
        before=(lambda x: (x.astype(np.float64),)) if of_bytes else None,
        after=lambda magnitude: (magnitude * scale).round(6).round() if of_bytes else magnitude * scale,
    )


for _name, _reference, _scale in (
    # scikit-image takes the mean of the squares of two derivatives, but not of the diagonal ones.
    ("scharr", "OpenCV Scharr, scikit-image scharr", math.sqrt(0.5)),
    ("prewitt", "scikit-image prewitt", math.sqrt(0.5)),
    ("roberts", "scikit-image roberts", 1.0),
):
    add(
        Spec(
            f"filters.{_name}",
            [image()],
            [TensorSpec("output", layout="NCHW", description="gradient magnitude")],
            symbols=STENCIL,
            peer=_scikit(_name, _scale),
            reference=_reference,
            frames=Frames(peer=_scikit(_name, _scale, True)),
        )
    )

add(
    Spec(
        "filters.canny",
        [image(channels=3, color="RGB")],
        [
            TensorSpec(
                "magnitude", layout="NCHW", description="gradient magnitude on the ridges, 0 elsewhere"
            ),
            TensorSpec("edges", layout="NCHW", description="1 on edges, 0 elsewhere"),
        ],
        config={
            "low_threshold": 0.5,
            "high_threshold": 0.9,
            "kernel_size": (5, 5),
            "sigma": (1.0, 1.0),
            "hysteresis": True,
        },
        symbols=STENCIL,
        reference="OpenCV Canny on the same gradients",
        frames=Frames(
            config={"low_threshold": 100.0, "high_threshold": 200.0},
            reference="OpenCV GaussianBlur and Canny",
        ),
        errors=(
            *NOT_SIGMAS,
            *(
                ErrorInput(t, math.nan, "low_threshold: expected 0 <= low_threshold <= high_threshold, got")
                for t in ("low_threshold", "high_threshold")
            ),
        ),
    )
)
