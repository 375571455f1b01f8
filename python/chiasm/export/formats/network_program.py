"""A network's program that is being rewritten, and the values of its parameters."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import torch
from torch import Tensor
from torch._subclasses.fake_tensor import FakeTensor
from torch.export import ExportedProgram
from torch.export.graph_signature import InputKind, InputSpec, TensorArgument
from torch.fx import Node, map_arg

from ..internals import is_operator, schema_of
from .network_forms import call

#: Outputs in a panel of packed weights (kPanel in runtime/artifact/kernels/products.h).
PANEL = 16


class NetworkProgram:
    """A program, with parameters added and removed."""

    def __init__(self, program: ExportedProgram) -> None:
        self.program, self.graph = program, program.graph
        specs = program.graph_signature.input_specs
        self.values = {
            spec.arg.name: tensor
            for spec in specs
            if spec.target is not None
            and isinstance(tensor := {**program.constants, **program.state_dict}.get(spec.target), Tensor)
        }
        self.added = 0

    def value(self, node: Any) -> Tensor | None:
        """The value of a node that has an element type of the kernels, if it is a parameter or computed from
        parameters alone."""
        found = self._known(node) if isinstance(node, Node) else None
        return found.detach() if found is not None and found.dtype in (torch.float32, torch.float64) else None

    def _known(self, node: Node) -> Any:
        """The value of a node, or None."""
        if node.op == "call_function" and node.name not in self.values:
            arguments = {source: self._known(source) for source in node.all_input_nodes}
            pure = is_operator(node.target) and not schema_of(node.target).is_mutable
            if pure and arguments and all(value is not None for value in arguments.values()):
                given, named = map_arg((node.args, node.kwargs), arguments.__getitem__)
                with torch.no_grad():
                    self.values[node.name] = cast("Callable[..., Any]", node.target)(*given, **named)
        return self.values.get(node.name)

    def call(self, target: Callable[..., Any], *arguments: Any) -> Node:
        return call(self.graph, target, *arguments)

    def parameter(self, tensor: Tensor) -> Node:
        """Add a parameter to the program, as its first input."""
        name = f"p_packed_{self.added}"
        self.added += 1
        first = next(iter(self.graph.nodes))
        mode = next(
            n.meta["val"].fake_mode for n in self.graph.nodes if isinstance(n.meta.get("val"), FakeTensor)
        )
        with self.graph.inserting_before(first):
            node = self.graph.placeholder(name)
        node.meta["val"] = mode.from_tensor(tensor, static_shapes=True)
        self.program.state_dict[name] = torch.nn.Parameter(tensor, requires_grad=False)
        self.program.graph_signature.input_specs.insert(
            0, InputSpec(InputKind.PARAMETER, TensorArgument(name), name)
        )
        self.values[name] = tensor
        return node

    def drop_unused(self) -> None:
        """Remove parameters without users, which would otherwise be in the artifact."""
        signature = self.program.graph_signature
        for node in [n for n in self.graph.nodes if n.op == "placeholder" and not n.users]:
            spec = next(s for s in signature.input_specs if s.arg.name == node.name)
            if spec.kind is InputKind.USER_INPUT or spec.target is None:
                continue
            signature.input_specs.remove(spec)
            self.graph.erase_node(node)
            if all(s.target != spec.target for s in signature.input_specs):
                self.program.state_dict.pop(spec.target, None)
                self.program.constants.pop(spec.target, None)
