"""AOTInductor, faster and with compilers of our own choice. The results are the same."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import reduce
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


class _Remembering:
    """A loop's body, `inner(index)`, that is evaluated once an index. Inductor evaluates it again at each of
    its uses, and so what it is made of: twice as often with every sum of two such values. It drops what came
    double later, one operation at a time."""

    def __init__(self, inner: Callable[[Any], Any]) -> None:
        self.inner = inner
        self.handler: Any = None  # what the operations are written to
        self.values: dict[tuple[Any, ...], Any] = {}

    def __call__(self, index: Any) -> Any:
        from torch._inductor.virtualized import V

        handler, key = V.get_ops_handler(), tuple(index)
        if handler is not self.handler:
            self.handler, self.values = handler, {}
        if key not in self.values:
            value = self.inner(index)
            if handler is not self.handler:  # it was asked for inside a branch in the meantime
                return value
            self.values[key] = value
        return self.values[key]


#: Lanes of 32 bits in a vector of AVX2: of bytes, a loop takes as many at a time.
_LANES = 8


@contextmanager
def fast_inductor(compile_command: Callable[[str, str], None]) -> Iterator[None]:
    """AOTInductor without `sympy.simplify`, which loads bytes by one instruction, puts tensors of bytes side
    by side itself, and whose compiler is `compile_command(command, folder)`."""
    from torch._inductor import ir, lowering
    from torch._inductor.codegen.cpp import CppVecKernel

    load_line, fallback = CppVecKernel._get_vec_load_line, lowering.fallback_handler
    channels_last = lowering.require_channels_last

    def load_bytes(kernel: Any, var: str, index: Any, dtype: torch.dtype, load_mask: Any = None) -> str:
        line, count = load_line(kernel, var, index, dtype, load_mask), f", static_cast<int64_t>({_LANES}))"
        if dtype in (torch.uint8, torch.int8) and "::loadu(" in line and line.endswith(count):
            line = line.replace("::loadu(", "::loadu_one_fourth(").removesuffix(count) + ")"
        return line

    def side_by_side(tensors: Any, dim: int) -> ir.TensorBox:
        dtype = reduce(torch.promote_types, (t.get_dtype() for t in tensors))
        made = [lowering.to_dtype(t, dtype) for t in tensors]
        return ir.TensorBox(ir.ConcatKernel.create(made, dim % len(made[0].get_size())))

    def handler(kernel: Any, *arguments: Any, **options: Any) -> Any:
        if kernel is torch.ops.aten.cat.default:
            return side_by_side
        return fallback(kernel, *arguments, **options)

    def as_laid_out(kernel: Any, *tensors: Any, **options: Any) -> Any:
        if kernel is torch.ops.aten.cat:
            return tensors, options
        return channels_last(kernel, *tensors, **options)

    with replaced(
        {
            "torch._inductor.codegen.cpp:CppVecKernel._get_vec_load_line": load_bytes,
            "torch._inductor.lowering:fallback_handler": handler,
            "torch._inductor.lowering:require_channels_last": as_laid_out,
            "torch._inductor.sizevars:sympy": _Sympy(),
            "torch._inductor.cpp_builder:run_compile_cmd": compile_command,
        }
    ):
        yield


@contextmanager
def fast_gradients() -> Iterator[None]:
    """AOTInductor which evaluates a loop's body once, and stacks planes as planes. Not for forward methods:
    how a loop is vectorised hangs on how often it counts an operation, and frames are better interleaved."""
    from torch._inductor import ir

    is_laid_out, make_loader = ir.is_contiguous_for_memory_format_or_false, ir.Pointwise.make_loader
    bodies = dict[int, tuple[Any, _Remembering]]()

    def is_only_laid_out(tensor: torch.Tensor, memory_format: torch.memory_format) -> bool:
        # (B, 1, H, W) is both; taken for channels_last, planes were interleaved, then separated again, by
        # loops that read through transposed tiles: code of 3.5 MB for the gradient of `adjust_hue`.
        contiguous = is_laid_out(tensor, memory_format=torch.contiguous_format)
        return not contiguous and is_laid_out(tensor, memory_format=memory_format)

    def loader_of(loop: ir.Pointwise) -> Callable[[Any], Any]:
        inner = make_loader(loop)
        if inner is not loop.inner_fn:
            return inner
        return bodies.setdefault(id(loop), (loop, _Remembering(inner)))[1]

    with replaced(
        {
            "torch._inductor.ir:Pointwise.make_loader": loader_of,
            "torch._inductor.ir:is_contiguous_for_memory_format_or_false": is_only_laid_out,
        }
    ):
        yield


@contextmanager
def known_vectors(machine: str) -> Iterator[None]:
    """Inductor with the vectors of a family of CPUs: AVX2, where this CPU has it, or NEON."""
    from torch._inductor import cpu_vec_isa

    found: list[cpu_vec_isa.VecISA] = []
    if machine == "aarch64":
        neon = cpu_vec_isa.VecNEON()
        neon._macro = ["CPU_CAPABILITY_NEON"]  # without Sleef: torch's header of it is this machine's
        found = [neon]
    elif "avx2" in cpu_vec_isa.x86_isa_checker():
        found = [cpu_vec_isa.VecAVX2()]
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
