"""A bundle as a module of a torch network, and the export of such a network to ONNX."""

from __future__ import annotations

import io
import os
from collections.abc import Sequence
from typing import Any

import numpy as np
import onnx
import torch
from torch import Tensor, nn

import chiasm.runtime
from chiasm.export.manifest import BundleError
from chiasm.export.onnx_function import DOMAIN, domain_version, function_name
from chiasm.export.sizes import evaluate

from .functions import nodes, read_model
from .merging import embed_methods, save_model
from .methods import Method

Size = int | torch.SymInt


class Node(nn.Module):
    """A bundle's method as a module, which becomes a single node when the network is exported to ONNX.

    In eager mode the bundle's TorchScript runs, on any device and with gradients. For a bundle without
    TorchScript, for any method but `forward`, and under the trust policy ``data_only``, ONNX Runtime runs
    instead, on the CPU and without gradients; an input that requires grad raises an error. In the exported
    model the node has no gradient.
    `torch.export` other than for ONNX is rejected: call the op itself there.

    Args:
        bundle: the folder ``NAME.chiasm``.
        method: one of the bundle's methods.
        dtype: for a bundle of several dtypes, the one to take; by default float32, else the first available.

    Raises:
        BundleError: the bundle is damaged, or has no such method, dtype or ONNX artifact.

    Example:
        >>> import chiasm.onnx, torch
        >>> prepare = chiasm.onnx.Node("build/bundles/pipelines.preprocess.chiasm")
        >>> network = torch.nn.Sequential(prepare, torch.nn.Conv2d(3, 8, 3))
        >>> network(torch.zeros(48, 64, 3, dtype=torch.uint8)).shape
        torch.Size([1, 8, 222, 222])
    """

    def __init__(
        self, bundle: str | os.PathLike[str], method: str = "forward", dtype: str | None = None
    ) -> None:
        super().__init__()
        self.opened = Method.open(bundle, method, dtype)
        read_model(self.opened, self.opened.flat())
        self.function = function_name(self.opened.manifest["name"], method)
        script = next((a for a in self.opened.artifacts() if a["format"] == "torchscript"), None)
        if method != "forward" or chiasm.runtime.get_trust() == "data_only":  # a script is a program
            script = None
        self.script = torch.jit.load(io.BytesIO(self.opened.read(script))) if script else None
        self._session: Any = None

    def forward(self, *inputs: Tensor) -> Tensor | tuple[Tensor, ...]:
        """The method's outputs for its inputs, in the manifest's order.

        Raises:
            TypeError: the number of inputs or a dtype is wrong.
            ValueError: a shape is wrong, or a size not within the manifest's limits.
            RuntimeError: an input requires a gradient that does not exist, or the export is not to ONNX.
        """
        shapes = self._output_shapes(inputs)
        if torch.onnx.is_in_onnx_export():
            results = self._symbolic(inputs, shapes)
        elif torch.compiler.is_exporting():
            raise RuntimeError(
                f"{self.opened.folder}: a Node is exported to ONNX only (chiasm.onnx.export): call the op"
                " itself in a network for torch.export"
            )
        elif self.script is not None:
            return self.script(*inputs)
        else:
            results = self._by_onnxruntime(inputs)
        return results[0] if len(results) == 1 else tuple(results)

    def extra_repr(self) -> str:
        """The function and its bundle, for `print(network)`."""
        return f"{DOMAIN}::{self.function}, {self.opened.folder}"

    def _symbolic(self, inputs: tuple[Tensor, ...], shapes: list[list[Size]]) -> Sequence[Tensor]:
        dtypes = [getattr(torch, self.opened.dtype_of(t)) for t in self.opened.outputs]
        version = domain_version(self.opened.manifest["version"])
        return torch.onnx.ops.symbolic_multi_out(
            f"{DOMAIN}::{self.function}", inputs, dtypes=dtypes, shapes=shapes, version=version
        )

    def _by_onnxruntime(self, inputs: tuple[Tensor, ...]) -> list[Tensor]:
        if torch.is_grad_enabled() and any(t.requires_grad for t in inputs):
            raise RuntimeError(
                f"{self.opened.folder}: {self.opened.name} is run by ONNX Runtime, which gives no gradient:"
                " use torch.no_grad(), detach the input, or export the bundle with the format torchscript"
                " (which the trust policy 'data_only' does not run)"
            )
        if self._session is None:
            import onnxruntime

            self._session = onnxruntime.InferenceSession(
                read_model(self.opened, self.opened.flat())[0], providers=["CPUExecutionProvider"]
            )
        named = {t["name"]: x.detach().cpu().contiguous().numpy() for t, x in zip(self.opened.inputs, inputs)}
        return [torch.from_numpy(np.asarray(r)).to(inputs[0].device) for r in self._session.run(None, named)]

    def _output_shapes(self, inputs: tuple[Tensor, ...]) -> list[list[Size]]:
        """The outputs' shapes by the manifest's expressions. Also checks the inputs."""
        specs, where = self.opened.inputs, self.opened.folder
        if len(inputs) != len(specs):
            raise TypeError(
                f"{where}: expected {len(specs)} inputs ({', '.join(t['name'] for t in specs)}), got"
                f" {len(inputs)}"
            )
        symbols: dict[str, Size] = {}
        for spec, tensor in zip(specs, inputs):
            if tensor.dtype != getattr(torch, self.opened.dtype_of(spec)):
                raise TypeError(
                    f"{where}: input {spec['name']!r}: expected {self.opened.dtype_of(spec)}, got"
                    f" {tensor.dtype}"
                )
            if tensor.dim() != len(spec["shape"]):
                raise self._wrong_shape(spec, tensor)
            for wanted, size in zip(spec["shape"], tensor.shape):
                if isinstance(wanted, str) and wanted.isidentifier():
                    limits = self.opened.manifest["symbols"].get(wanted)
                    # A size that is open in an export would be limited there by a comparison
                    if limits and isinstance(size, int) and not limits["min"] <= size <= limits["max"]:
                        why = f": {wanted} must be from {limits['min']} to {limits['max']}"
                        raise self._wrong_shape(spec, tensor, why)
                    wanted = symbols.setdefault(wanted, size)
                elif isinstance(wanted, str):
                    continue  # an expression, in the cotangents of a vjp
                if wanted != size:
                    raise self._wrong_shape(spec, tensor)
        try:
            return [
                [d if isinstance(d, int) else evaluate(d, symbols) for d in t["shape"]]
                for t in self.opened.outputs
            ]
        except ValueError as error:
            raise BundleError(f"an output's size is {error}") from error

    def _wrong_shape(self, spec: dict[str, Any], tensor: Tensor, why: str = "") -> ValueError:
        expected = ", ".join(map(str, spec["shape"]))
        return ValueError(
            f"{self.opened.folder}: input {spec['name']!r}: expected shape ({expected}), got"
            f" {tuple(tensor.shape)}{why}"
        )


def export(
    network: nn.Module, args: tuple[Any, ...], path: str | os.PathLike[str] | None = None, **options: Any
) -> onnx.ModelProto:
    """Export a network that has `Node`s to ONNX; each `Node` becomes a single node, and its function is added
    to the model.

    Args:
        network: any module that ``torch.onnx.export(dynamo=True)`` takes.
        args: example inputs, as for ``torch.onnx.export``.
        path: where to write the model, in one file of at most 2 GB; by default nowhere.
        options: the other arguments of ``torch.onnx.export``: `dynamic_shapes`, `input_names`,
            `opset_version` ...

    Returns:
        The complete model.

    Raises:
        ValueError: two Nodes cannot be in one model.

    Example:
        >>> import chiasm.onnx, torch
        >>> prepare = chiasm.onnx.Node("build/bundles/pipelines.preprocess.chiasm")
        >>> network = torch.nn.Sequential(prepare, torch.nn.Conv2d(3, 8, 3)).eval()
        >>> frame = torch.zeros(48, 64, 3, dtype=torch.uint8)
        >>> model = chiasm.onnx.export(network, (frame,), "network.onnx", dynamic_shapes=({0: "H", 1: "W"},))
        >>> [node.op_type for node in model.graph.node]
        ['pipelines_preprocess', 'Conv']
    """
    if not options.pop("dynamo", True):
        raise ValueError(
            "dynamo: expected True, got False: only the exporter by torch.export knows how to write a Node"
        )
    options.setdefault("verbose", False)
    program = torch.onnx.export(network, args, dynamo=True, **options)
    assert program is not None
    model = program.model_proto
    called = {n.op_type for n in nodes(model.graph) if n.domain == DOMAIN}
    found = [m for m in network.modules() if isinstance(m, Node) and m.function in called]
    whole = embed_methods(model, [m.opened for m in found])
    if path is not None:
        save_model(whole, path)
    return whole
