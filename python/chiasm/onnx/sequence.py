"""Models and bundles in a row, as one ONNX model and its session."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, TypeGuard

import numpy as np
import onnx

from chiasm.export.onnx_function import DOMAIN

from .functions import at_least, fused_model, names, nodes, opset
from .merging import (
    BundlePath,
    append,
    described,
    dtype_name,
    loaded_model,
    method_of_dtype,
    save_model,
)
from .methods import Method
from .sessions import serve

if TYPE_CHECKING:
    import onnxruntime

#: Of one joint: pairs (output, input).
Joint = Iterable[tuple[str, str]]


class ONNXSequential:
    """ONNX models and bundles in a row, each fed with what the one before gives: one model, and its session.

    A bundle becomes a node, as by `append`, and runs as native code where it can, as in `session`. Its dtype
    is that of the model before it; for the first, that of what follows. All are raised to the highest opset
    among them.

    Args:
        args: models, their files, or bundles, folders ``NAME.chiasm``; at least one.
        providers: as ONNX Runtime takes them; the CPU by default.
        session_options: the session's options; they are changed by `register`.
        io_maps: for each joint of two neighbours, pairs (output of the first, input of the second). Optional
            where both have only one.

    Raises:
        BundleError: a bundle is damaged.
        TypeError: an argument is something else.
        ValueError: neighbours do not fit together; the message names what was expected and what came.

    Example:
        >>> import chiasm.onnx, onnx, numpy as np
        >>> double = onnx.parser.parse_model(
        ...     '<ir_version: 8, opset_import: ["": 18]> '
        ...     "double (float[N] x) => (float[N] y) { y = Add(x, x) }"
        ... )
        >>> chiasm.onnx.ONNXSequential(double, double)(np.array([1.0, 2.0], np.float32))
        [array([4., 8.], dtype=float32)]
    """

    def __init__(
        self,
        *args: onnx.ModelProto | BundlePath,
        providers: Sequence[str] | None = None,
        session_options: onnxruntime.SessionOptions | None = None,
        io_maps: Sequence[Joint] | None = None,
    ) -> None:
        import onnxruntime

        if not args:
            raise ValueError("args: expected at least one model or bundle, got none")
        if io_maps is not None and len(io_maps) != len(args) - 1:
            raise ValueError(
                f"io_maps: expected {len(args) - 1} joints, for {len(args)} models, got {len(io_maps)}"
            )
        if isinstance(providers, str):
            raise TypeError(f"providers: expected a list of names, got the text {providers!r}")
        joints = [None] * (len(args) - 1) if io_maps is None else [list(joint) for joint in io_maps]
        parts = [
            Method.open(each, "forward", None) if _is_bundle(each) else loaded_model(each) for each in args
        ]
        if isinstance(parts[0], Method) and len(parts) > 1:
            parts[0] = _in_dtype_of(parts[0], parts[1], joints[0])
        parts = _raised(parts)
        first = parts[0]
        self.model = fused_model(first, _highest(parts)[0]) if isinstance(first, Method) else first
        for part, joint in zip(parts[1:], joints):
            self.model = (
                append(self.model, part.folder, connect=None if joint is None else _mapping(joint))
                if isinstance(part, Method)
                else _joined(self.model, part, joint)
            )
        options = onnxruntime.SessionOptions() if session_options is None else session_options
        serve([part for part in parts if isinstance(part, Method)], options)
        self.session = onnxruntime.InferenceSession(
            self.model.SerializeToString(), options, providers=list(providers or ["CPUExecutionProvider"])
        )

    def __call__(self, *inputs: Any) -> list[Any]:
        """The outputs of the model, arrays, for its inputs in their order: arrays, or CPU tensors."""
        wanted = [value.name for value in self.session.get_inputs()]
        if len(inputs) != len(wanted):
            raise ValueError(f"inputs: expected {len(wanted)}: {', '.join(wanted)}; got {len(inputs)}")
        return self.session.run(None, {name: np.asarray(each) for name, each in zip(wanted, inputs)})

    def export(self, file_path: str | os.PathLike[str]) -> None:
        """Write the model to a file, which any ONNX Runtime runs."""
        save_model(self.model, file_path)


def _is_bundle(given: onnx.ModelProto | BundlePath) -> TypeGuard[BundlePath]:
    return isinstance(given, (str, os.PathLike)) and os.path.isdir(given)


def _in_dtype_of(
    first: Method, second: Method | onnx.ModelProto, joint: list[tuple[str, str]] | None
) -> Method:
    """The first bundle in the dtype of what follows it, if it has that dtype."""
    if isinstance(second, Method):
        second = fused_model(second)
    targets = None if joint is None else {target for _, target in joint}
    return method_of_dtype(first, [v for v in _inputs(second) if targets is None or v.name in targets])


def _inputs(model: onnx.ModelProto) -> list[onnx.ValueInfoProto]:
    initialized = {t.name for t in model.graph.initializer}
    return [v for v in model.graph.input if v.name not in initialized]


def _highest(parts: Sequence[Method | onnx.ModelProto]) -> tuple[int, str]:
    """The highest opset among models and bundles, and which has it."""
    versions = [
        (opset(fused_model(part).functions[0]) or 0, str(part.folder))
        if isinstance(part, Method)
        else (opset(part) or 0, part.graph.name)
        for part in parts
    ]
    return max(versions, key=lambda each: each[0])


def _raised(parts: Sequence[Method | onnx.ModelProto]) -> list[Method | onnx.ModelProto]:
    """Copies of the models, of one opset: one with a bundle's function could not be raised any more."""
    version, who = _highest(parts)
    return [part if isinstance(part, Method) else at_least(part, version, who) for part in parts]


def _mapping(joint: list[tuple[str, str]]) -> dict[str, str]:
    """The pairs of a joint with a bundle, to which an output goes once."""
    mapping = dict(joint)
    if len(mapping) < len(joint):
        raise ValueError(f"io_maps: expected an output of the first once in front of a bundle, got {joint}")
    return mapping


def _joined(
    first: onnx.ModelProto, second: onnx.ModelProto, joint: list[tuple[str, str]] | None
) -> onnx.ModelProto:
    """Two models of one opset as one."""
    offered = {v.name: v for v in first.graph.output}
    wanted = {v.name: v for v in _inputs(second)}
    if joint is None:
        if len(offered) != 1 or len(wanted) != 1:
            raise ValueError(
                f"the model {first.graph.name} has the outputs {', '.join(offered)}, {second.graph.name} the"
                f" inputs {', '.join(wanted)}: say which goes where: io_maps=[[(OUTPUT, INPUT)]]"
            )
        joint = list(zip(offered, wanted))
    for output, target in joint:
        for name, known in ((output, offered), (target, wanted)):
            if name not in known:
                raise ValueError(f"io_maps: expected some of {', '.join(known)}, got {name!r}")
        if dtype_name(offered[output]) != dtype_name(wanted[target]):
            raise ValueError(
                f"{first.graph.name}: output {output!r} is {described(offered[output])},"
                f" {second.graph.name}'s input {target!r} is {described(wanted[target])}: the dtypes differ"
            )
    if len({target for _, target in joint}) < len(joint):
        raise ValueError(f"io_maps: expected an input of the second once, got {joint}")
    first.ir_version = second.ir_version = max(first.ir_version, second.ir_version)
    prefix = f"{second.graph.name}_{len(first.graph.node)}_"
    if names(first.graph) & names(second.graph):
        second = onnx.compose.add_prefix(second, prefix, rename_functions=False)
        joint = [(output, prefix + target) for output, target in joint]
    _separate_functions(first, second, prefix)
    try:
        merged = onnx.compose.merge_models(first, second, joint)
    except (ValueError, onnx.checker.ValidationError) as error:
        raise ValueError(f"{first.graph.name} and {second.graph.name} do not fit together: {error}") from None
    imports = {o.domain: o for o in merged.opset_import}  # both models'
    del merged.opset_import[:]
    merged.opset_import.extend(imports.values())
    return merged


def _separate_functions(first: onnx.ModelProto, second: onnx.ModelProto, prefix: str) -> None:
    """Change `second` so that the models have no function's name in common. A bundle's function keeps its
    name, by which the plug-in knows it, and is left out if both models have it."""
    known = {f.name: f for f in first.functions}
    renamed: set[tuple[str, str]] = set()
    for function in [f for f in second.functions if f.name in known]:
        other = known[function.name]
        if function.domain != DOMAIN or other.domain != DOMAIN:
            renamed.add((function.domain, function.name))
        elif function.SerializeToString(deterministic=True) == other.SerializeToString(deterministic=True):
            second.functions.remove(function)
        else:
            raise ValueError(
                f"{first.graph.name} and {second.graph.name} have different functions"
                f" {DOMAIN}::{function.name} (of another dtype, configuration or export): give the bundles"
                " names of their own"
            )
    for caller in (second.graph, *second.functions):
        for node in nodes(caller):
            if (node.domain, node.op_type) in renamed:
                node.op_type = prefix + node.op_type
    for function in second.functions:
        if (function.domain, function.name) in renamed:
            function.name = prefix + function.name
