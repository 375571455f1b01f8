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
from .network_forms import arguments_of, call

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
        self.computed = self._find_computed()

    def value(self, node: Any) -> Tensor | None:
        """The value of a node that has an element type of the kernels, if it is a parameter or computed from
        parameters alone."""
        found = self._known(node) if isinstance(node, Node) else None
        return found.detach() if found is not None and found.dtype in (torch.float32, torch.float64) else None

    def _find_computed(self) -> set[Node]:
        """The calls whose arguments are parameters or such calls. None of them if one is written to later,
        since its views change too."""
        found = set[Node]()
        for node in self.graph.nodes:
            if node.op != "call_function" or not is_operator(node.target):
                continue
            known = [source in found or source.name in self.values for source in node.all_input_nodes]
            if not schema_of(node.target).is_mutable:
                if known and all(known):
                    found.add(node)
            elif any(source in found for source in _written(node)):
                return set()
        return found

    def _known(self, node: Node) -> Any:
        """The value of a node, or None."""
        if node in self.computed and node.name not in self.values:
            given, named = map_arg((node.args, node.kwargs), self._known)
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


def _written(node: Node) -> list[Any]:
    """The arguments that a call changes in place."""
    assert is_operator(node.target)
    given = arguments_of(node)
    return [
        given[argument.name]
        for argument in schema_of(node.target).arguments
        if argument.alias_info is not None and argument.alias_info.is_write
    ]


def panels(weight: Tensor, groups: int = 1) -> Tensor:
    """Weights (N, G, KH, KW) in the kernels' layout, panels (P, KH, KW, G, PANEL) of each group's outputs."""
    outputs, depth, *window = weight.shape
    split = weight.view(groups, outputs // groups, depth, *window)
    count = -(-split.shape[1] // PANEL)
    filled = split.new_zeros(groups, count * PANEL, depth, *window)
    filled[:, : split.shape[1]] = split
    return filled.view(groups * count, PANEL, depth, *window).permute(0, 3, 4, 2, 1).contiguous()
