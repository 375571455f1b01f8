"""The export of an op to a bundle, stage by stage. The stages share an `ExportJob` (job.py)."""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable, Sequence
from contextlib import closing
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, cast

from torch import nn

import chiasm

from . import example_inputs
from .bundle import Writer
from .checks.arguments import check_call, check_inputs, check_results
from .checks.foreign import check_operators
from .checks.independence import SYMBOL, has_samples, independent
from .checks.purity import check_op, preserved
from .checks.trial import prepare, try_artifacts
from .documents import provenance, sbom
from .errors import ExportError, explain
from .formats import native, onnx, torchscript
from .job import Artifact, ExportJob, Method, call, run_eager
from .manifest import FORMATS, METHODS, SCHEMA_VERSION
from .spec import Spec, TensorSpec
from .text import first_sentence
from .tracing.gradient import vjp_module, vjp_signature
from .tracing.graph import output_specs
from .tracing.module import bind_spec

#: The function that makes a method's artifacts, for each format, in the bundle's order.
LOWERINGS = {"torchscript": torchscript.lower, "native": native.lower, "onnx": onnx.lower}


def export(
    fn: Callable[..., Any] | nn.Module,
    spec: Spec,
    path: str | Path,
    formats: Sequence[str] = FORMATS,
    isas: Sequence[str] = ("x86-64-v3",),
    methods: Sequence[str] | None = None,
    progress: Callable[[str], None] = lambda step: None,
) -> Path:
    """Export an op or a pipeline of ops, and write the bundle `path`/NAME.chiasm.

    Args:
        fn: a typed function on tensors, or an nn.Module (for example a torch.nn.Sequential of ops), which is
            exported in evaluation mode and left exactly as it was. It must give the same results for the same
            inputs, and change neither its inputs nor a state.
        spec: its inputs, outputs, configuration and tolerances.
        path: the folder that gets the bundle; created if it does not exist.
        formats: which of "torchscript", "onnx", "native" to make.
        isas: CPU levels, and GPUs ("sm_90"), to compile native code for.
        methods: ("forward",) omits the gradient, which takes most of an export's time; ("forward", "vjp")
            requires it. By default the gradient is exported in the formats that support it, and a warning
            names the others.
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
    check_call(fn, spec, path, formats, isas, METHODS if methods is None else methods)
    with preserved(fn):
        op = bind_spec(fn, spec)
        once = tuple(dict.fromkeys(formats)), tuple(dict.fromkeys(isas))
        with closing(ExportJob(fn, spec, *once, methods, progress, op)) as job:
            check(job)
            derive(job)
            describe(job)
            lower(job)
            writer = package(job)
            golden(job, writer)
            document(job, writer)
            return writer.write(Path(path))


# --- stages, in their order ---------------------------------------------------------------------------------


def check(job: ExportJob) -> None:
    """Reject an op that fails or is not a function of its inputs, before a tracer reports it in its own
    words."""
    job.progress("check")
    copied = [_check(job, variant) for variant in job.variants]
    if any(map(any, copied)):
        # Copy an output that is an input, or another output: a graph's outputs must be tensors of their own.
        job.op = bind_spec(job.fn, job.spec, [any(of) for of in zip(*copied, strict=True)])


def _check(job: ExportJob, variant: str | None) -> list[bool]:
    """For each result, whether it is itself an input or another result."""
    sizes = example_inputs.fit(job.spec, example_inputs.GOLDEN)
    inputs = example_inputs.make(job.spec, sizes, variant)
    check_inputs(job.spec, inputs, sizes, variant)
    try:
        copied = check_op(
            job.spec.name, lambda tensors: check_results(job.spec, call(job.op, tensors)), inputs, job.op
        )
        check_operators(job.spec.name, partial(call, job.op), inputs, job.formats)
        return copied
    except ExportError:
        raise
    except (Exception, SystemExit) as error:
        raise explain(
            job.spec.name,
            None,
            error,
            shapes=", ".join(f"{key} {tuple(t.shape)}" for key, t in inputs.items()),
        ) from error


def derive(job: ExportJob) -> None:
    """Find the outputs' dtypes and shapes from a first graph, and from them the gradient's signature."""
    job.progress("trace")
    forward = [
        Method(job, "forward", variant, job.op, job.spec.inputs, job.outputs) for variant in job.variants
    ]
    job.outputs += output_specs(forward[0].program("onnx"), job.spec, job.variants[0])
    job.work = forward
    if job.methods_asked is None or "vjp" in job.methods_asked:
        job.gradient = vjp_signature(job.spec, job.outputs)
    if job.gradient:
        # For other dtypes the torch backend's autograd computes the gradient.
        module = vjp_module(job.op, job.spec, job.outputs)
        assert module is not None
        vjp = Method(job, "vjp", job.variants[0], module, *job.gradient)
        # Last, so that the others are compiled while it is traced, which takes the longest.
        job.work = [*forward, vjp]


def describe(job: ExportJob) -> None:
    """Write the manifest's methods: signatures, tolerances, whether samples are independent."""
    signatures = {m.name: (m.inputs, m.outputs) for m in job.work}
    job.methods = {name: _described(job.spec, name, *signature) for name, signature in signatures.items()}
    if "native" in job.formats:
        job.progress("samples")
        if _independent(job):
            for name, signature in signatures.items():
                if has_samples(*signature):
                    job.methods[name]["samples"] = SYMBOL


def _independent(job: ExportJob) -> bool:
    """Whether the forward's samples are independent. A gradient's are if the forward's are and no gradient is
    a sum over the batch."""
    spec = job.spec
    if not has_samples(spec.inputs, job.outputs) or spec.limits(SYMBOL)[0] != 1 or spec.limits(SYMBOL)[1] < 2:
        return False
    variant = job.variants[0]
    made = example_inputs.make(spec, example_inputs.fit(spec, example_inputs.TESTS[1]), variant)
    tolerances = [spec.tolerance("forward", str(variant) if t.dtype == "T" else t.dtype) for t in job.outputs]
    return independent(lambda tensors: run_eager(job.op, tensors), spec.inputs, made, tolerances)


def lower(job: ExportJob) -> None:
    """Start every artifact: each method at each dtype in each format. Compilers may still run after this."""
    prepare()
    for format in LOWERINGS:  # one after the other: ONNX is made while native code is compiled
        for method in job.work:
            if format in job.formats:
                _try(job, method.name, format, partial(_lower, job, method, format))
    for method in job.work:
        method.forget()


def _lower(job: ExportJob, method: Method, format: str) -> None:
    job.artifacts.extend(LOWERINGS[format](job, method))


def package(job: ExportJob) -> Writer:
    """Wait for the artifacts that `lower` started, and put them into a bundle."""
    writer = Writer(_manifest(job))
    for artifact in job.artifacts:
        _try(job, artifact.method, artifact.format, partial(_add, writer, artifact))
    if job.gradient and not job.methods["vjp"]["artifacts"]:
        del job.methods["vjp"]
    for format, error in job.without_gradient.items():
        reason = "; ".join(line.strip() for line in str(error).splitlines()[1:])
        asked = "methods=('forward',) asks for none, methods=('forward', 'vjp') for all or an error"
        warnings.warn(
            f"{job.spec.name}: exported without its gradient in the format {format}: {reason} ({asked})",
            stacklevel=3,
        )
    return writer


def _add(writer: Writer, artifact: Artifact) -> None:
    data, entry = artifact.made()
    writer.artifact(artifact.method, artifact.file, data, **entry)


def _try(job: ExportJob, method: str, format: str, step: Callable[[], None]) -> None:
    """Do a step of a method. If it fails for a gradient, the format has no gradient."""
    try:
        step()
    except ExportError as error:
        if method != "vjp":
            raise
        job.lacks_gradient(format, error)


def golden(job: ExportJob, writer: Writer) -> None:
    """Run the artifacts and compare them with eager Python at several sizes. Add the inputs and results of
    one, by which a bundle tests itself."""
    job.progress("compare")
    writer.golden(try_artifacts(job, writer))


def document(job: ExportJob, writer: Writer) -> None:
    """Add the list of the bundle's parts and its provenance."""
    asked = {"formats": job.formats, "isas": job.isas, "methods": job.methods_asked or METHODS}
    try:
        writer.document("sbom", "sbom.cdx.json", sbom(writer.manifest, writer.files))
        # which names the list, too
        origin = provenance(job.fn, writer.manifest, writer.files, asked)
        writer.document("provenance", "provenance.json", origin)
    except OSError as error:  # a full disk: compiled code is read from a file
        raise explain(job.spec.name, "a bundle", error) from error


# --- the manifest -------------------------------------------------------------------------------------------


def _manifest(job: ExportJob) -> dict[str, Any]:
    spec = job.spec
    producer = {"chiasm": chiasm.__version__}
    for dependency in ("torch", "onnx", "onnxscript"):
        try:
            producer[dependency] = version(dependency)
        except PackageNotFoundError:
            continue
    return {
        "schema_version": SCHEMA_VERSION,
        "name": spec.name,
        "version": spec.version,
        "summary": spec.summary or first_sentence(inspect.getdoc(job.fn)),
        "reference": spec.reference,
        "created": "",
        "producer": producer,
        "config": {key: _listed(value) for key, value in sorted(spec.config.items())},
        "symbols": {name: {"min": low, "max": high} for name, (low, high) in spec.used_symbols().items()},
        "dtypes": list(spec.dtypes) if spec.generic else [],
        "methods": job.methods,
        "golden": {},
    }


def _listed(value: Any) -> Any:
    """A setting as JSON has it."""
    return list(cast("tuple[Any, ...]", value)) if isinstance(value, tuple) else value


def _described(
    spec: Spec, method: str, inputs: Sequence[TensorSpec], outputs: Sequence[TensorSpec]
) -> dict[str, Any]:
    return {
        "inputs": [_tensor(t) for t in inputs],
        "outputs": [_tensor(t) for t in outputs],
        "tolerances": _tolerances(spec, method, outputs),
        "artifacts": [],
    }


def _tensor(t: TensorSpec) -> dict[str, Any]:
    return {
        "name": t.name,
        "dtype": t.dtype,
        "shape": list(t.shape),
        "layout": t.layout,
        "color": t.color,
        "range": None if t.range is None else list(t.range),
        "description": t.description,
    }


def _tolerances(spec: Spec, method: str, outputs: Sequence[TensorSpec]) -> dict[str, Any]:
    dtypes = dict.fromkeys(d for t in outputs for d in (spec.dtypes if t.dtype == "T" else (t.dtype,)))
    found = {d: spec.tolerance(method, d) for d in dtypes}
    return {d: {"atol": t.atol, "rtol": t.rtol} for d, t in found.items() if t is not None}
