"""AOTInductor, faster and with compilers of our own choice. The results are the same."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import sympy

from . import replaced


class _Sympy:
    """sympy, but for `simplify`: Inductor calls it to see whether an index is linear in a loop's variable,
    for which expanding does as well, in a fraction of the time."""

    def __getattr__(self, name: str) -> Any:
        return getattr(sympy, name)

    @staticmethod
    def simplify(expression: Any) -> sympy.Expr:
        return sympy.expand(expression)


@contextmanager
def fast_inductor(compile_command: Callable[[str, str], None]) -> Iterator[None]:
    """AOTInductor without `sympy.simplify`, whose compiler is `compile_command(command, folder)`."""
    with replaced(
        {
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
