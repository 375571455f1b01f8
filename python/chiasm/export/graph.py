"""From a module to torch.export's graph, with dimensions named by the spec, for the forward and for its gradient."""

from __future__ import annotations

import logging
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any
from unittest.mock import patch

import sympy
import torch
from torch import nn
from torch._decomp import get_decompositions
from torch.export import Dim, ExportedProgram, _trace
from torch.fx.experimental.proxy_tensor import make_fx
from torch.fx.experimental.symbolic_shapes import ShapeEnv

from chiasm.primitives.core.target import exporting

from .backward import joined
from .errors import ExportError, explain, own_line
from .module import bind
from .purity import check_program
from .spec import Spec, TensorSpec
from .torch_speed import fast_tracing

Inputs = dict[str, torch.Tensor]


def dynamic_shapes(spec: Spec, tensors: list[TensorSpec]) -> dict[str, dict[int, Dim]]:
    """torch.export's description of the symbolic dimensions of `tensors`."""
    dims = {name: Dim(name, min=low, max=high) for name, (low, high) in spec.used_symbols().items()}
    return {t.name: {i: _derived_dim(d, dims) for i, d in enumerate(t.shape) if isinstance(d, str)} for t in tensors}


def _derived_dim(expression: str, dims: dict[str, Dim]) -> Dim:
    """A symbol's Dim, or one derived from it: the gradient of an output has the output's shape, `(-1 + H)` say."""
    try:
        # Our own text, from _expression; torch.export derives dims by linear arithmetic.
        return eval(expression, {"__builtins__": {}}, dims)
    except (TypeError, NotImplementedError):
        return Dim.AUTO


def trace(module: nn.Module, spec: Spec, tensors: list[TensorSpec], inputs: Inputs, target: str, vjp: bool = False) -> ExportedProgram:
    """Export `module` for a target ("onnx", "native")."""
    if spec.takes_gradients and not vjp:
        return trace_vjp(module, spec, tensors, inputs)
    # Loops go through torch.compile, whose code for an op before, made for 4 models say, else leaves the guard `S != 4` on this one.
    torch._dynamo.reset()
    guards: list[tuple[str, str]] = []
    args = tuple(inputs[t.name] for t in tensors)
    try:
        with torch.no_grad(), exporting("vjp" if vjp else target), fast_tracing(), _noted(guards), _quiet():
            program = torch.export.export(module, args, dynamic_shapes=dynamic_shapes(spec, tensors))
    except Exception as error:
        raise explain(spec.name, f"a graph ({target})", error, guards) from error
    check_program(spec.name, program, {t.name: inputs[t.name] for t in tensors})
    return program


@contextmanager
def _noted(guards: list[tuple[str, str]]) -> Iterator[None]:
    """Note what the trace assumes of sizes, and the user's line that it does so for."""
    log_guard = ShapeEnv._log_guard

    def noting(shapes: ShapeEnv, prefix: str, guard: Any, forcing_spec: bool) -> None:
        if line := own_line(traceback.extract_stack()):
            guards.append((str(guard), line))
        log_guard(shapes, prefix, guard, forcing_spec)

    with patch.object(ShapeEnv, "_log_guard", noting):
        yield


@contextmanager
def _quiet() -> Iterator[None]:
    """Without torch's own reports of what it raises anyway: to its log, and the graph so far to standard output."""
    logger = logging.getLogger("torch")
    level = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        with patch.object(_trace, "print", lambda *_, **__: None, create=True):
            yield
    finally:
        logger.setLevel(level)


def symbols_of(program: ExportedProgram, tensors: list[TensorSpec]) -> dict[sympy.Symbol, str]:
    """torch.export's own symbols (s77) to the spec's (H)."""
    # by position: torch.export writes names in lower case
    user = set(program.graph_signature.user_inputs)
    placeholders = [n for n in program.graph.nodes if n.op == "placeholder" and n.name in user]
    found: dict[sympy.Symbol, str] = {}
    for tensor, placeholder in zip(tensors, placeholders, strict=True):
        for size, symbol in zip(placeholder.meta["val"].shape, tensor.shape, strict=True):
            if isinstance(size, torch.SymInt) and isinstance(size.node.expr, sympy.Symbol):
                found[size.node.expr] = str(symbol)
    return found


def output_specs(program: ExportedProgram, spec: Spec, variant: str | None) -> list[TensorSpec]:
    """The spec's outputs with the dtypes and symbolic shapes that the graph has."""
    names = symbols_of(program, list(spec.inputs))
    values = [n.meta["val"] for n in next(n for n in program.graph.nodes if n.op == "output").args[0]]
    if len(values) != len(spec.outputs):
        raise ExportError(f"{spec.name}: the spec names {len(spec.outputs)} outputs, the op returns {len(values)}")
    result = []
    for tensor, value in zip(spec.outputs, values, strict=True):
        dtype = str(value.dtype).removeprefix("torch.")
        shape = tuple(_dim(size, names, spec.name) for size in value.shape)
        result.append(replace(tensor, dtype="T" if spec.generic and dtype == variant else dtype, shape=shape))
    return result


def _dim(size: int | torch.SymInt, names: dict[sympy.Symbol, str], op: str) -> int | str:
    if not isinstance(size, torch.SymInt):
        return int(size)
    expression = size.node.expr
    unknown = expression.free_symbols - set(names)
    if unknown:
        raise ExportError(f"{op}: an output's size {expression} depends on the data: give it a fixed capacity and a validity mask")
    text = _expression(expression, names)
    return int(text) if text.isdigit() else text


def _expression(e: sympy.Expr, names: dict[sympy.Symbol, str]) -> str:
    """In the manifest's grammar: integers, symbols, + - * // ( )."""
    if e.is_Integer:
        return str(int(e))
    if e.is_Symbol:
        return names[e]
    if e.is_Add:
        return "(" + " + ".join(_expression(a, names) for a in e.args) + ")"
    if e.is_Mul:
        return " * ".join(_expression(a, names) for a in e.args)
    if type(e).__name__ in ("FloorDiv", "CleanDiv"):
        return f"({_expression(e.args[0], names)} // {_expression(e.args[1], names)})"
    raise ExportError(f"an output's size is {e}, which is not made of + - * //")


# --- gradients ---------------------------------------------------------------------------------------------------------


def vjp_signature(spec: Spec, outputs: list[TensorSpec]) -> tuple[list[TensorSpec], list[TensorSpec]] | None:
    """Inputs and outputs of the method `vjp`: the forward's inputs and a `grad_` per floating output, to a `grad_` per
    differentiable input. None where there is nothing to differentiate."""
    wanted = spec.differentiated()
    seeds = [t for t in outputs if t.dtype == "T" or t.dtype.startswith(("float", "bfloat"))]
    if not wanted or not seeds:
        return None
    cotangents = [replace(t, name=f"grad_{t.name}", range=(-1.0, 1.0), description=f"gradient with respect to output {t.name}") for t in seeds]
    gradients = [replace(t, name=f"grad_{t.name}", range=None, description=f"gradient with respect to input {t.name}") for t in spec.inputs if t.name in wanted]
    return list(spec.inputs) + cotangents, gradients


class _Vjp(nn.Module):
    """inputs..., cotangents... -> gradients, by torch.func."""

    def __init__(self, op: nn.Module, input_names: list[str], gradients: list[str], floating_outputs: list[int]) -> None:
        super().__init__()
        self.op, self.input_names, self.gradients, self.floating_outputs = op, input_names, gradients, floating_outputs

    def forward(self, *args: torch.Tensor):
        inputs = dict(zip(self.input_names, args, strict=False))
        cotangents = args[len(self.input_names) :]

        def of_differentiable(*values: torch.Tensor):
            merged = inputs | dict(zip(self.gradients, values, strict=True))
            result = self.op(*(merged[n] for n in self.input_names))
            result = result if isinstance(result, (tuple, list)) else (result,)
            return tuple(result[i] for i in self.floating_outputs)

        _, pullback = torch.func.vjp(of_differentiable, *(inputs[n] for n in self.gradients))
        # A gradient that is a cotangent itself is copied: a graph's outputs may not be its inputs.
        return tuple(g.clone() if any(g is c for c in cotangents) else g for g in pullback(tuple(cotangents)))


def vjp_module(op: nn.Module, spec: Spec, outputs: list[TensorSpec]) -> nn.Module | None:
    """The eager vjp of a bound op, or None where it has none."""
    signature = vjp_signature(spec, outputs)
    if signature is None:
        return None
    seeds = [i for i, t in enumerate(outputs) if any(s.name == f"grad_{t.name}" for s in signature[0])]
    return _Vjp(op, [t.name for t in spec.inputs], [t.name.removeprefix("grad_") for t in signature[1]], seeds)


def trace_vjp(module: nn.Module, spec: Spec, tensors: list[TensorSpec], inputs: Inputs) -> ExportedProgram:
    """Export a vjp, or what takes gradients itself: torch.export cannot trace either, so make_fx turns it into a plain graph first."""
    args = tuple(inputs[t.name] for t in tensors)
    try:
        with exporting("vjp"), fast_tracing():
            graph = make_fx(module, tracing_mode="symbolic", decomposition_table=get_decompositions([torch.ops.aten.rsub]), _allow_non_fake_inputs=True)(*args)
    except Exception as error:
        raise explain(spec.name, "a gradient graph", error) from error
    graph = joined(graph)
    return trace(bind(graph, [t.name for t in tensors], {}, spec.name), spec, tensors, inputs, "onnx", vjp=True)
