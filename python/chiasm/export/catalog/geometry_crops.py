"""Geometric transforms of images: crops."""

from typing import Any

import numpy as np
import torch
from torch import Generator, Tensor

from ..peer import Peer, warped
from ..spec import Spec, TensorSpec, image, like
from . import add, rejected_sizes, rejected_words, warp_peers
from .geometry_transform import OUTPUT, SIZES, WARP, add_transform
from .rigid import uniform

_BOXES = TensorSpec("boxes", ("B", 4, 2), description="corners (x, y) from the upper left clockwise")
add_transform(
    "center_crop",
    [image("input_tensor"), like("size")],
    "torchvision center_crop",
    peer=Peer(
        "torchvision.transforms.functional",
        lambda F, x, like: F.center_crop(x, list(like.shape)),
        "tensors",
        sizes={"H": 41, "W": 30, "OH": 15, "OW": 12},  # crops that begin at a pixel
    ),
    fn="center_crop",
    symbols=SIZES,
    **WARP,
    errors=rejected_sizes("size"),
)
add_transform(
    "crop_and_resize",
    [image("input_tensor"), _BOXES],
    "OpenCV warpPerspective",
    fn="crop_and_resize",
    config={"size": (10, 12)},
    peer=warp_peers.between_boxes(lambda x, boxes: (x, boxes, warp_peers.corners(12, 10), (12, 10))),
    **WARP,
    errors=rejected_sizes("size"),
)
add_transform(
    "crop_by_transform_mat",
    [
        image("input_tensor"),
        TensorSpec("transform", ("B", 3, 3), description="from source to destination pixels"),
        like("out_size"),
    ],
    "OpenCV warpPerspective",
    fn="crop_by_transform_mat",
    peer=warped("warpPerspective", "bilinear", "zeros"),
    symbols=SIZES,
    **WARP,
    errors=rejected_sizes("out_size"),
)
add_transform(
    "crop_by_boxes",
    [
        image("input_tensor"),
        TensorSpec("src_box", ("B", 4, 2), description="corners (x, y) in the image"),
        TensorSpec("dst_box", ("B", 4, 2), description="where they go"),
        like("size"),
    ],
    "OpenCV warpPerspective",
    fn="crop_by_boxes",
    peer=warp_peers.between_boxes(lambda x, source, target, like: (x, source, target, like.shape[::-1])),
    config={"validate_boxes": False},
    symbols=SIZES,
    **WARP,
)


def _make_whole_boxes(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Images, and boxes of whole pixels in them."""
    batch, extent = sizes["B"], torch.tensor([sizes["W"], sizes["H"]])
    low = (uniform(generator, 0.0, 0.4, batch, 2) * extent).long()
    high = (uniform(generator, 0.5, 1.0, batch, 2) * extent).long()
    box = torch.stack(
        [low, torch.stack([high[:, 0], low[:, 1]], -1), high, torch.stack([low[:, 0], high[:, 1]], -1)], 1
    )
    shape = (batch, sizes["C"], sizes["H"], sizes["W"])
    return {"input_tensor": uniform(generator, 0, 1, *shape).to(dtype), "src_box": box}


def _resized(functional: Any, x: np.ndarray, box: np.ndarray) -> Tensor:
    (left, top), (right, lower) = box[0].tolist(), box[2].tolist()
    size = (top, left, lower - top + 1, right - left + 1)
    return functional.resized_crop(torch.as_tensor(x), *size, (9, 11), antialias=False)


for _name, _config in {
    "resize": {"interpolation": "bilinear"},
    "pad": {"shape_compensation": "pad"},
}.items():
    add(
        Spec(
            f"geometry.transform.crop_by_indices.{_name}",
            [
                image("input_tensor"),
                TensorSpec(
                    "src_box",
                    ("B", 4, 2),
                    "int64",
                    description="corner pixels (x, y) from the upper left clockwise",
                ),
            ],
            OUTPUT,
            config={"size": (9, 11), **_config},
            make_inputs=_make_whole_boxes,
            peer=Peer("torchvision.transforms.functional", _resized, "samples")
            if _name == "resize"
            else None,
            reference="NumPy slices and torch.nn.functional.interpolate",
            picture="warps",
            errors=rejected_words("shape_compensation"),
        ),
        fn="geometry.transform.crop_by_indices",
    )
