"""The native exporter: AOTInductor code, linked statically with a replacement of libtorch and with kernels
(runtime/artifact).

The result is a `.pt2`: a zip with the shared library in it. If an op calls an ATen function that has no
replacement, the package is AOTInductor's own, for the torch backend's loader, and its manifest entry says so
(`needs: libtorch`).
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import platform
import re
import shutil
import subprocess
import tempfile
import warnings
import zipfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing, nullcontext
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import torch
from torch.export import ExportedProgram

import chiasm

from ..errors import ExportError, explain
from ..files import MOST_OF_FILE, read_regular, write_whole
from ..job import Artifact, ExportJob, Method
from ..manifest import GPUS, sha256
from ..patches.cuda import gpu_compiler, on_gpu
from ..patches.index_checks import checked_native_code
from ..patches.inductor import fast_gradients, fast_inductor, known_vectors, short_minima
from ..patches.tracing import fast_tracing
from ..spec import Spec, TensorSpec
from . import compiler
from .compiler import HEADERS, Build
from .networks import use_kernels
from .selections import refuse_negative, select_by_tensors

#: The files for linking ops, which are built with the package: headers, and static libraries for each
#: instruction set (runtime/artifact/CMakeLists.txt).
LIBRARIES = Path(chiasm.__file__).parent / "artifact"


@dataclass(frozen=True)
class Isa:
    """An instruction set: the family of CPUs (as in platform.machine()), and the width in bits of the vectors
    that Inductor uses for it; 0 if it writes scalar loops. Code for a GPU has its compute capability (90 for
    9.0) in `sm`, and runs on any CPU of the family."""

    machine: str
    bits: int
    sm: int = 0

    @property
    def is_foreign(self) -> bool:
        """Whether compiling for it needs a cross-compiler here."""
        return self.machine != platform.machine()


#: By g++'s name after -march=. x86-64-v4 also uses 256-bit vectors, with its masks and registers. Inductor
#: has no vectors for SSE4: its loops are scalar, and only kernels have vectors.
ISAS = {
    "x86-64-v2": Isa("x86_64", 0),
    "x86-64-v3": Isa("x86_64", 256),
    "x86-64-v4": Isa("x86_64", 256),
    "armv8.2-a": Isa("aarch64", 128),
    **{name: Isa("x86_64", 0, int(name.removeprefix("sm_"))) for name in GPUS},
}
#: Settings for code that needs libtorch: no exception may leave a parallel region.
_ONE_THREAD = {"cpp.threads": 1, "cpp.dynamic_threads": False}
_ENTRY = "chiasm_native_entry"
#: The options after the libraries on the linker's command line, except the version script. glibc has vector
#: functions for x86 (and since 2.38 for aarch64, where the scalar functions are used).
_LINK = f"-Wl,--undefined={_ENTRY} -Wl,--gc-sections -s -static-libstdc++ -static-libgcc -Wl,--as-needed"
_LINK_OF = {"x86_64": f"{_LINK} -lmvec", "aarch64": _LINK}


def _folder(isa: str) -> Path:
    """The folder of the libraries for an instruction set."""
    return LIBRARIES / ("cuda" if ISAS[isa].sm else isa)


@dataclass(frozen=True)
class NativeArtifact:
    """The bytes of a `.pt2`, and whether and why it needs libtorch: the operators that have no
    replacement."""

    data: bytes
    needs_libtorch: bool
    why: str = ""

    def glibc(self) -> str:
        """The oldest glibc that the code runs with, "2.34"."""
        with zipfile.ZipFile(io.BytesIO(self.data)) as archive:
            listings = [
                _symbols(archive.read(name), "--with-symbol-versions")
                for name in archive.namelist()
                if name.endswith(".so")
            ]
        versions = [
            tuple(map(int, v.split("."))) for v in re.findall(r"@+GLIBC_(\d+\.\d+)", "".join(listings))
        ]
        return ".".join(map(str, max(versions)))


def cache_folder() -> Path:
    """The cache folder of compiled artifacts: $CHIASM_CACHE, or ~/.cache/chiasm; created if it does not
    exist."""
    folder = Path(os.environ.get("CHIASM_CACHE") or Path.home() / ".cache" / "chiasm")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _not_kept(folder, error) from error
    return folder


def _not_kept(path: Path, error: OSError) -> ExportError:
    return ExportError(
        f"compiled code cannot be kept in {path}: {error.strerror}: set CHIASM_CACHE to a folder that can be"
        " written and has room"
    )


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
            job.compiling[-1] if job.compiling else None,
            gradient=method.name == "vjp",
        )
        job.compiling.append(code)

        def made(code: NativeCode = code, isa: str = isa) -> tuple[bytes, dict[str, object]]:
            artifact = code.artifact()
            needs = {"backend": "native", "needs": []}
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
    after: NativeCode | None = None,
    gradient: bool = False,
) -> NativeCode:
    """Begin to compile for `isa`, a level of CPUs or a GPU, or fetch the same compilation from the cache. The
    code carries `signature`.

    `program` returns the program for a target ("native"), which may be changed. If the op turns out to need
    libtorch, the program without our kernels ("vjp") is used, because libtorch does not have these. `after`
    is other code that is being compiled; its compilers must end before new ones start. `gradient`: whether
    the program computes a gradient.
    """
    if isa not in ISAS:
        raise ExportError(f"{spec.name}: isa: expected one of {sorted(ISAS)}, got {isa!r}")
    source = program("cuda" if ISAS[isa].sm else "native")
    if not ISAS[isa].sm and not gradient:
        use_kernels(source)
    entry = cache_folder() / "native" / f"{_key(source, spec, isa, signature, gradient)}.pt2"
    if _kept(entry):
        return NativeCode(spec, isa, entry, None, program)
    try:
        build = _begin(source, spec, isa, signature, after and after.build, gradient)
    except OSError as error:
        raise explain(spec.name, f"native code ({isa})", error) from error
    return NativeCode(spec, isa, entry, build, program)


@dataclass
class NativeCode:
    """Native code that is being compiled. `artifact` waits for it; `close` cancels it."""

    spec: Spec
    isa: str
    entry: Path
    build: Build | None
    program: Callable[[str], ExportedProgram]

    def artifact(self) -> NativeArtifact:
        """The code, which is in the cache from then on."""
        if artifact := _kept(self.entry):
            return artifact
        if self.build is None:
            raise ExportError(f"{self.entry}: was removed while it was needed: export again")
        artifact = self._linked(self.build)
        try:
            self.entry.parent.mkdir(parents=True, exist_ok=True)
            if self.entry.is_dir():
                shutil.rmtree(self.entry)
            # Renamed when whole: two exports at once leave one file
            if artifact.why:
                write_whole(_why(self.entry), artifact.why.encode())
            write_whole(self.entry, artifact.data)
        except OSError as error:
            raise _not_kept(self.entry.parent, error) from error
        return artifact

    def _linked(self, build: Build) -> NativeArtifact:
        try:
            code = build.library()
        except Exception as error:
            raise explain(self.spec.name, f"native code ({self.isa})", error) from error
        missing = _missing_symbols(code)
        if not missing:
            return NativeArtifact(_package({"chiasm/op.so": code}), needs_libtorch=False)
        why = f"libtorch's {', '.join(missing)}"
        if ISAS[self.isa].sm:
            raise ExportError(
                f"{self.spec.name}: native code ({self.isa}) needs {why}: export it without --isa {self.isa}"
            )
        if ISAS[self.isa].is_foreign:
            raise ExportError(
                f"{self.spec.name}: native code ({self.isa}) needs {why}, which is here for"
                f" {platform.machine()} alone: export it without --isa {self.isa}"
            )
        with closing(Build(at_once=True)) as whole:
            program = refuse_negative(select_by_tensors(self.program("vjp"), self.spec.name))
            package = _inductor(program, self.spec, self.isa, _ONE_THREAD, whole)
        return NativeArtifact(_repack(package), needs_libtorch=True, why=why)

    def close(self) -> None:
        if self.build is not None:
            self.build.close()


def _kept(entry: Path) -> NativeArtifact | None:
    """The artifact with this name in the cache; None if it is missing or damaged."""
    try:
        data = read_regular(entry, MOST_OF_FILE)
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            names = archive.namelist()
            if data != _package({name: archive.read(name) for name in names}):
                return None
        if "chiasm/op.so" in names:
            return NativeArtifact(data, needs_libtorch=False)
        return NativeArtifact(data, True, read_regular(_why(entry), MOST_OF_FILE).decode())
    except Exception:  # a damaged archive raises many kinds of exceptions
        return None


def _why(entry: Path) -> Path:
    """The file next to an artifact with the reason why it needs libtorch."""
    return entry.with_suffix(".why")


def _key(program: ExportedProgram, spec: Spec, isa: str, signature: str, gradient: bool) -> str:
    """Everything that the compiled code depends on."""
    digest = hashlib.sha256()
    for part in (
        # without the comments on where the graph was traced: they contain numbers that depend on what the
        # process did before
        re.sub(r"(?m)^\s*# File: .*\n", "", program.graph_module.print_readable(print_output=False)),
        # sizes and dtypes of the inputs, which the listing does not have
        str([(n.name, str(n.meta.get("val"))) for n in program.graph.nodes if n.op == "placeholder"]),
        str(sorted((str(k), str(v)) for k, v in program.range_constraints.items())),
        str({k: _content(v) for k, v in sorted(program.constants.items()) if isinstance(v, torch.Tensor)}),
        str({k: _content(v) for k, v in sorted(program.state_dict.items())}),
        isa,
        signature,
        torch.__version__,
        run_tool([compiler_command(isa), "--version"]).partition("\n")[0],
        _libraries_hash(isa),
        str(sorted(_settings(spec.vectorize, isa).items())),
        _LINK_OF[ISAS[isa].machine],
        str(spec.without_nan),
        str(gradient),
        _hash([LIBRARIES / isa / "libchiasm_kernels.a"]) if _operators(program) else "",
    ):
        digest.update(part.encode() + b"\0")
    return digest.hexdigest()


def _content(tensor: torch.Tensor) -> tuple[str, list[int], str]:
    """The type, the shape and a hash of the values."""
    data = tensor.detach().contiguous().reshape(-1).view(torch.uint8).numpy()
    return str(tensor.dtype), list(tensor.shape), sha256(data.tobytes())


def compiler_command(isa: str) -> str:
    """$CXX if the code is for CPUs of this machine's family; else the cross-compiler."""
    return f"{ISAS[isa].machine}-linux-gnu-g++" if ISAS[isa].is_foreign else os.environ.get("CXX", "g++")


@cache
def _libraries_hash(isa: str) -> str:
    """A hash of the compile settings and of the linked libraries, without the kernels."""
    formats, patches = Path(__file__).parent, Path(__file__).parents[1] / "patches"
    sources = [
        *(
            formats / f"{name}.py"
            for name in ("native", "networks", "index_ranges", "compiler", "selections")
        ),
        *(patches / f"{name}.py" for name in ("inductor", "index_checks", "tracing")),
        *([patches / "cuda.py"] if ISAS[isa].sm else []),
    ]
    libraries = [
        _folder(isa) / "libchiasm_aoti.a",
        *([] if ISAS[isa].sm else [_folder(isa) / "libgomp.a"]),
        LIBRARIES / "symbols.map",
    ]
    if missing := [str(f) for f in libraries if not f.exists()]:
        target = f"build-{ISAS[isa].machine}" if ISAS[isa].is_foreign else "build"
        target = f"build-{isa}" if isa == "x86-64-v4" else target
        raise ExportError(
            f"the native format needs {missing[0]}, which is not there: pip install chiasm-export, or in a"
            f" source tree make {target}"
        )
    folders = ["include", "cuda/include"] if ISAS[isa].sm else ["include"]
    headers = [f for name in folders for f in (LIBRARIES / name).rglob("*") if f.is_file()]
    return _hash(sources + libraries + headers)


def _hash(files: Iterable[Path]) -> str:
    digest = hashlib.sha256()
    for file in sorted(files):
        digest.update(file.read_bytes())
    return digest.hexdigest()


def _operators(program: ExportedProgram) -> list[torch._ops.OpOverload]:
    """The operators of the program that are chiasm's kernels."""
    # Including the bodies of loops
    modules = [m for m in program.graph_module.modules() if isinstance(m, torch.fx.GraphModule)]
    targets = {
        n.target for m in modules for n in m.graph.nodes if isinstance(n.target, torch._ops.OpOverload)
    }
    return sorted((t for t in targets if t.namespace == "chiasm"), key=str)


def run_tool(command: list[str]) -> str:
    package = "g++-aarch64-linux-gnu" if command[0].startswith("aarch64") else "g++"
    needs = f"The native format needs g++ and binutils (Debian: apt-get install {package})"
    try:
        done = subprocess.run(command, capture_output=True, text=True)
    except OSError as error:
        raise ExportError(f"{command[0]} cannot be run: {error.strerror}. {needs}") from error
    if done.returncode:
        said = done.stderr[-2000:].strip() or f"exit status {done.returncode}, without a message"
        raise ExportError(f"{command[0]} failed:\n{said}\n{needs}")
    if "-o" in command and not Path(written := command[command.index("-o") + 1]).exists():
        raise ExportError(f"{command[0]} did not write {Path(written).name}: it is no C++ compiler. {needs}")
    return done.stdout


def _check_vector_isa(spec: Spec, isa: str) -> None:
    """Raise if this machine's CPU lacks the vector width: AOTInductor would silently write scalar loops."""
    from torch._inductor import config, cpu_vec_isa

    with config.patch(_settings(spec.vectorize, isa)), known_vectors(ISAS[isa].machine):
        if spec.vectorize and ISAS[isa].bits and not cpu_vec_isa.pick_vec_isa():
            raise ExportError(
                f"{spec.name}: native code ({isa}) needs a CPU with AVX2 to be exported on: this one has none"
            )


def _begin(
    program: ExportedProgram, spec: Spec, isa: str, signature: str, after: Build | None, gradient: bool
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
        f"{'' if sm else 'chiasm_kernels -l'}chiasm_aoti -L{_folder(isa)}"
        f" -Wl,--version-script={LIBRARIES / 'symbols.map'} {_LINK_OF[ISAS[isa].machine]}"
    )
    options = {
        "aot_inductor.link_libtorch": False,
        "aot_inductor.custom_op_libs": [link],
        "aot_inductor.custom_ops_to_c_shims": {
            operator: [_declaration(operator)] for operator in _operators(program)
        },
    }
    build = Build(
        LIBRARIES / "include", None if sm else LIBRARIES / isa, after=after, dropped=["-lcuda"] if sm else []
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

    with config.patch(_settings(True, isa)), known_vectors(ISAS[isa].machine):
        for kind in HEADERS:
            options = CppTorchDeviceOptions(
                vec_isa=pick_vec_isa(),
                device_type="cpu",
                aot_mode=True,
                compile_only=True,
                min_optimize=kind == "wrapper",
            )
            compiler.precompile(
                LIBRARIES / isa,
                kind,
                CppBuilder(kind, f"{kind}.cpp", options).get_command_line(),
                LIBRARIES / "include",
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


def _declaration(operator: torch._ops.OpOverload) -> str:
    """The C function of a kernel's operator (generated by runtime/artifact/generate.py)."""
    types = {
        "Tensor": "AtenTensorHandle",
        "int": "int64_t",
        "SymInt": "int64_t",
        "float": "double",
        "bool": "int32_t",
    }
    arguments = [f"{types[str(a.real_type)]} {a.name}" for a in operator._schema.arguments]
    return (
        "AOTITorchError"
        f" aoti_torch_cpu_{operator._opname}({', '.join([*arguments, 'AtenTensorHandle* ret0'])})"
    )


def _settings(vectorize: bool, isa: str) -> dict[str, object]:
    if ISAS[isa].sm:
        return {
            "cpp.march": "x86-64",
            "cpp.cxx": (None, compiler_command(isa)),
            "aot_inductor.enable_line_tables": False,
            "aot_inductor.precompile_headers": False,
            "aot_inductor.embed_kernel_binary": True,
            "triton.autotune_at_compile_time": True,
            "compile_threads": 1,
            "assume_32bit_indexing": True,  # runtime/artifact/aoti/entry.cpp rejects larger tensors
            "triton.prefer_nd_tiling": True,  # a row and a column, without a division for each pixel
            "joint_graph_constant_folding": False,  # it would need a GPU
            "assert_indirect_indexing": False,  # `gpu_compiler` checks without ending the process
            "optimize_scatter_upon_const_tensor": False,
        }
    return {
        "cpp.march": isa,
        "cpp.cxx": (None, compiler_command(isa)),
        "cpp.simdlen": (vectorize and ISAS[isa].bits) or 1,
        # Otherwise Inductor compiles a probe with these settings, which fails without libtorch, and makes all
        # loops scalar.
        "cpp.vec_isa_ok": True,
        "cpp.dynamic_threads": True,  # the thread count is the caller's, at run time
        "cpp.min_chunk_size": 0,  # however small the example is
        "emulate_precision_casts": True,  # x.half().float() rounds, as it does in eager Python
        "cpp.fallback_scatter_reduce_sum": False,  # atomic additions, not a call of libtorch
        "aot_inductor.enable_line_tables": False,
        "aot_inductor.precompile_headers": (
            False
        ),  # 280 MB in /tmp and 11 s for each state of the package; ours are built with it
        "assert_indirect_indexing": False,  # `checked_native_code` checks without ending the process
        # As comparisons, a scatter on zeros has no index to check
        "optimize_scatter_upon_const_tensor": False,
    }


def _inductor(
    program: ExportedProgram, spec: Spec, isa: str, options: dict, build: Build, gradient: bool = False
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
            None if build.include else LIBRARIES / "include" / "chiasm" / "checked.h"
        )
        if ISAS[isa].sm:
            minima, checks = nullcontext(), gpu_compiler(ISAS[isa].sm, LIBRARIES / "cuda")
        with (
            tempfile.TemporaryDirectory() as scratch,
            fast_tracing(),
            known_vectors(ISAS[isa].machine),
            fast_inductor(build.run),
            fast_gradients() if gradient else nullcontext(),
            minima,
            checks,
            warnings.catch_warnings(),
        ):
            warnings.simplefilter("ignore")  # PyTorch's warnings about itself
            path = str(Path(scratch) / "op.pt2")
            aoti_compile_and_package(
                program, package_path=path, inductor_configs=_settings(spec.vectorize, isa) | options
            )
            return Path(path).read_bytes()
    except Exception as error:
        raise explain(spec.name, f"native code ({isa})", error) from error
    finally:
        torch.set_num_threads(threads)


def _symbols(code: bytes, *options: str) -> str:
    """The undefined symbols of a library, as nm lists them."""
    with tempfile.NamedTemporaryFile(suffix=".so") as file:
        file.write(code)
        file.flush()
        return run_tool(["nm", "-D", "--undefined-only", *options, file.name])


def _missing_symbols(code: bytes) -> list[str]:
    """The functions of libtorch that the code calls and that have no replacement."""
    return sorted(set(re.findall(r"\b(?:aoti_torch_|Sleef_|GOMP_|omp_)\w+", _symbols(code))))


def _repack(package: bytes) -> bytes:
    """AOTInductor's package without what differs from one export to the next (sources with their build
    commands)."""
    with zipfile.ZipFile(io.BytesIO(package)) as archive:
        return _package({n: archive.read(n) for n in archive.namelist() if not n.endswith((".cpp", ".h"))})


def _package(files: dict[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as archive:
        for name, data in sorted(files.items()):
            archive.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)), data)
    return buffer.getvalue()
