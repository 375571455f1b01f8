"""The fused form of an ONNX artifact: the whole graph as one function, so that the model is a single node.

An engine without chiasm inlines the function and runs its body, standard operators. If chiasm's custom-op
library is registered with ONNX Runtime, the bundle's native code runs the node, and the body is ignored.
"""

from __future__ import annotations

from collections.abc import Iterator

import onnx
from google.protobuf.message import Message
from onnx import helper

DOMAIN = "chiasm"


def function_name(op: str, method: str) -> str:
    """The function's name for a method of an op: filters_sobel for forward, filters_sobel_vjp for vjp.

    Example:
        >>> function_name("filters.sobel", "forward"), function_name("filters.sobel", "vjp")
        ('filters_sobel', 'filters_sobel_vjp')
    """
    name = "".join(c if c.isalnum() else "_" for c in op)
    return name if method == "forward" else f"{name}_{method}"


def domain_version(version: str) -> int:
    """The version of the domain for an op's semantic version: its major number, and 1 for the versions before
    1.0.

    Example:
        >>> domain_version("2.1.0"), domain_version("0.3.0")
        (2, 1)
    """
    return max(int(version.split(".")[0]), 1)


def fuse(model: onnx.ModelProto, name: str, version: int) -> onnx.ModelProto:
    """A model that is one call of a function of its own, whose body is the graph of `model`.

    Inputs, outputs and the model's metadata stay as they are. The types of values in the body are omitted:
    functions can have them only since IR version 10, and engines infer them.

    Args:
        model: a model without functions of its own.
        name: the function's name in the domain "chiasm".
        version: the version of the domain.

    Returns:
        The fused model; `model` is not changed.

    Raises:
        ValueError: `model` has functions, or data outside the file.
    """
    if model.functions:
        raise ValueError(
            f"{model.graph.name}: has functions already: {', '.join(f.name for f in model.functions)}"
        )
    for tensor in external_tensors(model):
        raise ValueError(
            f"constant {tensor.name!r} is stored outside the file: load the model with its external data"
        )
    graph = model.graph
    inputs, outputs = [i.name for i in graph.input], [o.name for o in graph.output]
    body = [_constant(tensor) for tensor in graph.initializer]
    for node in graph.node:
        copied = onnx.NodeProto()
        copied.CopyFrom(node)
        for inner in _subgraphs(copied):
            del inner.value_info[:]
        body.append(copied)
    # not by make_function and make_model, which set IR versions, opsets and names by their own defaults
    function = onnx.FunctionProto(
        domain=DOMAIN, name=name, input=inputs, output=outputs, node=body, opset_import=model.opset_import
    )
    fused = onnx.ModelProto(
        ir_version=model.ir_version,
        producer_name=model.producer_name,
        producer_version=model.producer_version,
        opset_import=[*model.opset_import, helper.make_opsetid(DOMAIN, version)],
        metadata_props=model.metadata_props,
        functions=[function],
    )
    fused.graph.name = graph.name
    fused.graph.input.extend(graph.input)
    fused.graph.output.extend(graph.output)
    fused.graph.node.append(helper.make_node(name, inputs, outputs, name=name, domain=DOMAIN))
    return fused


def external_tensors(message: Message) -> Iterator[onnx.TensorProto]:
    """The tensors of a model whose data is in another file: of graphs in graphs, sparse ones and attributes'
    defaults too."""
    if isinstance(message, onnx.TensorProto):
        if message.data_location == onnx.TensorProto.EXTERNAL:
            yield message
        return
    for field, value in message.ListFields():
        if field.message_type is not None:
            for each in (value,) if isinstance(value, Message) else value:
                yield from external_tensors(each)


def _constant(tensor: onnx.TensorProto) -> onnx.NodeProto:
    value = onnx.TensorProto()
    value.CopyFrom(tensor)
    value.name = ""  # the node's output names it
    return helper.make_node("Constant", [], [tensor.name], value=value)


def _subgraphs(node: onnx.NodeProto) -> Iterator[onnx.GraphProto]:
    """The graphs in a node's attributes, and the graphs nested in them."""
    for attribute in node.attribute:
        for graph in [
            *([attribute.g] if attribute.type == onnx.AttributeProto.GRAPH else []),
            *attribute.graphs,
        ]:
            yield graph
            for inner in graph.node:
                yield from _subgraphs(inner)
