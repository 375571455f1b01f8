"""Models and bundles in a row, as one ONNX model and its session."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, TypeGuard

import numpy as np
import onnx

from .functions import at_least, fused_model, names, opset
from .merging import BundlePath, append, loaded_model
from .methods import Method
from .sessions import serve

if TYPE_CHECKING:
    import onnxruntime

#: Of one joint: pairs (output, input).
Joint = Iterable[tuple[str, str]]


class ONNXSequential:
    """ONNX models and bundles in a row, each fed with what the one before gives: one model, and its session.

    A bundle becomes a node, as by `append`, and runs as native code where it can, as in `session`. Of two
    models that import different opsets, the lower one is raised.

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
        self.model = _as_model(args[0])
        for i, each in enumerate(args[1:]):
            joint = None if io_maps is None else list(io_maps[i])
            self.model = (
                append(self.model, each, connect=None if joint is None else _mapping(joint))
                if _is_bundle(each)
                else _joined(self.model, loaded_model(each), joint)
            )
        options = onnxruntime.SessionOptions() if session_options is None else session_options
        serve([Method.open(each, "forward", None) for each in args if _is_bundle(each)], options)
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
        onnx.save(self.model, os.fspath(file_path))


def _is_bundle(given: onnx.ModelProto | BundlePath) -> TypeGuard[BundlePath]:
    return isinstance(given, (str, os.PathLike)) and os.path.isdir(given)


def _as_model(given: onnx.ModelProto | BundlePath) -> onnx.ModelProto:
    """A model that may be changed."""
    bundled = fused_model(Method.open(given, "forward", None)) if _is_bundle(given) else loaded_model(given)
    return at_least(bundled, 0, bundled.graph.name)


def _mapping(joint: list[tuple[str, str]]) -> dict[str, str]:
    """The pairs of a joint with a bundle, to which an output goes once."""
    mapping = dict(joint)
    if len(mapping) < len(joint):
        raise ValueError(f"io_maps: expected an output of the first once in front of a bundle, got {joint}")
    return mapping


def _joined(
    first: onnx.ModelProto, second: onnx.ModelProto, joint: list[tuple[str, str]] | None
) -> onnx.ModelProto:
    """Two models as one."""
    offered, initialized = [v.name for v in first.graph.output], {t.name for t in second.graph.initializer}
    wanted = [v.name for v in second.graph.input if v.name not in initialized]
    if joint is None:
        if len(offered) != 1 or len(wanted) != 1:
            raise ValueError(
                f"the model {first.graph.name} has the outputs {', '.join(offered)}, {second.graph.name} the"
                f" inputs {', '.join(wanted)}: say which goes where: io_maps=[[(OUTPUT, INPUT)]]"
            )
        joint = [(offered[0], wanted[0])]
    for output, target in joint:
        for name, known in ((output, offered), (target, wanted)):
            if name not in known:
                raise ValueError(f"io_maps: expected some of {', '.join(known)}, got {name!r}")
    if len({target for _, target in joint}) < len(joint):
        raise ValueError(f"io_maps: expected an input of the second once, got {joint}")
    version = max(opset(first) or 0, opset(second) or 0)
    first, second = (at_least(each, version, each.graph.name) for each in (first, second))
    first.ir_version = second.ir_version = max(first.ir_version, second.ir_version)
    if names(first.graph) & names(second.graph):
        prefix = f"{second.graph.name}_{len(first.graph.node)}_"
        second = onnx.compose.add_prefix(second, prefix)
        joint = [(output, prefix + target) for output, target in joint]
    try:
        return onnx.compose.merge_models(first, second, joint)
    except (ValueError, onnx.checker.ValidationError) as error:
        raise ValueError(f"{first.graph.name} and {second.graph.name} do not fit together: {error}") from None
