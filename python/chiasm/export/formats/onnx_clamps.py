"""Limits of one side.

ONNX Runtime's Clip replaces a limit that is left out by the dtype's largest finite number, so that infinity
becomes that number.
"""

from __future__ import annotations

import numpy as np
import onnx_ir


def keep_infinities(model: onnx_ir.Model) -> None:
    """Give each Clip of floating-point numbers both limits, infinity instead of one that is left out."""
    for node in list(model.graph.all_nodes()):
        if node.op_type != "Clip" or node.inputs[0] is None:
            continue
        dtype, given = node.inputs[0].dtype, [*node.inputs[1:], None, None][:2]
        if dtype is None or not dtype.is_floating_point():
            continue
        node.resize_inputs(3)
        for i, limit in enumerate((-np.inf, np.inf)):
            if given[i] is not None:
                continue
            value = onnx_ir.Tensor(np.array(limit, dtype.numpy()))
            constant = onnx_ir.node("Constant", [], attributes={"value": value})
            constant.outputs[0].name = f"{node.outputs[0].name}_{'lower' if i == 0 else 'upper'}"
            assert node.graph is not None
            node.graph.insert_before(node, [constant])
            node.replace_input_with(1 + i, constant.outputs[0])
