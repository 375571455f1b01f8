"""An LSTM or GRU layer as a linear layer, which takes the inputs of all steps at once, and a kernel, which
goes from step to step."""

from __future__ import annotations

import operator
from typing import Any, cast

import torch
from torch import Tensor
from torch.fx import Node

from .network_forms import arguments_of
from .network_program import NetworkProgram, panels

aten = torch.ops.aten
RECURRENT = (aten.lstm.input, aten.gru.input)


def replace_recurrent(network: NetworkProgram, node: Node) -> None:
    """Replace a layer whose weights are parameters. Others stay, among them those that project the hidden
    state, and dropout in training."""
    a = arguments_of(node)
    directions = 2 if a["bidirectional"] else 1
    layers, each = a["num_layers"] * directions, 4 if a["has_biases"] else 2
    weights = [network.value(weight) for weight in a["params"]]
    if len(weights) != layers * each or (a["train"] and a["dropout"]):
        return
    if any(w is None or w.dtype != a["input"].meta["val"].dtype for w in weights):
        return
    made = _emit_lstm if node.target is aten.lstm.input else _emit_gru
    with network.graph.inserting_before(node):
        call = network.call
        steps = call(aten.permute.default, a["input"], [1, 0, 2]) if a["batch_first"] else a["input"]
        #: of each layer and direction, the states after its last step
        ends = list[list[Node]]()
        for first in range(0, layers, directions):
            results = list[Node]()
            for index in range(first, first + directions):
                reverse = index > first
                every = made(network, steps, a["params"][index * each :][:each], a["hx"], index, reverse)
                ends.append([call(aten.select.int, states, 0, 0 if reverse else -1) for states in every])
                results.append(every[0])
            steps = results[0] if directions == 1 else call(aten.cat.default, results, 2)
        outputs = [call(aten.permute.default, steps, [1, 0, 2]) if a["batch_first"] else steps]
        outputs += [call(aten.stack.default, list(states)) for states in zip(*ends, strict=True)]
    for user in list(node.users):
        assert user.target is operator.getitem
        user.replace_all_uses_with(outputs[cast(int, user.args[1])])


def _emit_lstm(
    network: NetworkProgram, steps: Node, weights: list[Node], start: list[Node], index: int, reverse: bool
) -> list[Node]:
    """The hidden states and the cells of all steps."""
    of_input, of_state, *biases = weights
    bias = None
    if biases:
        bias = network.parameter(_value(network, biases[0]) + _value(network, biases[1]))
    gates = _gates(network, steps, of_input, bias)
    states = [_start(network, state, index) for state in start]
    both = network.call(torch.ops.chiasm.lstm.default, gates, _panels(network, of_state), *states, reverse)
    return [network.call(aten.select.int, both, 0, k) for k in range(2)]


def _emit_gru(
    network: NetworkProgram, steps: Node, weights: list[Node], start: Node, index: int, reverse: bool
) -> list[Node]:
    """The hidden states of all steps."""
    of_input, of_state, *biases = weights
    weight = _value(network, of_state)
    bias = _value(network, biases[1]) if biases else weight.new_zeros(weight.shape[0])
    gates = _gates(network, steps, of_input, biases[0] if biases else None)
    arguments: list[Any] = [network.parameter(bias), _start(network, start, index), reverse]
    return [network.call(torch.ops.chiasm.gru.default, gates, _panels(network, of_state), *arguments)]


def _value(network: NetworkProgram, node: Node) -> Tensor:
    value = network.value(node)
    assert value is not None
    return value


def _gates(network: NetworkProgram, steps: Node, weight: Node, bias: Node | None) -> Node:
    gates = network.call(aten.linear.default, steps, weight, bias)
    return network.call(aten.contiguous.default, gates)


def _start(network: NetworkProgram, states: Node, index: int) -> Node:
    return network.call(aten.contiguous.default, network.call(aten.select.int, states, 0, index))


def _panels(network: NetworkProgram, weight: Node) -> Node:
    """(outputs, inputs) as (panels, inputs, PANEL)."""
    return network.parameter(panels(_value(network, weight)[:, :, None, None]).flatten(1, 3))
