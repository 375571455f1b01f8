"""Pipelines: several ops in one bundle, from camera frame to result."""

from ..spec import Spec, TensorSpec, Tolerance, frame
from . import STENCIL, add

add(Spec(
    "pipelines.preprocess",
    [frame()],
    [TensorSpec("output", layout="NCHW", color="RGB", description="224 x 224, normalised by ImageNet's mean and standard deviation")],
    symbols=STENCIL,
    vectorize=False,  # byte gathers: scalar loops were measured three times as fast
    reference="OpenCV resize and blobFromImage",
))

add(Spec(
    "pipelines.edges",
    [frame()],
    [TensorSpec("output", layout="HW", color="GRAY", range=(0, 255), description="Sobel magnitude of the blurred grey image")],
    symbols=STENCIL,
    tolerances={"uint8": Tolerance(1, 0)},  # a float result on the border between two integers may round either way
    reference="OpenCV cvtColor, GaussianBlur, Sobel, magnitude",
))
