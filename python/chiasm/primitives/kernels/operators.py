"""The kernels as operators ``chiasm::NAME``, which a lowering for native code calls: ``operators.canny_nms(x,
1e-6)``.

A call takes the arguments of the kernel's declaration, enumerators by their names. The operators have shapes
and types, but no computation. The definition of the primitive that they lower says in tensor code what they
compute; it runs everywhere else, and gradients are derived from it.
"""

import functools
from typing import Any, Callable, Dict

import torch
from torch import Tensor

from ..core.target import current_target
from .declarations import CONSTANTS, ENUMERATIONS, KERNELS
from .schema import INT32_MAX, VARIABLES, Argument, Kernel


def __getattr__(name: str) -> Callable[..., Tensor]:
    if name in KERNELS:
        return _caller(KERNELS[name])
    raise AttributeError(f"there is no kernel {name!r}; the kernels are {', '.join(KERNELS)}")


MOST_ROWS, MOST_TERMS = CONSTANTS["MOST_ROWS"], CONSTANTS["MOST_TERMS"]


def available(x: Tensor, *_: object) -> bool:
    """Whether x is being traced for an export to the CPU: elsewhere the operators cannot run."""
    return torch.compiler.is_exporting() and x.device.type == "cpu" and current_target() != "cuda"


def has_kernel(x: Tensor, *_: object) -> bool:
    """``available``, and x has a floating-point type that the kernels support."""
    return available(x) and (x.dtype == torch.float32 or x.dtype == torch.float64)


def has_pixel_kernel(x: Tensor, *_: object) -> bool:
    """``available``, and x has a type that kernels of pixels (type P) support."""
    return available(x) and x.dtype in _PIXELS


def has_moving_kernel(x: Tensor, *_: object) -> bool:
    """``available``, and x has a type that kernels which only move values (type A) support."""
    return available(x) and x.dtype in _MOVED


def runs_to_its_end(limit: int) -> bool:
    """Whether ``limit`` lets a loop over connected pixels run to its end: the number of its steps grows with
    the logarithm of the number of pixels, and 64 are enough for any mask."""
    return limit >= 64


_PIXELS = [getattr(torch, name) for name in VARIABLES["P"]]
_MOVED = [getattr(torch, name) for name in VARIABLES["A"]]
_NUMBERS = {e.name: e.numbers for e in ENUMERATIONS}
_SCHEMA_TYPES = {"int": "SymInt", "float": "float", "bool": "bool"} | {e.name: "int" for e in ENUMERATIONS}


def _register(kernel: Kernel) -> None:
    arguments = ", ".join(
        f"{'Tensor' if a.shape is not None else _SCHEMA_TYPES[a.type]} {a.name}" for a in kernel.arguments
    )
    torch.library.define(f"chiasm::{kernel.name}", f"({arguments}) -> Tensor")
    torch.library.register_fake(f"chiasm::{kernel.name}", functools.partial(declared_result, kernel))


def declared_result(kernel: Kernel, *values: Any) -> Tensor:
    """A result of the declared shape and type, without values."""
    known: Dict[str, Any] = {"INT32_MAX": INT32_MAX, **CONSTANTS}
    folded: list[Any] = []
    like = values[0]
    for argument, value in zip(kernel.arguments, values, strict=True):
        if argument.shape is None:
            known[argument.name] = value
            continue
        like = value if argument.type == kernel.variable else like
        named = [size for size in argument.shape if size != "..."]
        leading = value.dim() - len(named)
        if leading < 0 or (leading > 0 and len(named) == len(argument.shape)):
            raise ValueError(
                f"{kernel.name}: {argument.name}: expected shape ({', '.join(argument.shape)}), got"
                f" {list(value.shape)}"
            )
        folded = list(value.shape[:leading]) if len(named) < len(argument.shape) else folded
        known |= {size: value.shape[leading + i] for i, size in enumerate(named)}
    sizes = [eval(size, {"__builtins__": {}}, known) for size in kernel.result.shape or () if size != "..."]
    dtype = like.dtype if kernel.result.type == kernel.variable else getattr(torch, kernel.result.type)
    return like.new_empty([*(folded if "..." in (kernel.result.shape or ()) else []), *sizes], dtype=dtype)


@functools.cache
def _caller(kernel: Kernel) -> Callable[..., Tensor]:
    operator = getattr(torch.ops.chiasm, kernel.name)

    def call(*values: Any) -> Tensor:
        return operator(*(_as_number(kernel, a, v) for a, v in zip(kernel.arguments, values, strict=True)))

    call.__name__, call.__doc__ = kernel.name, kernel.doc
    return call


def _as_number(kernel: Kernel, argument: Argument, value: Any) -> Any:
    numbers = _NUMBERS.get(argument.type)
    if numbers is None:
        return value
    if value not in numbers:
        raise ValueError(
            f"{kernel.name}: {argument.name}: expected one of {', '.join(numbers)}, got {value!r}"
        )
    return numbers[value]


for _kernel in KERNELS.values():
    _register(_kernel)
