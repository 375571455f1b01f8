"""Compiled code in files: what an artifact is, and the cache that keeps it."""

from __future__ import annotations

import hashlib
import io
import os
import re
import shutil
import tempfile
import zipfile
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import torch
from torch.export import ExportedProgram

from ...writing import write_whole
from .. import isas
from ..errors import ExportError
from ..files import MOST_OF_FILE, read_regular
from ..internals import Operator, is_operator, limits_of_program
from ..isas import ISAS, LINK_OF, compiler_command, library_folder, run_tool, settings
from ..manifest import sha256
from ..spec import Spec


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
                symbols_of(archive.read(name), "--with-symbol-versions")
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


def kept(entry: Path) -> bytes | None:
    """The compiled code with this name in the cache; None if it is missing or damaged."""
    try:
        data = read_regular(entry, MOST_OF_FILE)
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            whole = data == zipped({name: archive.read(name) for name in archive.namelist()})
        return data if whole else None
    except Exception:  # a damaged archive raises many kinds of exceptions
        return None


def reason(entry: Path) -> str:
    """Why the code with this name needs libtorch, and so is in the cache by the name of another program; ""
    if that is not known."""
    try:
        return read_regular(_why(entry), MOST_OF_FILE).decode()
    except (OSError, UnicodeDecodeError):
        return ""


def _why(entry: Path) -> Path:
    return entry.with_suffix(".why")


def keep_reason(entry: Path, why: str) -> None:
    """Write the reason why code needs libtorch into the cache."""
    keep(_why(entry), why.encode())


def keep(entry: Path, data: bytes) -> None:
    """Write compiled code into the cache."""
    try:
        entry.parent.mkdir(parents=True, exist_ok=True)
        if entry.is_dir():
            shutil.rmtree(entry)
        write_whole(entry, data)  # renamed when whole: two exports at once leave one file
    except OSError as error:
        raise _not_kept(entry.parent, error) from error


def entry_of(program: ExportedProgram, spec: Spec, isa: str, signature: str, gradient: bool) -> Path:
    """The file of a program's compiled code in the cache."""
    return cache_folder() / "native" / f"{key(program, spec, isa, signature, gradient)}.pt2"


def key(program: ExportedProgram, spec: Spec, isa: str, signature: str, gradient: bool) -> str:
    """Everything that the compiled code depends on."""
    digest = hashlib.sha256()
    for part in (
        # without the comments on where the graph was traced: they contain numbers that depend on what the
        # process did before
        re.sub(r"(?m)^\s*# File: .*\n", "", program.graph_module.print_readable(print_output=False)),
        # sizes and dtypes of the inputs, which the listing does not have
        str([(n.name, str(n.meta.get("val"))) for n in program.graph.nodes if n.op == "placeholder"]),
        str(sorted((str(k), str(v)) for k, v in limits_of_program(program).items())),
        str({k: _content(v) for k, v in sorted(program.constants.items()) if isinstance(v, torch.Tensor)}),
        str({k: _content(v) for k, v in sorted(program.state_dict.items())}),
        isa,
        signature,
        torch.__version__,
        run_tool([compiler_command(isa), "--version"]).partition("\n")[0],
        _libraries_hash(isa),
        str(sorted(settings(spec.vectorize, isa).items())),
        LINK_OF[ISAS[isa].machine],
        str(spec.without_nan),
        str(gradient),
        _hash([isas.LIBRARIES / isa / "libchiasm_kernels.a"]) if operators(program) else "",
    ):
        digest.update(part.encode() + b"\0")
    return digest.hexdigest()


def _content(tensor: torch.Tensor) -> tuple[str, list[int], str]:
    """The type, the shape and a hash of the values."""
    data = tensor.detach().contiguous().reshape(-1).view(torch.uint8).numpy()
    return str(tensor.dtype), list(tensor.shape), sha256(data.tobytes())


@cache
def _libraries_hash(isa: str) -> str:
    """A hash of the compile settings and of the linked libraries, without the kernels."""
    formats, patches = Path(__file__).parent, Path(__file__).parents[1] / "patches"
    sources = [
        Path(isas.__file__),
        *(
            formats / f"{name}.py"
            for name in (
                "native",
                "networks",
                "network_forms",
                "network_program",
                "recurrent",
                "index_ranges",
                "compiler",
                "selections",
            )
        ),
        *(patches / f"{name}.py" for name in ("inductor", "index_checks", "tracing")),
        *([patches / "cuda.py"] if ISAS[isa].sm else []),
    ]
    libraries = [
        library_folder(isa) / "libchiasm_aoti.a",
        *([] if ISAS[isa].sm else [library_folder(isa) / "libgomp.a"]),
        isas.LIBRARIES / "symbols.map",
    ]
    if missing := [str(f) for f in libraries if not f.exists()]:
        target = f"build-{ISAS[isa].machine}" if ISAS[isa].is_foreign else "build"
        target = f"build-{isa}" if isa == "x86-64-v4" else target
        raise ExportError(
            f"the native format needs {missing[0]}, which is not there: pip install chiasm-export, or in a"
            f" source tree make {target}"
        )
    folders = ["include", "cuda/include"] if ISAS[isa].sm else ["include"]
    headers = [f for name in folders for f in (isas.LIBRARIES / name).rglob("*") if f.is_file()]
    return _hash(sources + libraries + headers)


def _hash(files: Iterable[Path]) -> str:
    digest = hashlib.sha256()
    for file in sorted(files):
        digest.update(file.read_bytes())
    return digest.hexdigest()


def operators(program: ExportedProgram) -> list[Operator]:
    """The operators of the program that are chiasm's kernels."""
    # Including the bodies of loops
    modules = [m for m in program.graph_module.modules() if isinstance(m, torch.fx.GraphModule)]
    targets = {n.target for m in modules for n in m.graph.nodes if is_operator(n.target)}
    return sorted((t for t in targets if t.namespace == "chiasm"), key=str)


def symbols_of(code: bytes, *options: str) -> str:
    """The undefined symbols of a library, as nm lists them."""
    with tempfile.NamedTemporaryFile(suffix=".so") as file:
        file.write(code)
        file.flush()
        return run_tool(["nm", "-D", "--undefined-only", *options, file.name])


def missing_symbols(code: bytes) -> list[str]:
    """The functions of libtorch that the code calls and that have no replacement."""
    return sorted(set(re.findall(r"\b(?:aoti_torch_|Sleef_|GOMP_|omp_)\w+", symbols_of(code))))


def zipped(files: dict[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as archive:
        for name, data in sorted(files.items()):
            archive.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)), data)
    return buffer.getvalue()
