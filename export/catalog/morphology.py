"""Morphology."""

from ..spec import Spec, TensorSpec, image
from . import STENCIL, add


def _sample(generator, sizes, dtype):
    """An image and a 3x3 structuring element (a cross: zero means outside)."""
    import torch

    shape = (sizes["B"], sizes["C"], sizes["H"], sizes["W"])
    cross = torch.tensor([[0.0, 1.0, 0.0], [1.0, 1.0, 1.0], [0.0, 1.0, 0.0]], dtype=dtype)
    return {"tensor": torch.rand(shape, generator=generator, dtype=torch.float64).to(dtype), "kernel": cross}


add(Spec(
    "morphology.dilation",
    [image("tensor"), TensorSpec("kernel", (3, 3), range=(0, 1), description="structuring element, zero where it has no point")],
    [TensorSpec("output", layout="NCHW")],
    symbols=STENCIL,
    gradients=("tensor",),
    sample=_sample,
    reference="OpenCV dilate, SciPy grey_dilation",
))
