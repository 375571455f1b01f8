"""Specs of random changes of images."""

from __future__ import annotations

from typing import Any

import torch
from torch import Generator, Tensor

from ..spec import Spec, TensorSpec, image
from . import STENCIL, add

_PHILOX = "Philox's published numbers"


def _made(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    shape = (sizes["B"], sizes["C"], sizes["H"], sizes["W"])
    return {
        "input": torch.rand(shape, generator=generator, dtype=torch.float64).to(dtype),
        "seed": torch.randint(-(2**63), 2**63 - 1, (sizes["B"],), generator=generator),
    }


def _spec(name: str, reference: str, **rest: Any):
    seed = TensorSpec("seed", ("B",), "int64", description="one seed a sample, any 64 bits")
    return Spec(
        f"augmentation.{name}",
        [image(), seed],
        [TensorSpec("output", layout="NCHW")],
        make_inputs=_made,
        reference=f"{reference}; {_PHILOX}",
        **rest,
    )


add(_spec("random_horizontal_flip", "NumPy"))
add(_spec("random_vertical_flip", "NumPy"))
add(_spec("random_rotation", "cv2.warpPerspective, torchvision", config={"degrees": (-30.0, 30.0)}))
add(
    _spec(
        "random_affine",
        "cv2.warpPerspective, torchvision",
        config={"degrees": (-20.0, 20.0), "translate": (0.1, 0.1), "scale": (0.8, 1.25)},
    )
)
add(_spec("random_perspective", "cv2.warpPerspective"))
add(
    _spec(
        "random_resized_crop",
        "torch's interpolate of the box",
        config={"size": (32, 40), "scale": (0.3, 1.0)},
    )
)
add(_spec("random_erasing", "torchvision's erase"))
add(
    _spec(
        "random_crop",
        "torchvision's crop, numpy.pad",
        config={"size": (6, 7), "padding": (3, 2, 1, 0)},
        symbols=STENCIL,
    )
)
add(_spec("random_rotation90", "torch.rot90", config={"times": (-1, 2)}))
add(
    _spec(
        "random_elastic_transform",
        "SciPy's gaussian_filter, torchvision's elastic",
        config={"kernel_size": (5, 7), "sigma": (1.5, 2.0)},
    )
)
add(_spec("random_thin_plate_spline", "the points that it moves, SciPy's map_coordinates"))
add(_spec("random_fisheye", "cv2.remap"))
