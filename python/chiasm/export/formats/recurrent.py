"""An LSTM layer as a linear layer, which takes the inputs of all steps at once, and the kernel `lstm`, which
goes from step to step."""

from __future__ import annotations

import operator
from typing import cast

import torch
import torch.nn.functional as F
from torch import Tensor
from torch.fx import Node

from .network_forms import arguments_of
from .network_program import PANEL, NetworkProgram

aten = torch.ops.aten


def replace_lstm(network: NetworkProgram, node: Node) -> None:
    """Replace `aten.lstm.input` if its weights are parameters. Others stay, among them those that project the
    hidden state, and dropout in training."""
    a = arguments_of(node)
    directions = 2 if a["bidirectional"] else 1
    each = 4 if a["has_biases"] else 2
    weights = [network.value(weight) for weight in a["params"]]
    if len(weights) != a["num_layers"] * directions * each or (a["train"] and a["dropout"]):
        return
    if any(w is None or w.dtype != a["input"].meta["val"].dtype for w in weights):
        return
    with network.graph.inserting_before(node):
        steps = network.call(aten.permute.default, a["input"], [1, 0, 2]) if a["batch_first"] else a["input"]
        hidden, cells = list[Node](), list[Node]()
        for first in range(0, a["num_layers"] * directions, directions):
            results = list[Node]()
            for index in range(first, first + directions):
                states, memory = _layer(
                    network, steps, a["params"][index * each :][:each], a["hx"], index, index > first
                )
                last = 0 if index > first else -1
                hidden.append(network.call(aten.select.int, states, 0, last))
                cells.append(network.call(aten.select.int, memory, 0, last))
                results.append(states)
            steps = results[0] if directions == 1 else network.call(aten.cat.default, results, 2)
        if a["batch_first"]:
            steps = network.call(aten.permute.default, steps, [1, 0, 2])
        made = [steps, *(network.call(aten.stack.default, ends) for ends in (hidden, cells))]
    for user in list(node.users):
        assert user.target is operator.getitem
        user.replace_all_uses_with(made[cast(int, user.args[1])])


def _layer(
    network: NetworkProgram, steps: Node, weights: list[Node], start: list[Node], index: int, reverse: bool
) -> list[Node]:
    """The hidden states and the cells of all steps of one layer in one direction."""
    of_input, of_state, *biases = weights
    bias = None
    if biases:
        first, second = (network.value(node) for node in biases)
        assert first is not None and second is not None
        bias = network.parameter(first + second)
    between = network.value(of_state)
    assert between is not None
    gates = network.call(aten.linear.default, steps, of_input, bias)
    gates = network.call(aten.contiguous.default, gates)
    states = [
        network.call(aten.contiguous.default, network.call(aten.select.int, state, 0, index))
        for state in start
    ]
    both = network.call(
        torch.ops.chiasm.lstm.default, gates, network.parameter(_panels(between)), *states, reverse
    )
    return [network.call(aten.select.int, both, 0, k) for k in range(2)]


def _panels(weight: Tensor) -> Tensor:
    """(outputs, inputs) as (panels, inputs, PANEL)."""
    outputs, inputs = weight.shape
    filled = F.pad(weight, (0, 0, 0, -outputs % PANEL))
    return filled.view(-1, PANEL, inputs).transpose(1, 2).contiguous()
