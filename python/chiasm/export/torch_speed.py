"""What PyTorch's exporters do slowly for ops with symbolic sizes, put in its place while chiasm exports.

Together it was three quarters of an export's time; the results are the same.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any
from unittest.mock import patch

import sympy
import torch

from . import onnx_numbers
from .compiler import Build
from .decomposition import decomposed


class _Sympy:
    """sympy, but for `simplify`: Inductor calls it to see whether an index is linear in a loop's variable, for which expanding
    does as well, in a fraction of the time."""

    def __getattr__(self, name: str) -> Any:
        return getattr(sympy, name)

    @staticmethod
    def simplify(expression: Any) -> sympy.Expr:
        return sympy.expand(expression)


@contextmanager
def fast_inductor(build: Build) -> Iterator[None]:
    """AOTInductor without `sympy.simplify`, whose compilers `build` runs."""
    from torch._inductor import cpp_builder, sizevars

    with patch.object(sizevars, "sympy", _Sympy()), patch.object(cpp_builder, "run_compile_cmd", build.run):
        yield


@contextmanager
def known_vectors() -> Iterator[None]:
    """Inductor with AVX2 where the CPU has it, and without else. It would compile and load a program for each form of AVX-512 to see which of
    them it could take, though it is told to take none."""
    from torch._inductor import cpu_vec_isa

    found = [cpu_vec_isa.VecAVX2()] if "avx2" in cpu_vec_isa.x86_isa_checker() else []
    with patch.object(cpu_vec_isa, "valid_vec_isa_list", lambda: found):
        yield


@contextmanager
def fast_tracing() -> Iterator[None]:
    """Fake tensors without their cache: with symbolic sizes a hit costs more than computing the result's metadata again. And without asking
    of each operand whether it has its channels last, which takes more such arithmetic than all the rest; what has not is computed as well."""
    import torch._dynamo.config
    from torch._subclasses import fake_impls

    is_contiguous = fake_impls.is_contiguous_for_memory_format_or_false

    def is_plain(tensor: torch.Tensor, memory_format: torch.memory_format) -> bool:
        return memory_format is torch.contiguous_format and is_contiguous(tensor, memory_format=memory_format)

    with torch._dynamo.config.patch(fake_tensor_cache_enabled=False), patch.object(fake_impls, "is_contiguous_for_memory_format_or_false", is_plain):
        yield


@contextmanager
def fast_onnx() -> Iterator[None]:
    """torch.onnx without reading its 1500 operator definitions at each export, and without running the whole graph again: to decompose
    a few operators, and to see which types are to be promoted. It may change the program that it is given."""
    from torch.onnx._internal.exporter import _fx_passes, _registration
    from torch.onnx._internal.fx.passes import type_promotion

    registry = _registry()
    with (
        fast_tracing(),
        patch.object(_registration.ONNXRegistry, "from_torchlib", staticmethod(lambda **_: registry)),
        patch.object(_fx_passes, "decompose_with_registry", decomposed),
        patch.object(type_promotion._TypePromotionInterpreter, "run_node", _promoted),
    ):
        yield


@cache
def _registry() -> Any:
    from onnxscript.values import TracedOnnxFunction
    from torch.onnx._internal.exporter import _registration

    # It reads the source text of each of 600 functions, to note a domain that nobody asks for: that of the opset, which is taken instead.
    with patch.object(TracedOnnxFunction, "function_ir", property(lambda function: function.opset)):
        registry = _registration.ONNXRegistry.from_torchlib()
    onnx_numbers.register(registry)
    return registry


def _promoted(interpreter: Any, node: torch.fx.Node) -> Any:
    """A node's value, once its arguments are of the types that it promotes them to. The value that tracing left with the node holds
    still, since a promoted node is followed by a cast where its type would change."""
    from torch.onnx._internal.fx.passes import type_promotion

    if node.op != "call_function" or "val" not in node.meta:
        return torch.fx.Interpreter.run_node(interpreter, node)
    with interpreter._set_current_node(node):
        if rule := type_promotion.get_type_promotion_rule(node, interpreter.type_promotion_table):
            interpreter._maybe_promote_node(node, rule)
    return node.meta["val"]
