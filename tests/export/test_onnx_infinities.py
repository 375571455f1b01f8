"""Infinity stays infinity in ONNX: Clip without a limit has the largest number for one."""

from pathlib import Path

import numpy as np
import pytest
import torch
from torch import Tensor

import chiasm.runtime
from chiasm.export import Spec, TensorSpec, export
from chiasm.export.catalog import catalog


def limited(x: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    return x.clamp(min=0.5), x.clamp(max=0.5), torch.clamp_min(x, -1.0), x.clamp(-1.0, 1.0)


@pytest.mark.parametrize("dtype", ["float32", "float64", "float16"])
def test_limits_of_one_side(dtype: str, tmp_path: Path) -> None:
    outputs = [TensorSpec(f"o{i}") for i in range(4)]
    spec = Spec("test.limited", [TensorSpec("x", ("N",))], outputs, dtypes=(dtype,), gradients=())
    method = chiasm.runtime.open(export(limited, spec, tmp_path, formats=["onnx"])).method(backend="onnx")
    x = np.array([np.inf, -np.inf, np.nan, 0.25, -2.0, 7.0] * 3, dtype)
    expected = np.maximum(x, 0.5), np.minimum(x, 0.5), np.maximum(x, -1), np.clip(x, -1, 1)
    for actual, wanted in zip(method(x), expected, strict=True):
        np.testing.assert_array_equal(actual, wanted)


def areas(box: np.ndarray) -> np.ndarray:
    return (box[..., 2] - box[..., 0]) * (box[..., 3] - box[..., 1])


def kept_by_definition(boxes: np.ndarray, threshold: float) -> np.ndarray:
    """Boxes in the order of their scores, one after the other, by IEEE 754's arithmetic. A box whose second
    corner is before its first is empty."""
    boxes = np.concatenate([boxes[:, :2], np.maximum(boxes[:, :2], boxes[:, 2:])], 1)
    kept = np.ones(len(boxes), bool)
    with np.errstate(invalid="ignore"):
        for i in range(len(boxes)):
            for j in np.flatnonzero(kept[:i]):
                sides = np.minimum(boxes[i, 2:], boxes[j, 2:]) - np.maximum(boxes[i, :2], boxes[j, :2])
                common = np.prod(np.maximum(sides, 0))
                kept[i] &= not common > threshold * (areas(boxes[i]) + areas(boxes[j]) - common)
    return kept


def test_suppression_of_boxes_with_infinite_corners(tmp_path: Path) -> None:
    entry = catalog()["geometry.bbox.nms_fixed"]
    bundle = export(entry.function(), entry.spec, tmp_path, formats=["onnx"], methods=["forward"])
    method = chiasm.runtime.open(bundle).method("forward", backend="onnx", fused=False)
    threshold = entry.spec.config["iou_threshold"]
    rng = np.random.default_rng(0)
    for _ in range(30):
        corner = rng.uniform(0, 50, (40, 2))
        boxes = np.concatenate([corner, corner + rng.uniform(0, 50, (40, 2))], 1).astype(np.float32)
        draw = rng.uniform(size=boxes.shape)
        boxes[draw < 0.3], boxes[draw > 0.7] = np.inf, -np.inf
        scores = np.linspace(1, 0, 40, dtype=np.float32)
        order, kept = method(boxes, scores)
        np.testing.assert_array_equal(order, np.arange(40))
        np.testing.assert_array_equal(kept, kept_by_definition(boxes, threshold))
