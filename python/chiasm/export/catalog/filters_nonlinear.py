"""Filters: ranks, and blurs that keep edges."""

import math

from ..peer import Peer, opencv
from ..spec import ErrorInput, Frames, Spec, TensorSpec, image
from . import STENCIL, add, rejected, rejected_sizes, rejected_words
from .filters_kernels import NOT_POSITIVE

# --- ranks --------------------------------------------------------------------------------------------------

add(
    Spec(
        "filters.median_blur",
        [image()],
        [TensorSpec("output", layout="NCHW")],
        config={"kernel_size": (3, 3), "border_type": "reflect"},
        symbols=STENCIL,
        without_nan=True,
        peer=opencv(lambda cv2, x: cv2.medianBlur(x, 3), "planes", edge=1),
        also=(
            {"kernel_size": (5, 5), "border_type": "replicate"},
            {"kernel_size": (3, 5), "border_type": "constant"},
        ),
        reference="SciPy median_filter(mode='mirror')",
        frames=Frames(
            ("uint8", "uint16"), peer=opencv(lambda cv2, x: cv2.medianBlur(x, 3), "planes", edge=1)
        ),
        errors=(*rejected_sizes("kernel_size"), *rejected("kernel_size", "odd positive sizes", (3, 2))),
    )
)

add(
    Spec(
        "filters.rank_filter",
        [image()],
        [TensorSpec("output", layout="NCHW")],
        config={"rank": 2, "kernel_size": (3, 3), "border_type": "reflect"},
        symbols=STENCIL,
        without_nan=True,
        peer=Peer("scipy.ndimage", lambda ndimage, x: ndimage.rank_filter(x, 2, 3, mode="mirror"), "planes"),
        reference="SciPy rank_filter(mode='mirror')",
    )
)

add(
    Spec(
        "filters.percentile_filter",
        [image()],
        [TensorSpec("output", layout="NCHW")],
        config={"percentile": 80.0, "kernel_size": (3, 3), "border_type": "reflect"},
        symbols=STENCIL,
        without_nan=True,
        peer=Peer(
            "scipy.ndimage", lambda ndimage, x: ndimage.percentile_filter(x, 80, 3, mode="mirror"), "planes"
        ),
        reference="SciPy percentile_filter(mode='mirror')",
        errors=rejected("percentile", "0 to 100", math.nan),
    )
)

# --- blurs that keep edges ----------------------------------------------------------------------------------

_OWN_WEIGHT = (
    "native code knows a pixel's weight for itself, which eager code computes of the difference of an"
    " infinity with itself"
)

_BILATERAL = (
    *rejected("sigma_color", "a positive number", *NOT_POSITIVE),
    ErrorInput("sigma_color", "1", "sigma_color: expected a number or a tensor, got str", TypeError),
    *rejected("sigma_space", "positive numbers", (math.nan, 1.0)),
)

add(
    Spec(
        "filters.bilateral_blur",
        [image()],
        [TensorSpec("output", layout="NCHW")],
        config={
            "kernel_size": (5, 5),
            "sigma_color": 0.1,
            "sigma_space": (1.5, 1.5),
            "border_type": "reflect",
        },
        symbols=STENCIL,
        special_values=_OWN_WEIGHT,
        also=({"kernel_size": (3, 5), "border_type": "replicate", "color_distance_type": "l2"},),
        reference="the definition in NumPy float64, and OpenCV bilateralFilter on one channel",
        frames=Frames(
            config={"sigma_color": 25.0},
            reference="the definition in NumPy float64, and OpenCV bilateralFilter",
        ),
        errors=(*_BILATERAL, *rejected_words("color_distance_type")),
    )
)

add(
    Spec(
        "filters.joint_bilateral_blur",
        [image(), image("guidance", channels=1, color="GRAY")],
        [TensorSpec("output", layout="NCHW")],
        config={
            "kernel_size": (3, 3),
            "sigma_color": 0.1,
            "sigma_space": (1.5, 1.5),
            "border_type": "reflect",
        },
        symbols=STENCIL,
        special_values=_OWN_WEIGHT,
        reference="the definition in NumPy float64",
        frames=Frames(config={"sigma_color": 25.0}, reference="the definition in NumPy float64"),
        errors=_BILATERAL,
    )
)

add(
    Spec(
        "filters.guided_blur",
        [image("guidance", channels=3, color="RGB"), image()],
        [TensorSpec("output", layout="NCHW")],
        config={"kernel_size": (5, 5), "eps": 0.01, "border_type": "reflect"},
        symbols=STENCIL,
        reference="the definition in NumPy float64",
    )
)

add(
    Spec(
        "filters.fast_guided_blur",
        [image("guidance", channels=1, color="GRAY"), image()],
        [TensorSpec("output", layout="NCHW")],
        config={"kernel_size": (5, 5), "eps": 0.01, "border_type": "reflect", "subsample": 2},
        # The small images must also be large enough for stencils.
        symbols={"H": (16, 32768), "W": (16, 32768)},
        reference="the definition in NumPy float64",
    ),
    fn="filters.guided_blur",
)

add(
    Spec(
        "filters.non_local_means",
        [image()],
        [TensorSpec("output", layout="NCHW")],
        config={"patch_size": 5, "patch_distance": 5, "h": 0.2, "sigma": 0.05, "border_type": "reflect"},
        symbols=STENCIL,
        gradients=(),
        reference="the definition in NumPy float64, OpenCV fastNlMeansDenoising",
        errors=rejected("h", "a positive number", math.nan),
    )
)
