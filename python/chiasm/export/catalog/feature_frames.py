"""Features: local affine frames and their patches."""

import math
from collections.abc import Sequence
from typing import Any

import torch
from torch import Generator, Tensor

from ..spec import InputMaker, Maker, Spec, TensorSpec, Tolerance, image
from . import ZERO_WEIGHTS, add
from .rigid import linalg, uniform

_FRAMES = ("B", "N", 2, 3)
#: Positions in pixels: differences are relative to the image's size.
_PIXELS: dict[str, Any] = {"float32": Tolerance(1e-4, 1e-5)}


def frames(generator: Generator, sizes: dict[str, int], largest: float = 8.0):
    """(B, N, 2, 3) frames of all orientations and moderate shapes, inside the image and around its border."""
    shape = (sizes["B"], sizes["N"])
    draw = torch.rand((*shape, 6), generator=generator, dtype=torch.float64)
    turn, skew = 2.0 * math.pi * draw[..., 0], 0.6 * draw[..., 1] - 0.3
    scale, stretch = 1.0 + (largest - 1.0) * draw[..., 2], 0.7 + 0.6 * draw[..., 3]
    cosine, sine = torch.cos(turn), torch.sin(turn)
    a, b = scale * stretch * cosine, scale * stretch * sine
    c, d = -scale * sine + skew * a, scale * cosine + skew * b
    x, y = draw[..., 4] * sizes.get("W", 100), draw[..., 5] * sizes.get("H", 100)
    return torch.stack([torch.stack([a, b, x], -1), torch.stack([c, d, y], -1)], -2)


def _laf(name: str = "laf", description: str = "local affine frames"):
    return TensorSpec(name, _FRAMES, description=description)


def _made(first: str, **others: Maker) -> InputMaker:
    """Frames under the name ``first``; the other inputs are made by functions of (generator, sizes)."""

    def sample(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        made = {first: frames(generator, sizes)}
        made.update({name: make(generator, sizes) for name, make in others.items()})
        return {name: value.to(dtype) for name, value in made.items()}

    return sample


def _uniform(low: float, high: float, *shape: int | str) -> Maker:
    def make(generator: Generator, sizes: dict[str, int]):
        size = [sizes[d] if isinstance(d, str) else d for d in shape]
        return uniform(generator, low, high, *size)

    return make


def _add(
    name: str,
    inputs: Sequence[TensorSpec],
    outputs: Sequence[TensorSpec | str],
    reference: str,
    picture: str = "local affine frames",
    **rest: Any,
):
    add(
        Spec(
            f"feature.{name}",
            inputs,
            [TensorSpec(o) if isinstance(o, str) else o for o in outputs],
            reference=reference,
            picture=picture,
            **rest,
        )
    )


_ANGLES = TensorSpec("angles_degrees", ("B", "N", 1), range=(-170.0, 170.0), description="degrees")
_TURNED = _uniform(-170.0, 170.0, "B", "N", 1)
_IMAGES = _uniform(0.0, 1.0, "B", "C", "H", "W")
_OUT = TensorSpec("output", description="local affine frames")

_add(
    "get_laf_center",
    [_laf("LAF")],
    [TensorSpec("center", description="x and y")],
    "NumPy",
    make_inputs=_made("LAF"),
)
_add(
    "get_laf_scale",
    [_laf("LAF")],
    [TensorSpec("scale", description="pixels")],
    "NumPy determinants",
    make_inputs=_made("LAF"),
)
_add(
    "get_laf_orientation",
    [_laf("LAF")],
    [TensorSpec("orientation", description="degrees")],
    "NumPy arctan2",
    make_inputs=_made("LAF"),
    tolerances={"float32": Tolerance(1e-3, 1e-5)},
    gradient_tolerances={"float32": Tolerance(1e-3, 1e-4)},
)
_add(
    "set_laf_orientation",
    [_laf("LAF"), _ANGLES],
    [_OUT],
    "its inverse, and ellipses that stay",
    make_inputs=_made("LAF", angles_degrees=_TURNED),
    tolerances=_PIXELS,
)
_add(
    "rotate_laf",
    [_laf("LAF"), _ANGLES],
    [_OUT],
    "OpenCV KeyPoint angles; NumPy",
    make_inputs=_made("LAF", angles_degrees=_TURNED),
    tolerances=_PIXELS,
)
_add(
    "scale_laf",
    [_laf(), TensorSpec("scale_coef", ("B", "N", 1, 1), range=(0.5, 3.0))],
    [_OUT],
    "NumPy",
    make_inputs=_made("laf", scale_coef=_uniform(0.5, 3.0, "B", "N", 1, 1)),
)
_add("make_upright", [_laf()], [_OUT], "NumPy QR", make_inputs=_made("laf"))
_add(
    "laf_from_center_scale_ori",
    [
        TensorSpec("xy", ("B", "N", 2), range=(0.0, 100.0), description="centres"),
        TensorSpec("scale", ("B", "N", 1, 1), range=(1.0, 9.0), description="radii in pixels"),
        TensorSpec("ori", ("B", "N", 1), range=(-170.0, 170.0), description="degrees"),
    ],
    [_OUT],
    "OpenCV KeyPoint angles",
)
_add(
    "normalize_laf",
    [_laf("LAF"), image("images")],
    [_OUT],
    "NumPy",
    make_inputs=_made("LAF", images=_IMAGES),
    gradients=("LAF",),
)
_add(
    "denormalize_laf",
    [_laf("LAF"), image("images")],
    [_OUT],
    "NumPy",
    make_inputs=_made("LAF", images=_IMAGES),
    gradients=("LAF",),
    tolerances={"float32": Tolerance(1e-3, 1e-5)},
)
_add(
    "laf_to_three_points",
    [_laf()],
    [TensorSpec("points", description="the ends of both axes, and the centre")],
    "NumPy",
    make_inputs=_made("laf"),
)
_add(
    "laf_from_three_points",
    [_laf("threepts", "the ends of both axes, and the centre")],
    [_OUT],
    "its inverse",
    make_inputs=_made("threepts"),
)
_add(
    "laf_to_boundary_points",
    [_laf("LAF")],
    [TensorSpec("points", description="x and y")],
    "NumPy",
    config={"n_pts": 50},
    make_inputs=_made("LAF"),
    tolerances=_PIXELS,
)
_add(
    "laf_is_filled",
    [_laf()],
    [TensorSpec("filled", description="which slots hold a frame")],
    "NumPy",
    make_inputs=_made("laf"),
    gradients=(),
)
_add(
    "laf_is_valid",
    [_laf()],
    [TensorSpec("valid", description="which frames have an area")],
    "NumPy determinants",
    make_inputs=_made("laf"),
    gradients=(),
)
_add(
    "laf_is_inside_image",
    [_laf(), image("images")],
    [TensorSpec("inside", description="which frames lie in their images")],
    "NumPy",
    config={"border": 2},
    make_inputs=_made("laf", images=_IMAGES),
    gradients=(),
)


def _make_ellipses(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    frame = frames(generator, sizes)
    a = frame[..., :2]
    form = linalg.inv(a @ a.transpose(-1, -2))
    return {
        "ells": (
            torch.stack(
                [frame[..., 0, 2], frame[..., 1, 2], form[..., 0, 0], form[..., 0, 1], form[..., 1, 1]], -1
            ).to(dtype)
        )
    }


_add(
    "ellipse_to_laf",
    [TensorSpec("ells", ("B", "N", 5), description="x, y, a, b, c of a dx^2 + 2 b dx dy + c dy^2 = 1")],
    [_OUT],
    "NumPy Cholesky",
    make_inputs=_make_ellipses,
    gradient_tolerances={"float32": Tolerance(1e-2, 1e-3)},
)


def _homographies(generator: Generator, sizes: dict[str, int]):
    wild = torch.tensor([[0.1, 0.1, 3.0], [0.1, 0.1, 3.0], [5e-4, 5e-4, 0.0]], dtype=torch.float64)
    return (
        torch.eye(3, dtype=torch.float64)
        + (2.0 * torch.rand((sizes["B"], 3, 3), generator=generator, dtype=torch.float64) - 1.0) * wild
    )


_add(
    "perspective_transform_lafs",
    [TensorSpec("trans_01", ("B", 3, 3), description="homographies between pixels"), _laf("lafs_1")],
    [_OUT],
    "the Jacobian by autograd",
    make_inputs=_made("lafs_1", trans_01=_homographies),
    tolerances=_PIXELS,
    gradient_tolerances={"float32": Tolerance(1e-2, 1e-3)},
)

# --- patches ------------------------------------------------------------------------------------------------

_PATCHES: dict[str, Any] = {
    "outputs": [TensorSpec("patches", description="(B, N, C, PS, PS)")],
    "config": {"PS": 16},
    "picture": "patches",
    # weights amplify the rounding of positions by the contrast, and the gradient by a frame is a sum over its
    # patch
    "tolerances": {"float32": Tolerance(1e-3, 1e-3)},
    "gradient_tolerances": {"float32": Tolerance(5e-3, 2e-3)},
}


def _make_regions(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Some frames of many pixels, which are read from coarse levels."""
    return {"img": _IMAGES(generator, sizes).to(dtype), "laf": frames(generator, sizes, 40.0).to(dtype)}


_add(
    "extract_patches_simple",
    [image("img"), _laf()],
    reference="SciPy map_coordinates",
    make_inputs=_make_regions,
    **_PATCHES,
)
_add(
    "extract_patches_from_pyramid",
    [image("img"), _laf()],
    reference="SciPy map_coordinates on levels made by NumPy",
    make_inputs=_make_regions,
    special_values=ZERO_WEIGHTS,
    **_PATCHES,
)
