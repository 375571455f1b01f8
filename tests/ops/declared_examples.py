"""Example arguments for primitives that a kernel lowers as it is: they follow from its declaration, by the
search that makes the calls of the kernels' tests in C++ (runtime/artifact/example_calls.py)."""

import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from chiasm.primitives.core.lowering import Lowering
from chiasm.primitives.kernels import operators
from chiasm.primitives.kernels.schema import VARIABLES, Argument, Kernel

ROOT = Path(__file__).resolve().parents[2]
#: The search reads the declarations as the build does, without the package chiasm.
sys.path += [str(ROOT / "runtime/artifact"), str(ROOT / "python/chiasm/primitives")]
KERNELS: dict[str, Kernel] = import_module("kernels.declarations").KERNELS
allowed = import_module("example_calls").allowed

#: How many calls are looked for.
CALLS = 16


def declared_examples(lowerings: list[Lowering], dtype: torch.dtype) -> list[tuple[Any, ...]]:
    """Arguments for the first lowering that is a kernel's operator; none if there is no such lowering. A
    kernel that also takes integers gets them of all its types."""
    kernel = next(
        (KERNELS[r.form.__name__] for r in lowerings if r.form.__module__ == operators.__name__), None
    )
    if kernel is None:
        return []
    integers = [t for t in VARIABLES.get(kernel.variable or "", ()) if not t.startswith("float")]
    return [
        tuple(value(kernel, argument, call, of) for argument in kernel.arguments)
        for of in (dtype, *(getattr(torch, name) for name in integers))
        for call in allowed(kernel, CALLS)
        if is_ordinary(kernel, call)
    ]


def is_ordinary(kernel: Kernel, call: dict[str, Any]) -> bool:
    """Whether no tensor is empty and no number extreme, for which a definition need not have a value."""
    numbers = [call[a.name] for a in kernel.arguments if a.type == "float"]
    return all(call[size] > 0 for size in kernel.sizes) and all(abs(n) < 256 for n in numbers)


def value(kernel: Kernel, argument: Argument, call: dict[str, Any], variable: torch.dtype) -> Any:
    if argument.shape is None:
        return bool(call[argument.name]) if argument.type == "bool" else call[argument.name]
    dtype = variable if argument.type == kernel.variable else getattr(torch, argument.type)
    shape = [n for name in argument.shape for n in sizes(name, call)]
    if argument.name in call:
        return repeated(call[argument.name], shape, dtype)
    generator = torch.Generator().manual_seed(sum(shape))
    if dtype.is_floating_point:  # from below 0 to above 1
        return (torch.rand(shape, generator=generator, dtype=torch.float64) * 2 - 0.5).to(dtype)
    low, high = next(((low, high) for name, low, high in kernel.tried if name == argument.name), (0, 255))
    return torch.randint(low, high + 1, shape, generator=generator).to(dtype)


def sizes(name: str, call: dict[str, Any]) -> tuple[int, ...]:
    """A size of a declared shape; "..." stands for two."""
    if name == "...":
        return call["count"], 1
    return (int(name) if name.isdigit() else call[name],)


def repeated(entries: list[int], shape: list[int], dtype: torch.dtype) -> Tensor:
    count = torch.Size(shape).numel()
    return torch.tensor(entries, dtype=dtype).repeat(count)[:count].reshape(shape)
