# What is patched is without types.
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false
"""Makes AOTInductor's code check indices and divisors that come from data.

AOTInductor either trusts an index (a wrong one reads and writes anywhere) or throws inside a parallel region,
which ends the process. Here a wrong index is noted for the run, a valid one is used instead, and the run
returns the error (`runtime/artifact/include/chiasm/checked.h`). An index that `IndexRanges` proves to be in
range costs nothing.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest.mock import patch

import sympy

from ..formats.index_ranges import IndexRanges, depends_on_data
from . import replaced

#: Functions of PyTorch's header that have checked forms in namespace chiasm.
_DIVISIONS = re.compile(r"(?<![\w:.])(floor_divide_integral|remainder_integral|mod)\(")
_WRAPPER = "torch._inductor.codegen.cpp_wrapper_cpu:CppWrapperCpu"
_PREFIX = "#include <torch/csrc/inductor/cpp_prefix.h>\n"
#: PyTorch notes a division by zero through a global pointer to a local variable, which concurrent runs
#: overwrite.
_DIVISION_FLAG = re.compile(
    r"^\s*(?:std::atomic<int> )?inductor_cpu_(?:integer_div_error|throw_if_integer_div_error)\b.*\n", re.M
)
_DIVISION_POINTER = re.compile(r"^\s*inductor_cpu_integer_div_error_flag = .*\n", re.M)


@contextmanager
def checked_native_code(header: Path | None = None) -> Generator[None]:
    """Inside this context, AOTInductor writes loops that check values from data. With a `header` (checked.h),
    the code is for libtorch: it contains that text, and its checks throw."""
    from torch._inductor.codegen import cpp

    group = cpp.KernelGroup.codegen_group
    include = "#include <chiasm/checked.h>\n"
    if header is not None:
        # As text, not by its folder, which has other headers too
        text = header.read_text().replace("#pragma once\n", "")
        include = f"#ifndef CHIASM_CHECKS_THROW\n#define CHIASM_CHECKS_THROW\n{text}#endif\n"

    def codegen_group(self: Any, name: str | None = None) -> str:
        code = group(self, name)
        if not code:
            return code
        code, count = _DIVISION_POINTER.subn("", code)
        code, others = _DIVISION_FLAG.subn("", code)
        if count != 2 or others != 2 or _PREFIX not in code:
            raise RuntimeError(
                "this PyTorch writes its loops differently: chiasm/export/patches was made for 2.13"
            )
        return _DIVISIONS.sub(r"chiasm::\1(", code).replace(_PREFIX, _PREFIX + include)

    def nothing(_: Any) -> None: ...

    with replaced(
        {
            "torch._inductor.codegen.common:CSEProxy.indirect_indexing": indirect_indexing_with(
                IndexRanges(), _checked
            ),
            "torch._inductor.index_propagation:IndexPropagation.indirect_indexing": checked_propagation(),
            "torch._inductor.codegen.cpp:KernelGroup.codegen_group": codegen_group,
            "torch._inductor.codegen.cpp:CppOverrides.truncdiv": staticmethod(_Scalars.truncdiv),
            "torch._inductor.codegen.cpp:CppVecOverrides.truncdiv": staticmethod(_Vectors.truncdiv),
            "torch._inductor.codegen.cpp:CppVecOverrides.remainder": staticmethod(_Vectors.remainder),
        }
        | {
            f"{_WRAPPER}.{name}": _reporting(name)
            for name in ("_generate_scatter_fallback", "_generate_index_put_fallback")
        }
        | {f"{_WRAPPER}.generate_input_output_runtime_checks": without_runtime_checks}
        # The needed part of it is compiled with the package (runtime/artifact/aoti/entry.cpp).
        | ({} if header else {f"{_WRAPPER}._write_aoti_interface_header": nothing})
    ):
        yield


def without_runtime_checks(wrapper: Any) -> None:
    """In place of the wrapper's checks of inputs, which are on if an environment variable is set."""
    wrapper.prefix.splice_aot(
        """
        static constexpr bool _check_aoti_runtime_check_inputs_env() { return false; }
        static void __check_inputs_outputs(AtenTensorHandle*, AtenTensorHandle*) {}
        """
    )


class _Scalars:
    @staticmethod
    def truncdiv(a: Any, b: Any) -> str:
        return f"chiasm::truncated_quotient({a}, {b})"


class _Vectors:
    # Inductor finds the scalar forms by these names.
    @staticmethod
    def truncdiv(a: Any, b: Any) -> str:
        return f"chiasm::truncated_quotient({a}, {_divisor(b)})"

    @staticmethod
    def remainder(a: Any, b: Any) -> str:
        from torch._inductor.codegen.cpp import CppVecOverrides

        if a.dtype.is_floating_point:
            return f"{a} - ({CppVecOverrides.floordiv(a, b)}) * {b}"
        return f"remainder_integral({a}, {_divisor(b)})"


def _divisor(b: Any) -> str:
    """The vector b with 1 in the lanes that are not used at a row's end, which may be 0."""
    from torch._inductor.codegen.cpp_utils import cexpr_index
    from torch._inductor.virtualized import V

    kernel: Any = V.kernel
    return f"decltype({b})::set(decltype({b})(1), {b}, {cexpr_index(kernel.num_elems)})"


def _reporting(name: str) -> Callable[..., None]:
    """For the wrapper's method `name`, which calls libtorch and ignores whether the call failed: with a wrong
    index, nothing would be written and the run would succeed."""
    from torch._inductor.codegen.cpp_wrapper_cpu import CppWrapperCpu

    unchecked = getattr(CppWrapperCpu, name)

    def generate(self: Any, *arguments: Any, **keywords: Any) -> None:
        lines: list[str] = []
        with patch.object(self, "writeline", lines.append):
            unchecked(self, *arguments, **keywords)
        for line in lines:
            is_call = line.startswith("aoti_torch_")
            self.writeline(f"AOTI_TORCH_ERROR_CODE_CHECK({line.removesuffix(';')});" if is_call else line)

    return generate


def indirect_indexing_with(
    ranges: IndexRanges, checked: Callable[[Any, Any, Any, bool], str]
) -> Callable[..., Any]:
    """For `CSEProxy.indirect_indexing`: an index that `ranges` does not prove becomes `checked(kernel, index,
    size, wrapped)`, an expression of the language that the kernel is written in."""
    from torch._inductor.codegen import common

    trusted = common.CSEProxy.indirect_indexing

    def indirect_indexing(
        self: Any, var: Any, size: Any, check: bool = True, wrap_neg: bool = True
    ) -> sympy.Symbol:
        from torch._inductor.virtualized import V

        wrapped = wrap_neg and bool(var.bounds.lower < 0)
        current = V.interpreter.current_node
        assert current is not None
        node = current.args[0]
        proved = ranges.proves(node, size, wrapped) or not (check or depends_on_data(node))
        symbol = trusted(self, var, size, False, wrap_neg)
        if proved:
            return symbol
        index = self.kernel.cse.varname_map[symbol.name]
        safe = self.kernel.cse.generate(
            self.kernel.compute,
            checked(self.kernel, index, size, wrapped),
            bounds=index.bounds,
            dtype=index.dtype,
            shape=index.shape,
        )
        safe.update_on_args("checked_index", (index,), {})
        return self.parent_handler.indirect_indexing(safe, size, False)

    return indirect_indexing


def checked_propagation() -> Callable[..., Any]:
    """For `IndexPropagation.indirect_indexing`: an index that is an expression of sizes is checked like one
    from data, unless it is proved to be in range."""
    from torch._inductor.index_propagation import IndexPropagation

    propagated = IndexPropagation.indirect_indexing

    def propagate(self: Any, index: Any, size: Any, check: bool = True, wrap_neg: bool = True) -> Any:
        if check and getattr(index, "is_symbolic", False):
            expression = sympy.sympify(index.value.expr)
            low = self.statically_true(expression >= 0) or (
                wrap_neg and self.statically_true(-size <= expression)
            )
            if not (low and self.statically_true(expression < size)):
                return self.fallback("indirect_indexing", (index, size, check, wrap_neg), {}).value
        return propagated(self, index, size, check, wrap_neg)

    return propagate


def _checked(kernel: Any, index: Any, size: Any, wrapped: bool) -> str:
    """The C++ expression for `index` with its check. The axis is not empty: no symbol may be 0
    (checks/arguments.py), and torch.export ensures the rest."""
    from torch._inductor.codegen.cpp_utils import cexpr_index

    limit = cexpr_index(kernel.rename_indexing(sympy.sympify(size)))
    arguments = [str(index), f"static_cast<int64_t>({limit})", f'"{_reader(kernel)}"']
    mask = kernel._load_mask
    masked_by_vector = mask is not None and getattr(mask, "is_vec", False)
    if getattr(index, "is_vec", False):
        used = kernel.tail_size or f"chiasm::Lanes<std::decay_t<decltype({index})>>::count"
        arguments.append(used if isinstance(used, str) else f"static_cast<int>({cexpr_index(used)})")
        if mask is not None:
            arguments.append(
                f"[&](int lane) {{ return bool({f'{mask}.is_masked(lane)' if masked_by_vector else mask}); }}"
            )
    elif mask is not None:
        arguments.append(f"!{mask}.all_zero()" if masked_by_vector else f"bool({mask})")
    return f"chiasm::checked_index<{str(wrapped).lower()}>({', '.join(arguments)})"


def _operators(kernel: Any) -> set[str]:
    """The ATen operators of the op's code from which the loop was made; only those that use indices, if there
    are any."""
    origins = kernel.current_node.node.get_origins() if kernel.current_node is not None else ()
    names = {
        str(n.meta.get("original_aten") or n.target).rpartition(".")[0] or str(n.target)
        for n in origins
        if n.op == "call_function"
    }
    return {n for n in names if re.search(r"index|gather|scatter|embedding|put|take|select|pool", n)} or names


def _reader(kernel: Any) -> str:
    """The operators that an error names."""
    return " or ".join(sorted(_operators(kernel))) or "an index"
