"""Intensity changes."""

from ..spec import Spec, TensorSpec, Tolerance, image
from . import add

add(Spec(
    "enhance.normalize",
    [image("data"),
     TensorSpec("mean", ("C",), description="one value a channel"),
     TensorSpec("std", ("C",), range=(0.2, 1.0), description="one value a channel, not zero")],
    [TensorSpec("output", layout="NCHW")],
    # the gradients of mean and std are sums over all pixels, whose order each backend chooses
    gradient_tolerances={"float32": Tolerance(1e-3, 1e-4)},
    reference="(data - mean) / std in NumPy float64",
))
