"""The gradient of an op as a module of its own, `vjp`, and its graph."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import torch
from torch import nn
from torch.export import ExportedProgram
from torch.fx.experimental.proxy_tensor import make_fx

from chiasm.primitives.core.target import exporting

from ..checks.branches import Doubt
from ..errors import explain
from ..internals import decompositions_of
from ..patches.tracing import fast_tracing
from ..spec import Spec, TensorSpec
from .adaptive_means import MEANS
from .gradient_parts import joined
from .graph import Inputs, trace
from .grid_sample import GridSampling
from .module import bind, results_of


def vjp_signature(spec: Spec, outputs: list[TensorSpec]) -> tuple[list[TensorSpec], list[TensorSpec]] | None:
    """Inputs and outputs of the method `vjp`: the forward's inputs and a `grad_` per floating output, to a
    `grad_` per differentiable input. None if there is nothing to differentiate."""
    wanted = spec.differentiated()
    seeds = [t for t in outputs if t.dtype == "T" or t.dtype.startswith(("float", "bfloat"))]
    if not wanted or not seeds:
        return None
    cotangents = [
        replace(
            t,
            name=f"grad_{t.name}",
            range=(-1.0, 1.0),
            description=f"gradient with respect to output {t.name}",
        )
        for t in seeds
    ]
    gradients = [
        replace(t, name=f"grad_{t.name}", range=None, description=f"gradient with respect to input {t.name}")
        for t in spec.inputs
        if t.name in wanted
    ]
    return list(spec.inputs) + cotangents, gradients


class _Vjp(nn.Module):
    """inputs..., cotangents... -> gradients, by torch.func."""

    def __init__(
        self, op: nn.Module, input_names: list[str], gradients: list[str], floating_outputs: list[int]
    ) -> None:
        super().__init__()
        self.op, self.input_names, self.gradients, self.floating_outputs = (
            op,
            input_names,
            gradients,
            floating_outputs,
        )

    def forward(self, *args: torch.Tensor) -> tuple[torch.Tensor, ...]:
        inputs = dict(zip(self.input_names, args, strict=False))
        cotangents = args[len(self.input_names) :]

        def of_differentiable(*values: torch.Tensor) -> tuple[torch.Tensor, ...]:
            merged = inputs | dict(zip(self.gradients, values, strict=True))
            results = results_of(self.op(*(merged[n] for n in self.input_names)))
            return tuple(results[i] for i in self.floating_outputs)

        pullback = torch.func.vjp(of_differentiable, *(inputs[n] for n in self.gradients))[1]
        # Copy a gradient that is itself a cotangent: a graph's outputs must not be its inputs.
        return tuple(g.clone() if any(g is c for c in cotangents) else g for g in pullback(tuple(cotangents)))


def vjp_module(op: nn.Module, spec: Spec, outputs: list[TensorSpec]) -> nn.Module | None:
    """The eager vjp of a bound op, or None if it has none."""
    signature = vjp_signature(spec, outputs)
    if signature is None:
        return None
    seeds = [i for i, t in enumerate(outputs) if any(s.name == f"grad_{t.name}" for s in signature[0])]
    return _Vjp(
        op, [t.name for t in spec.inputs], [t.name.removeprefix("grad_") for t in signature[1]], seeds
    )


def trace_vjp(
    module: nn.Module,
    spec: Spec,
    tensors: Sequence[TensorSpec],
    inputs: Inputs,
    doubts: list[Doubt] | None = None,
) -> ExportedProgram:
    """Export a vjp, or a function that computes gradients itself: torch.export can trace neither, so make_fx
    turns it into a plain graph first."""
    args = tuple(inputs[t.name] for t in tensors)
    try:
        with exporting("vjp"), fast_tracing(), GridSampling():
            graph = make_fx(
                module,
                tracing_mode="symbolic",
                decomposition_table=MEANS | decompositions_of([torch.ops.aten.rsub]),
                _allow_non_fake_inputs=True,
            )(*args)
    except Exception as error:
        raise explain(spec.name, "a gradient graph", error) from error
    graph = joined(graph)
    return trace(
        bind(graph, {t.name: f"{t.name}={t.name}" for t in tensors}, {}, spec.name),
        spec,
        tensors,
        inputs,
        "vjp",
        doubts,
    )
