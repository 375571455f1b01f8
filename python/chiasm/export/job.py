"""The data of the exporter's stages (pipeline.py): the request, and the results that each stage adds."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import deepcopy
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import torch
from torch import nn
from torch.export import ExportedProgram
from torch.fx import GraphModule

from . import example_inputs
from .checks.branches import Doubt
from .checks.quotients import SafeQuotients
from .errors import ExportError
from .formats.compiler import AT_ONCE
from .spec import Spec, TensorSpec
from .tracing.gradient import trace_vjp
from .tracing.graph import trace
from .tracing.module import results_of

if TYPE_CHECKING:
    from .formats.native import NativeCode

Tensors = dict[str, torch.Tensor]


def run_eager(module: nn.Module, inputs: Mapping[str, torch.Tensor]) -> tuple[torch.Tensor, ...]:
    """The reference: the results of eager Python."""
    return tuple(result.detach() for result in results_of(call(module, inputs)))


def call(module: nn.Module, inputs: Mapping[str, torch.Tensor]) -> Any:
    """The module's result, unchanged."""
    with torch.enable_grad(), SafeQuotients():  # an optimisation step computes gradients itself
        return module(*inputs.values())


def with_cotangents(
    op: nn.Module, spec: Spec, sizes: dict[str, int], variant: str | None, tensors: Sequence[TensorSpec]
) -> Tensors:
    """Inputs for a method: the spec's, and for a vjp random cotangents of the outputs' shapes."""
    made = example_inputs.make(spec, sizes, variant)
    extra = [t for t in tensors if t.name not in made]
    if extra:
        generator = torch.Generator().manual_seed(1)
        shaped = dict(zip([f"grad_{t.name}" for t in spec.outputs], run_eager(op, made), strict=True))
        for tensor in extra:
            like = shaped[tensor.name]
            made[tensor.name] = (torch.rand(like.shape, generator=generator, dtype=torch.float64) * 2 - 1).to(
                like.dtype
            )
    return made


@dataclass
class Method:
    """A method of the bundle for one value of T, from which every format makes its artifact.

    name: "forward" or "vjp".
    variant: what T stands for; None for an op without T.
    module: computes it, eager.
    doubts: sizes that its graphs were not made for.
    """

    job: ExportJob
    name: str
    variant: str | None
    module: nn.Module
    inputs: Sequence[TensorSpec]
    outputs: Sequence[TensorSpec]
    doubts: list[Doubt] = field(default_factory=list)
    _programs: dict[str, ExportedProgram | ExportError] = field(default_factory=dict)

    @property
    def title(self) -> str:
        """The name in messages: "forward float32"."""
        return self.file.replace(".", " ")

    @property
    def file(self) -> str:
        """The prefix of its files' names: "forward.float32"."""
        return f"{self.name}.{self.variant}" if self.variant else self.name

    @property
    def dtypes(self) -> list[str]:
        """The manifest's entry."""
        return [self.variant] if self.variant else []

    def tensors(self, sizes: Mapping[str, int]) -> Tensors:
        """Inputs of given sizes."""
        return with_cotangents(
            self.job.op,
            self.job.spec,
            example_inputs.fit(self.job.spec, dict(sizes)),
            self.variant,
            self.inputs,
        )

    def program(self, target: str) -> ExportedProgram:
        """The traced graph for a target ("onnx", "native"), a copy that the caller may change. Tracing is
        slow, so it is done once per target, and once for all targets if the graph computes gradients, which
        have one form."""
        gradients = self.name == "vjp" or self.job.spec.takes_gradients
        key = "vjp" if gradients else target
        if key not in self._programs:
            if gradients:
                self.job.progress(f"{self.title} trace")
            sizes = example_inputs.EXAMPLE | example_inputs.example(self.job.spec, self.inputs)
            arguments = (self.module, self.job.spec, self.inputs, self.tensors(sizes))
            try:
                self._programs[key] = (
                    trace_vjp(*arguments, self.doubts)
                    if gradients
                    else trace(*arguments, target, self.doubts)
                )
            except ExportError as error:
                self._programs[key] = error
        found = self._programs[key]
        if isinstance(found, ExportError):
            raise found
        return _copied(found)

    def forget(self) -> None:
        """Drop the graphs, which are large; a graph that is needed again is traced again."""
        self._programs.clear()


def _copied(program: ExportedProgram) -> ExportedProgram:
    """A copy whose nodes have the names in the signature: deepcopy renames `input` to `input_1`, because
    Python has a builtin `input`."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # PyTorch's warnings about itself
        result = deepcopy(program)
    for module, copy in zip(program.graph_module.modules(), result.graph_module.modules(), strict=True):
        if isinstance(module, GraphModule) and isinstance(copy, GraphModule):
            for node, other in zip(module.graph.nodes, copy.graph.nodes, strict=True):
                other.name = node.name
            copy.recompile()
    return result


@dataclass
class Artifact:
    """A file of the bundle that is being exported.

    format: the requested format. made: waits for the file; returns its bytes, and its manifest entry without
    the file's name, size and hash.
    """

    method: str
    format: str
    file: str
    made: Callable[[], tuple[bytes, dict[str, Any]]]


@dataclass
class ExportJob:
    """One export. The first members are the caller's request; for each of the others, the stage that sets it
    is named."""

    fn: Callable[..., Any] | nn.Module
    spec: Spec
    formats: Sequence[str]
    isas: Sequence[str]
    methods_asked: Sequence[str] | None
    progress: Callable[[str], None]

    #: The op with its configuration bound (begin; check copies results that are inputs).
    op: nn.Module
    #: Outputs with their dtypes and shapes, and the gradient's inputs and outputs (derive).
    outputs: list[TensorSpec] = field(default_factory=list)
    gradient: tuple[list[TensorSpec], list[TensorSpec]] | None = None
    #: The manifest's methods (describe).
    methods: dict[str, dict[str, Any]] = field(default_factory=dict)
    #: The methods to export, one for each dtype (derive).
    work: list[Method] = field(default_factory=list)
    #: In the bundle's order, and what is still compiled (lower).
    artifacts: list[Artifact] = field(default_factory=list)
    compiling: list[NativeCode] = field(default_factory=list)
    compilers: ThreadPoolExecutor = field(default_factory=lambda: ThreadPoolExecutor(AT_ONCE))
    #: Formats without the gradient, and why (lower, package).
    without_gradient: dict[str, ExportError] = field(default_factory=dict)

    @property
    def variants(self) -> tuple[str | None, ...]:
        """The values of T."""
        return self.spec.variants()

    def lacks_gradient(self, format: str, error: ExportError) -> None:
        """Note that a format has no gradient. Raises `error` if the caller requested the gradient."""
        if self.methods_asked is not None:
            raise error
        self.without_gradient[format] = error

    def close(self) -> None:
        """Stop all compilers."""
        for code in self.compiling:
            code.close()
        self.compilers.shutdown()
