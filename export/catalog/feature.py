"""Features."""

from ..spec import Spec, TensorSpec, image
from . import STENCIL, add

add(Spec(
    "feature.harris_response",
    [image()],
    [TensorSpec("output", layout="NCHW", description="corner response")],
    config={"k": 0.04, "grads_mode": "sobel"},
    symbols=STENCIL,
    reference="the definition in NumPy float64; OpenCV cornerHarris up to scale",
))

add(Spec(
    "feature.harris_keypoints",
    [image(channels=1, color="GRAY")],
    [TensorSpec("keypoints", description="(x, y) in pixels, -1 where not valid"),
     TensorSpec("scores", description="corner response, sorted, 0 where not valid"),
     TensorSpec("valid", description="which of the slots hold a keypoint")],
    config={"max_keypoints": 64, "k": 0.04, "nms_size": 5, "threshold": 0.0},
    symbols=STENCIL,
    gradients=(),
    reference="NumPy argsort of the response's local maxima",
))
