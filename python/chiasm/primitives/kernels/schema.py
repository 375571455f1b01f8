"""Parses and checks the declarations of kernels. Needs only the standard library: the build reads
declarations without torch.

A declaration is one line, in the manner of PyTorch's operator schemas, with shapes::

    separable(T[B, C, H, W] x, T[R, K] taps, Border border, float scale) -> T[B, C, H, W]

* A tensor's type is ``T`` (float32 or float64), ``I`` (uint8 or int32), ``U`` (uint8 or uint16), ``P`` (a
  pixel's: uint8, int16, uint16, float32 or float64), ``float32``, ``float64``, ``uint8``, ``int16``,
  ``uint16``, ``int32``, ``int64`` or ``bool``. All tensors of type T in a call have the same type.
* A shape has names and numbers, and may begin with ``...``. A name stands for the same size wherever it
  occurs. Sizes named H and W are those of images: 1 to 2^31 - 1. The result's sizes are expressions in
  Python's syntax.
* Other arguments have the type ``int``, ``float``, ``bool`` or an enumeration.

Conditions are comparisons in Python's syntax, of sizes, numbers, constants, and int64 tensors, each of whose
entries is compared. An enumerator is in quotes.
"""

import ast
import re
from dataclasses import dataclass
from types import MappingProxyType
from typing import Dict, List, Mapping, Optional, Sequence, Tuple

#: What a type variable may stand for.
VARIABLES: Dict[str, Tuple[str, ...]] = {
    "T": ("float32", "float64"),
    "I": ("uint8", "int32"),
    "U": ("uint8", "uint16"),
    "P": ("uint8", "int16", "uint16", "float32", "float64"),
}
ELEMENTS = ("float32", "float64", "uint8", "int16", "uint16", "int32", "int64", "bool")
NUMBERS = ("int", "float", "bool")
#: The largest number of a pixel or bin: kernels index them by 32 bits.
INT32_MAX = 2**31 - 1

_NAME = r"[A-Za-z_][A-Za-z_0-9]*"
_SCHEMA = re.compile(rf"({_NAME})\((.*)\) -> ({_NAME})\[(.*)\]", re.DOTALL)
_TENSOR = re.compile(rf"({_NAME})\[(.*)\] ({_NAME})", re.DOTALL)
_NUMBER = re.compile(rf"({_NAME}) ({_NAME})")


class DeclarationError(ValueError):
    """A declaration that cannot be understood or does not fit the sources."""


@dataclass(frozen=True)
class Enumeration:
    """Names that stand for numbers from 0, in Python and in C++."""

    name: str
    values: Tuple[str, ...]
    doc: str

    @property
    def numbers(self) -> Dict[str, int]:
        return {value: number for number, value in enumerate(self.values)}


@dataclass(frozen=True)
class Argument:
    """``shape`` is None if it is no tensor."""

    name: str
    type: str
    shape: Optional[Tuple[str, ...]] = None


@dataclass(frozen=True)
class Kernel:
    """One kernel. Its operator, its C++ declarations and its documentation are generated from this."""

    schema: str
    #: File in runtime/artifact/kernels with the loop.
    source: str
    doc: str
    where: Tuple[str, ...]
    name: str
    arguments: Tuple[Argument, ...]
    result: Argument
    #: For the tests' calls: names of numbers, and of tensors whose entries are then whole, each with the
    #: least and the greatest value, where callers promise more than conditions can check.
    tried: Tuple[Tuple[str, int, int], ...] = ()
    #: Whether results are the same with every instruction set, also those of huge numbers.
    exact: bool = True

    @property
    def tensors(self) -> List[Argument]:
        return [a for a in self.arguments if a.shape is not None]

    @property
    def variable(self) -> Optional[str]:
        """Its type variable, if it has one."""
        return next((a.type for a in self.tensors if a.type in VARIABLES), None)

    @property
    def sizes(self) -> Dict[str, str]:
        """The names of sizes, each with the first argument that has it."""
        found: Dict[str, str] = {}
        for tensor in self.tensors:
            for size in tensor.shape or ():
                if size.isidentifier():
                    found.setdefault(size, tensor.name)
        return found

    @property
    def conditions(self) -> List[str]:
        """The conditions on the sizes' names, then ``where``."""
        return [f"1 <= {size} <= INT32_MAX" for size in self.sizes if size in ("H", "W")] + list(self.where)


def kernel(
    schema: str,
    source: str,
    doc: str,
    where: Sequence[str] = (),
    *,
    enumerations: Sequence[Enumeration] = (),
    constants: Mapping[str, int] = MappingProxyType({}),
    tried: Sequence[Tuple[str, int, int]] = (),
    exact: bool = True,
) -> Kernel:
    """A declaration, read and checked.

    >>> k = kernel(
    ...     "halved(T[..., H, W] x, bool twice) -> T[..., H, W]", "halved.cpp", "Half of each value."
    ... )
    >>> k.name, k.sizes, k.conditions[0]
    ('halved', {'H': 'x', 'W': 'x'}, '1 <= H <= INT32_MAX')
    >>> kernel("halved(Matrix[N] x) -> T[N]", "halved.cpp", "")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ...
    chiasm.primitives.kernels.schema.DeclarationError: kernel halved: argument x: unknown type Matrix, ...
    """
    schema = " ".join(schema.split())
    parts = _SCHEMA.fullmatch(schema)
    if parts is None:
        raise DeclarationError(
            f"kernel {schema!r}: expected name(type[shape] argument, type argument, ...) -> type[shape]"
        )
    name, inside, result_type, result_shape = parts.groups()
    arguments = tuple(_argument(name, text, [e.name for e in enumerations]) for text in _split(inside))
    result = Argument("result", result_type, tuple(_split(result_shape)))
    declared = Kernel(
        schema, source, " ".join(doc.split()), tuple(where), name, arguments, result, tuple(tried), exact
    )
    _check(declared, ["INT32_MAX", *constants])
    return declared


def identifiers(expression: str, kernel_name: str) -> List[str]:
    """The names in an expression, in their order."""
    try:
        tree = ast.parse(expression, mode="eval")
    except SyntaxError:
        raise DeclarationError(f"kernel {kernel_name}: {expression!r} is no expression") from None
    return [
        node.id
        for node in sorted((n for n in ast.walk(tree) if isinstance(n, ast.Name)), key=lambda n: n.col_offset)
    ]


def _split(text: str) -> List[str]:
    """At commas outside brackets."""
    return [part.strip() for part in re.split(r",(?![^\[(]*[\])])", text)] if text.strip() else []


def _argument(kernel_name: str, text: str, enumerations: Sequence[str]) -> Argument:
    tensor, number = _TENSOR.fullmatch(text), _NUMBER.fullmatch(text)
    if tensor is not None:
        argument = Argument(tensor[3], tensor[1], tuple(_split(tensor[2])))
        known: Sequence[str] = (*VARIABLES, *ELEMENTS)
    elif number is not None:
        argument = Argument(number[2], number[1])
        known = (*NUMBERS, *enumerations)
    else:
        raise DeclarationError(
            f"kernel {kernel_name}: expected 'type[shape] name' or 'type name', got {text!r}"
        )
    if argument.type not in known:
        raise DeclarationError(
            f"kernel {kernel_name}: argument {argument.name}: unknown type {argument.type}, known are"
            f" {', '.join(known)}"
        )
    return argument


def _check(k: Kernel, constants: Sequence[str]) -> None:
    names = [a.name for a in k.arguments] + [size.lower() for size in k.sizes] + ["out"]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise DeclarationError(
            f"kernel {k.name}: two arguments or sizes named {twice[0]} (sizes have small letters in C++)"
        )
    if len({a.type for a in k.tensors if a.type in VARIABLES}) > 1:
        raise DeclarationError(
            f"kernel {k.name}: one of the type variables {', '.join(VARIABLES)} at most, got several"
        )
    if k.result.type not in (*ELEMENTS, k.variable):
        raise DeclarationError(
            f"kernel {k.name}: result: unknown type {k.result.type}, known are the arguments' type variable"
            f" and {', '.join(ELEMENTS)}"
        )
    for tensor in k.tensors:
        for i, size in enumerate(tensor.shape or ()):
            if not (size.isidentifier() or size.isdigit() or (size == "..." and i == 0)):
                raise DeclarationError(
                    f"kernel {k.name}: argument {tensor.name}: a size is a name, a number, or '...' at the"
                    f" beginning, got {size!r}"
                )
    folded = [t.name for t in k.tensors if "..." in (t.shape or ())]
    if len(folded) > 1 or ("..." in (k.result.shape or ()) and not folded):
        raise DeclarationError(
            f"kernel {k.name}: '...' stands in one argument's shape, and from there in the result's; got"
            f" {', '.join(folded) or 'none'}"
        )
    limited = {a.name for a in k.arguments if a.shape is not None or a.type == "int"}
    for name, low, high in k.tried:
        if name not in limited or low > high:
            raise DeclarationError(
                f"kernel {k.name}: tried: expected an int or a tensor among the arguments, and two limits,"
                f" got {name}, {low}, {high}"
            )
    numbers = {a.name for a in k.arguments if a.shape is None}
    entries = {a.name for a in k.tensors if a.type == "int64"}
    for expressions, known in (
        ([s for s in k.result.shape or () if s != "..."], {*k.sizes, *numbers, *constants}),
        (k.where, {*k.sizes, *numbers, *entries, *constants}),
    ):
        for expression in expressions:
            unknown = [name for name in identifiers(expression, k.name) if name not in known]
            if unknown:
                raise DeclarationError(
                    f"kernel {k.name}: {expression!r} names {unknown[0]}, which is no size, number or int64"
                    " tensor among the arguments"
                )
