"""One call from an op to a bundle."""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import torch
from torch import nn
from torch.export import ExportedProgram

import chiasm

from . import samples
from .bundle import Golden, Writer
from .checks import check_call, check_inputs, check_results
from .documents import provenance, sbom
from .errors import ExportError, explain
from .graph import output_specs, trace, trace_vjp, vjp_module, vjp_signature
from .independence import SYMBOL, has_samples, independent
from .manifest import FORMATS, METHODS, SCHEMA_VERSION
from .module import bind
from .native import NativeCode, signature_text, to_native
from .onnx_format import IR_VERSION, OPSET, onnx_bytes, to_fused_onnx, to_onnx
from .purity import check_op, preserved
from .spec import Spec, TensorSpec
from .torchscript import to_torchscript


def export(
    fn: Callable | nn.Module,
    spec: Spec,
    path: str | Path,
    formats: Sequence[str] = FORMATS,
    isas: Sequence[str] = ("x86-64-v3",),
    methods: Sequence[str] | None = None,
    progress: Callable[[str], None] = lambda step: None,
) -> Path:
    """Export an op or a pipeline of ops, and write the bundle `path`/NAME.chiasm.

    Args:
        fn: a typed function on tensors, or an nn.Module (torch.nn.Sequential of ops, say), which is exported in evaluation mode and
            left exactly as it was. It gives the same for the same inputs, and changes neither them nor a state.
        spec: its inputs, outputs, configuration and tolerances.
        path: the folder that gets the bundle; made where it does not exist.
        formats: which of "torchscript", "onnx", "native" to make.
        isas: CPU levels to compile native code for.
        methods: ("forward",) leaves the gradient out, which takes most of an export's time; ("forward", "vjp") demands it. Without
            either the gradient is exported in the formats that have one, and a warning names the others.
        progress: called with the name of each step as it begins.

    Returns:
        The bundle's folder.

    Raises:
        ExportError: names the format, the line or operator at fault, and the reason.

    Example:
        >>> from chiasm.export import Spec, export, image
        >>> from chiasm.filters import sobel
        >>> bundle = export(sobel, Spec("my.sobel", [image()]), "/tmp/bundles", formats=["onnx"])
        >>> bundle.name
        'my.sobel.chiasm'
    """
    check_call(fn, spec, formats, isas, METHODS if methods is None else methods)
    with preserved(fn), closing(_Export(fn, spec, formats, isas, methods, progress)) as making:
        return making.run(Path(path))


class _Export:
    """One export, step by step."""

    def __init__(self, fn, spec: Spec, formats, isas, methods, progress) -> None:
        self.fn, self.spec, self.formats, self.isas, self.methods, self.progress = fn, spec, formats, isas, methods, progress
        self.op = bind(fn, [t.name for t in spec.inputs], spec.config, spec.name)
        self.cases: list[Golden] = []
        self.codes: list[NativeCode] = []
        self.later: list[Callable[[], None]] = []  # what is put into the bundle when all is traced, in its order: compilers work meanwhile
        self.missing: dict[str, ExportError] = {}  # formats without the gradient, and why

    def close(self) -> None:
        """Leave no compiler at work."""
        for code in self.codes:
            code.close()

    def run(self, path: Path) -> Path:
        spec, variants = self.spec, self.spec.variants()
        self.progress("check")
        taken = [self._check(variant) for variant in variants]
        if any(map(any, taken)):
            self.op = bind(self.fn, [t.name for t in spec.inputs], spec.config, spec.name, [any(of) for of in zip(*taken, strict=True)])
        self.progress("trace")
        first = trace(self.op, spec, list(spec.inputs), samples.make(spec, samples.fit(spec, samples.EXAMPLE), variants[0]), "onnx")
        self.outputs = output_specs(first, spec, variants[0])
        self.gradient = vjp_signature(spec, self.outputs) if self.methods is None or "vjp" in self.methods else None
        self.writer = Writer(_manifest(self.fn, spec, self.outputs, self.gradient))
        if "native" in self.formats:
            self.progress("samples")
            signatures = {"forward": (list(spec.inputs), self.outputs)} | ({"vjp": self.gradient} if self.gradient else {})
            _note_samples(self.op, spec, self.writer.manifest["methods"], signatures)
        if "torchscript" in self.formats:
            self.progress("torchscript")
            data = to_torchscript(self.op, spec)
            entry = {"backend": "torch", "format": "torchscript", "dtypes": [v for v in variants if v], "device": "any"}
            self.writer.artifact("forward", "forward.pt", data, **entry)
            if self.gradient:
                self.writer.artifact("vjp", "forward.pt", data, autograd=True, **entry)
        for variant in variants:
            self._forward(variant, first if variant == variants[0] else None)
            if self.gradient and variant == variants[0]:  # other dtypes: the torch backend's autograd
                self._gradient(variant)
        for step in self.later:
            step()
        self._warn()
        self.writer.golden(self.cases)
        asked = {"formats": self.formats, "isas": self.isas, "methods": self.methods or METHODS}
        self.writer.document("sbom", "sbom.cdx.json", sbom(self.writer.manifest, self.writer.files))
        self.writer.document("provenance", "provenance.json", provenance(self.fn, self.writer.manifest, self.writer.files, asked))
        return self.writer.write(path)

    def _check(self, variant: str | None) -> list[bool]:
        """Refuse an op that fails or is no function of its inputs, before a tracer tells it in its own words; returns which results are
        an input themselves, or another result."""
        sizes = samples.fit(self.spec, samples.GOLDEN)
        inputs = samples.make(self.spec, sizes, variant)
        check_inputs(self.spec, inputs, sizes, variant)
        try:
            return check_op(self.spec.name, lambda tensors: check_results(self.spec, _call(self.op, tensors)), inputs, self.op)
        except ExportError:
            raise
        except (Exception, SystemExit) as error:
            raise explain(self.spec.name, None, error, shapes=", ".join(f"{key} {tuple(t.shape)}" for key, t in inputs.items())) from error

    def _forward(self, variant: str | None, traced: ExportedProgram | None) -> None:
        spec, inputs = self.spec, list(self.spec.inputs)
        example = samples.make(spec, samples.fit(spec, samples.EXAMPLE), variant)
        if "native" in self.formats:
            again = partial(trace, self.op, spec, inputs, example, "native")
            self._native("forward", variant, traced if traced and spec.takes_gradients else again(), again, inputs, self.outputs)
        if "onnx" in self.formats and variant != "bfloat16":  # ONNX Runtime's CPU kernels have no bfloat16
            self._onnx("forward", variant, traced or trace(self.op, spec, inputs, example, "onnx"), inputs, self.outputs)
        self.later.append(partial(self._golden, "forward", variant, self.op, inputs, self.outputs))

    def _gradient(self, variant: str | None) -> None:
        """The gradient in the formats that have one; in all, where it was asked for."""
        module, (inputs, outputs) = vjp_module(self.op, self.spec, self.outputs), self.gradient
        try:
            example = with_cotangents(self.op, self.spec, samples.fit(self.spec, samples.EXAMPLE), variant, inputs)
            # Backward passes are traced in one form for all targets, and tracing is the slow part: once serves both.
            self.progress(f"vjp{_suffix(variant)} trace")
            traced = trace_vjp(module, self.spec, inputs, example)
        except ExportError as error:
            self._lacks([f for f in ("native", "onnx") if f in self.formats], error)
        else:
            again = partial(trace_vjp, module, self.spec, inputs, example)
            makers = {"native": lambda: self._native("vjp", variant, traced, again, inputs, outputs), "onnx": lambda: self._onnx("vjp", variant, traced, inputs, outputs)}
            for form, make in makers.items():
                if form in self.formats and (form, variant) != ("onnx", "bfloat16"):
                    self._try("vjp", form, make)
        self.later.append(partial(self._end_gradient, variant, module, inputs, outputs))

    def _end_gradient(self, variant: str | None, module: nn.Module, inputs: list[TensorSpec], outputs: list[TensorSpec]) -> None:
        if self.writer.manifest["methods"]["vjp"]["artifacts"]:
            self._golden("vjp", variant, module, inputs, outputs)
        else:
            del self.writer.manifest["methods"]["vjp"]

    def _try(self, method: str, form: str, step: Callable[[], None]) -> None:
        """Do a step of a method, of which a gradient may lack the format."""
        try:
            step()
        except ExportError as error:
            if method != "vjp":
                raise
            self._lacks([form], error)

    def _lacks(self, formats: list[str], error: ExportError) -> None:
        if self.methods is not None:
            raise error
        self.missing |= dict.fromkeys(formats, error)

    def _warn(self) -> None:
        for form, error in self.missing.items():
            reason = "; ".join(line.strip() for line in str(error).splitlines()[1:])
            asked = "methods=('forward',) asks for none, methods=('forward', 'vjp') for all or an error"
            warnings.warn(f"{self.spec.name}: exported without its gradient in the format {form}: {reason} ({asked})", stacklevel=4)

    def _native(
        self, method: str, variant: str | None, program: ExportedProgram, again: Callable[[], ExportedProgram], inputs: list[TensorSpec], outputs: list[TensorSpec]
    ) -> None:
        signature = signature_text(self.spec, inputs, outputs, variant, self.writer.manifest["methods"][method].get("samples"))
        for isa in self.isas:
            self.progress(f"{method}{_suffix(variant)} {isa}")
            self.codes.append(to_native(program, self.spec, isa, signature, again, self.codes[-1] if self.codes else None))
            self.later.append(partial(self._try, method, "native", partial(self._end_native, method, variant, isa, self.codes[-1])))

    def _end_native(self, method: str, variant: str | None, isa: str, code: NativeCode) -> None:
        made = code.artifact()
        backend = {"backend": "torch", "needs": ["libtorch"], "why": made.why} if made.needs_libtorch else {"backend": "native", "needs": []}
        entry = {"format": "aotinductor", "dtypes": [variant] if variant else [], "device": "cpu", "isa": isa, "glibc": made.glibc()}
        self.writer.artifact(method, f"{method}{_suffix(variant)}.{isa}.pt2", made.data, **backend, **entry)

    def _onnx(self, method: str, variant: str | None, program: ExportedProgram, inputs: list[TensorSpec], outputs: list[TensorSpec]) -> None:
        self.progress(f"{method}{_suffix(variant)} onnx")
        # It may change the program: whatever else is made of that comes before.
        flat = to_onnx(program, self.spec, inputs, outputs, method)
        fused = to_fused_onnx(flat, self.spec, method)
        entry = {"backend": "onnx", "format": "onnx", "dtypes": [variant] if variant else [], "device": "any", "opset": OPSET, "ir_version": IR_VERSION}
        files = [(f"{method}{_suffix(variant)}.{form}", onnx_bytes(model, self.spec.name)) for form, model in (("onnx", flat), ("fused.onnx", fused))]
        self.later.append(partial(self.writer.artifact, method, *files[0], **entry))
        self.later.append(partial(self.writer.artifact, method, *files[1], **entry, function=fused.functions[0].name))

    def _golden(self, method: str, variant: str | None, module: nn.Module, inputs: list[TensorSpec], outputs: list[TensorSpec]) -> None:
        made = with_cotangents(self.op, self.spec, samples.fit(self.spec, samples.GOLDEN), variant, inputs)
        self.cases.append(Golden(method, variant, made | dict(zip([t.name for t in outputs], run_eager(module, made), strict=True))))


def _suffix(variant: str | None) -> str:
    return f".{variant}" if variant else ""


def with_cotangents(op: nn.Module, spec: Spec, sizes: dict[str, int], variant: str | None, tensors: list[TensorSpec]) -> dict[str, torch.Tensor]:
    """Inputs for a method: the spec's, and for a vjp random cotangents of the outputs' shapes."""
    made = samples.make(spec, sizes, variant)
    extra = [t for t in tensors if t.name not in made]
    if extra:
        generator = torch.Generator().manual_seed(1)
        shaped = dict(zip([f"grad_{t.name}" for t in spec.outputs], run_eager(op, made), strict=True))
        for tensor in extra:
            like = shaped[tensor.name]
            made[tensor.name] = (torch.rand(like.shape, generator=generator, dtype=torch.float64) * 2 - 1).to(like.dtype)
    return made


def run_eager(module: nn.Module, inputs: dict[str, torch.Tensor]) -> tuple[torch.Tensor, ...]:
    """The reference: what eager Python gives."""
    result = _call(module, inputs)
    return tuple(r.detach() for r in (result if isinstance(result, (tuple, list)) else (result,)))


def _call(module: nn.Module, inputs: Mapping[str, torch.Tensor]) -> Any:
    with torch.enable_grad():  # a step of an optimisation takes gradients itself
        return module(*inputs.values())


def _manifest(fn, spec: Spec, outputs: list[TensorSpec], gradient) -> dict[str, Any]:
    producer = {"chiasm": chiasm.__version__}
    for package in ("torch", "onnx", "onnxscript"):
        try:
            producer[package] = version(package)
        except PackageNotFoundError:
            continue
    methods = {"forward": _method(spec, "forward", list(spec.inputs), outputs)}
    if gradient:
        methods["vjp"] = _method(spec, "vjp", *gradient)
    return {
        "schema_version": SCHEMA_VERSION,
        "name": spec.name,
        "version": spec.version,
        "summary": spec.summary or _summary(fn),
        "reference": spec.reference,
        "created": "",
        "producer": producer,
        "config": {k: list(v) if isinstance(v, tuple) else v for k, v in sorted(spec.config.items())},
        "symbols": {name: {"min": low, "max": high} for name, (low, high) in spec.used_symbols().items()},
        "dtypes": list(spec.dtypes) if spec.generic else [],
        "methods": methods,
        "golden": {},
    }


def _note_samples(op: nn.Module, spec: Spec, methods: dict[str, Any], signatures: dict[str, tuple[list[TensorSpec], list[TensorSpec]]]) -> None:
    """Say of each method whether its samples are independent; a gradient's are where the forward's are and no gradient is a sum over the batch."""
    inputs, outputs = signatures["forward"]
    if not has_samples(inputs, outputs) or spec.limits(SYMBOL)[0] != 1 or spec.limits(SYMBOL)[1] < 2:
        return
    variant = spec.variants()[0]
    made = samples.make(spec, samples.fit(spec, samples.TESTS[1]), variant)
    tolerances = [spec.tolerance("forward", variant if t.dtype == "T" else t.dtype) for t in outputs]
    if not independent(lambda tensors: run_eager(op, tensors), inputs, made, tolerances):
        return
    for method, signature in signatures.items():
        if has_samples(*signature):
            methods[method]["samples"] = SYMBOL


def _method(spec: Spec, method: str, inputs: list[TensorSpec], outputs: list[TensorSpec]) -> dict[str, Any]:
    return {"inputs": [_tensor(t) for t in inputs], "outputs": [_tensor(t) for t in outputs],
            "tolerances": _tolerances(spec, method, outputs), "artifacts": []}


def _tensor(t: TensorSpec) -> dict[str, Any]:
    return {"name": t.name, "dtype": t.dtype, "shape": list(t.shape), "layout": t.layout, "color": t.color,
            "range": None if t.range is None else list(t.range), "description": t.description}


def _tolerances(spec: Spec, method: str, outputs: list[TensorSpec]) -> dict[str, Any]:
    dtypes = dict.fromkeys(d for t in outputs for d in (spec.dtypes if t.dtype == "T" else (t.dtype,)))
    found = {d: spec.tolerance(method, d) for d in dtypes}
    return {d: {"atol": t.atol, "rtol": t.rtol} for d, t in found.items() if t is not None}


def _summary(fn) -> str:
    return (inspect.getdoc(fn) or "").split("\n")[0]
