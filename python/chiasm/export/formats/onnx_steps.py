"""Nodes that take the place of one node in an ONNX model."""

from __future__ import annotations

from typing import Any

import numpy as np
import onnx_ir
from onnx_ir import convenience


class Steps:
    """Adds nodes, and gives their values new names."""

    def __init__(self, name: str) -> None:
        self.name, self.nodes = name, list[onnx_ir.Node]()

    def __call__(
        self, op: str, *inputs: onnx_ir.Value, outputs: int = 1, **attributes: int | str | onnx_ir.Tensor[Any]
    ) -> onnx_ir.Value:
        """The first of the node's outputs."""
        node = onnx_ir.node(op, inputs, attributes=attributes, num_outputs=outputs)
        for i, output in enumerate(node.outputs):
            output.name = f"{self.name}_{len(self.nodes)}{'_' * i}"
        self.nodes.append(node)
        return node.outputs[0]

    def numbers(self, *values: int) -> onnx_ir.Value:
        return self("Constant", value=onnx_ir.Tensor(np.array(values, np.int64)))

    def replace(self, node: onnx_ir.Node, result: onnx_ir.Value) -> None:
        """Put the nodes in the place of `node`, and `result` in the place of its output."""
        assert node.graph is not None
        output = node.outputs[0]
        result.type, result.shape = output.type, output.shape
        node.graph.insert_before(node, self.nodes)
        convenience.replace_all_uses_with(output, result, replace_graph_outputs=True)
        node.graph.remove(node, safe=True)
        result.name, output.name = output.name, None  # an output of the graph keeps its name
