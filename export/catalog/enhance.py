"""Intensity changes."""

from ..spec import Spec, TensorSpec, image
from . import add

add(Spec(
    "enhance.normalize",
    [image("data"),
     TensorSpec("mean", ("C",), description="one value a channel"),
     TensorSpec("std", ("C",), range=(0.2, 1.0), description="one value a channel, not zero")],
    [TensorSpec("output", layout="NCHW")],
    reference="(data - mean) / std in NumPy float64",
))
