"""Regions of images, masks, rotated boxes, soft suppression, deformable convolution."""

from collections.abc import Sequence
from functools import partial

import torch
from torch import Generator, Tensor

from ..peer import Peer
from ..spec import Spec, TensorSpec, image, like
from . import ZERO_WEIGHTS, add
from .ops import scored, torchvision


def _regions(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> Tensor:
    """Boxes that extend beyond images."""
    count = sizes["N"]
    corner = torch.rand((count, 2), generator=generator, dtype=torch.float64) * 30 - 5
    extent = 2 + 20 * torch.rand((count, 2), generator=generator, dtype=torch.float64)
    image = torch.randint(0, sizes["B"], (count, 1), generator=generator)
    return torch.cat([image, corner, corner + extent], 1).to(dtype)


def _with_regions(
    generator: Generator, sizes: dict[str, int], dtype: torch.dtype, channels: int | None = None
) -> dict[str, Tensor]:
    shape = (sizes["B"], channels or sizes["C"], sizes["H"], sizes["W"])
    image = torch.randn(shape, generator=generator, dtype=torch.float64).to(dtype)
    return {"input": image, "boxes": _regions(generator, sizes, dtype)}


_REGIONS = TensorSpec("boxes", ("N", 5), description="image number, x1, y1, x2, y2")
_POOLED = [TensorSpec("output", description="a row and a column for each bin")]
_REGION_SYMBOLS = {"B": (1, 64), "N": (1, 1 << 14)}

add(
    Spec(
        "ops.roi_align",
        [image(), _REGIONS],
        _POOLED,
        config={"output_size": (7, 5), "spatial_scale": 0.5, "sampling_ratio": 2, "aligned": True},
        also=({"sampling_ratio": -1}, {"sampling_ratio": 3, "aligned": False}),
        symbols=_REGION_SYMBOLS,
        gradients=("input",),
        make_inputs=_with_regions,
        peer=torchvision("roi_align", (7, 5), 0.5, 2, True),
        reference="torchvision.ops.roi_align",
        picture="tensors",
    )
)
add(
    Spec(
        "ops.roi_pool",
        [image(), _REGIONS],
        _POOLED,
        config={"output_size": (7, 5), "spatial_scale": 0.5},
        symbols=_REGION_SYMBOLS,
        gradients=("input",),
        make_inputs=_with_regions,
        special_values="ONNX Runtime passes NaN over in maxima",
        peer=torchvision("roi_pool", (7, 5), 0.5),
        reference="torchvision.ops.roi_pool",
        picture="tensors",
    )
)
for _name, _config, _settings, _also in (
    ("ps_roi_align", {"sampling_ratio": 2}, (2,), ({"sampling_ratio": -1},)),
    ("ps_roi_pool", {}, (), ()),
):
    add(
        Spec(
            f"ops.{_name}",
            # A fixed number of channels: for a symbol, no exporter knows that it is a multiple of the bins.
            [image(channels=18), _REGIONS],
            _POOLED,
            config={"output_size": (3, 3), "spatial_scale": 0.5, **_config},
            also=_also,
            symbols=_REGION_SYMBOLS,
            gradients=("input",),
            make_inputs=partial(_with_regions, channels=18),
            peer=torchvision(_name, (3, 3), 0.5, *_settings),
            reference=f"torchvision.ops.{_name}",
            picture="tensors",
        )
    )


def _filled_masks(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Masks of which none is empty, because torchvision rejects empty ones."""
    masks = torch.rand((sizes["N"], sizes["H"], sizes["W"]), generator=generator) < 0.05
    masks[:, sizes["H"] // 2, sizes["W"] // 2] = True
    return {"masks": masks}


def _shapes(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Shapes of some pixels, with holes, and noise in the last mask."""
    size = (sizes["N"], 1, sizes["H"], sizes["W"])
    noise = torch.rand(size, generator=generator, dtype=torch.float64)
    smooth = torch.nn.functional.avg_pool2d(noise, 3, 1, 1, count_include_pad=False)
    smooth[-1:] = noise[-1:]
    return {"masks": smooth[:, 0] > 0.5}


def _prototypes(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    batch, count = sizes["B"], sizes["N"]

    def normal(*shape: int):
        return torch.randn(shape, generator=generator, dtype=torch.float64).to(dtype)

    boxes = _regions(generator, {"B": 1, "N": batch * count}, dtype)[:, 1:]
    return {
        "prototypes": normal(batch, sizes["P"], sizes["H"], sizes["W"]),
        "coefficients": normal(batch, count, sizes["P"]),
        "boxes": boxes.unflatten(0, [batch, count]),
        "like": torch.zeros(sizes["OH"], sizes["OW"], dtype=torch.uint8),
    }


def _pasted(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    masks = torch.rand((sizes["N"], 1, sizes["H"], sizes["W"]), generator=generator, dtype=torch.float64)
    return {
        "masks": masks.to(dtype),
        "boxes": _regions(generator, {"B": 1, "N": sizes["N"]}, dtype)[:, 1:],
        "like": torch.zeros(sizes["OH"], sizes["OW"], dtype=torch.uint8),
    }


add(
    Spec(
        "ops.masks_to_boxes",
        [TensorSpec("masks", ("N", "H", "W"), "bool", description="of instances")],
        [TensorSpec("boxes", description="x1, y1, x2, y2")],
        symbols={"N": (1, 1 << 20)},
        gradients=(),
        make_inputs=_filled_masks,
        peer=torchvision("masks_to_boxes"),
        reference="torchvision.ops.masks_to_boxes",
        picture="tensors",
    )
)
add(
    Spec(
        "ops.masks_to_polygons",
        [TensorSpec("masks", ("N", "H", "W"), "bool", description="of instances")],
        [
            TensorSpec("points", description="x, y"),
            TensorSpec("counts", description="of points in each polygon"),
            TensorSpec("holes", description="which polygons are around holes"),
        ],
        config={"max_polygons": 8, "max_points": 64},
        also=({"max_polygons": 3, "max_points": 7},),
        symbols={"N": (1, 1 << 12)},
        gradients=(),
        make_inputs=_shapes,
        reference="cv2.findContours",
        picture="tensors",
    )
)
add(
    Spec(
        "ops.masks_from_prototypes",
        [
            TensorSpec("prototypes", ("B", "P", "H", "W"), description="of an image"),
            TensorSpec("coefficients", ("B", "N", "P"), description="of each detection"),
            TensorSpec("boxes", ("B", "N", 4), description="x1, y1, x2, y2 in pixels of the result"),
            like("size"),
        ],
        [TensorSpec("masks", description="0 to 1, 0 outside of the boxes")],
        symbols={"B": (1, 64), "N": (1, 1 << 12), "P": (2, 256), "OH": (1, 32768), "OW": (1, 32768)},
        gradients=("prototypes", "coefficients"),
        make_inputs=_prototypes,
        special_values="sums of infinities are NaN or are not, by their order",
        reference="NumPy and torch.nn.functional.interpolate",
        picture="tensors",
    )
)
add(
    Spec(
        "ops.paste_masks",
        [
            TensorSpec("masks", ("N", 1, "H", "W"), description="each of its box"),
            TensorSpec("boxes", ("N", 4), description="x1, y1, x2, y2 in pixels of the image"),
            like("size"),
        ],
        symbols={"N": (1, 1 << 12), "OH": (1, 32768), "OW": (1, 32768)},
        make_inputs=_pasted,
        reference="torch.nn.functional.grid_sample",
        picture="tensors",
    )
)


def _scored_boxes(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    made = scored(generator, sizes, dtype)
    return {"boxes": made["boxes"], "scores": made["scores"]}


add(
    Spec(
        "ops.soft_nms",
        [
            TensorSpec("boxes", ("B", "N", 4), description="x1, y1, x2, y2"),
            TensorSpec("scores", ("B", "N"), range=(0.0, 1.0), description="scores"),
        ],
        [
            TensorSpec("indices", description="of the boxes kept, by falling score"),
            TensorSpec("scores_left", description="what is left of their scores"),
            TensorSpec("kept", description="which slots hold a box"),
        ],
        config={"max_output": 50},
        also=({"method": "linear"},),
        symbols={"B": (1, 64), "N": (1, 1 << 16)},
        gradients=(),
        make_inputs=_scored_boxes,
        reference="a loop in NumPy, and cv2.dnn.softNMSBoxes",
        picture="tensors",
    )
)


def _rotated(generator: Generator, shape: Sequence[int]):
    """Boxes cx, cy, width, height, angle, float64."""
    low = torch.tensor([0.0, 0.0, 4.0, 4.0, -180.0], dtype=torch.float64)
    range = torch.tensor([30.0, 30.0, 20.0, 20.0, 360.0], dtype=torch.float64)
    return low + range * torch.rand((*shape, 5), generator=generator, dtype=torch.float64)


def _rotated_pairs(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    return {
        "boxes1": _rotated(generator, (sizes["N"],)).to(dtype),
        "boxes2": _rotated(generator, (sizes["M"],)).to(dtype),
    }


def _rotated_scored(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    shape = (sizes["B"], sizes["N"])
    return {
        "boxes": _rotated(generator, shape).to(dtype),
        "scores": torch.rand(shape, generator=generator).to(dtype),
        "idxs": torch.randint(0, 3, shape, generator=generator),
    }


add(
    Spec(
        "ops.rotated_iou",
        [
            TensorSpec("boxes1", ("N", 5), description="cx, cy, width, height, angle in degrees"),
            TensorSpec("boxes2", ("M", 5), description="cx, cy, width, height, angle in degrees"),
        ],
        symbols={"N": (1, 1 << 14), "M": (1, 1 << 14)},
        make_inputs=_rotated_pairs,
        reference="scipy.spatial.HalfspaceIntersection, and cv2.rotatedRectangleIntersection",
        picture="tensors",
    )
)
add(
    Spec(
        "ops.rotated_nms_fixed",
        [
            TensorSpec("boxes", ("B", "N", 5), description="cx, cy, width, height, angle in degrees"),
            TensorSpec("scores", ("B", "N"), range=(0.0, 1.0), description="scores"),
            TensorSpec("idxs", ("B", "N"), "int64", description="classes"),
        ],
        [
            TensorSpec("indices", description="of the boxes kept, by falling score"),
            TensorSpec("kept", description="which slots hold a box"),
        ],
        config={"iou_threshold": 0.3, "max_output": 50, "score_threshold": 0.25},
        symbols={"B": (1, 64), "N": (1, 1 << 16)},
        gradients=(),
        make_inputs=_rotated_scored,
        reference="cv2.dnn.NMSBoxesRotated",
        picture="tensors",
    )
)


def _deformed(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    def normal(*shape: int):
        return torch.randn(shape, generator=generator, dtype=torch.float64).to(dtype)

    batch, height, width = sizes["B"], sizes["H"], sizes["W"]
    return {
        "input": normal(batch, 4, height, width),
        "offset": 2 * normal(batch, 36, height, width),
        "weight": normal(6, 2, 3, 3),
        "bias": normal(6),
        "mask": torch.sigmoid(normal(batch, 18, height, width)),
    }


add(
    Spec(
        "ops.deform_conv2d",
        [
            image(channels=4),
            TensorSpec("offset", ("B", 36, "H", "W"), description="rows and columns that taps are moved by"),
            TensorSpec("weight", (6, 2, 3, 3), description="of the taps"),
            TensorSpec("bias", (6,), description="is added"),
            TensorSpec("mask", ("B", 18, "H", "W"), description="what each tap is multiplied by"),
        ],
        [TensorSpec("output", layout="NCHW")],
        config={"padding": (1, 1)},
        make_inputs=_deformed,
        special_values=ZERO_WEIGHTS,
        peer=Peer(
            "torchvision.ops",
            lambda ops, x, offset, weight, bias, mask: ops.deform_conv2d(
                x, offset, weight, bias, padding=(1, 1), mask=mask
            ),
            "tensors",
            atol=2e-5,
            rtol=1e-4,
        ),
        reference="torchvision.ops.deform_conv2d",
        picture="tensors",
    )
)
