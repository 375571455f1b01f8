"""Colour conversions."""

from ..spec import Spec, TensorSpec, image
from . import add

add(Spec(
    "color.rgb_to_grayscale",
    [image("image", channels=3, color="RGB")],
    [TensorSpec("output", layout="NCHW", color="GRAY")],
    dtypes=("float32", "float64", "float16", "bfloat16"),
    reference="OpenCV cvtColor(COLOR_RGB2GRAY)",
))

add(Spec(
    "color.rgb_to_hsv",
    [image("image", channels=3, color="RGB")],
    [TensorSpec("output", layout="NCHW", color="HSV", description="hue in [0, 2 pi], saturation and value in [0, 1]")],
    reference="OpenCV cvtColor(COLOR_RGB2HSV) on float32",
))
