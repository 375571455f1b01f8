# torch.onnx and onnx declare parameters without the types of their parts.
# pyright: reportUnknownMemberType=false
"""The ONNX exporter: standard operators of opset 18, which runs anywhere."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator, Sequence

import numpy as np
import onnx
import onnx_ir
import onnx_ir.passes
import onnx_ir.passes.common as passes
import torch
from onnxscript.optimizer import _constant_folding
from torch.export import ExportedProgram

from ..errors import ExportError, explain
from ..job import Artifact, ExportJob, Method
from ..onnx_function import domain_version, function_name, fuse
from ..patches.onnx import fast_onnx
from ..spec import Spec, TensorSpec
from ..tracing.graph import dynamic_shapes
from .onnx_clamps import keep_infinities
from .onnx_division import TRANSLATIONS
from .onnx_order import keep_order
from .onnx_scatter import add_in_order
from .onnx_shifts import SHIFTS

OPSET = 18
IR_VERSION = 8  # what ONNX Runtime 1.14 and later read


def lower(job: ExportJob, method: Method) -> Iterator[Artifact]:
    """A method as a flat model, and as one call of a function, which native code can replace."""
    if method.variant == "bfloat16":  # ONNX Runtime's CPU kernels do not support it
        return
    job.progress(f"{method.title} onnx")
    flat = to_onnx(method.program("onnx"), job.spec, method.inputs, method.outputs, method.name)
    fused = to_fused_onnx(flat, job.spec, method.name)
    entry = {
        "backend": "onnx",
        "format": "onnx",
        "dtypes": method.dtypes,
        "device": "any",
        "opset": OPSET,
        "ir_version": IR_VERSION,
    }
    for kind, model, more in (
        ("onnx", flat, {}),
        ("fused.onnx", fused, {"function": fused.functions[0].name}),
    ):
        data = onnx_bytes(model, job.spec.name)
        yield Artifact(
            method.name, "onnx", f"{method.file}.{kind}", lambda data=data, more=more: (data, entry | more)
        )


def to_onnx(
    program: ExportedProgram,
    spec: Spec,
    inputs: Sequence[TensorSpec],
    outputs: Sequence[TensorSpec],
    method: str,
) -> onnx.ModelProto:
    """The model, checked. Its inputs and outputs are the named ones, all of them and in this order. Changes
    the program."""
    exporter_log = logging.getLogger("torch.onnx")
    level = exporter_log.level
    exporter_log.setLevel(logging.ERROR)  # it reports that torchvision is missing, which nothing here uses
    try:
        with warnings.catch_warnings(), fast_onnx():
            warnings.simplefilter("ignore")
            made = torch.onnx.export(
                program,
                dynamo=True,
                opset_version=OPSET,
                dynamic_shapes=dynamic_shapes(spec, inputs),
                input_names=[t.name for t in inputs],
                output_names=[t.name for t in outputs],
                optimize=False,
                verbose=False,
                custom_translation_table=TRANSLATIONS | SHIFTS,
            )
            assert made is not None
            _simplify(made.model)
            add_in_order(made.model)
            keep_infinities(made.model)
            keep_order(made.model)
            _keep_tiny_terms(made.model)
    except Exception as error:
        raise explain(spec.name, "ONNX", error) from error
    finally:
        exporter_log.setLevel(level)
    model = made.model_proto
    _strip(model.graph)
    for function in model.functions:
        _strip(function)
    model.ir_version = IR_VERSION
    model.producer_name, model.producer_version = "chiasm", ""
    model.graph.name = f"{spec.name}.{method}"
    del model.metadata_props[:]
    for key, value in (("chiasm.op", spec.name), ("chiasm.version", spec.version), ("chiasm.method", method)):
        model.metadata_props.add(key=key, value=value)
    for kind, found, wanted in (
        ("inputs", model.graph.input, inputs),
        ("outputs", model.graph.output, outputs),
    ):
        if [v.name for v in found] != [t.name for t in wanted]:
            raise ExportError(
                f"{spec.name}: the ONNX graph's {kind} are {[v.name for v in found]}, the spec's"
                f" {[t.name for t in wanted]}"
            )
    return model


def to_fused_onnx(model: onnx.ModelProto, spec: Spec, method: str) -> onnx.ModelProto:
    """The model of `to_onnx` as one function call."""
    return fuse(model, function_name(spec.name, method), domain_version(spec.version))


def onnx_bytes(model: onnx.ModelProto, name: str) -> bytes:
    """The bytes of a `.onnx`, checked."""
    try:
        onnx.checker.check_model(model, full_check=True)
    except Exception as error:
        raise explain(name, "ONNX", error) from error
    return model.SerializeToString(deterministic=True)


def _simplify(model: onnx_ir.Model) -> None:
    """torch.onnx's own optimisation without its pattern rewriter, whose time grows with the square of the
    graph (minutes for a small linear solver) and whose fusions ONNX Runtime does at load anyway."""
    limit = 8192  # elements; larger constants stay computed
    onnx_ir.passes.Sequential(
        passes.InlinePass(),
        _constant_folding.FoldConstantsPass(
            shape_inference=True, input_size_limit=limit, output_size_limit=limit
        ),
        passes.RemoveUnusedNodesPass(),
        passes.RemoveUnusedFunctionsPass(),
        passes.RemoveUnusedOpsetsPass(),
        passes.LiftConstantsToInitializersPass(lift_all_constants=True, size_limit=0),
        passes.LiftSubgraphInitializersToMainGraphPass(),
        passes.DeduplicateInitializersPass(),
        passes.CommonSubexpressionEliminationPass(),
        passes.RemoveUnusedNodesPass(),
        passes.OutputFixPass(),
        passes.NameFixPass(),
    )(model)


def _keep_tiny_terms(model: onnx_ir.Model) -> None:
    """`x + 1e-300` as a Sum: ONNX Runtime removes an Add if its constant is zero in float32."""
    for node in model.graph.all_nodes():
        if node.op_type == "Add" and any(_is_tiny(value) for value in node.inputs):
            node.op_type = "Sum"


def _is_tiny(value: onnx_ir.Value | None) -> bool:
    constant = value.const_value if value is not None else None
    if constant is None or constant.size != 1 or constant.dtype != onnx_ir.DataType.DOUBLE:
        return False
    number = float(constant.numpy().item())
    return number != 0 and np.float32(number) == 0


def _strip(graph: onnx.GraphProto | onnx.FunctionProto) -> None:
    """Remove traces of the exporting machine: stack traces and file names."""
    graph.doc_string = ""
    del graph.metadata_props[:]
    for value in list(getattr(graph, "value_info", [])) + list(getattr(graph, "initializer", [])):
        value.doc_string = ""
        del value.metadata_props[:]
    for tensor in [*getattr(graph, "input", []), *getattr(graph, "output", [])]:
        if hasattr(tensor, "metadata_props"):
            del tensor.metadata_props[:]
    for node in graph.node:
        node.doc_string = ""
        del node.metadata_props[:]
        for attribute in node.attribute:
            if attribute.type == onnx.AttributeProto.GRAPH:
                _strip(attribute.g)
