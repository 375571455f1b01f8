"""AOTInductor, faster and with compilers of our own choice. The results are the same."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import sympy
import torch

from . import replaced


class _Sympy:
    """sympy, but for `simplify`: Inductor calls it to see whether an index is linear in a loop's variable,
    for which expanding does as well, in a fraction of the time."""

    def __getattr__(self, name: str) -> Any:
        return getattr(sympy, name)

    @staticmethod
    def simplify(expression: Any) -> sympy.Expr:
        return sympy.expand(expression)


#: Lanes of 32 bits in a vector of AVX2: of bytes, a loop takes as many at a time.
_LANES = 8


@contextmanager
def fast_inductor(compile_command: Callable[[str, str], None]) -> Iterator[None]:
    """AOTInductor without `sympy.simplify`, which loads bytes by one instruction, and whose compiler is
    `compile_command(command, folder)`."""
    from torch._inductor.codegen.cpp import CppVecKernel

    load_line = CppVecKernel._get_vec_load_line

    def load_bytes(kernel: Any, var: str, index: Any, dtype: torch.dtype, load_mask: Any = None) -> str:
        line, count = load_line(kernel, var, index, dtype, load_mask), f", static_cast<int64_t>({_LANES}))"
        if dtype in (torch.uint8, torch.int8) and "::loadu(" in line and line.endswith(count):
            line = line.replace("::loadu(", "::loadu_one_fourth(").removesuffix(count) + ")"
        return line

    with replaced(
        {
            "torch._inductor.codegen.cpp:CppVecKernel._get_vec_load_line": load_bytes,
            "torch._inductor.sizevars:sympy": _Sympy(),
            "torch._inductor.cpp_builder:run_compile_cmd": compile_command,
        }
    ):
        yield


@contextmanager
def known_vectors() -> Iterator[None]:
    """Inductor with AVX2 where the CPU has it, and without else."""
    from torch._inductor import cpu_vec_isa

    found = [cpu_vec_isa.VecAVX2()] if "avx2" in cpu_vec_isa.x86_isa_checker() else []
    with replaced({"torch._inductor.cpu_vec_isa:valid_vec_isa_list": lambda: found}):
        yield


@contextmanager
def plain_minima() -> Iterator[None]:
    """Native minima and maxima of one instruction where the CPU has it (chiasm/minima_avx2.h). PyTorch's,
    which pass NaN on, take three, and networks of them are all that a rank filter or a dilation does."""

    def smaller(a: Any, b: Any) -> str:
        return f"chiasm::smaller({a}, {b})"

    def larger(a: Any, b: Any) -> str:
        return f"chiasm::larger({a}, {b})"

    overrides = "torch._inductor.codegen.cpp:CppVecOverrides"
    with replaced(
        {f"{overrides}.minimum": staticmethod(smaller), f"{overrides}.maximum": staticmethod(larger)}
    ):
        yield
