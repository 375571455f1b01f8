"""Metrics: errors of results against the truth."""

import math
from dataclasses import replace

import numpy as np
import torch
from torch import Generator, Tensor

from ..peer import Peer
from ..spec import Spec, TensorSpec
from . import add, rejected
from .metrics import mean
from .ops import torchvision
from .rigid import linalg, scipys, uniform

_DOUBLE = torch.float64


def _whole(generator: Generator, low: int, high: int, *shape: int) -> Tensor:
    """Integers, including low and high."""
    return torch.randint(low, high + 1, shape, generator=generator)


# --- classes ------------------------------------------------------------------------------------------------


def _make_accuracy(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    batch, classes = sizes["B"], sizes["C"]
    # one in eight scores is a tie, and some labels are outside the classes
    scores = torch.floor(uniform(generator, 0, 8, batch, classes)) / 8
    return {"pred": scores.to(dtype), "target": _whole(generator, -1, classes, batch)}


add(
    Spec(
        "metrics.accuracy",
        [
            TensorSpec("pred", ("B", "C"), description="a score for each class"),
            TensorSpec("target", ("B",), "int64", description="true classes"),
        ],
        [TensorSpec("percentages", description="one for each k")],
        config={"topk": [1, 3]},
        gradients=(),
        make_inputs=_make_accuracy,
        reference="scikit-learn top_k_accuracy_score, torchmetrics accuracy",
        picture="ranking",
    )
)

_LABELS = [
    TensorSpec(
        name,
        ("B", "H", "W"),
        "int64",
        range=(-1, 6),
        description=f"{what} classes; those that are none of 0 to 5 are not counted",
    )
    for name, what in (("pred", "found"), ("target", "true"))
]


def _confused(normalize: str | None) -> Peer:
    return Peer(
        "sklearn.metrics",
        lambda metrics, pred, target: metrics.confusion_matrix(
            target, pred, labels=range(6), normalize=normalize
        ),
        "samples",
        before=lambda pred, target: (pred.ravel(), target.ravel()),
        timed=False,
    )


_MATRIX = "row i, column j: how often i is taken for j"
_SCIKIT = "scikit-learn confusion_matrix, torchmetrics"

add(
    Spec(
        "metrics.confusion_matrix.counts",
        _LABELS,
        [TensorSpec("counts", description=_MATRIX)],
        {"num_classes": 6},
        peer=_confused(None),
        reference=_SCIKIT,
        picture="confusion matrix",
    ),
    fn="metrics.confusion_matrix",
)
add(
    Spec(
        "metrics.confusion_matrix.normalized",
        _LABELS,
        [TensorSpec("shares", description=f"{_MATRIX}, as part of how often j is found")],
        {"num_classes": 6, "normalized": True},
        peer=_confused("pred"),
        reference=_SCIKIT,
        picture="confusion matrix",
    ),
    fn="metrics.confusion_matrix",
)


def _counted(*labels: np.ndarray) -> tuple[np.ndarray, ...]:
    """The pixels where both labels are classes."""
    known = np.all([(x >= 0) & (x < 6) for x in labels], 0)
    return tuple(x[known] for x in labels)


add(
    Spec(
        "metrics.mean_iou",
        _LABELS,
        [TensorSpec("iou", description="of each class")],
        {"num_classes": 6},
        peer=Peer(
            "sklearn.metrics",
            lambda metrics, pred, target: metrics.jaccard_score(
                target, pred, labels=range(6), average=None, zero_division=1
            ),
            "samples",
            before=_counted,
            timed=False,
        ),
        reference="scikit-learn jaccard_score, torchmetrics",
        picture="values of classes",
        errors=rejected("eps", "a positive number", math.nan),
    )
)

# --- boxes --------------------------------------------------------------------------------------------------


def _boxes(generator: Generator, *shape: int):
    corner = uniform(generator, 0, 10, *shape, 2)
    return torch.cat([corner, corner + uniform(generator, 1, 8, *shape, 2)], -1)


def _make_boxes(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    return {
        "boxes_1": _boxes(generator, sizes["N"]).to(dtype),
        "boxes_2": _boxes(generator, sizes["M"]).to(dtype),
    }


add(
    Spec(
        "metrics.mean_iou_bbox",
        [
            TensorSpec("boxes_1", ("N", 4), description="x1, y1, x2, y2"),
            TensorSpec("boxes_2", ("M", 4), description="x1, y1, x2, y2"),
        ],
        [TensorSpec("iou", description="of each of one with each of the other")],
        symbols={"N": (1, 1 << 15), "M": (1, 1 << 15)},
        make_inputs=_make_boxes,
        peer=torchvision("box_iou"),
        reference="areas of polygons by OpenCV",
        picture="overlaps",
    )
)


def _make_detections(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Three of four true boxes are detected, slightly displaced; the other boxes are not, and the other
    detections are elsewhere."""
    batch, found, there = sizes["B"], sizes["N"], sizes["M"]
    gt_boxes, gt_labels = _boxes(generator, batch, there), _whole(generator, 0, 4, batch, there)
    pred_boxes, pred_labels = _boxes(generator, batch, found), _whole(generator, 0, 4, batch, found)
    both = min(found, there) * 3 // 4
    pred_boxes[:, :both] = gt_boxes[:, :both] + uniform(generator, -1, 1, batch, both, 4)
    pred_labels[:, :both] = gt_labels[:, :both]
    return {
        "pred_boxes": pred_boxes.to(dtype),
        "pred_labels": pred_labels,
        "pred_scores": uniform(generator, 0, 1, batch, found).to(dtype),
        "gt_boxes": gt_boxes.to(dtype),
        "gt_labels": gt_labels,
        "pred_mask": uniform(generator, 0, 1, batch, found) < 0.8,
        "gt_mask": uniform(generator, 0, 1, batch, there) < 0.8,
    }


_DETECTED = [
    TensorSpec("pred_boxes", ("B", "N", 4), description="x1, y1, x2, y2 of what is detected"),
    TensorSpec("pred_labels", ("B", "N"), "int64", description="its classes; 0 makes a box void"),
    TensorSpec("pred_scores", ("B", "N"), description="how sure each is"),
    TensorSpec("gt_boxes", ("B", "M", 4), description="x1, y1, x2, y2 of what is there"),
    TensorSpec("gt_labels", ("B", "M"), "int64", description="its classes; 0 makes a box void"),
]
_MASKS = [
    TensorSpec("pred_mask", ("B", "N"), "bool", description="which detections there are"),
    TensorSpec("gt_mask", ("B", "M"), "bool", description="which true boxes there are"),
]
for _variant, _inputs in (("labels", _DETECTED), ("masks", _DETECTED + _MASKS)):
    add(
        Spec(
            f"metrics.mean_average_precision.{_variant}",
            _inputs,
            [
                TensorSpec("mean", description="over the classes"),
                TensorSpec("precisions", description="average precision of the classes 1 to 4"),
            ],
            config={"n_classes": 5},
            symbols={"N": (1, 4096), "M": (1, 4096)},
            gradients=(),
            make_inputs=_make_detections,
            reference="the rules of Pascal VOC as a loop in NumPy; scikit-learn precision_recall_curve",
            picture="detections",
        ),
        fn="metrics.mean_average_precision",
    )

# --- flow and disparity -------------------------------------------------------------------------------------

_DISTANCE = Peer("torch.nn.functional", lambda F, x, y: F.pairwise_distance(x, y, eps=0.0), "tensors")
add(
    Spec(
        "metrics.aepe",
        [
            TensorSpec(name, ("B", "H", "W", 2), range=(-8.0, 8.0), description=f"{what} flow, in pixels")
            for name, what in (("input", "found"), ("target", "true"))
        ],
        [TensorSpec("error", description="in pixels")],
        peer=replace(_DISTANCE, after=mean),
        reference="torch.nn.functional.pairwise_distance",
        picture="comparison",
    )
)

_DISPARITIES = [
    TensorSpec("input", ("B", 1, "H", "W"), layout="NCHW", range=(0.0, 80.0), description="disparity found"),
    TensorSpec("target", ("B", 1, "H", "W"), layout="NCHW", range=(0.0, 80.0), description="true disparity"),
    TensorSpec(
        "valid_mask", ("B", 1, "H", "W"), "bool", layout="NCHW", description="where the true one is known"
    ),
]


def _of_known(found: np.ndarray, true: np.ndarray, valid: np.ndarray) -> tuple[np.ndarray, ...]:
    return found[valid], true[valid]


for _kind in ("mean_absolute", "root_mean_squared"):
    _scikits = f"{_kind}_error"
    add(
        Spec(
            f"metrics.{_kind}_disparity_error",
            _DISPARITIES,
            [TensorSpec("error", description="in pixels")],
            peer=Peer(
                "sklearn.metrics",
                lambda metrics, x, y, scikits=_scikits: getattr(metrics, scikits)(y, x),
                "batch",
                before=_of_known,
                timed=False,
            ),
            reference=f"scikit-learn {_scikits}",
            picture="comparison",
        )
    )
for _name in ("mean_bad_pixel_error", "kitti_d1_error"):
    _share = TensorSpec("share", description="of the pixels that are bad")
    add(
        Spec(
            f"metrics.{_name}",
            _DISPARITIES,
            [_share],
            gradients=(),
            reference="a loop in Python",
            picture="comparison",
        )
    )

# --- poses --------------------------------------------------------------------------------------------------


def _rotations(generator: Generator, count: int) -> Tensor:
    q, r = linalg.qr(torch.randn((count, 3, 3), generator=generator, dtype=_DOUBLE))
    q = q * torch.sign(torch.diagonal(r, dim1=1, dim2=2))[:, None]
    return (q * linalg.det(q)[:, None, None]).contiguous()  # LAPACK writes columns


def _make_rotations(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    return {name: _rotations(generator, sizes["B"]).to(dtype) for name in ("R1", "R2")}


def _make_poses(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    def pose():
        return torch.cat(
            [_rotations(generator, sizes["B"]), uniform(generator, -1, 1, sizes["B"], 3, 1)], 2
        ).to(dtype)

    return {"P": pose(), "P_gt": pose()}


add(
    Spec(
        "metrics.angle_error_mat",
        [
            TensorSpec("R1", ("B", 3, 3), description="rotations found"),
            TensorSpec("R2", ("B", 3, 3), description="true ones"),
        ],
        [TensorSpec("angle", description="in degrees")],
        make_inputs=_make_rotations,
        peer=scipys(
            lambda transform, r1, r2: (
                transform.Rotation.from_matrix(r1).inv() * transform.Rotation.from_matrix(r2)
            ).magnitude(),
            after=np.rad2deg,
        ),
        reference="SciPy Rotation.magnitude",
        picture="pose errors",
    )
)
add(
    Spec(
        "metrics.angle_error_vec",
        [
            TensorSpec(name, ("B", 3), range=(-1.0, 1.0), description=f"vectors {what}")
            for name, what in (("v1", "found"), ("v2", "that are true"))
        ],
        [TensorSpec("angle", description="in degrees")],
        reference="angles that vectors are made of",
        picture="pose errors",
    )
)
add(
    Spec(
        "metrics.pose_errors",
        [
            TensorSpec("P", ("B", 3, 4), description="poses [R | t] found"),
            TensorSpec("P_gt", ("B", 3, 4), description="true ones"),
        ],
        [
            TensorSpec("rotation", description="in degrees"),
            TensorSpec("translation", description="in degrees, up to sign"),
        ],
        make_inputs=_make_poses,
        reference="SciPy Rotation.magnitude, NumPy arccos",
        picture="pose errors",
    )
)
add(
    Spec(
        "metrics.translation_ate",
        [
            TensorSpec(name, ("B", 3), range=(-5.0, 5.0), description=f"{what} positions")
            for name, what in (("t", "found"), ("t_gt", "true"))
        ],
        [TensorSpec("distance")],
        peer=_DISTANCE,
        reference="torch.nn.functional.pairwise_distance",
        picture="drift",
    )
)
add(
    Spec(
        "metrics.auc_from_errors",
        [TensorSpec("errors", ("N",), range=(0.0, 15.0), description="an error for each pose")],
        [TensorSpec("areas", description="one for each threshold, in parts of it")],
        config={"thresholds": [1.0, 3.0, 5.0, 10.0]},
        reference="scikit-learn auc of the curve",
        picture="areas under a curve",
    )
)
