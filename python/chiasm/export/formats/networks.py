"""Replaces a network's convolutions and linear layers by kernels, for native code.

The weights are parameters of the network. They are packed here into the layout that the kernels read, batch
normalisation is folded into them, and a clamp that follows becomes a part of the kernel. Kernels take images
(B, H, W, C); Inductor chooses this layout for the loops between two kernels too.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import torch
from torch import Tensor
from torch.export import ExportedProgram
from torch.fx import Node

from ..internals import FLOOR_DIVISION
from .network_forms import arguments_of, use_forms
from .network_program import NetworkProgram, panels
from .recurrent import RECURRENT, replace_recurrent

aten = torch.ops.aten
_INFINITY = float("inf")
#: An operator, and its arguments after the tensor.
_Step: TypeAlias = tuple[Any, ...]


def use_kernels(program: ExportedProgram) -> None:
    """Rewrite layers by forms that have a kernel, then replace, in place, those with constant weights by
    kernels. Others stay."""
    use_forms(program)
    network = _Network(program)
    for node in list(program.graph.nodes):
        if node.target in RECURRENT:
            replace_recurrent(network, node)
    for node in list(program.graph.nodes):
        layer = network.layer(node)
        if layer is not None:
            network.replace(node, layer)
    program.graph.eliminate_dead_code()
    network.drop_unused()
    program.graph_module.recompile()


@dataclass
class _Layer:
    """A convolution; a linear layer is one of single pixels. Pairs are (rows, columns).

    padding: zeros above and left of the image; below and right there are as many as the result needs, whose
    size is (the image's + growth) // stride + 1. input_dilation: the distance of the image's pixels; zeros
    are between them and after the last.
    """

    image: Node
    weight: Tensor  # (N, G, KH, KW)
    bias: Tensor
    stride: Sequence[int] = (1, 1)
    padding: Sequence[int] = (0, 0)
    growth: Sequence[int] = (-1, -1)
    dilation: Sequence[int] = (1, 1)
    groups: int = 1
    input_dilation: Sequence[int] = (1, 1)
    low: float = -_INFINITY
    high: float = _INFINITY

    def normalised(self, scale: Tensor, shift: Tensor) -> None:
        """Fold in a scale and a shift of each output channel."""
        self.weight = (self.weight.double() * scale.view(-1, 1, 1, 1)).to(self.weight.dtype)
        self.bias = (self.bias.double() * scale + shift).to(self.bias.dtype)

    def packed(self) -> Tensor:
        """The weights in the kernels' layout: panels (P, KH, KW, G, PANEL), or (KH, KW, C) if depthwise."""
        if self.is_depthwise:
            return self.weight[:, 0].permute(1, 2, 0).contiguous()
        return panels(self.weight, self.groups)

    def subpixel(self) -> tuple[list[list[tuple[_Layer, list[int]]]], list[int]]:
        """Equivalent convolutions of the image itself, without the zeros of input_dilation, each with the
        numbers of rows and columns of a block that it computes; and the numbers of surplus rows and columns
        of the result.

        One pixel of their results has the channels of a whole block of pixels (W. Shi et al., Is the
        deconvolution layer the same as a convolutional layer?, arXiv:1609.07009, 2016). One convolution
        computes neighbouring pixels of a block that read the same pixels of the image. With weights of 0, it
        could compute all pixels of the block, but zero times infinity would give NaN.
        """
        block = self.input_dilation
        surplus = [-(g + 1) % b for g, b in zip(self.growth, block, strict=True)]
        growth = [(g + s + 1) // b - 1 for g, s, b in zip(self.growth, surplus, block, strict=True)]
        rows, columns = (self._phases(axis) for axis in (0, 1))
        parts = [[(self._part(r, c, growth), [len(r.taps), len(c.taps)]) for c in columns] for r in rows]
        return parts, surplus

    def _phases(self, axis: int) -> list[_Phases]:
        """The pixels of a block along an axis, in runs that read the same pixels of the image."""
        size, step, block = self.weight.shape[2 + axis], self.dilation[axis], self.input_dilation[axis]
        found: list[_Phases] = []
        for phase in range(block):
            # Tap k reads the image's pixel at `offset`, or a zero.
            read = [divmod(phase - self.padding[axis] + k * step, block) for k in range(size)]
            taps = [k for k, (_, rest) in enumerate(read) if rest == 0]
            offsets = [read[k][0] for k in taps] or [_NOWHERE]
            if not found or found[-1].offsets != offsets:
                found.append(_Phases(offsets, []))
            found[-1].taps.append(taps)
        return found

    def _part(self, rows: _Phases, columns: _Phases, growth: Sequence[int]) -> _Layer:
        """The convolution for some pixels of a block, whose channels are (N, rows, columns)."""
        weight = self.weight
        for axis, phases in enumerate((rows, columns)):
            window = weight.movedim(-2 + axis, -1)
            made = window.new_zeros(len(phases.taps), *window.shape[:-1], len(phases.offsets))
            for phase, taps in enumerate(phases.taps):
                if taps:
                    made[phase] = window[..., taps]
            # (N, phases of the axis before, phases of this axis, ...)
            weight = made.movedim(-1, axis - 2).movedim(0, 1 + axis)
        weight = weight.flatten(0, 2)
        return replace(
            self,
            weight=weight,
            bias=self.bias.repeat_interleave(len(rows.taps) * len(columns.taps)),
            padding=[-rows.offsets[0], -columns.offsets[0]],
            growth=growth,
            dilation=[rows.apart, columns.apart],
            input_dilation=(1, 1),
        )

    @property
    def is_depthwise(self) -> bool:
        return self.weight.shape[1] == 1 and self.weight.shape[0] == self.groups > 1


#: A position so far outside of every image that a tap there reads no pixel.
_NOWHERE = -(1 << 31) + 1


@dataclass
class _Phases:
    """Neighbouring pixels of a block along an axis: the positions at which they read the image, and the taps
    that read there, for each pixel."""

    offsets: list[int]
    taps: list[list[int]]

    @property
    def apart(self) -> int:
        return self.offsets[1] - self.offsets[0] if len(self.offsets) > 1 else 1


class _Network(NetworkProgram):
    """Replaces layers by kernels."""

    # --- what there is ---

    def layer(self, node: Node) -> _Layer | None:
        """The layer of a node, if a kernel can compute it."""
        read = _LAYERS.get(node.target) if node.op == "call_function" else None
        if read is None or not all(isinstance(a, Node) for a in node.args[:2]):
            return None
        arguments = arguments_of(node)
        weight = self.value(arguments["weight"])
        image = arguments["input"].meta["val"]
        if weight is None or image.dtype != weight.dtype or image.dim() not in _VIEWS[node.target]:
            return None
        bias = weight.new_zeros(weight.shape[0])
        if arguments["bias"] is not None:
            given = self.value(arguments["bias"])
            if given is None:
                return None
            bias = given
        return read(arguments, weight, bias)

    # --- what it becomes ---

    def replace(self, node: Node, layer: _Layer) -> None:
        """Replace a layer by a kernel, together with a normalisation and a clamp that follow it."""
        last = node
        for take in (self._take_normalisation, self._take_clamp):
            following = next(iter(last.users)) if len(last.users) == 1 else None
            if following is not None and following.args[0] is last and take(layer, last, following):
                last = following
        with self.graph.inserting_before(node):
            made = self._emit(layer, node)
        last.replace_all_uses_with(made)
        for done in (last, *([node] if node is not last else [])):
            if not done.users:
                self.graph.erase_node(done)

    def _take_normalisation(self, layer: _Layer, last: Node, node: Node) -> bool:
        channels_are_last = layer.image.meta["val"].dim() > 2 and last.target is aten.linear.default
        if node.target is not aten.batch_norm.default or channels_are_last:
            return False
        arguments = arguments_of(node)
        mean, variance = (self.value(arguments[name]) for name in ("running_mean", "running_var"))
        weight, bias = (
            self.value(arguments[name]) if arguments[name] is not None else fill
            for name, fill in (("weight", torch.ones(())), ("bias", torch.zeros(())))
        )
        if arguments["training"] or mean is None or variance is None or weight is None or bias is None:
            return False
        scale = weight.double() / torch.sqrt(variance.double() + arguments["eps"])
        layer.normalised(scale.expand_as(mean), bias.double() - mean.double() * scale)
        return True

    def _take_clamp(self, layer: _Layer, _last: Node, node: Node) -> bool:
        limits = _clamp(node)
        if limits is None:
            return False
        layer.low, layer.high = limits
        return True

    def _emit(self, layer: _Layer, node: Node) -> Node:
        shape = layer.image.meta["val"].dim()
        before, after = _VIEWS[node.target][shape]
        image = self._views(layer.image, before)
        if tuple(layer.input_dilation) == (1, 1) and min(layer.padding) >= 0:
            return self._views(self._kernel(layer, image), after)
        parts, surplus = layer.subpixel()
        results = [[self._blocks(part, pixels, image) for part, pixels in row] for row in parts]
        return self._views(self._unblocked(results, surplus), after)

    def _kernel(self, layer: _Layer, image: Node) -> Node:
        size = [self._result_size(layer, image, axis) for axis in (0, 1)]
        for axis, padding in enumerate(layer.padding):
            if padding < 0:  # the kernels have none
                image = self.call(aten.slice.Tensor, image, 1 + axis, -padding)
        image = self.call(aten.contiguous.default, image)
        layer = replace(layer, padding=[max(padding, 0) for padding in layer.padding])
        weight, bias = self.parameter(layer.packed()), self.parameter(layer.bias)
        kernel = (
            torch.ops.chiasm.depthwise_convolution
            if layer.is_depthwise
            else torch.ops.chiasm.packed_convolution
        ).default
        numbers = (*layer.stride, *layer.padding, *layer.dilation, *size, layer.low, layer.high)
        return self.call(kernel, image, weight, bias, *numbers)

    def _blocks(self, layer: _Layer, pixels: list[int], image: Node) -> Node:
        """Some pixels of each block, (B, H, rows, W, columns, N)."""
        result = self._kernel(layer, image)
        outputs = result.meta["val"].shape[3] // (pixels[0] * pixels[1])
        unflatten = (aten.unflatten.int, 3, [outputs, *pixels])
        return self._views(result, [unflatten, (aten.permute.default, [0, 1, 4, 2, 5, 3])])

    def _unblocked(self, results: list[list[Node]], surplus: Sequence[int]) -> Node:
        """Move the pixels of each block to their places (pixel shuffle)."""
        rows = [row[0] if len(row) == 1 else self.call(aten.cat.default, row, 4) for row in results]
        blocks = rows[0] if len(rows) == 1 else self.call(aten.cat.default, rows, 2)
        steps: list[_Step] = [
            (aten.flatten.using_ints, 3, 4),
            (aten.flatten.using_ints, 1, 2),
            *((aten.slice.Tensor, 1 + axis, 0, -count) for axis, count in enumerate(surplus) if count),
        ]
        return self._views(blocks, steps)

    def _result_size(self, layer: _Layer, image: Node, axis: int) -> Any:
        """The result's number of rows (axis 0) or columns."""
        size = self._computed(operator.add, self._size(image, 1 + axis), layer.growth[axis])
        return self._computed(operator.add, self._computed(FLOOR_DIVISION, size, layer.stride[axis]), 1)

    def _size(self, image: Node, axis: int) -> Any:
        """The size of an image's axis: a number, or a node if it depends on the inputs."""
        size = image.meta["val"].shape[axis]
        return size if isinstance(size, int) else self.call(aten.sym_size.int, image, axis)

    def _computed(self, compute: Callable[..., Any], size: Any, number: int) -> Any:
        return self.call(compute, size, number) if isinstance(size, Node) else compute(size, number)

    def _views(self, node: Node, steps: Sequence[_Step]) -> Node:
        for target, *arguments in steps:
            node = self.call(target, node, *arguments)
        return node


#: The setting along rows if the input is a single row of pixels, (B, C, L).
_OF_ONE_ROW = {"stride": 1, "padding": 0, "dilation": 1, "output_padding": 0}


def _setting(a: dict[str, Any], name: str) -> tuple[int, int]:
    """A setting of a convolution, (rows, columns)."""
    numbers = list(a[name]) if isinstance(a[name], (list, tuple)) else [a[name]]
    if a["input"].meta["val"].dim() == 3:
        return _OF_ONE_ROW[name], numbers[0]
    return numbers[0], numbers[-1]


def _convolution(a: dict[str, Any], weight: Tensor, bias: Tensor) -> _Layer:
    weight = weight if weight.dim() == 4 else weight[:, :, None]
    stride, dilation = _setting(a, "stride"), _setting(a, "dilation")
    gaps = [d * (k - 1) for d, k in zip(dilation, weight.shape[2:], strict=True)]
    if a["padding"] == "same":
        padding, growth = [gap // 2 for gap in gaps], (-1, -1)
    else:
        padding = (0, 0) if a["padding"] == "valid" else _setting(a, "padding")
        growth = [2 * p - gap - 1 for p, gap in zip(padding, gaps, strict=True)]
    return _Layer(a["input"], weight, bias, stride, padding, growth, dilation, a["groups"])


def _transposed(a: dict[str, Any], weight: Tensor, bias: Tensor) -> _Layer:
    """A transposed convolution is a convolution with the flipped window, of the image dilated by the
    stride."""
    weight = weight if weight.dim() == 4 else weight[:, :, None]
    stride, dilation, groups = _setting(a, "stride"), _setting(a, "dilation"), a["groups"]
    padding, more = _setting(a, "padding"), _setting(a, "output_padding")
    gaps = [d * (k - 1) for d, k in zip(dilation, weight.shape[2:], strict=True)]
    inputs, outputs, *window = weight.shape  # outputs: of a group
    turned = weight.view(groups, inputs // groups, outputs, *window).transpose(1, 2).flip(-2, -1)
    return _Layer(
        a["input"],
        turned.reshape(groups * outputs, inputs // groups, *window),
        bias if a["bias"] is not None else weight.new_zeros(groups * outputs),
        padding=[gap - p for gap, p in zip(gaps, padding, strict=True)],
        growth=[g - s - 2 * p + m for g, s, p, m in zip(gaps, stride, padding, more, strict=True)],
        dilation=dilation,
        groups=groups,
        input_dilation=stride,
    )


def _linear(a: dict[str, Any], weight: Tensor, bias: Tensor) -> _Layer:
    return _Layer(a["input"], weight[:, :, None, None], bias)


_LAYERS: dict[Any, Callable[[dict[str, Any], Tensor, Tensor], _Layer]] = {
    aten.conv2d.default: _convolution,
    aten.conv2d.padding: _convolution,
    aten.conv1d.default: _convolution,
    aten.conv1d.padding: _convolution,
    aten.conv_transpose1d.default: _transposed,
    aten.conv_transpose2d.input: _transposed,
    aten.linear.default: _linear,
}
_CHANNELS_LAST = ([(aten.permute.default, [0, 2, 3, 1])], [(aten.permute.default, [0, 3, 1, 2])])
_ROWS_LAST = (
    [(aten.permute.default, [0, 2, 1]), (aten.unsqueeze.default, 1)],
    [(aten.squeeze.dim, 1), (aten.permute.default, [0, 2, 1])],
)
#: By number of dimensions: views that bring the input to (B, H, W, C), and the result back.
_VIEWS: dict[Any, dict[int, tuple[list[_Step], list[_Step]]]] = {
    aten.conv2d.default: {4: _CHANNELS_LAST},
    aten.conv2d.padding: {4: _CHANNELS_LAST},
    aten.conv1d.default: {3: _ROWS_LAST},
    aten.conv1d.padding: {3: _ROWS_LAST},
    aten.conv_transpose1d.default: {3: _ROWS_LAST},
    aten.conv_transpose2d.input: {4: _CHANNELS_LAST},
    aten.linear.default: {
        2: ([(aten.unsqueeze.default, 0), (aten.unsqueeze.default, 0)], [(aten.squeeze.dim, 0)] * 2),
        3: ([(aten.unsqueeze.default, 0)], [(aten.squeeze.dim, 0)]),
        4: ([], []),
    },
}


def _clamp(node: Node) -> tuple[float, float] | None:
    """The limits of a clamp, if the node is one."""
    if node.target in (aten.relu.default, aten.relu_.default):
        return (0.0, _INFINITY)
    if node.target in (aten.relu6.default, aten.relu6_.default):
        return (0.0, 6.0)
    if node.target in (aten.hardtanh.default, aten.hardtanh_.default):
        arguments = arguments_of(node)
        return (float(arguments["min_val"]), float(arguments["max_val"]))
    return None
