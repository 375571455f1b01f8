"""Morphology."""

import numpy as np
import torch
from torch import Generator, Tensor

from ..peer import Peer, opencv
from ..spec import Frames, Spec, TensorSpec, image
from . import STENCIL, add, rejected, rejected_words


def _morphology(operation: str) -> Peer:
    return opencv(
        lambda cv2, x, kernel: cv2.morphologyEx(x, getattr(cv2, operation), kernel),
        before=lambda x, kernel: (x, (kernel != 0).astype(np.uint8)),
    )


def _square(function: str) -> Peer:
    return opencv(lambda cv2, x: getattr(cv2, function)(x, np.ones((5, 5), np.uint8)))


def _made(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """An image and a 3x3 structuring element (a cross: zero means outside)."""
    shape = (sizes["B"], sizes["C"], sizes["H"], sizes["W"])
    cross = torch.tensor([[0.0, 1.0, 0.0], [1.0, 1.0, 1.0], [0.0, 1.0, 0.0]], dtype=dtype)
    return {"tensor": torch.rand(shape, generator=generator, dtype=torch.float64).to(dtype), "kernel": cross}


add(
    Spec(
        "morphology.dilation",
        [
            image("tensor"),
            TensorSpec(
                "kernel", (3, 3), range=(0, 1), description="structuring element, zero where it has no point"
            ),
        ],
        [TensorSpec("output", layout="NCHW")],
        symbols=STENCIL,
        gradients=("tensor",),
        make_inputs=_made,
        without_nan=True,
        peer=_morphology("MORPH_DILATE"),
        also=(
            {"origin": [0, 2], "border_type": "constant", "border_value": 0.25},
            {"border_type": "reflect"},
        ),
        reference="OpenCV dilate, SciPy grey_dilation",
        frames=Frames(("uint8", "uint16"), peer=_morphology("MORPH_DILATE")),
        errors=(
            *rejected("origin", "a position inside the (3, 3) kernel", [0, 3]),
            *rejected_words("border_type"),
        ),
    )
)

for _name, _operation, _reference in (
    ("erosion", "MORPH_ERODE", "OpenCV erode, SciPy grey_erosion"),
    ("opening", "MORPH_OPEN", "OpenCV MORPH_OPEN, SciPy grey_opening"),
    ("closing", "MORPH_CLOSE", "OpenCV MORPH_CLOSE, SciPy grey_closing"),
    ("gradient", "MORPH_GRADIENT", "OpenCV MORPH_GRADIENT, SciPy morphological_gradient"),
    ("top_hat", "MORPH_TOPHAT", "OpenCV MORPH_TOPHAT, SciPy white_tophat"),
    ("bottom_hat", "MORPH_BLACKHAT", "OpenCV MORPH_BLACKHAT, SciPy black_tophat"),
):
    add(
        Spec(
            f"morphology.{_name}",
            [
                image("tensor"),
                TensorSpec(
                    "kernel",
                    (3, 3),
                    range=(0, 1),
                    description="structuring element, zero where it has no point",
                ),
            ],
            [TensorSpec("output", layout="NCHW")],
            symbols=STENCIL,
            gradients=("tensor",),
            make_inputs=_made,
            without_nan=True,
            peer=_morphology(_operation),
            reference=_reference,
            frames=Frames(
                ("uint8", "uint16") if _name == "erosion" else ("uint8",), peer=_morphology(_operation)
            ),
        )
    )

for _name, _function, _reference in (
    ("max_filter2d", "dilate", "OpenCV dilate, SciPy maximum_filter"),
    ("min_filter2d", "erode", "OpenCV erode, SciPy minimum_filter"),
):
    add(
        Spec(
            f"morphology.{_name}",
            [image()],
            [TensorSpec("output", layout="NCHW")],
            config={"kernel_size": (5, 5), "border_type": "replicate"},
            symbols=STENCIL,
            without_nan=True,
            peer=_square(_function),
            reference=_reference,
            frames=Frames(peer=_square(_function)),
        )
    )


def _seed_and_mask(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """A mask, and a seed below it that is 0 in three quarters of the pixels."""
    shape = (sizes["B"], sizes["C"], sizes["H"], sizes["W"])
    mask, chance = (torch.rand(shape, generator=generator, dtype=torch.float64).to(dtype) for _ in range(2))
    return {"seed": torch.where(chance < 0.25, 0.8 * mask, torch.zeros_like(mask)), "mask": mask}


add(
    Spec(
        "morphology.reconstruction",
        [image("seed"), image("mask", description="what the result never exceeds")],
        [TensorSpec("output", layout="NCHW")],
        config={"method": "dilation"},
        symbols=STENCIL,
        gradients=(),
        make_inputs=_seed_and_mask,
        without_nan=True,
        peer=Peer("skimage.morphology", lambda m, seed, mask: m.reconstruction(seed, mask), "planes"),
        reference="scikit-image reconstruction",
    )
)


def _shapes(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """A binary image: three of five pixels are set."""
    shape = (sizes["B"], sizes["C"], sizes["H"], sizes["W"])
    return {"input": (torch.rand(shape, generator=generator) < 0.6).to(dtype)}


def _shapes_and_corner(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """A binary image and the pattern of an upper right corner."""
    hit = torch.tensor([[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], dtype=dtype)
    miss = torch.tensor([[0.0, 1.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]], dtype=dtype)
    return _shapes(generator, sizes, dtype) | {"hit": hit, "miss": miss}


add(
    Spec(
        "morphology.hit_or_miss",
        [
            image(description="binary image batch, set above 0"),
            TensorSpec("hit", (3, 3), range=(0, 1), description="nonzero where a pixel must be set"),
            TensorSpec("miss", (3, 3), range=(0, 1), description="nonzero where none may be"),
        ],
        [TensorSpec("output", layout="NCHW", description="1 where the pattern is found")],
        symbols=STENCIL,
        gradients=(),
        make_inputs=_shapes_and_corner,
        peer=Peer("scipy.ndimage", lambda n, x, hit, miss: n.binary_hit_or_miss(x, hit, miss), "planes"),
        reference="SciPy binary_hit_or_miss, OpenCV MORPH_HITMISS",
    )
)

for _name, _reference, _peer in (
    ("skeletonize", "the definition in NumPy", None),
    ("thin", "scikit-image thin", Peer("skimage.morphology", lambda m, x: m.thin(x), "planes")),
):
    add(
        Spec(
            f"morphology.{_name}",
            [image(description="binary image batch, set above 0")],
            [TensorSpec("output", layout="NCHW", description="1 on the skeleton")],
            symbols=STENCIL,
            gradients=(),
            make_inputs=_shapes,
            peer=_peer,
            reference=_reference,
        )
    )
