# torch.export declares a Dim's hint as no Dim, and has its context for what it compiles in a private module.
# pyright: reportArgumentType=false, reportReturnType=false, reportPrivateUsage=false
"""From a module to torch.export's graph, with dimensions named by the spec."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import sympy
import torch
from torch import nn
from torch._export.utils import _compiling_state_context
from torch.export import Dim, ExportedProgram
from torch.fx import Node

from chiasm.primitives.core.target import exporting

from ..checks.branches import Doubt, doubts_of
from ..checks.purity import check_program
from ..errors import SIZES, ExportError, explain
from ..internals import expression_of
from ..patches.recurrent import layers_of_any_length
from ..patches.tracing import Guard, fast_tracing, noted_guards, quiet
from ..spec import Spec, TensorSpec
from .choices import remove_certain_choices
from .expansion import expand_all
from .forms import FORMS

Inputs = dict[str, torch.Tensor]


def dynamic_shapes(spec: Spec, tensors: Sequence[TensorSpec]) -> dict[str, dict[int, Dim]]:
    """torch.export's description of the symbolic dimensions of `tensors`."""
    dims = {name: Dim(name, min=low, max=high) for name, (low, high) in spec.used_symbols().items()}
    return {
        t.name: {i: _derived_dim(d, dims) for i, d in enumerate(t.shape) if isinstance(d, str)}
        for t in tensors
    }


def _derived_dim(expression: str, dims: dict[str, Dim]) -> Dim:
    """A symbol's Dim, or one derived from it: the gradient of an output has the output's shape, for example
    `(-1 + H)`."""
    try:
        # The text is our own, from _expression. torch.export derives Dims by linear arithmetic on Dims.
        return eval(expression, {"__builtins__": {}}, dims)
    except (TypeError, NotImplementedError):
        return Dim.AUTO


def trace(
    module: nn.Module,
    spec: Spec,
    tensors: Sequence[TensorSpec],
    inputs: Inputs,
    target: str,
    doubts: list[Doubt] | None = None,
) -> ExportedProgram:
    """Export `module` for a target ("onnx", "native", "vjp"); `doubts` gets the sizes that the graph was not
    made for."""
    # while_loop uses Dynamo: without a reset, guards of the op before (`S != 4`) leak into this trace.
    torch._dynamo.reset()
    guards: list[Guard] = []
    args = tuple(inputs[t.name] for t in tensors)
    try:
        with (
            torch.no_grad(),
            exporting(target),
            fast_tracing(),
            layers_of_any_length(),
            noted_guards(guards),
            quiet(),
        ):
            program = torch.export.export(module, args, dynamic_shapes=dynamic_shapes(spec, tensors))
    except Exception as error:
        raise explain(spec.name, f"a graph ({target})", error, guards) from error
    # Forms see that they are exported, as the module did: else they would use no kernels.
    with exporting(target), _compiling_state_context():
        expand_all(program, FORMS)
    check_program(spec.name, program, {t.name: inputs[t.name] for t in tensors})
    if doubts is not None:
        doubts.extend(doubts_of(program, spec, tensors, symbols_of(program, tensors), guards))
    remove_certain_choices(program)
    return program


def symbols_of(program: ExportedProgram, tensors: Sequence[TensorSpec]) -> dict[sympy.Symbol, str]:
    """torch.export's own symbols (s77) to the spec's (H)."""
    # by position: torch.export writes names in lower case
    user = set(program.graph_signature.user_inputs)
    placeholders = [n for n in program.graph.nodes if n.op == "placeholder" and n.name in user]
    found: dict[sympy.Symbol, str] = {}
    for tensor, placeholder in zip(tensors, placeholders, strict=True):
        for size, symbol in zip(placeholder.meta["val"].shape, tensor.shape, strict=True):
            expression = expression_of(size) if isinstance(size, torch.SymInt) else None
            if isinstance(expression, sympy.Symbol):
                found[expression] = str(symbol)
    return found


def output_specs(program: ExportedProgram, spec: Spec, variant: str | None) -> list[TensorSpec]:
    """The spec's outputs with the dtypes and symbolic shapes that the graph has."""
    names = symbols_of(program, list(spec.inputs))
    made = next(n for n in program.graph.nodes if n.op == "output").args[0]
    if len(made) != len(spec.outputs):
        raise ExportError(
            f"{spec.name}: the spec names {len(spec.outputs)} outputs, the op returns {len(made)}"
        )
    result: list[TensorSpec] = []
    for tensor, node in zip(spec.outputs, made, strict=True):
        value = node.meta["val"]
        dtype = str(value.dtype).removeprefix("torch.")
        shape = tuple(_dim(size, names, spec.name, node) for size in value.shape)
        result.append(replace(tensor, dtype="T" if spec.generic and dtype == variant else dtype, shape=shape))
    return result


def _dim(size: int | torch.SymInt, names: dict[sympy.Symbol, str], op: str, node: Node) -> int | str:
    if not isinstance(size, torch.SymInt):
        return int(size)
    expression = expression_of(size)
    unknown = expression.free_symbols - set(names)
    if unknown:
        raise ExportError(
            f"{op}: an output's size {expression} depends on the data: give it a fixed capacity and a"
            " validity mask"
        )
    text = _expression(expression, names)
    if text is None:
        readable = str(expression.subs({symbol: sympy.Symbol(name) for symbol, name in names.items()}))
        raise ExportError(
            f"{op}: an output's size cannot be written down\n"
            f"  operator {node.target}\n"
            f"  because: it is {readable}, which is not made of + - * //\n  {SIZES}"
        )
    return int(text) if text.isdigit() else text


def _expression(e: sympy.Expr, names: dict[sympy.Symbol, str]) -> str | None:
    """The expression in the manifest's grammar: integers, symbols, + - * // ( ); None if it has others."""
    if e.is_Integer:
        return str(int(e))
    if e.is_Symbol:
        return names[e]
    if scaled := _scaled(e):
        part = _expression(scaled[0], names)
        return part and f"({part} * {scaled[1]} // {scaled[2]})"
    parts = [part for a in e.args if (part := _expression(a, names)) is not None]
    if len(parts) < len(e.args):
        return None
    if e.is_Add:
        return f"({' + '.join(parts)})"
    if e.is_Mul:
        return " * ".join(parts)
    if type(e).__name__ in ("FloorDiv", "CleanDiv"):
        return f"({parts[0]} // {f'({parts[1]})' if e.args[1].is_Mul else parts[1]})"
    return None


def _scaled(e: sympy.Expr) -> tuple[sympy.Expr, int, int] | None:
    """(n, p, q) of an expression n * p // q that torch writes as int(n * (p / q)), as for an image resized by
    a scale factor of 1.5. The product is exact if p and q are small and q is a power of 2."""
    if type(e).__name__ != "TruncToInt" or not e.args[0].is_Mul or len(e.args[0].args) != 2:
        return None
    factor, size = e.args[0].args
    if not isinstance(factor, sympy.Float) or type(size).__name__ != "ToFloat" or not factor > 0:
        return None
    p, q = float(factor).as_integer_ratio()
    return (size.args[0], p, q) if max(p, q) < 1 << 20 else None
