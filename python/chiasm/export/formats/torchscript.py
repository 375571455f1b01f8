# torch.jit's functions have hardly any types.
# pyright: reportUnknownMemberType=false
"""The TorchScript exporter: by script, never by trace, so that every branch of the op is in the file."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator

import torch
from torch import nn
from torch.nn.utils import parametrize

from ..checks.script_purity import check_script
from ..errors import ExportError, explain
from ..job import Artifact, ExportJob, Method
from ..spec import Spec
from .torchscript_division import guard_quotients


def lower(job: ExportJob, method: Method) -> Iterator[Artifact]:
    """One file for all dtypes and both methods: for the gradient, the backend uses the op's own autograd."""
    if method.variant != job.variants[0]:
        return
    entry = {
        "backend": "torch",
        "format": "torchscript",
        "dtypes": [v for v in job.variants if v],
        "device": "any",
    }
    file, first = "forward.pt", next((a for a in job.artifacts if a.format == "torchscript"), None)
    if first is not None:
        yield Artifact(
            method.name, "torchscript", file, lambda: (first.made()[0], entry | {"autograd": True})
        )
        return
    job.progress("torchscript")
    data = to_torchscript(job.op, job.spec)
    yield Artifact(method.name, "torchscript", file, lambda: (data, entry))


def to_torchscript(module: nn.Module, spec: Spec) -> bytes:
    """The bytes of a `.pt`."""
    if any(map(parametrize.is_parametrized, module.modules())):  # scripted, it would fail when it is run
        raise ExportError(
            f"{spec.name}: cannot be exported to TorchScript\n  because: it has parametrized weights\n"
            "  instead: call torch.nn.utils.parametrize.remove_parametrizations first; their values are kept"
        )
    try:
        scripted = torch.jit.script(module)
    except Exception as error:
        raise explain(spec.name, "TorchScript", error) from error
    check_script(
        spec.name, scripted, {t.name: spec.dtypes if t.dtype == "T" else (t.dtype,) for t in spec.inputs}
    )
    guard_quotients(scripted)
    buffer = io.BytesIO()
    try:
        torch.jit.save(scripted, buffer)
    except Exception as error:  # a call of Python, as an autograd.Function is
        raise explain(spec.name, "TorchScript", error) from error
    return _anywhere(buffer)


def _anywhere(program: io.BytesIO) -> bytes:
    """The program without traces of the exporting machine: the paths of the sources, and a number that
    depends on them."""
    result = io.BytesIO()
    with zipfile.ZipFile(program) as given, zipfile.ZipFile(result, "w", zipfile.ZIP_STORED) as kept:
        for entry in given.infolist():
            if not entry.filename.endswith((".debug_pkl", ".data/serialization_id")):
                kept.writestr(zipfile.ZipInfo(entry.filename, (1980, 1, 1, 0, 0, 0)), given.read(entry))
    return result.getvalue()
