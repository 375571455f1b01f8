"""Features: corner and blob responses of pixels."""

import math

from ..peer import Peer
from ..spec import ErrorInput, Frames, Spec, TensorSpec, image
from . import STENCIL, add, rejected

add(
    Spec(
        "feature.harris_response",
        [image()],
        [TensorSpec("output", layout="NCHW", description="corner response")],
        config={"k": 0.04, "grads_mode": "sobel"},
        symbols=STENCIL,
        reference="the definition in NumPy float64; OpenCV cornerHarris up to scale",
        errors=(ErrorInput("grads_mode", "other", "mode: expected one of"),),
    )
)

add(
    Spec(
        "feature.harris_keypoints",
        [image(channels=1, color="GRAY")],
        [
            TensorSpec("keypoints", description="(x, y) in pixels, -1 where not valid"),
            TensorSpec("scores", description="corner response, sorted, 0 where not valid"),
            TensorSpec("valid", description="which of the slots hold a keypoint"),
        ],
        config={"max_keypoints": 64, "k": 0.04, "nms_size": 5, "threshold": 0.0},
        symbols=STENCIL,
        gradients=(),
        reference="NumPy argsort of the response's local maxima",
        picture="keypoints",
        errors=(
            *rejected("max_keypoints", "a positive number", 0),
            *rejected("threshold", "a number >= 0", -1.0),
        ),
    )
)

_SIGMAS = TensorSpec("sigmas", ("B",), range=(0.8, 1.6), description="the scale of each image")
_BORDER = {"H": (16, 32768), "W": (16, 32768)}
add(
    Spec(
        "feature.gftt_response",
        [image(), _SIGMAS],
        [TensorSpec("output", layout="NCHW", description="corner response")],
        config={"grads_mode": "sobel"},
        symbols=STENCIL,
        reference="the definition in NumPy float64; OpenCV cornerMinEigenVal with a box for the Gaussian",
    )
)
add(
    Spec(
        "feature.hessian_response",
        [image(), _SIGMAS],
        [TensorSpec("output", layout="NCHW", description="blob response")],
        config={"grads_mode": "sobel"},
        symbols=STENCIL,
        reference="the definition in NumPy float64",
    )
)
add(
    Spec(
        "feature.dog_response",
        [
            TensorSpec(
                "input",
                ("B", "C", "D", "H", "W"),
                layout="NCDHW",
                range=(0.0, 1.0),
                description="scale space",
            )
        ],
        [TensorSpec("output", layout="NCDHW", description="coarser minus finer levels")],
        symbols={"D": (3, 4096)},
        peer=Peer("numpy", lambda np, x: np.diff(x, axis=2), "batch"),
        reference="NumPy diff",
        picture="volumes",
    )
)
add(
    Spec(
        "feature.dog_response_single",
        [image()],
        [TensorSpec("output", layout="NCHW", description="blob response")],
        symbols=_BORDER,
        peer=Peer(
            "scipy.ndimage",
            lambda ndimage, x: (
                ndimage.gaussian_filter(x, 1.6, mode="mirror", radius=6)
                - ndimage.gaussian_filter(x, 1.0, mode="mirror", radius=4)
            ),
            "planes",
        ),
        reference="SciPy gaussian_filter in float64",
        errors=(
            ErrorInput("sigma2", math.nan, "sigma1, sigma2: expected positive numbers, got 1.0 and nan"),
        ),
    )
)
add(
    Spec(
        "feature.fast_response",
        [image()],
        [TensorSpec("output", layout="NCHW", description="corner response")],
        symbols=STENCIL,
        without_nan=True,
        special_values="differences of infinities are NaN",
        reference="OpenCV FastFeatureDetector",
        frames=Frames(),
    )
)
