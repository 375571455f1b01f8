"""Ops that fit no other family."""

import torch

from ..spec import Spec, TensorSpec, Tolerance, image
from . import STENCIL, add

# --- histogram ---------------------------------------------------------------------------------------------------------


def _sample_interp(generator, sizes, dtype):
    n = sizes["N"]
    # knots at even distances, moved by less than half of them, and values of x within and beyond
    knots = (torch.arange(n) + 0.6 * torch.rand(n, generator=generator, dtype=torch.float64)) / n
    x = torch.rand((sizes["B"], sizes["C"], sizes["H"], sizes["W"]), generator=generator, dtype=torch.float64) * 1.4 - 0.2
    return {"x": x.to(dtype), "xp": knots.to(dtype), "fp": torch.rand(n, generator=generator, dtype=torch.float64).to(dtype)}


add(Spec(
    "contrib.interp",
    [image("x"), TensorSpec("xp", ("N",), description="ascending knots"), TensorSpec("fp", ("N",), description="values at the knots")],
    [TensorSpec("output")],
    symbols={"N": (2, 1 << 20)},
    sample=_sample_interp,
    # slopes amplify the rounding of x, and the gradient by a knot is a sum over all values beside it
    tolerances={"float32": Tolerance(1e-4, 1e-4)},
    gradient_tolerances={"float32": Tolerance(1e-2, 1e-3)},
    reference="numpy.interp",
))

add(Spec(
    "contrib.histogram_matching",
    [image("source"), TensorSpec("template", ("B", "C", "OH", "OW"), layout="NCHW", description="image whose histogram is wanted")],
    [TensorSpec("output", layout="NCHW")],
    config={"per_plane": True},
    symbols={"OH": (1, 32768), "OW": (1, 32768)},
    gradients=(),
    reference="scikit-image match_histograms on bytes",
))

# --- shapes ----------------------------------------------------------------------------------------------------------


def _shapes(generator, sizes, dtype):
    """Binary images: two of five pixels are set, about where shapes are longest and most winding."""
    shape = (sizes["B"], sizes["C"], sizes["H"], sizes["W"])
    return {"image": (torch.rand(shape, generator=generator) < 0.4).to(dtype)}


def _sparse(generator, sizes, dtype):
    """Binary images with few pixels set."""
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
