# What is patched is private, and most of it without types.
# pyright: reportPrivateUsage=false, reportPrivateImportUsage=false, reportUnknownMemberType=false
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false
"""AOTInductor, faster and with compilers of our own choice. The results are the same."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager
from functools import reduce, wraps
from typing import Any

import sympy
import torch

from . import replaced


class _Sympy:
    """sympy with a faster `simplify`: Inductor calls it to find out whether an index is linear in a loop's
    variable. Expanding is sufficient for that, in a fraction of the time."""

    def __getattr__(self, name: str) -> Any:
        return getattr(sympy, name)

    @staticmethod
    def simplify(expression: Any) -> sympy.Expr:
        return sympy.expand(expression)


class _Remembering:
    """A loop's body, `inner(index)`, that is evaluated only once for each index. Inductor evaluates it again
    at each use, and its operands too, so that every sum of two such values doubles the work: 230,443
    evaluations for the 1,137 operations of `solve_cubic`. Inductor removes the duplicates later, one
    operation at a time."""

    def __init__(self, inner: Callable[[Any], Any]) -> None:
        self.inner = inner
        self.handler: Any = None  # the handler that records the operations
        self.values: dict[tuple[Any, ...], Any] = {}

    def __call__(self, index: Any) -> Any:
        from torch._inductor.virtualized import V

        handler, key = V.get_ops_handler(), tuple(index)
        if handler is not self.handler:
            self.handler, self.values = handler, {}
        if key not in self.values:
            value = self.inner(index)
            if handler is not self.handler:  # it was evaluated inside a branch meanwhile
                return value
            self.values[key] = value
        return self.values[key]


#: 32-bit lanes of an AVX2 vector: a loop reads as many bytes at a time.
_LANES = 8


@contextmanager
def fast_inductor(compile_command: Callable[[str, str], None]) -> Generator[None]:
    """AOTInductor without `sympy.simplify`, which evaluates a loop's body once, loads bytes by one
    instruction, reduces only the bytes it has loaded, concatenates tensors of bytes itself, and compiles by
    `compile_command(command, folder)`."""
    from torch._inductor import ir, lowering
    from torch._inductor.codegen.cpp import CppVecKernel

    load_line, fallback = CppVecKernel._get_vec_load_line, lowering.fallback_handler
    combine = CppVecKernel.reduction_combine_vec
    channels_last, make_loader = lowering.require_channels_last, ir.Pointwise.make_loader
    bodies = dict[int, tuple[Any, _Remembering]]()

    def loader_of(loop: ir.Pointwise) -> Callable[[Any], Any]:
        inner = make_loader(loop)
        if inner is not loop.inner_fn:
            return inner
        return bodies.setdefault(id(loop), (loop, _Remembering(inner)))[1]

    def load_bytes(kernel: Any, var: str, index: Any, dtype: torch.dtype, load_mask: Any = None) -> str:
        line, count = load_line(kernel, var, index, dtype, load_mask), f", static_cast<int64_t>({_LANES}))"
        if dtype in (torch.uint8, torch.int8) and "::loadu(" in line and line.endswith(count):
            line = line.replace("::loadu(", "::loadu_one_fourth(").removesuffix(count) + ")"
        return line

    def combine_bytes(kernel: Any, kind: str, *values: Any, **options: Any) -> str:
        # Only the first lanes of a vector of bytes have values if the loop also has wider numbers. The others
        # are 0, which would be the minimum.
        dtype = options.get("src_dtype")
        if (
            dtype not in (torch.uint8, torch.int8)
            or kind not in ("min", "max", "argmin", "argmax")
            or kernel.tail_size is not None
            or kernel.tiling_factor >= kernel.vec_isa.bit_width() // 8
        ):
            return combine(kernel, kind, *values, **options)
        kernel.tail_size = kernel.tiling_factor
        try:
            return combine(kernel, kind, *values, **options)
        finally:
            kernel.tail_size = None

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
            "torch._inductor.ir:Pointwise.make_loader": loader_of,
            "torch._inductor.codegen.cpp:CppVecKernel._get_vec_load_line": load_bytes,
            "torch._inductor.codegen.cpp:CppVecKernel.reduction_combine_vec": combine_bytes,
            "torch._inductor.lowering:fallback_handler": handler,
            "torch._inductor.lowering:require_channels_last": as_laid_out,
            "torch._inductor.sizevars:sympy": _Sympy(),
            "torch._inductor.cpp_builder:run_compile_cmd": compile_command,
        }
    ):
        yield


@contextmanager
def stacked_planes() -> Generator[None]:
    """AOTInductor which stacks planes as planes. Not for forward methods, whose frames should stay
    interleaved."""
    from torch._inductor import ir

    is_laid_out = ir.is_contiguous_for_memory_format_or_false

    def is_only_laid_out(tensor: torch.Tensor, memory_format: torch.memory_format) -> bool:
        # (B, 1, H, W) is contiguous and channels_last. As channels_last, planes were interleaved and then
        # separated again, by loops over transposed tiles: 3.5 MB of code for the gradient of `adjust_hue`.
        contiguous = is_laid_out(tensor, memory_format=torch.contiguous_format)
        return not contiguous and is_laid_out(tensor, memory_format=memory_format)

    with replaced({"torch._inductor.ir:is_contiguous_for_memory_format_or_false": is_only_laid_out}):
        yield


@contextmanager
def known_vectors(machine: str) -> Generator[None]:
    """Inductor with the vectors of a family of CPUs: AVX2, if this CPU has it, or NEON."""
    from torch._inductor import cpu_vec_isa

    found: list[cpu_vec_isa.VecISA] = []
    if machine == "aarch64":
        neon = cpu_vec_isa.VecNEON()
        neon._macro = ["CPU_CAPABILITY_NEON"]  # no Sleef: torch has only this machine's header
        found = [neon]
    elif "avx2" in cpu_vec_isa.x86_isa_checker():
        found = [cpu_vec_isa.VecAVX2()]
    with replaced({"torch._inductor.cpu_vec_isa:valid_vec_isa_list": lambda: found}):
        yield


@contextmanager
def short_minima(without_nan: bool) -> Generator[None]:
    """Minima and maxima by one instruction if the CPU has it (chiasm/minima_avx2.h). PyTorch's propagate NaN
    and take three instructions; rank filters and dilations consist only of minima and maxima. Where values
    may be NaN, one instruction is enough if the second value is a known number, as in a clamp."""
    from torch._inductor.codegen.cpp import CppVecOverrides

    def form(original: Callable[[Any, Any], str], short: str) -> Any:
        @wraps(original)  # Inductor finds the scalar form by the name
        def code(a: Any, b: Any) -> str:
            return original(a, b) if a.dtype == torch.bool else f"chiasm::{short}({a}, {b})"

        return staticmethod(code)

    names = ("smaller", "larger") if without_nan else ("minimum", "maximum")
    overrides = "torch._inductor.codegen.cpp:CppVecOverrides"
    with replaced(
        {
            f"{overrides}.minimum": form(CppVecOverrides.minimum, names[0]),
            f"{overrides}.maximum": form(CppVecOverrides.maximum, names[1]),
        }
    ):
        yield
