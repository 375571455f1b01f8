"""What fits no other family."""

from ..spec import Spec, TensorSpec, image
from . import STENCIL, add


def _shapes(generator, sizes, dtype):
    """Binary images: two of five pixels are set, about where shapes are longest and most winding."""
    import torch

    shape = (sizes["B"], sizes["C"], sizes["H"], sizes["W"])
    return {"image": (torch.rand(shape, generator=generator) < 0.4).to(dtype)}


def _sparse(generator, sizes, dtype):
    """Binary images with few pixels set."""
    import torch

    shape = (sizes["B"], sizes["C"], sizes["H"], sizes["W"])
    return {"image": (torch.rand(shape, generator=generator) < 0.02).to(dtype)}


def _dense(generator, sizes, dtype):
    """Binary images with few pixels clear, in every plane one at least: distances are finite."""
    made = 1.0 - _sparse(generator, sizes, dtype)["image"]
    made[:, :, 3, 5] = 0.0
    return {"image": made}


_BINARY = image("image", description="binary image batch, set above 0")

add(Spec(
    "contrib.connected_components",
    [_BINARY],
    [TensorSpec("labels", layout="NCHW", description="0 where not set, else 1 + the index of the shape's first pixel")],
    config={"num_iterations": 100},
    symbols=STENCIL,
    gradients=(),
    sample=_shapes,
    reference="SciPy label up to the names of the labels",
))

add(Spec(
    "contrib.connected_components_union_find",
    [_BINARY],
    [TensorSpec("labels", layout="NCHW", description="0 where not set, else 1 + the index of the shape's first pixel")],
    symbols=STENCIL,
    gradients=(),
    sample=_shapes,
    reference="SciPy label up to the names of the labels",
))

add(Spec(
    "contrib.distance_transform",
    [image("image", description="binary image batch, 1 on the shapes")],
    [TensorSpec("output", layout="NCHW", description="distance to the nearest shape")],
    config={"kernel_size": 3, "h": 0.35},
    symbols=STENCIL,
    # A loop until nothing changes, whose number of steps is the largest distance: no exported graph can differentiate it.
    gradients=(),
    sample=_sparse,
    reference="the definition in NumPy float64; SciPy distance_transform_edt to within its approximation",
))

add(Spec(
    "contrib.distance_transform_edt",
    [_BINARY],
    [TensorSpec("output", layout="NCHW", description="distance to the nearest pixel that is not set")],
    symbols=STENCIL,
    gradients=(),
    sample=_dense,
    reference="SciPy distance_transform_edt",
))
