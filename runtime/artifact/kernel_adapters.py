"""Makes the headers of the kernels, one for each source, and the C functions that AOTInductor's code calls:
kernel_calls.h and kernel_calls.cpp, which check everything that the loops assume."""

import ast
import re
import textwrap
from typing import Dict, Iterator, List

from kernels.declarations import CONSTANTS, ENUMERATIONS, KERNELS
from kernels.schema import VARIABLES, Argument, DeclarationError, Kernel, identifiers

MADE = (
    "// Made from the declarations in python/chiasm/primitives/kernels/declarations by"
    " runtime/artifact/generate.py."
)
CPP = {
    "float32": "float",
    "float64": "double",
    "uint8": "uint8_t",
    "int16": "int16_t",
    "uint16": "uint16_t",
    "int32": "int32_t",
    "int64": "int64_t",
    "bool": "bool",
    "int": "int64_t",
}
CODES = {
    "float32": "kFloat",
    "float64": "kDouble",
    "uint8": "kUint8",
    "int16": "kInt16",
    "uint16": "kUint16",
    "int32": "kInt32",
    "int64": "kInt64",
    "bool": "kBool",
}
ENUMERATORS = {e.name: e.numbers for e in ENUMERATIONS}
OPERATORS: Dict[type, str] = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.FloorDiv: "/",
    ast.Mod: "%",
    ast.Lt: "<",
    ast.LtE: "<=",
    ast.Gt: ">",
    ast.GtE: ">=",
    ast.Eq: "==",
    ast.NotEq: "!=",
}


def cpp_type(kernel: Kernel, argument: Argument) -> str:
    """The C++ type of a number, or of a tensor's elements."""
    if argument.type == "float":
        return "T" if kernel.variable == "T" else "double"
    return CPP.get(argument.type, argument.type)


def parameters(kernel: Kernel) -> Iterator[tuple[str, str, str]]:
    """Type, name and value (in kernel_calls.cpp) of each parameter of the C++ function: a tensor's data and
    those of its sizes that are not parameters yet."""
    there: set[str] = set()
    for argument in kernel.arguments:
        kind = cpp_type(kernel, argument)
        if argument.shape is None:
            forms = {
                "bool": f"{argument.name} != 0",
                "int64_t": argument.name,
                "T": f"static_cast<T>({argument.name})",
            }
            yield kind, argument.name, forms.get(kind, f"{kind}({argument.name})")
            continue
        yield f"const {kind}*", argument.name, f"{argument.name}.data<{kind}>()"
        if argument.shape == ("...", "H", "W"):
            yield "Planes", "planes", "{count, H, W}"
            there |= {"H", "W"}
        elif argument.shape == ("B", "C", "H", "W") and not there & set(argument.shape):
            yield "Images", "images", "{B, C, H, W}"
            there |= set(argument.shape)
        elif "..." in argument.shape:
            yield "int64_t", "count", "count"
        for size in argument.shape:
            if size.isidentifier() and size not in there:
                there.add(size)
                yield "int64_t", size.lower(), size
    yield f"{cpp_type(kernel, kernel.result)}*", "out", f"data<{cpp_type(kernel, kernel.result)}>(out)"


def headers(sources: List[str]) -> Dict[str, str]:
    """The headers by their paths: declared/types.h for all sources, declared/SOURCE.h of the kernels that a
    source defines, and kernels.h of all, for tests and calls. A source that includes no other's header is not
    compiled again when another kernel is added."""
    own = {s: f"declared/{s[: -len('.cpp')]}.h" for s in sources}
    made = {
        path: _header(["declared/types.h"], [line for k in _of(source) for line in _declaration(k)])
        for source, path in own.items()
    }
    made["declared/types.h"] = _header(["artifact/kernels/images.h"], _types())
    made["kernels.h"] = _header(list(own.values()), [])
    return made


def _of(source: str) -> List[Kernel]:
    return [k for k in KERNELS.values() if k.source == source]


def _header(included: List[str], lines: List[str]) -> str:
    out = [MADE, "#pragma once", "", *(f'#include "{header}"' for header in included), ""]
    if lines:
        out += ["namespace chiasm::kernels {", "", *lines, "}  // namespace chiasm::kernels", ""]
    return "\n".join(out)


def _types() -> List[str]:
    """The enumerations and constants of declarations."""
    out: List[str] = []
    for e in ENUMERATIONS:
        values = ", ".join("k" + value.capitalize() for value in e.values)
        out += [f"/** {e.doc} */", f"enum class {e.name} : int64_t {{ {values} }};", ""]
    out += [f"inline constexpr int64_t {constant(name)} = {value};" for name, value in CONSTANTS.items()]
    return [
        *out,
        "",
        "/** Stands at the end of a source, for each of its kernels with a type variable. */",
        "#define CHIASM_INSTANTIATE(kernel) CHIASM_INSTANTIATE_##kernel",
        "",
    ]


def _declaration(k: Kernel) -> List[str]:
    types = [kind for kind, _, _ in parameters(k)]
    function = f"void {k.name}({', '.join(f'{kind} {name}' for kind, name, _ in parameters(k))})"
    where = [f"Where {', '.join(k.where)}."] if k.where else []
    out = [f"/** {k.schema}", " *", *(f" *  {line}" for line in [*textwrap.wrap(k.doc, 140), *where])]
    out[-1] += " */"
    if not k.variable:
        return [*out, f"{function};", ""]
    instances = [re.sub(rf"\b{k.variable}\b", CPP[t], ", ".join(types)) for t in VARIABLES[k.variable]]
    return [
        *out,
        f"template <class {k.variable}>",
        f"{function};",
        f"#define CHIASM_INSTANTIATE_{k.name} \\",
        *(f"  template void {k.name}({instance}); \\" for instance in instances),
        "",
    ]


def constant(name: str) -> str:
    """A constant's name in C++."""
    return "k" + name.title().replace("_", "")


class Expression:
    """A Python expression of a declaration as C++."""

    def __init__(self, kernel: Kernel) -> None:
        self.kernel = kernel
        self.types = {a.name: a.type for a in kernel.arguments}
        self.entries = [a.name for a in kernel.tensors if a.type == "int64"]

    def cpp(self, text: str) -> str:
        return self._node(ast.parse(text, mode="eval").body, text)

    def _node(self, node: ast.expr, text: str) -> str:
        if isinstance(node, ast.Name) and self.types.get(node.id) not in ENUMERATORS:
            return (
                f"{node.id}_entries[i]"
                if node.id in self.entries
                else constant(node.id)
                if node.id in CONSTANTS
                else node.id
            )
        if isinstance(node, ast.Constant) and type(node.value) is int and node.value < 2**63:
            return f"int64_t{{{node.value}}}"
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            return f"(-{self._node(node.operand, text)})"
        match node:
            case ast.BinOp(ast.Constant(int(base)), ast.Pow(), ast.Constant(int(exponent))) if exponent < 64:
                return self._node(ast.Constant(base**exponent), text)
        if isinstance(node, ast.BinOp) and type(node.op) in OPERATORS and not self._divides_floats(node):
            return (
                f"({self._node(node.left, text)} {OPERATORS[type(node.op)]} {self._node(node.right, text)})"
            )
        if isinstance(node, ast.IfExp):
            return (
                f"({self._node(node.test, text)} ? {self._node(node.body, text)} :"
                f" {self._node(node.orelse, text)})"
            )
        if isinstance(node, ast.Compare):
            return f"({self._comparison(node, text)})"
        raise DeclarationError(
            f"kernel {self.kernel.name}: {text!r}: no C++ form of {ast.unparse(node)!r} is known"
        )

    def _divides_floats(self, node: ast.BinOp) -> bool:
        """Whether it has a remainder or a whole quotient of floats."""
        names = (n.id for n in ast.walk(node) if isinstance(n, ast.Name))
        floats = any(self.types.get(name) == "float" for name in names)
        return floats and isinstance(node.op, (ast.Mod, ast.FloorDiv))

    def _comparison(self, node: ast.Compare, text: str) -> str:
        terms, parts = [node.left, *node.comparators], []
        for left, operator, right in zip(terms, node.ops, node.comparators):
            match left, operator, right:
                case _, ast.In(), ast.Tuple([_, *_] as values):
                    equal = (f"{self._node(left, text)} == {self._node(value, text)}" for value in values)
                    parts.append(f"({' || '.join(equal)})")
                case ast.Name(name), ast.Eq() | ast.NotEq(), ast.Constant(str(value)):
                    enumerators = ENUMERATORS.get(self.types.get(name, ""), {})
                    if value not in enumerators:
                        raise DeclarationError(
                            f"kernel {self.kernel.name}: {text!r}: {name} has no enumerator {value}"
                        )
                    parts.append(f"{name} {OPERATORS[type(operator)]} int64_t{{{enumerators[value]}}}")
                case _ if type(operator) in OPERATORS:
                    sides = self._node(left, text), self._node(right, text)
                    parts.append(f" {OPERATORS[type(operator)]} ".join(sides))
                case _:
                    raise DeclarationError(
                        f"kernel {self.kernel.name}: {text!r}: no C++ form of this comparison is known"
                    )
        return " && ".join(parts)


def prototypes() -> str:
    """kernel_calls.h: the C functions that AOTInductor's code calls."""
    out = [
        MADE,
        "#pragma once",
        "",
        "#include <torch/csrc/inductor/aoti_torch/c/shim.h>",
        "",
        'extern "C" {',
        "",
    ]
    return "\n".join([*out, *(f"{prototype(k)};" for k in KERNELS.values()), "", "}", ""])


def prototype(k: Kernel) -> str:
    passed = {"int": "int64_t", "float": "double", "bool": "int32_t"}
    arguments = [
        f"AtenTensorHandle {a.name}_" if a.shape is not None else f"{passed.get(a.type, 'int64_t')} {a.name}"
        for a in k.arguments
    ]
    return f"AOTITorchError aoti_torch_cpu_{k.name}({', '.join(arguments)}, AtenTensorHandle* result)"


def calls() -> str:
    """kernel_calls.cpp."""
    out = [
        MADE,
        "// Everything that the loops assume is checked here: they check nothing.",
        '#include "kernel_calls.h"',
        "",
        '#include "artifact/aoti/calls.h"',
        "",
        "using namespace chiasm::artifact;",
        "using namespace chiasm::kernels;",
        "",
        'extern "C" {',
        "",
    ]
    for k in KERNELS.values():
        out += [*call(k), ""]
    return "\n".join([*out, '}  // extern "C"', ""])


def call(k: Kernel) -> List[str]:
    """One kernel's C function."""
    out = [f"{prototype(k)} {{", "  return guarded([&] {"]
    bound: set[str] = set()
    typed = ""
    for a in k.tensors:
        dtype = CODES.get(a.type) or typed or f"k{a.type}"
        typed = typed or (f"{a.name}.dtype()" if a.type in VARIABLES else "")
        out += [f"    {line}" for line in bind(k, a, dtype, bound)]
    for a in k.arguments:
        if a.type in ENUMERATORS:
            out.append(f'    within("{k.name}: {a.name}", {a.name}, 0, {len(ENUMERATORS[a.type]) - 1});')
    compared = {name for text in k.conditions for name in identifiers(text, k.name)}
    out += [
        f"    const int64_t* const {name}_entries = {name}.data<int64_t>();"
        for name in Expression(k).entries
        if name in compared
    ]
    out += [f"    {condition(k, text)}" for text in k.conditions]
    first = next((a.name for a in k.tensors if "..." in (a.shape or ())), None)
    sizes = [Expression(k).cpp(s) for s in k.result.shape or () if s != "..."]
    element = f"{typed}" if k.result.type in VARIABLES else CODES[k.result.type]
    shape = (
        f"{{{', '.join(sizes)}}}"
        if "..." not in (k.result.shape or ())
        else f"{first}.with_leading({{{', '.join(sizes)}}})"
    )
    out.append(f"    Result out = make({shape}, {element});")
    # Without a value there is nothing to do, but a loop might still count through what has no size.
    out.append("    if (!is_empty(out)) {")
    passed = [value if "{" not in value else f"{kind}{value}" for kind, _, value in parameters(k)]
    function = f"chiasm::kernels::{k.name}({', '.join(passed)});"
    if k.variable:
        out += [
            f"      for_type<{', '.join(CPP[t] for t in VARIABLES[k.variable])}>({typed}, [&]<class"
            f" {k.variable}>({k.variable}) {{ {function} }});"
        ]
    else:
        out.append(f"      {function}")
    return [*out, "    }", "    *result = out.release();", "  });", "}"]


def bind(k: Kernel, a: Argument, dtype: str, bound: set[str]) -> Iterator[str]:
    """Checks a tensor's type and shape and binds its sizes to their names."""
    named = [s for s in a.shape or () if s != "..."]
    expected = ", ".join(s if s.isdigit() or s in bound else "kAny" for s in named)
    folded = "..." in (a.shape or ())
    yield (
        f'const Argument {a.name}("{k.name}: {a.name}", {a.name}_, {dtype}, {{{expected}}},'
        f" {str(folded).lower()});"
    )
    if folded:
        yield f"const int64_t count = {a.name}.leading();"
    for i, size in enumerate(named):
        place = f"{a.name}.trailing({len(named) - i})"
        if size.isidentifier() and size not in bound:
            bound.add(size)
            yield f"[[maybe_unused]] const int64_t {size} = {place};"
        elif size in named[:i]:
            yield (
                f'if ({place} != {size}) refuse("{k.name}: {a.name}", "shape ({", ".join(a.shape or ())})",'
                f" {a.name}.shape_text());"
            )


def condition(k: Kernel, text: str) -> str:
    """Rejects a call for which a condition does not hold. The error names the condition's first argument."""
    cpp, names = (
        Expression(k).cpp(text),
        list(dict.fromkeys(n for n in identifiers(text, k.name) if n not in ("INT32_MAX", *CONSTANTS))),
    )
    entries = [name for name in names if name in Expression(k).entries]
    values = ", ".join(f'{{"{name}", {f"{name}_entries[i]" if name in entries else name}}}' for name in names)
    check = f'if (!{cpp}) refuse("{k.name}: {subject(k, text)}", "{text}", values_text({{{values}}}));'
    return f"for (int64_t i = 0; i < {entries[0]}.numel(); ++i) {check}" if entries else check


def subject(k: Kernel, text: str) -> str:
    """The argument that a condition is about."""
    names = (n for n in identifiers(text, k.name) if n not in ("INT32_MAX", *CONSTANTS))
    return next(k.sizes.get(name, name) for name in names)
