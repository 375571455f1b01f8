"""Boxes of detectors, and decoders of networks' boxes."""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import torch
from torch import Generator, Tensor

from ..peer import Peer
from ..spec import Spec, TensorSpec
from . import NO_GRADIENT, add


def torchvision(name: str, *settings: Any) -> Peer:
    def call(ops: Any, *inputs: Any) -> Any:
        return getattr(ops, name)(*inputs, *settings)

    return Peer("torchvision.ops", call, "tensors")


def _boxes(*names: str):
    """Makes boxes of positive size for each input."""

    def sample(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        def some(count: int):
            corner = torch.rand((count, 2), generator=generator, dtype=torch.float64) * 30
            size = 2 + 10 * torch.rand((count, 2), generator=generator, dtype=torch.float64)
            return torch.cat([corner, corner + size], 1).to(dtype)

        counts = [sizes["N"], sizes.get("M", sizes["N"])]
        return {name: some(count) for name, count in zip(names, counts)}

    return sample


_BOXES = TensorSpec("boxes", ("N", 4), description="x1, y1, x2, y2")
_MANY = {"N": (1, 1 << 20)}

for _name, _config, _settings in (
    ("box_area", {}, ()),
    ("box_convert", {"in_fmt": "cxcywh", "out_fmt": "xyxy"}, ("cxcywh", "xyxy")),
    ("clip_boxes_to_image", {"size": (20, 30)}, ((20, 30),)),
):
    add(
        Spec(
            f"ops.{_name}",
            [_BOXES],
            config=_config,
            symbols=_MANY,
            make_inputs=_boxes("boxes"),
            peer=torchvision(_name, *_settings),
            reference=f"torchvision.ops.{_name}",
            picture="tensors",
        )
    )
for _name in ("box_iou", "generalized_box_iou", "distance_box_iou", "complete_box_iou"):
    add(
        Spec(
            f"ops.{_name}",
            [
                TensorSpec("boxes1", ("N", 4), description="x1, y1, x2, y2"),
                TensorSpec("boxes2", ("M", 4), description="x1, y1, x2, y2"),
            ],
            symbols={"N": (1, 1 << 16), "M": (1, 1 << 16)},
            gradients=() if f"ops.{_name}" in NO_GRADIENT else None,
            make_inputs=_boxes("boxes1", "boxes2"),
            peer=torchvision(_name),
            reference=f"torchvision.ops.{_name}",
            picture="tensors",
        )
    )
for _name in ("generalized_box_iou_loss", "distance_box_iou_loss", "complete_box_iou_loss"):
    add(
        Spec(
            f"ops.{_name}",
            [
                TensorSpec("boxes1", ("N", 4), description="x1, y1, x2, y2"),
                TensorSpec("boxes2", ("N", 4), description="the targets"),
            ],
            config={"reduction": "none"},
            gradients=() if f"ops.{_name}" in NO_GRADIENT else None,
            symbols=_MANY,
            make_inputs=_boxes("boxes1", "boxes2"),
            peer=torchvision(_name, "none"),
            reference=f"torchvision.ops.{_name}",
            picture="tensors",
        )
    )


def clusters(generator: Generator, sizes: dict[str, int]):
    """Boxes clustered around a third as many places, as centre, width and height."""
    batch, count = sizes["B"], sizes["N"]
    places = 100 * torch.rand((batch, count // 3 + 1, 2), generator=generator, dtype=torch.float64)
    centres = places.repeat_interleave(3, 1)[:, :count]
    return torch.cat([centres, 8 + 16 * torch.rand((batch, count, 2), generator=generator)], 2)


def _corners(centred: Tensor) -> Tensor:
    centre, half = centred[..., :2], centred[..., 2:] / 2
    return torch.cat([centre - half, centre + half], -1)


def scored(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    corners = _corners(clusters(generator, sizes))
    shape = (sizes["B"], sizes["N"])
    return {
        "boxes": corners.to(dtype),
        "scores": torch.rand(shape, generator=generator).to(dtype),
        "idxs": torch.randint(0, 3, shape, generator=generator),
    }


def in_slots(parts: Sequence[Tensor], slots: int) -> tuple[Tensor, ...]:
    """An image's results in slots, with zeros after the last, and which slots hold one."""
    found = torch.arange(slots) < len(parts[0])
    return (*(torch.cat([p, p.new_zeros((slots - len(p), *p.shape[1:]))]) for p in parts), found)


def _suppressed(ops: Any, boxes: Tensor, scores: Tensor, idxs: Tensor) -> tuple[Tensor, ...]:
    made: list[Tensor] = []
    for b, s, i in zip(boxes, scores, idxs, strict=True):
        order = ops.batched_nms(b, s, i, 0.45)
        made.append(order[s[order] > 0.25][:300])
    return tuple(made)


def _stacked(each: Sequence[Tensor]) -> tuple[Tensor, ...]:
    slots = [in_slots([indices], 300) for indices in each]
    return tuple(torch.stack(part) for part in zip(*slots, strict=True))


add(
    Spec(
        "ops.batched_nms_fixed",
        [
            TensorSpec("boxes", ("B", "N", 4), description="x1, y1, x2, y2"),
            TensorSpec("scores", ("B", "N"), range=(0.0, 1.0), description="scores"),
            TensorSpec("idxs", ("B", "N"), "int64", description="classes"),
        ],
        [
            TensorSpec("indices", description="of the boxes kept, by falling score"),
            TensorSpec("kept", description="which slots hold a box"),
        ],
        config={"iou_threshold": 0.45, "max_output": 300, "score_threshold": 0.25},
        symbols={"B": (1, 64), "N": (1, 1 << 14)},  # except in native code, all pairs are compared
        gradients=(),
        make_inputs=scored,
        peer=Peer("torchvision.ops", _suppressed, "tensors", after=_stacked),
        reference="torchvision.ops.batched_nms",
        picture="tensors",
    )
)

_DETECTIONS = [
    TensorSpec("boxes", description="x1, y1, x2, y2 in pixels of the input"),
    TensorSpec("scores", description="by falling score"),
    TensorSpec("labels", description="classes"),
    TensorSpec("found", description="which slots hold an object"),
]


def _yolo(places_last: bool):
    def sample(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        boxes = clusters(generator, sizes)
        scores = torch.rand((sizes["B"], sizes["N"], sizes["C"] - 4), generator=generator) ** 2
        output = torch.cat([boxes, scores], 2).to(dtype)
        return {"output": output.transpose(1, 2) if places_last else output}

    return sample


# At least two classes: the graph for a single class differs.
for _name, _shape, _least in (("yolov8", ("B", "C", "N"), 6), ("yolov5", ("B", "N", "C"), 7)):
    add(
        Spec(
            f"ops.decode_{_name}",
            [TensorSpec("output", _shape, description="of the network")],
            _DETECTIONS,
            symbols={"B": (1, 256), "N": (1000, 1 << 16), "C": (_least, 1024)},
            gradients=(),
            make_inputs=_yolo(places_last=_name == "yolov8"),
            reference="torchvision.ops.batched_nms of NumPy's scores",
            picture="tensors",
        )
    )
add(
    Spec(
        "ops.decode_detr",
        [
            TensorSpec("logits", ("B", "N", "C"), range=(-3.0, 3.0), description="of classes for each query"),
            TensorSpec(
                "pred_boxes", ("B", "N", 4), range=(0.1, 0.9), description="centre and size, in [0, 1]"
            ),
        ],
        _DETECTIONS,
        config={"size": (640, 640)},
        symbols={"B": (1, 256), "N": (300, 1 << 16), "C": (1, 1024)},
        gradients=(),
        reference="NumPy argsort",
        picture="tensors",
    )
)


def _anchored(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    batch, count = sizes["B"], sizes["N"]
    anchors = _corners(clusters(generator, {"B": 1, "N": count})[0])
    logits = torch.randn((batch, count, sizes["C"]), generator=generator, dtype=torch.float64)
    deltas = torch.randn((batch, count, 4), generator=generator, dtype=torch.float64)
    made = {"logits": 2 * logits, "deltas": deltas, "anchors": anchors}
    return {name: each.to(dtype) for name, each in made.items()}


def _torchvisions_ssd(ssd: Any, logits: Any, deltas: Any, anchors: Any):
    # Only the method, with settings, because the class also needs a network.
    settings = SimpleNamespace(
        box_coder=ssd.det_utils.BoxCoder((10.0, 10.0, 5.0, 5.0)),
        score_thresh=0.01,
        nms_thresh=0.45,
        detections_per_img=200,
        topk_candidates=400,
    )
    outputs = {"cls_logits": logits, "bbox_regression": deltas}
    count = len(logits)
    return ssd.SSD.postprocess_detections(settings, outputs, [anchors] * count, [(300, 300)] * count)


def _in_slots(found: Sequence[dict[str, Tensor]]) -> tuple[Tensor, ...]:
    """torchvision's detections of each image, in 200 slots."""
    slots = [in_slots([each[name] for name in ("boxes", "scores", "labels")], 200) for each in found]
    return tuple(torch.stack(part) for part in zip(*slots, strict=True))


add(
    Spec(
        "ops.decode_ssd",
        [
            TensorSpec("logits", ("B", "N", "C"), description="of classes, the background first"),
            TensorSpec("deltas", ("B", "N", 4), description="of boxes, against anchors"),
            TensorSpec("anchors", ("N", 4), description="x1, y1, x2, y2 in pixels"),
        ],
        _DETECTIONS,
        config={"size": (300, 300)},
        symbols={"B": (1, 256), "N": (1000, 1 << 16), "C": (3, 1024)},
        gradients=(),
        make_inputs=_anchored,
        # With another number of classes, other candidates would be dropped.
        peer=Peer(
            "torchvision.models.detection.ssd",
            _torchvisions_ssd,
            "tensors",
            share=1e-3,  # scores that differ in the last digit only change places
            after=_in_slots,
            sizes={"C": 6},
        ),
        reference="torchvision.models.detection.ssd",
        picture="tensors",
    )
)
