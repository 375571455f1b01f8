"""One call from an op to a bundle."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import torch
from torch import nn

import chiasm

from . import samples
from .bundle import Golden, Writer
from .errors import ExportError
from .graph import output_specs, trace, trace_vjp, vjp_module, vjp_signature
from .independence import SYMBOL, has_samples, independent
from .manifest import FORMATS, METHODS, SCHEMA_VERSION
from .module import bind
from .native import to_native
from .onnx_format import IR_VERSION, OPSET, onnx_bytes, to_fused_onnx, to_onnx
from .spec import Spec, TensorSpec
from .torchscript import to_torchscript


def export(
    fn: Callable | nn.Module,
    spec: Spec,
    path: str | Path,
    formats: Sequence[str] = FORMATS,
    isas: Sequence[str] = ("x86-64-v3",),
    methods: Sequence[str] = METHODS,
    progress: Callable[[str], None] = lambda step: None,
) -> Path:
    """Export an op or a pipeline of ops, and write the bundle `path`/NAME.chiasm.

    Args:
        fn: a typed function on tensors, or an nn.Module (torch.nn.Sequential of ops, say).
        spec: its inputs, outputs, configuration and tolerances.
        path: the folder that gets the bundle; made where it does not exist.
        formats: which of "torchscript", "onnx", "native" to make.
        isas: CPU levels to compile native code for.
        methods: ("forward",) leaves the gradient out, which takes most of an export's time.
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
    unknown = set(formats) - set(FORMATS)
    if unknown or not formats:
        raise ExportError(f"formats: expected some of {FORMATS}, got {tuple(formats)}")
    op = bind(fn, [t.name for t in spec.inputs], spec.config, spec.name)
    progress("trace")
    first = trace(op, spec, list(spec.inputs), samples.make(spec, samples.fit(spec, samples.EXAMPLE), spec.variants()[0]), "onnx")
    outputs = output_specs(first, spec, spec.variants()[0])
    gradient = vjp_signature(spec, outputs) if "vjp" in methods else None
    manifest = _manifest(fn, spec, outputs, gradient)
    if "native" in formats:
        progress("samples")
        _note_samples(op, spec, manifest["methods"], {"forward": (list(spec.inputs), outputs)} | ({"vjp": gradient} if gradient else {}))
    writer = Writer(manifest)
    if "torchscript" in formats:
        progress("torchscript")
        data = to_torchscript(op, spec.name)
        entry = {"backend": "torch", "format": "torchscript", "dtypes": [v for v in spec.variants() if v], "device": "any"}
        writer.artifact("forward", "forward.pt", data, **entry)
        if gradient:
            writer.artifact("vjp", "forward.pt", data, autograd=True, **entry)
    cases = []
    for variant in spec.variants():
        traced = first if variant == spec.variants()[0] else None
        _export_variant(op, spec, variant, traced, outputs, gradient, formats, isas, writer, cases, progress)
    writer.golden(cases)
    return writer.write(Path(path))


def _export_variant(op, spec, variant, traced, outputs, gradient, formats, isas, writer, cases, progress) -> None:
    inputs, dtypes = list(spec.inputs), [variant] if variant else []
    suffix = f".{variant}" if variant else ""
    methods: list[tuple[str, nn.Module, list[TensorSpec], list[TensorSpec]]] = [("forward", op, inputs, outputs)]
    pullback = vjp_module(op, spec, outputs) if gradient else None
    if gradient and pullback is not None and variant == spec.variants()[0]:  # other dtypes: the torch backend's autograd
        methods.append(("vjp", pullback, *gradient))
    for method, module, ins, outs in methods:
        example = with_cotangents(op, spec, samples.fit(spec, samples.EXAMPLE), variant, ins)
        if method == "vjp":
            # Backward passes are traced in one form for all targets, and tracing is the slow part: once serves both.
            progress(f"{method}{suffix} trace")
            traced = trace_vjp(module, spec, ins, example)
        if "native" in formats:
            program = traced if method == "vjp" or (traced and spec.takes_gradients) else trace(module, spec, ins, example, "native")
            for isa in isas:
                progress(f"{method}{suffix} {isa}")
                made = to_native(program, spec, isa)
                backend, needs = ("torch", ["libtorch"]) if made.needs_libtorch else ("native", [])
                writer.artifact(method, f"{method}{suffix}.{isa}.pt2", made.data, backend=backend, format="aotinductor", dtypes=dtypes, device="cpu", isa=isa, needs=needs)
        if "onnx" in formats and variant != "bfloat16":  # ONNX Runtime's CPU kernels have no bfloat16
            progress(f"{method}{suffix} onnx")
            # Last, because it may change the traced program.
            flat = to_onnx(traced or trace(module, spec, ins, example, "onnx"), spec, ins, outs, method)
            entry = {"backend": "onnx", "format": "onnx", "dtypes": dtypes, "device": "any", "opset": OPSET, "ir_version": IR_VERSION}
            writer.artifact(method, f"{method}{suffix}.onnx", onnx_bytes(flat, spec.name), **entry)
            fused = to_fused_onnx(flat, spec, method)
            writer.artifact(method, f"{method}{suffix}.fused.onnx", onnx_bytes(fused, spec.name), **entry, function=fused.functions[0].name)
        golden = with_cotangents(op, spec, samples.fit(spec, samples.GOLDEN), variant, ins)
        cases.append(Golden(method, variant, golden | dict(zip([t.name for t in outs], run_eager(module, golden), strict=True))))


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
    with torch.enable_grad():  # a step of an optimisation takes gradients itself
        result = module(*inputs.values())
    return tuple(r.detach() for r in (result if isinstance(result, (tuple, list)) else (result,)))


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
