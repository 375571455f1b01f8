"""Geometric transforms of images: crops."""

from typing import Any

import numpy as np
import torch
from torch import Generator, Tensor

from ..peer import Peer, opencv, warped
from ..spec import PIXELS, Frames, Spec, TensorSpec, image, like
from . import add, rejected_sizes, rejected_words, warp_peers
from .geometry_transform import OUTPUT, SIZES, WARP, add_transform
from .rigid import uniform

#: Images and crops for which crops begin at a pixel.
_WHOLE = {"H": 41, "W": 30, "OH": 15, "OW": 12}


def _centre(_: Any, x: np.ndarray, size: tuple[int, ...]) -> np.ndarray:
    top, left = (x.shape[0] - size[0]) // 2, (x.shape[1] - size[1]) // 2
    return np.ascontiguousarray(x[top : top + size[0], left : left + size[1]])


_BOXES = TensorSpec("boxes", ("B", 4, 2), description="corners (x, y) from the upper left clockwise")
add_transform(
    "center_crop",
    [image("input_tensor"), like("size")],
    "torchvision center_crop",
    peer=Peer(
        "torchvision.transforms.functional",
        lambda F, x, like: F.center_crop(x, list(like.shape)).contiguous(),
        "tensors",
        sizes=_WHOLE,
    ),
    frames=Frames(
        PIXELS,
        reference="NumPy slices",
        peer=Peer("numpy", _centre, before=lambda x, like: (x, like.shape), sizes=_WHOLE),
    ),
    fn="center_crop",
    symbols=SIZES,
    **WARP,
    errors=rejected_sizes("size"),
)


def _to_corners(x: np.ndarray, boxes: np.ndarray) -> tuple[Any, ...]:
    return x, boxes, warp_peers.corners(12, 10), (12, 10)


def _to_boxes(x: np.ndarray, source: np.ndarray, target: np.ndarray, like: np.ndarray) -> tuple[Any, ...]:
    return x, source, target, like.shape[::-1]


add_transform(
    "crop_and_resize",
    [image("input_tensor"), _BOXES],
    "OpenCV warpPerspective",
    fn="crop_and_resize",
    config={"size": (10, 12)},
    peer=warp_peers.between_boxes(_to_corners),
    frames=Frames(peer=warp_peers.between_boxes(_to_corners, True)),
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
    frames=Frames(peer=warped("warpPerspective", "bilinear", "zeros", True)),
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
    peer=warp_peers.between_boxes(_to_boxes),
    frames=Frames(peer=warp_peers.between_boxes(_to_boxes, True)),
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


def _part(x: np.ndarray, box: np.ndarray) -> np.ndarray:
    (left, top), (right, lower) = box[0].tolist(), box[2].tolist()
    return x[top : lower + 1, left : right + 1]


def _padded(np: Any, x: np.ndarray, box: np.ndarray) -> np.ndarray:
    part = _part(x, box)[:9, :11]
    out = np.zeros((9, 11, *x.shape[2:]), x.dtype)
    out[: part.shape[0], : part.shape[1]] = part
    return out


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
            else Peer("numpy", _padded),
            frames=Frames(
                peer=opencv(lambda cv2, x, box: cv2.resize(_part(x, box), (11, 9)), atol=1.0),
                reference="OpenCV resize of NumPy slices",
            )
            if _name == "resize"
            else Frames(PIXELS, peer=Peer("numpy", _padded), reference="NumPy slices"),
            reference="NumPy slices and torch.nn.functional.interpolate",
            picture="warps",
            errors=rejected_words("shape_compensation"),
        ),
        fn="geometry.transform.crop_by_indices",
    )
