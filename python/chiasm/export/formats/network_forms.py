"""Rewrites layers that have no kernel as layers that have one.

* Layers in half precision compute in float32, as PyTorch's own kernels do inside, and round their results.
* Attention becomes matrix products and a softmax.
* A convolution of volumes becomes one of images, whose channels are those of all slices under the window.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import torch
from torch.export import ExportedProgram
from torch.fx import Graph, Node, map_arg

from ..internals import is_operator, schema_of

aten = torch.ops.aten
_HALF = (torch.float16, torch.bfloat16)


def use_forms(program: ExportedProgram) -> None:
    """Rewrite, in place, the layers for which there is a form."""
    for node in list(program.graph.nodes):
        if node.target in _IN_FLOAT32 and node.meta["val"].dtype in _HALF:
            _compute_in_float32(program.graph, node)
    program.graph.eliminate_dead_code()
    for node in list(program.graph.nodes):
        change = _FORMS.get(node.target) if node.op == "call_function" else None
        if change is not None:
            with program.graph.inserting_before(node):
                made = change(program.graph, node)
            if made is not None:
                node.replace_all_uses_with(made)
                program.graph.erase_node(node)


def arguments_of(node: Node) -> dict[str, Any]:
    """The arguments of a call by name, with the schema's defaults."""
    assert is_operator(node.target)
    schema = schema_of(node.target).arguments
    given: dict[str, Any] = dict(zip([a.name for a in schema], node.args, strict=False)) | node.kwargs
    return {a.name: given.get(a.name, a.default_value) for a in schema}


def call(graph: Graph, target: Callable[..., Any], *arguments: Any, **named: Any) -> Node:
    """A new call, with its value's shape and type."""
    node = graph.call_function(target, arguments, named)
    given, more = map_arg((arguments, named), lambda argument: argument.meta["val"])
    node.meta["val"] = target(*given, **more)
    return node


def _compute_in_float32(graph: Graph, node: Node) -> None:
    """Widen the arguments of a call and round its result. Between two such calls nothing is rounded, unless
    others read the value: they may also change it, in place."""

    def is_unrounded(argument: Node) -> bool:
        return "unrounded" in argument.meta and len(argument.users) == 1

    def widened(argument: Node) -> Node:
        if argument.meta["val"].dtype not in _HALF:
            return argument
        if is_unrounded(argument):
            return argument.meta["unrounded"]
        return call(graph, aten.to.dtype, argument, torch.float32)

    if node.target in _IN_PLACE and not is_unrounded(node.all_input_nodes[0]):
        return

    with graph.inserting_before(node):
        arguments, named = map_arg((node.args, node.kwargs), widened)
        wide = call(graph, node.target, *arguments, **named)  # pyright: ignore[reportArgumentType]
        rounded = call(graph, aten.to.dtype, wide, node.meta["val"].dtype)
    rounded.meta["unrounded"] = wide
    node.replace_all_uses_with(rounded)
    graph.erase_node(node)


def _attention(graph: Graph, node: Node) -> Node:
    a = arguments_of(node)
    mask = _added(graph, a["attn_mask"])
    arguments = (a["query"], a["key"], a["value"], mask, a["dropout_p"], a["is_causal"], None)
    both = graph.call_function(
        aten._scaled_dot_product_attention_math.default,
        arguments,
        {"scale": a["scale"], "enable_gqa": a["enable_gqa"]},
    )
    first = graph.call_function(operator.getitem, (both, 0))
    first.meta["val"] = node.meta["val"]
    return first


def _added(graph: Graph, mask: Node | None) -> Node | None:
    """The mask as numbers that are added to scores: `_scaled_dot_product_attention_math` takes True for 1."""
    if mask is None or mask.meta["val"].dtype != torch.bool:
        return mask
    hidden = graph.call_function(aten.logical_not.default, (mask,))
    zeros = graph.call_function(aten.mul.Scalar, (mask, 0.0))
    return graph.call_function(aten.masked_fill.Scalar, (zeros, hidden, -float("inf")))


def _convolution_of_images(graph: Graph, node: Node) -> Node | None:
    """A convolution of (B, C, D, H, W) as one of B * (slices of the result) images."""
    a = arguments_of(node)
    volume, weight = a["input"], a["weight"]
    if volume.meta["val"].dim() != 5:
        return None
    window = weight.meta["val"].shape[2]
    stride, dilation = (_of_each_axis(a[name]) for name in ("stride", "dilation"))
    reach = dilation[0] * (window - 1)
    if isinstance(a["padding"], str):
        before = reach // 2 if a["padding"] == "same" else 0
        after = reach - before if a["padding"] == "same" else 0
        convolve, padding = aten.conv2d.padding, a["padding"]
    else:
        before, *padding = _of_each_axis(a["padding"])
        after, convolve = before, aten.conv2d.default
    if before or after:  # not by constant_pad_nd, which fixes symbolic sizes
        first = call(graph, aten.slice.Tensor, volume, 2, 0, 1)
        zeros = call(graph, aten.zeros_like.default, first)
        volume = call(graph, aten.cat.default, [zeros] * before + [volume] + [zeros] * after, 2)
    slices = call(graph, aten.unfold.default, volume, 2, reach + 1, stride[0])
    slices = call(graph, aten.slice.Tensor, slices, 5, 0, None, dilation[0])
    # (B, C, slices, H, W, window) -> (B * slices, C * window, H, W)
    slices = call(graph, aten.permute.default, slices, [0, 2, 1, 5, 3, 4])
    images = call(graph, aten.flatten.using_ints, slices, 2, 3)
    images = call(graph, aten.flatten.using_ints, images, 0, 1)
    flat = call(graph, aten.flatten.using_ints, weight, 1, 2)
    made = call(graph, convolve, images, flat, a["bias"], stride[1:], padding, dilation[1:], a["groups"])
    count = slices.meta["val"].shape[1]
    if not isinstance(count, int):
        count = call(graph, aten.sym_size.int, slices, 1)
    made = call(graph, aten.unflatten.int, made, 0, [-1, count])
    return call(graph, aten.permute.default, made, [0, 2, 1, 3, 4])


def _of_each_axis(setting: list[int]) -> list[int]:
    """A setting of (depth, rows, columns), of which PyTorch also takes one for all."""
    return list(setting) * (3 // len(setting))


_FORMS: dict[Any, Callable[[Graph, Node], Node | None]] = {
    aten.scaled_dot_product_attention.default: _attention,
    aten.conv3d.default: _convolution_of_images,
    aten.conv3d.padding: _convolution_of_images,
}
_IN_PLACE = (aten.relu_.default, aten.relu6_.default, aten.hardtanh_.default)
#: Layers, what kernels compute together with them, and products of computed matrices.
_IN_FLOAT32 = {
    *(aten.conv1d.default, aten.conv1d.padding, aten.conv2d.default, aten.conv2d.padding),
    *(aten.conv3d.default, aten.conv3d.padding, aten.conv_transpose1d.default, aten.conv_transpose2d.input),
    *(aten.linear.default, aten.batch_norm.default),
    *(aten.relu.default, aten.relu6.default, aten.hardtanh.default, *_IN_PLACE),
    *(aten.matmul.default, aten.mm.default, aten.bmm.default, aten.addmm.default, aten.baddbmm.default),
    aten.scaled_dot_product_attention.default,
}
