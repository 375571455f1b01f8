"""Instruction sets that native code is compiled for: the compiler, the libraries and Inductor's settings of
each."""

from __future__ import annotations

import os
import platform
import subprocess
from dataclasses import dataclass
from pathlib import Path

import chiasm

from .errors import ExportError
from .manifest import GPUS

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
_ENTRY = "chiasm_native_entry"
#: The options after the libraries on the linker's command line, except the version script. glibc has vector
#: functions for x86 (and since 2.38 for aarch64, where the scalar functions are used).
_LINK = f"-Wl,--undefined={_ENTRY} -Wl,--gc-sections -s -static-libstdc++ -static-libgcc -Wl,--as-needed"
LINK_OF = {"x86_64": f"{_LINK} -lmvec", "aarch64": _LINK}


def library_folder(isa: str) -> Path:
    """The folder of the libraries for an instruction set."""
    return LIBRARIES / ("cuda" if ISAS[isa].sm else isa)


def compiler_command(isa: str) -> str:
    """$CXX if the code is for CPUs of this machine's family; else the cross-compiler."""
    return f"{ISAS[isa].machine}-linux-gnu-g++" if ISAS[isa].is_foreign else os.environ.get("CXX", "g++")


def settings(vectorize: bool, isa: str) -> dict[str, object]:
    """Inductor's settings."""
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
        # Otherwise Inductor lowers a scatter into zeros to comparisons, so there is no index to check
        "optimize_scatter_upon_const_tensor": False,
    }


def run_tool(command: list[str]) -> str:
    """What a compiler or a tool of binutils prints; an ExportError if it fails or is not installed."""
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
