# Inductor's interfaces are private, and its configuration and its names have no types.
# pyright: reportPrivateUsage=false, reportUnknownMemberType=false, reportUnknownVariableType=false
"""The native exporter: AOTInductor code, linked statically with a replacement of libtorch and with kernels
(runtime/artifact).

The result is a `.pt2`: a zip with the shared library in it. If an op calls an ATen function that has no
replacement, the package is AOTInductor's own, for the torch backend's loader, and its manifest entry says so
(`needs: libtorch`).
"""

from __future__ import annotations

import io
import json
import os
import platform
import tempfile
import warnings
import zipfile
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import closing, contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from shlex import quote
from typing import Any

import torch
from torch import Tensor
from torch.export import ExportedProgram

from .. import isas
from ..errors import ExportError, explain
from ..internals import Operator, expression_of, schema_of
from ..isas import ISAS, LINK_OF, compiler_command, library_folder, run_tool, settings
from ..job import Artifact, ExportJob, Method
from ..patches.cuda import gpu_compiler, on_gpu
from ..patches.index_checks import checked_native_code
from ..patches.inductor import fast_inductor, known_vectors, short_minima, stacked_planes
from ..patches.tracing import fast_tracing
from ..spec import Spec, TensorSpec
from . import compiler
from .compiler import HEADERS, Build
from .native_cache import (
    NativeArtifact,
    entry_of,
    keep,
    keep_reason,
    kept,
    missing_symbols,
    operators,
    reason,
    zipped,
)
from .native_sums import sum_in_steps
from .networks import use_kernels
from .selections import refuse_negative, select_by_tensors

#: Settings for code that needs libtorch: no exception may leave a parallel region.
_ONE_THREAD = {"cpp.threads": 1, "cpp.dynamic_threads": False}


def signature_text(
    spec: Spec,
    inputs: Sequence[TensorSpec],
    outputs: Sequence[TensorSpec],
    variant: str | None,
    batch: str | None,
) -> str:
    """The signature that compiled code relies on. The runtime writes the same text from the manifest
    (runtime/core/signature_text.cpp) and compares the two.

    Args:
        spec: the symbols' limits.
        inputs: of the method.
        outputs: of the method, with the shapes that were derived.
        variant: the value of T.
        batch: the symbol that counts independent samples, if there is one.
    """
    lines = ["chiasm 1"] + sorted(
        f"symbol {name} {low} {high}" for name, (low, high) in spec.used_symbols().items()
    )
    for kind, tensors in (("input", inputs), ("output", outputs)):
        for t in tensors:
            batched = " batched" if batch and t.shape[:1] == (batch,) else ""
            lines.append(
                f"{kind} {t.name} {variant if t.dtype == 'T' else t.dtype}"
                f" [{', '.join(map(str, t.shape))}]{batched}"
            )
    return "\n".join(lines) + "\n"


def lower(job: ExportJob, method: Method) -> Iterator[Artifact]:
    """Native code of a method for each CPU level and GPU. Compilers may still be running when this returns;
    the artifact waits for them."""
    batch = job.methods[method.name].get("samples")
    signature = signature_text(job.spec, method.inputs, method.outputs, method.variant, batch)
    for isa in job.isas:
        job.progress(f"{method.title} {isa}")
        code = to_native(
            method.program,
            job.spec,
            isa,
            signature,
            job.compilers,
            gradient=method.name == "vjp",
        )
        job.compiling.append(code)

        def made(code: NativeCode = code, isa: str = isa) -> tuple[bytes, dict[str, Any]]:
            artifact = code.artifact()
            needs: dict[str, Any] = {"backend": "native", "needs": []}
            if artifact.needs_libtorch:
                needs = {"backend": "torch", "needs": ["libtorch"], "why": artifact.why}
            return artifact.data, needs | {
                "format": "aotinductor",
                "dtypes": method.dtypes,
                **({"device": "cuda", "sm": ISAS[isa].sm} if ISAS[isa].sm else {"device": "cpu", "isa": isa}),
                "glibc": artifact.glibc(),
            }

        yield Artifact(method.name, "native", f"{method.file}.{isa}.pt2", made)


def to_native(
    program: Callable[[str], ExportedProgram],
    spec: Spec,
    isa: str,
    signature: str,
    compilers: Executor,
    gradient: bool = False,
) -> NativeCode:
    """Begin to compile for `isa`, a level of CPUs or a GPU, or fetch the same compilation from the cache. The
    code carries `signature`.

    `program` returns the program for a target ("native"), which may be changed. If the op turns out to need
    libtorch, the program without our kernels ("vjp") is used, because libtorch does not have these.
    `compilers` runs the compilers. `gradient`: whether the program computes a gradient.
    """
    if isa not in ISAS:
        raise ExportError(f"{spec.name}: isa: expected one of {sorted(ISAS)}, got {isa!r}")
    source = program("cuda" if ISAS[isa].sm else "native")
    if not ISAS[isa].sm:
        if not gradient:
            use_kernels(source)
        sum_in_steps(source)
    entry = entry_of(source, spec, isa, signature, gradient)
    build = None
    if not kept(entry) and not reason(entry):
        try:
            build = _begin(source, spec, isa, signature, compilers, gradient)
        except OSError as error:
            raise explain(spec.name, f"native code ({isa})", error) from error
    return NativeCode(spec, isa, signature, gradient, entry, build, program, compilers)


@dataclass
class NativeCode:
    """Native code that is being compiled. `artifact` waits for it; `close` cancels it."""

    spec: Spec
    isa: str
    signature: str
    gradient: bool
    entry: Path
    build: Build | None
    program: Callable[[str], ExportedProgram]
    compilers: Executor

    def artifact(self) -> NativeArtifact:
        """The code, which is in the cache from then on."""
        if data := kept(self.entry):
            return NativeArtifact(data, needs_libtorch=False)
        why = reason(self.entry)
        if not why:
            if self.build is None:
                raise ExportError(f"{self.entry}: was removed while it was needed: export again")
            try:
                code = self.build.library()
            except Exception as error:
                raise explain(self.spec.name, f"native code ({self.isa})", error) from error
            missing = missing_symbols(code)
            if not missing:
                data = zipped({"chiasm/op.so": code})
                keep(self.entry, data)
                return NativeArtifact(data, needs_libtorch=False)
            why = f"libtorch's {', '.join(missing)}"
            keep_reason(self.entry, why)
        return NativeArtifact(self._with_libtorch(why), needs_libtorch=True, why=why)

    def _with_libtorch(self, why: str) -> bytes:
        if ISAS[self.isa].sm:
            raise ExportError(
                f"{self.spec.name}: native code ({self.isa}) needs {why}: export it without --isa {self.isa}"
            )
        if ISAS[self.isa].is_foreign:
            raise ExportError(
                f"{self.spec.name}: native code ({self.isa}) needs {why}, which is here for"
                f" {platform.machine()} alone: export it without --isa {self.isa}"
            )
        program = refuse_negative(select_by_tensors(self.program("vjp"), self.spec.name))
        sum_in_steps(program)
        entry = entry_of(program, self.spec, self.isa, self.signature, self.gradient)
        entry = entry.with_suffix(".libtorch.pt2")  # the same program may have been tried without libtorch
        if data := kept(entry):
            return data
        with closing(Build(self.compilers, at_once=True)) as whole:
            data = _repack(_inductor(program, self.spec, self.isa, _ONE_THREAD, whole))
        keep(entry, data)
        return data

    def close(self) -> None:
        if self.build is not None:
            self.build.close()


def _check_vector_isa(spec: Spec, isa: str) -> None:
    """Raise if this machine's CPU lacks the vector width: AOTInductor would silently write scalar loops."""
    from torch._inductor import config, cpu_vec_isa

    with config.patch(settings(spec.vectorize, isa)), known_vectors(ISAS[isa].machine):
        if spec.vectorize and ISAS[isa].bits and not cpu_vec_isa.pick_vec_isa():
            raise ExportError(
                f"{spec.name}: native code ({isa}) needs a CPU with AVX2 to be exported on: this one has none"
            )


def _begin(
    program: ExportedProgram, spec: Spec, isa: str, signature: str, compilers: Executor, gradient: bool
) -> Build:
    program = refuse_negative(select_by_tensors(program, spec.name))
    sm = ISAS[isa].sm
    if sm:
        on_gpu(program)
    else:
        _check_vector_isa(spec, isa)
    # AOTInductor has no setting for link flags; the names of op libraries reach the linker's command line as
    # they are.
    link = (
        f"{'' if sm else 'chiasm_kernels -l'}chiasm_aoti -L{quote(str(library_folder(isa)))}"
        f" -Wl,--version-script={quote(str(isas.LIBRARIES / 'symbols.map'))} {LINK_OF[ISAS[isa].machine]}"
    )
    options = {
        "aot_inductor.link_libtorch": False,
        "aot_inductor.custom_op_libs": [link],
        "aot_inductor.custom_ops_to_c_shims": {
            operator: [_declaration(operator)] for operator in operators(program)
        },
    }
    build = Build(
        compilers,
        isas.LIBRARIES / "include",
        None if sm else isas.LIBRARIES / isa,
        dropped=["-lcuda"] if sm else [],
    )
    try:
        build.objects.append(str(_compile_signature(signature, isa, build.folder)))
        _inductor(program, spec, isa, options, build, gradient)
    except BaseException:
        build.close()
        raise
    return build


def precompile(isa: str) -> None:
    """Precompile the headers of native code, when the package is built (runtime/artifact/CMakeLists.txt)."""
    from torch._inductor import config
    from torch._inductor.cpp_builder import CppBuilder, CppTorchDeviceOptions
    from torch._inductor.cpu_vec_isa import pick_vec_isa

    with config.patch(settings(True, isa)), known_vectors(ISAS[isa].machine):
        for kind in HEADERS:
            options = CppTorchDeviceOptions(
                vec_isa=pick_vec_isa(),
                device_type="cpu",
                aot_mode=True,
                compile_only=True,
                min_optimize=kind == "wrapper",
            )
            compiler.precompile(
                isas.LIBRARIES / isa,
                kind,
                CppBuilder(kind, f"{kind}.cpp", options).get_command_line(),
                isas.LIBRARIES / "include",
            )


def _compile_signature(signature: str, isa: str, folder: Path) -> Path:
    """An object file with the signature, which the library's entry point returns
    (runtime/artifact/aoti/entry.cpp)."""
    source, compiled = folder / "signature.cpp", folder / "signature.o"
    text = "".join(f"\n  {json.dumps(line)}" for line in signature.splitlines(keepends=True))
    source.write_text(
        'extern "C" { extern const char chiasm_native_signature[]; const char chiasm_native_signature[]'
        f" ={text}; }}\n"
    )
    compiler = compiler_command(isa)
    run_tool([compiler, "-fPIC", "-fvisibility=hidden", "-c", str(source), "-o", str(compiled)])
    return compiled


def _declaration(operator: Operator) -> str:
    """The C function of a kernel's operator (generated by runtime/artifact/generate.py)."""
    types = {
        "Tensor": "AtenTensorHandle",
        "int": "int64_t",
        "SymInt": "int64_t",
        "float": "double",
        "bool": "int32_t",
    }
    arguments = [f"{types[str(a.real_type)]} {a.name}" for a in schema_of(operator).arguments]
    return (
        "AOTITorchError"
        f" aoti_torch_cpu_{operator._opname}({', '.join([*arguments, 'AtenTensorHandle* ret0'])})"
    )


def _inductor(
    program: ExportedProgram,
    spec: Spec,
    isa: str,
    options: dict[str, Any],
    build: Build,
    gradient: bool = False,
) -> bytes:
    """AOTInductor's package, whose C++ `build` compiles."""
    from torch._inductor import aoti_compile_and_package

    threads = torch.get_num_threads()
    # Inductor collapses parallel loops until there are twice as many iterations as threads: here, those over
    # the batch, the channels and the rows.
    torch.set_num_threads(64)
    try:
        minima = short_minima(spec.without_nan) if build.include else nullcontext()
        # libtorch has no place to record a wrong index: there the check throws
        checks = checked_native_code(
            None if build.include else isas.LIBRARIES / "include" / "chiasm" / "checked.h"
        )
        if ISAS[isa].sm:
            minima, checks = nullcontext(), gpu_compiler(ISAS[isa].sm, isas.LIBRARIES / "cuda")
        with (
            tempfile.TemporaryDirectory() as scratch,
            _inductor_folder(scratch),
            fast_tracing(),
            known_vectors(ISAS[isa].machine),
            fast_inductor(build.run),
            stacked_planes() if gradient else nullcontext(),
            minima,
            checks,
            warnings.catch_warnings(),
        ):
            warnings.simplefilter("ignore")  # PyTorch's warnings about itself
            path = str(Path(scratch) / "op.pt2")
            aoti_compile_and_package(
                program, package_path=path, inductor_configs=settings(spec.vectorize, isa) | options
            )
            _check_sizes(program, spec, isa)
            return Path(path).read_bytes()
    except ExportError:
        raise
    except Exception as error:
        raise explain(spec.name, f"native code ({isa})", error) from error
    finally:
        torch.set_num_threads(threads)


@contextmanager
def _inductor_folder(folder: str) -> Generator[None]:
    """Inductor keeps its sources in this folder. In one that lasts, it adds its commands to them at each
    export: the same code would get larger each time, until it were compiled as large code is."""
    name = "TORCHINDUCTOR_CACHE_DIR"
    before = os.environ.get(name)
    os.environ[name] = folder
    try:
        yield
    finally:
        if before is None:
            del os.environ[name]
        else:
            os.environ[name] = before


def _check_sizes(program: ExportedProgram, spec: Spec, isa: str) -> None:
    """Raise if Inductor has fixed a size: its code does not check that, and reads beyond other inputs."""
    for node in program.graph.find_nodes(op="placeholder"):
        value = node.meta["val"]
        shape: Sequence[int | torch.SymInt] = value.shape if isinstance(value, Tensor) else ()
        for place, size in enumerate(shape):
            if isinstance(size, torch.SymInt) and expression_of(size).is_Integer:
                raise ExportError(
                    f"{spec.name}: cannot be exported to native code ({isa})\n"
                    f"  because: the compiler makes code for {node.name}.shape[{place}] = {int(size)} alone\n"
                    "  instead: write the size into the input's shape, or leave the format out (formats=...)"
                )


def _repack(package: bytes) -> bytes:
    """AOTInductor's package without what differs from one export to the next (sources with their build
    commands)."""
    with zipfile.ZipFile(io.BytesIO(package)) as archive:
        return zipped({n: archive.read(n) for n in archive.namelist() if not n.endswith((".cpp", ".h"))})
