"""Sums by index, in one order.

ONNX Runtime's ScatterND adds values with the same index from several threads without a lock, so that a sum
sometimes lacks a term (its issues 18048 and 23396); its ScatterElements adds one value after the other.
"""

from __future__ import annotations

import numpy as np
import onnx_ir

from .onnx_steps import Steps


def add_in_order(model: onnx_ir.Model) -> None:
    """Replace each ScatterND that adds by a ScatterElements over its indexed dimensions, flattened to one."""
    for node in list(model.graph.all_nodes()):
        reduction = node.attributes.get("reduction")
        if node.op_type != "ScatterND" or reduction is None or reduction.as_string() != "add":
            continue
        data, indices, updates = node.inputs
        assert node.graph is not None and data is not None and indices is not None and updates is not None
        count = indices.shape[-1] if indices.shape is not None else None
        if not isinstance(count, int):
            raise ValueError(f"ScatterND of {indices.name}: how many dimensions it indexes is not known")
        steps = Steps(node.outputs[0].name or "scattered")
        steps.replace(node, _scattered(steps, data, indices, updates, count))


def _scattered(
    step: Steps, data: onnx_ir.Value, indices: onnx_ir.Value, updates: onnx_ir.Value, count: int
) -> onnx_ir.Value:
    """The result of ScatterND by ONNX's definition: `updates` belong to the first `count` dimensions of
    `data`."""
    zero, rest = step.numbers(0), step.numbers(-1)
    shape = step("Shape", data)
    place = step("Gather", indices, zero, axis=-1)
    outside: onnx_ir.Value | None = None
    for k in range(count if count > 1 else 0):  # a single index is checked as it is
        size = step("Slice", shape, step.numbers(k), step.numbers(k + 1))
        index = step("Gather", indices, step.numbers(k), axis=-1)
        index = step("Where", step("Less", index, zero), step("Add", index, size), index)
        place = index if outside is None else step("Add", step("Mul", place, size), index)
        wrong = step("Or", step("Less", index, zero), step("GreaterOrEqual", index, size))
        outside = wrong if outside is None else step("Or", outside, wrong)
    if outside is not None:  # it may be in range after flattening
        place = step("Where", outside, step.numbers(np.iinfo(np.int64).min), place)
    indexed = step("ReduceProd", step("Slice", shape, zero, step.numbers(count)), keepdims=1)
    rows = step("Reshape", data, step("Concat", indexed, rest, axis=0))
    width = step("Slice", step("Shape", rows), step.numbers(1), step.numbers(2))
    added = step("Reshape", updates, step("Concat", rest, width, axis=0))
    place = step("Expand", step("Reshape", place, step.numbers(-1, 1)), step("Shape", added))
    return step("Reshape", step("ScatterElements", rows, place, added, axis=0, reduction="add"), shape)
