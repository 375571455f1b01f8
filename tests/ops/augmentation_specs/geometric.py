"""Specs of random changes of images."""

from __future__ import annotations

import torch

from chiasm.export.spec import Spec, TensorSpec, image

from . import add

_PHILOX = "Philox's published numbers"


def _sample(generator, sizes, dtype):
    shape = (sizes["B"], sizes["C"], sizes["H"], sizes["W"])
    return {
        "input": torch.rand(shape, generator=generator, dtype=torch.float64).to(dtype),
        "seed": torch.randint(-(2**63), 2**63 - 1, (sizes["B"],), generator=generator),
    }


def _spec(name, reference, **rest):
    seed = TensorSpec("seed", ("B",), "int64", description="one seed a sample, any 64 bits")
    return Spec(
        f"augmentation.{name}",
        [image(), seed],
        [TensorSpec("output", layout="NCHW")],
        sample=_sample,
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
