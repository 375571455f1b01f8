"""Parses and checks the declarations of kernels. Needs only the standard library: the build reads
declarations without torch.

A declaration is one line, in the manner of PyTorch's operator schemas, with shapes::

    separable(T[B, C, H, W] x, T[R, K] taps, Border border, float scale) -> T[B, C, H, W]

* A tensor's type is ``T`` (float32 or float64), ``I`` (uint8 or int32), ``U`` (uint8 or uint16), ``S`` (16
  bits: int16 or uint16), ``V`` (8 or 16 bits: uint8, int16 or uint16), ``P`` (a pixel's: uint8, int16,
  uint16, float32 or float64), ``A`` (``P`` or int64, for values that are only moved), ``float32``,
  ``float64``, ``uint8``, ``int16``, ``uint16``, ``int32``, ``int64`` or ``bool``. All tensors of type T in a
  call have the same type.
* A shape has names and numbers, and may begin with ``...``. A name stands for the same size wherever it
  occurs. Sizes named H and W are those of images: 1 to 2^31 - 1. The result's sizes are expressions in
  Python's syntax.
* Other arguments have the type ``int``, ``float``, ``bool`` or an enumeration.

Conditions are comparisons in Python's syntax, of sizes, numbers, constants, and int64 tensors, each of whose
entries is compared; those in one condition have the same shape. An enumerator is in single quotes, and a
power has two numbers, as ``2**24``.
"""

import ast
import keyword
import re
from dataclasses import dataclass
from types import MappingProxyType
from typing import Dict, Iterator, List, Mapping, Optional, Sequence, Tuple

#: What a type variable may stand for.
VARIABLES: Dict[str, Tuple[str, ...]] = {
    "T": ("float32", "float64"),
    "I": ("uint8", "int32"),
    "U": ("uint8", "uint16"),
    "S": ("int16", "uint16"),
    "V": ("uint8", "int16", "uint16"),
    "P": ("uint8", "int16", "uint16", "float32", "float64"),
    "A": ("uint8", "int16", "uint16", "float32", "float64", "int64"),
}
ELEMENTS = ("float32", "float64", "uint8", "int16", "uint16", "int32", "int64", "bool")
NUMBERS = ("int", "float", "bool")
#: The largest number of a pixel or bin: kernels index them by 32 bits.
INT32_MAX = 2**31 - 1

#: Words of C++ that are no names.
_WORDS = """
    alignas alignof and and_eq asm auto bitand bitor bool break case catch char char16_t char32_t char8_t
    class co_await co_return co_yield compl concept const const_cast consteval constexpr constinit continue
    decltype default delete do double dynamic_cast else enum explicit export extern false float for friend
    goto if inline int long mutable namespace new noexcept not not_eq nullptr operator or or_eq private
    protected public register reinterpret_cast requires return short signed sizeof static static_assert
    static_cast struct switch template this thread_local throw true try typedef typeid typename union unsigned
    using virtual void volatile wchar_t while xor xor_eq
"""
#: Names in the generated code (runtime/artifact/kernel_adapters.py, example_tests.py).
_GENERATED = """
    Argument AtenTensorHandle Handle INFINITY INT64_MIN Images NAN Planes Result Tensor argument blank c call
    data expect_refused expected for_type guarded i int16_t int32_t int64_t is_empty make of refuse
    refuses_altered result uint16_t uint8_t values_text within
"""

#: The generated code has other names that begin with k and a capital letter, or end with "_".
_NAME = r"(?!k[A-Z])[A-Za-z](?:_?[A-Za-z0-9])*"
_SCHEMA = re.compile(rf"({_NAME})\((.*)\) -> ({_NAME})\[(.*)\]", re.DOTALL)
_SIZE = re.compile(rf"{_NAME}|0|[1-9][0-9]*")
_SOURCE = re.compile(r"\w+\.cpp")
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
    for what, value in (("schema", schema), ("source", source), ("doc", doc)):
        if not isinstance(value, str):  # pyright: ignore[reportUnnecessaryIsInstance]
            raise DeclarationError(f"kernel {schema!r}: {what}: expected a text, got {value!r}")
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
    fault = next(_faults(declared, [e.name for e in enumerations], ["INT32_MAX", *constants]), None)
    if fault is not None:
        raise DeclarationError(f"kernel {name}: {fault}")
    return declared


def parsed(expression: str, kernel_name: str) -> ast.expr:
    """An expression in Python's syntax."""
    try:
        return ast.parse(expression, mode="eval").body
    except (SyntaxError, ValueError):
        raise DeclarationError(f"kernel {kernel_name}: {expression!r} is no expression") from None


def identifiers(expression: str, kernel_name: str) -> List[str]:
    """The names in an expression, in their order."""
    names = (node for node in ast.walk(parsed(expression, kernel_name)) if isinstance(node, ast.Name))
    return [node.id for node in sorted(names, key=lambda node: node.col_offset)]


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


def _faults(k: Kernel, enumerations: Sequence[str], constants: Sequence[str]) -> Iterator[str]:
    """What is wrong; each check relies on those before it."""
    arguments, small = [a.name for a in k.arguments], [size.lower() for size in k.sizes]
    names = [*arguments, *small, *(size for size in k.sizes if size not in small), "out"]
    for name in sorted({name for name in names if names.count(name) > 1}):
        yield f"two arguments or sizes named {name} (sizes have small letters in C++)"
    folded = [t.name for t in k.tensors if "..." in (t.shape or ())]
    words = {*keyword.kwlist, *_WORDS.split(), *(("count", "planes") if folded else ())}
    if any(t.shape == ("B", "C", "H", "W") for t in k.tensors):
        words.add("images")
    others = {*_GENERATED.split(), *enumerations, *constants, k.variable}
    for name in (k.name, *arguments, *k.sizes):
        if name in words | others or (name in k.sizes and name.lower() in words):
            yield f"the name {name} has another meaning in the generated code"
    if not _SOURCE.fullmatch(k.source):
        yield f"source: expected a name like medians.cpp, got {k.source!r}"
    if "*/" in k.doc:
        yield "doc: expected a text that can be a comment, got one with '*/'"
    if not k.tensors:
        yield "expected a tensor among the arguments, got none"
    if len({a.type for a in k.tensors if a.type in VARIABLES}) > 1:
        yield f"one of the type variables {', '.join(VARIABLES)} at most, got several"
    if k.result.type not in (*ELEMENTS, k.variable):
        yield (
            f"result: unknown type {k.result.type}, known are the arguments' type variable and"
            f" {', '.join(ELEMENTS)}"
        )
    for tensor in k.tensors:
        for i, size in enumerate(tensor.shape or ()):
            if not (_SIZE.fullmatch(size) or (size == "..." and i == 0)):
                yield (
                    f"argument {tensor.name}: a size is a name, a number, or '...' at the beginning, got"
                    f" {size!r}"
                )
    if len(folded) > 1 or ("..." in (k.result.shape or ()) and not folded):
        yield (
            "'...' stands in one argument's shape, and from there in the result's; got"
            f" {', '.join(folded) or 'none'}"
        )
    limited = {a.name for a in k.arguments if a.shape is not None or a.type == "int"}
    for entry in k.tried:
        match entry:
            case (str(name), int(low), int(high)) if name in limited and low <= high:
                pass
            case _:
                got = ", ".join(map(str, entry)) if isinstance(entry, tuple) else repr(entry)
                yield f"tried: expected an int or a tensor among the arguments, and two limits, got {got}"
    numbers = {a.name: a.type for a in k.arguments if a.shape is None}
    for text in (size for size in k.result.shape or () if size != "..."):
        whole = [name for name, kind in numbers.items() if kind in ("int", "bool")]
        for name in identifiers(text, k.name):
            if name not in (*k.sizes, *whole, *constants):
                yield f"{text!r} names {name}, which is no size, int or bool among the arguments"
    shapes = {a.name: a.shape for a in k.tensors if a.type == "int64"}
    for text in k.where:
        if not isinstance(text, str) or not set(text).isdisjoint('"\\\n'):  # pyright: ignore[reportUnnecessaryIsInstance]
            yield f"expected a condition as one line, enumerators in single quotes, got {text!r}"
        names = identifiers(text, k.name)
        for name in names:
            if name not in (*k.sizes, *numbers, *shapes, *constants):
                yield f"{text!r} names {name}, which is no size, number or int64 tensor among the arguments"
        if not isinstance(parsed(text, k.name), ast.Compare) or not set(names) - {*constants}:
            yield f"{text!r} is no comparison of a size, a number or an int64 tensor"
        if len({shapes[name] for name in names if name in shapes}) > 1:
            yield f"{text!r} compares int64 tensors of different shapes"
