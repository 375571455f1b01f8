"""Ops that fit no other family."""

from ..spec import Spec, TensorSpec, Tolerance, image
from . import add

# --- histogram ---------------------------------------------------------------------------------------------------------


def _sample_interp(generator, sizes, dtype):
    import torch

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
