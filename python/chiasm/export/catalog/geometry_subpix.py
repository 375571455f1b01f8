"""Geometry: local maxima to a fraction of a pixel, and heat maps."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import torch

from ..peer import Peer
from ..spec import Spec, TensorSpec, Tolerance, image, like
from . import STENCIL, add, rejected

_VOLUME = TensorSpec(
    "input", ("B", "C", "D", "H", "W"), layout="NCDHW", range=(0.0, 1.0), description="volumes"
)
#: A size of 1 is another program, and borders take two voxels of each axis.
_CUBE = {"D": (4, 4096), **STENCIL}


def _add(
    name: str, inputs: Sequence[TensorSpec], outputs: Sequence[TensorSpec | str], reference: str, **rest: Any
):
    family, _, _variant = name.partition(".")
    add(
        Spec(
            f"geometry.subpix.{name}",
            inputs,
            [TensorSpec(o) if isinstance(o, str) else o for o in outputs],
            reference=reference,
            **rest,
        ),
        fn=f"geometry.subpix.{family}",
    )


# --- local maxima -------------------------------------------------------------------------------------------

_MASK = TensorSpec("mask", description="where the maxima are")
_SUPPRESSED = TensorSpec("output", description="input at the maxima, 0 elsewhere")
_SCIPY = "SciPy maximum_filter"


def _exceeding(size: tuple[int, ...]) -> Callable[[Any, np.ndarray], np.ndarray]:
    """Which values exceed all others in a window, by SciPy's filter; what lies outside is infinite."""
    others = np.ones(size, bool)
    others[tuple((k - 1) // 2 for k in size)] = False
    options: dict[str, Any] = {
        "footprint": others[None, None],
        "mode": "constant",
        "cval": np.inf,
        "origin": [0, 0, *((k - 1) // 2 - k // 2 for k in size)],
    }

    return lambda ndimage, x: x > ndimage.maximum_filter(x, **options)


def _maxima(size: tuple[int, ...], mask_only: bool) -> Peer:
    found = _exceeding(size)
    return Peer("scipy.ndimage", found if mask_only else lambda ndimage, x: found(ndimage, x) * x, "batch")


_add(
    "nms2d.values",
    [image()],
    [_SUPPRESSED],
    _SCIPY,
    peer=_maxima((5, 5), False),
    config={"kernel_size": (5, 5)},
    symbols=STENCIL,
    errors=rejected("kernel_size", "positive sizes of more than one pixel", (1, 1), (0, 3)),
)
_add(
    "nms2d.mask",
    [image()],
    [_MASK],
    _SCIPY,
    config={"kernel_size": (3, 4), "mask_only": True},
    peer=_maxima((3, 4), True),
    symbols=STENCIL,
    gradients=(),
)
_add(
    "nms3d.values",
    [_VOLUME],
    [_SUPPRESSED],
    _SCIPY,
    config={"kernel_size": (3, 5, 4)},
    peer=_maxima((3, 5, 4), False),
    symbols=_CUBE,
    errors=rejected("kernel_size", "positive sizes of more than one voxel", (1, 1, 1)),
)
_add(
    "nms3d.mask",
    [_VOLUME],
    [_MASK],
    _SCIPY,
    config={"kernel_size": (3, 3, 3), "mask_only": True},
    peer=_maxima((3, 3, 3), True),
    symbols=_CUBE,
    gradients=(),
)
_HIGH = _exceeding((3, 3, 3))
_add(
    "nms3d_minmax",
    [_VOLUME],
    ["maxima", "minima"],
    _SCIPY,
    peer=Peer("scipy.ndimage", lambda ndimage, x: (_HIGH(ndimage, x), _HIGH(ndimage, -x)), "batch"),
    symbols=_CUBE,
    gradients=(),
)

# --- quadratics ---------------------------------------------------------------------------------------------

_QUADRATIC: dict[str, Any] = {
    "outputs": [
        TensorSpec("positions", description="scale, x and y in voxels"),
        TensorSpec("values", description="the quadratic's at the maxima"),
    ],
    "reference": "a loop in NumPy",
    "symbols": _CUBE,
    # if a quadratic is nearly flat, small changes of the input move its extremum far
    "gradient_tolerances": {"float32": Tolerance(1e-2, 1e-3)},
}
_CHOSEN = TensorSpec("precomputed_nms_mask", ("B", "C", "D", "H", "W"), "bool", description="what to refine")
_add(
    "conv_quad_interp3d.maxima",
    [_VOLUME],
    **_QUADRATIC,
    errors=(*rejected("n_iters", "a positive number", 0), *rejected("dilation_radius", "a number >= 0", -1)),
)
_add(
    "conv_quad_interp3d.masked",
    [_VOLUME, _CHOSEN],
    config={"dilation_radius": 2, "allow_scale_steps": False},
    **_QUADRATIC,
)
_add(
    "iterative_quad_interp3d.maxima",
    [_VOLUME],
    **_QUADRATIC,
    errors=rejected("max_candidates", "a number >= 0", -1),
)
_add(
    "iterative_quad_interp3d.strongest", [_VOLUME], config={"max_candidates": 20, "n_iters": 3}, **_QUADRATIC
)

# --- heat maps ----------------------------------------------------------------------------------------------

_HEATMAP = image(range=(0.0, 5.0), description="heat maps")
_TEMPERATURE = TensorSpec("temperature", (1,), range=(0.3, 2.0), description="smaller is sharper")
_DISTRIBUTION = TensorSpec("output", layout="NCHW", description="distributions")
#: Positions in pixels: differences are relative to the image's size.
_PIXELS: dict[str, Any] = {"tolerances": {"float32": Tolerance(2e-4, 1e-5)}}


def _softmax(F: Any, x: torch.Tensor, temperature: Any) -> torch.Tensor:
    return F.softmax(x.flatten(2) / temperature, -1).reshape(x.shape)


_add(
    "spatial_softmax2d.number",
    [_HEATMAP],
    [_DISTRIBUTION],
    "torch.nn.functional.softmax",
    config={"temperature": 0.5},
    peer=Peer("torch.nn.functional", lambda F, x: _softmax(F, x, 0.5), "tensors"),
    errors=rejected("temperature", "one positive number", 0.0, math.nan),
)
_add(
    "spatial_softmax2d.tensor",
    [_HEATMAP, _TEMPERATURE],
    [_DISTRIBUTION],
    "torch.nn.functional.softmax",
    peer=Peer("torch.nn.functional", _softmax, "tensors"),
)
_add(
    "spatial_expectation2d",
    [image(range=(0.0, 1e-3), description="distributions")],
    [TensorSpec("positions", description="x and y in [-1, 1]")],
    "NumPy average",
)
_add(
    "spatial_soft_argmax2d",
    [_HEATMAP],
    [TensorSpec("positions", description="x and y in pixels")],
    "NumPy average",
    config={"temperature": 0.3, "normalized_coordinates": False},
    **_PIXELS,
)

_MEAN = TensorSpec("mean", ("N", 2), range=(-1.0, 1.0), description="x and y in [-1, 1]")
_STD = TensorSpec("std", ("N", 2), range=(0.1, 0.5), description="along x and y")
_add(
    "render_gaussian2d.fixed",
    [_MEAN, _STD],
    ["output"],
    "SciPy norm",
    config={"size": (24, 31)},
    picture="heat maps",
    errors=rejected("size", "positive sizes", (4, 0)),
)
add(
    Spec(
        "geometry.subpix.render_gaussian2d.like",
        [
            _MEAN,
            _STD,
            like("size"),
        ],
        symbols={"OH": (1, 32768), "OW": (1, 32768)},
        reference="SciPy norm",
        picture="heat maps",
    ),
    fn="geometry.subpix.heatmaps.render_gaussian2d",
)

_WINDOWS = ["positions", TensorSpec("values", description="means under the softmax")]
_add(
    "conv_soft_argmax2d.pixels",
    [_HEATMAP, _TEMPERATURE],
    _WINDOWS,
    "a loop in NumPy",
    config={"normalized_coordinates": False, "output_value": True},
    symbols=STENCIL,
    **_PIXELS,
    errors=(
        *rejected("kernel_size", "positive sizes", [0, 3]),
        *rejected("stride", "positive numbers", [1, 0]),
        *rejected("padding", "numbers from 0 to half of kernel_size", [1, 2]),
    ),
)
_add(
    "conv_soft_argmax2d.normalized",
    [_HEATMAP],
    ["positions"],
    "a loop in NumPy",
    config={"kernel_size": (5, 5), "stride": (2, 2), "padding": (2, 2)},
    symbols=STENCIL,
)
_add(
    "conv_soft_argmax3d",
    [_VOLUME],
    _WINDOWS,
    "a loop in NumPy",
    config={"stride": (1, 2, 2), "padding": (0, 1, 1), "temperature": 0.3},
    symbols=_CUBE,
    **_PIXELS,
)
