"""The order of integers of 64 bits.

ONNX Runtime compares their lower halves as signed numbers if the upper halves are equal: in Min, Max, Clip,
Sign, ReduceMax and ReduceMin of more than one element, 2**31 is less than 7. Its Less and TopK are right.
Values that fit into 32 bits are compared right, so these operators stay: they are faster, and OpenVINO has no
TopK of integers.
"""

from __future__ import annotations

from collections.abc import Callable

import onnx_ir

from .onnx_steps import Steps

#: Types whose values fit into int32.
_NARROW = {onnx_ir.DataType[name] for name in ("BOOL", "INT8", "UINT8", "INT16", "UINT16", "INT32")}


def keep_order(model: onnx_ir.Model) -> None:
    """Replace these operators on int64 by operators that are right."""
    for node in list(model.graph.all_nodes()):
        rule = _RULES.get(node.op_type)
        if rule is None or node.inputs[0] is None or node.inputs[0].dtype != onnx_ir.DataType.INT64:
            continue
        if all(_is_single(value) for value in (*node.inputs, *node.outputs)):  # arithmetic of sizes
            continue
        if all(_is_narrow(value) for value in node.inputs):
            continue
        step = Steps(f"{node.outputs[0].name}_ordered")
        result = rule(step, node)
        if step.nodes:
            step.replace(node, result)


def _is_single(value: onnx_ir.Value | None) -> bool:
    return value is None or (value.shape is not None and all(size == 1 for size in value.shape))


def _is_narrow(value: onnx_ir.Value | None) -> bool:
    """Whether the value is left out, or all its elements are known to fit into int32."""
    if value is None:
        return True
    if value.const_value is not None:
        numbers = value.const_value.numpy()
        return bool(((numbers >= -(2**31)) & (numbers < 2**31)).all())
    made = value.producer()
    if made is None or made.op_type != "Cast" or made.inputs[0] is None:
        return False
    return made.inputs[0].dtype in _NARROW


def _greater(step: Steps, a: onnx_ir.Value, b: onnx_ir.Value) -> onnx_ir.Value:
    return step("Where", step("Less", a, b), b, a)


def _less(step: Steps, a: onnx_ir.Value, b: onnx_ir.Value) -> onnx_ir.Value:
    return step("Where", step("Less", b, a), b, a)


def _extreme(choose: Callable[..., onnx_ir.Value]) -> Callable[..., onnx_ir.Value]:
    def rule(step: Steps, node: onnx_ir.Node) -> onnx_ir.Value:
        result, *others = (value for value in node.inputs if value is not None)
        for other in others:
            result = choose(step, result, other)
        return result

    return rule


def _clip(step: Steps, node: onnx_ir.Node) -> onnx_ir.Value:
    result, least, most = (*node.inputs, None, None)[:3]
    assert result is not None
    result = result if least is None else _greater(step, result, least)
    return result if most is None else _less(step, result, most)


def _sign(step: Steps, node: onnx_ir.Node) -> onnx_ir.Value:
    value, zero, int64 = node.inputs[0], step.numbers(0), onnx_ir.DataType.INT64
    assert value is not None
    above, below = step("Less", zero, value), step("Less", value, zero)
    return step("Sub", step("Cast", above, to=int64), step("Cast", below, to=int64))


def _reduced(largest: int) -> Callable[..., onnx_ir.Value]:
    def rule(step: Steps, node: onnx_ir.Node) -> onnx_ir.Value:
        result, given = (*node.inputs, None)[:2]
        assert result is not None
        known = given.const_value if given is not None else None
        if result.shape is None or (given is not None and known is None):
            return result
        axes = range(len(result.shape)) if known is None else known.numpy().tolist()
        for axis in axes:
            result = step("TopK", result, step.numbers(1), outputs=2, axis=axis, largest=largest)
        keeps = node.attributes.get("keepdims")
        if keeps is None or keeps.as_int() or not axes:
            return result
        return step("Squeeze", result, step.numbers(*axes))

    return rule


_RULES: dict[str, Callable[[Steps, onnx_ir.Node], onnx_ir.Value]] = {
    "Max": _extreme(_greater),
    "Min": _extreme(_less),
    "Clip": _clip,
    "Sign": _sign,
    "ReduceMax": _reduced(largest=1),
    "ReduceMin": _reduced(largest=0),
}
