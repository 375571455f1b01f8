"""Makes the tests of the kernels' calls, which tests/kernels includes: guarded_calls.inc has calls that the
declarations allow, refused_calls.inc calls that they forbid, named_calls.inc the functions by their names."""

import math
from typing import Any, Dict

from example_calls import ENTRIES, FOLDED, Search, allowed
from kernel_adapters import CPP, ENUMERATORS, MADE, subject
from kernels.declarations import KERNELS
from kernels.schema import VARIABLES, Argument, Kernel

#: How many calls of a kernel are looked for (some are found twice).
CALLS = 40


def allowed_calls() -> str:
    """guarded_calls.inc: a test of each kernel that makes calls which its declaration allows."""
    inexact = ", ".join(function(k) for k in KERNELS.values() if not k.exact)
    out = [MADE, "", "bool Guarded::is_inexact(void (*call)()) {"]
    out += [
        f"  static void (*const kInexact[])() = {{{inexact}}};",
        "  return std::find(std::begin(kInexact), std::end(kInexact), call) != std::end(kInexact);",
        "}",
        "",
    ]
    for k in KERNELS.values():
        search = Search(k)
        out += [
            f"TEST_F(GuardedCalls, {k.name}) {{",
            f"  [[maybe_unused]] static constexpr struct {{{fields(search, ENTRIES)}}} kCalls[] = {{",
        ]
        out += [f"      {row(search, call)}," for call in allowed(k, CALLS)]
        out += ["  };", "  watch([&] {"]
        passed = ", ".join(
            f"c.{a.name}" if a.shape is None else any_tensor(search, i, a) for i, a in enumerate(k.arguments)
        )
        loop = f"for (const auto& c : kCalls) run(aoti_torch_cpu_{k.name}, {passed});"
        concrete = any(is_special(search, a) for a in k.tensors if a.type not in VARIABLES)
        if k.variable:
            kinds = ", ".join(CPP[t] for t in VARIABLES[k.variable])
            out.append(f"    each<{kinds}>({str(concrete).lower()}, [&]<class {k.variable}>({k.variable}) {{")
            out += [f"      {loop}", "    });"]
        else:
            out.append(f"    {loop}")
        out += ["  }" + (");" if k.variable or concrete else ", kWhole);"), "}", ""]
    return "\n".join(out)


def forbidden_calls() -> str:
    """refused_calls.inc: a test of each kernel that makes calls which its declaration forbids: a few for
    each tensor, enumeration and condition."""
    out = [MADE, ""]
    for k in KERNELS.values():
        search = Search(k)
        valid = allowed(k, CALLS)[0]
        valid = {**valid, **{name: valid[name][0] for name in search.entries}}
        rows = [("nullptr", "", valid)]
        for name, kind in search.types.items():
            last = len(ENUMERATORS.get(kind, ())) - 1
            rows += [
                (f'"{k.name}: {name}"', f"0 to {last}", {**valid, name: wrong})
                for wrong in (-1, last + 1)
                if last > 0
            ]
        rows += [(f'"{k.name}: {subject(k, text)}"', text, call) for text, call in search.forbidden()]
        named = fields(search, 0)
        out += [
            f"TEST(RefusedCalls, {k.name}) {{",
            f"  static constexpr struct {{const char *argument, *expected; {named}}} kCalls[] = {{",
            *(f'      {{{argument}, "{text}", {row(search, call)[1:]},' for argument, text, call in rows),
            "  };",
            "  for (const auto& c : kCalls) {",
        ]
        bound: set[str] = set()
        altered = []
        for a in k.tensors:
            kind = CPP[VARIABLES.get(a.type, (a.type,))[0]]
            made = (
                f"of<int64_t>({dims(a)}, {{c.{a.name}}})"
                if a.name in search.entries
                else f"blank<{kind}>({dims(a)})"
            )
            out.append(f"    Tensor {a.name} = {made};")
            sizes = [s for s in a.shape or () if s != "..."]
            fixed = [
                str(len(sizes) - i)
                for i, s in enumerate(sizes)
                if s.isdigit() or s in bound or s in sizes[:i]
            ]
            bound |= set(sizes)
            places = f"{str(not sizes).lower()}, {{{', '.join(fixed)}}}"
            altered.append(f'      refuses_altered("{k.name}: {a.name}", {a.name}, {places}, call);')
        passed = ", ".join(f"c.{a.name}" if a.shape is None else f"{a.name}.get()" for a in k.arguments)
        out += [
            f"    const auto call = [&](Handle* out) {{ return aoti_torch_cpu_{k.name}({passed}, out); }};",
            "    if (c.argument != nullptr) {",
            "      expect_refused(c.argument, call, c.expected);",
            "    } else {",
            *altered,
            "    }",
            "  }",
            "}",
            "",
        ]
    return "\n".join(out)


def named_calls() -> str:
    """named_calls.inc: each kernel's name and the function that compiled ops call."""
    return "\n".join([MADE, *(f'{{"{k.name}", {function(k)}}},' for k in KERNELS.values()), ""])


def function(kernel: Kernel) -> str:
    """The function that compiled ops call, without its type, in C++."""
    return f"reinterpret_cast<void (*)()>(aoti_torch_cpu_{kernel.name})"


def fields(search: Search, entries: int) -> str:
    """The members of a struct with a call's values; of int64 tensors that many entries."""
    out = [
        f"{ {'float': 'double', 'bool': 'int32_t'}.get(kind, 'int64_t') } {name};"
        for name, kind in search.types.items()
    ]
    out += [f"int64_t {name};" for name in search.sizes]
    return " ".join(
        [*out, *(f"int64_t {name}{f'[{entries}]' if entries else ''};" for name in search.entries)]
    )


def row(search: Search, call: Dict[str, Any]) -> str:
    """A call's values, in the order of ``fields``."""
    out = [
        number(ENUMERATORS[kind].get(call[name], call[name]) if kind in ENUMERATORS else call[name], kind)
        for name, kind in search.types.items()
    ]
    out += [number(call[name], "int") for name in search.sizes]
    for name in search.entries:
        values = call[name]
        one = number(values, "int") if isinstance(values, int) else ", ".join(map(str, values))
        out.append(one if isinstance(values, int) else f"{{{one}}}")
    return f"{{{', '.join(out)}}}"


def number(value: Any, kind: str) -> str:
    """A number as C++."""
    if kind != "float":
        return str(int(value)) if value > -(2**63) else "INT64_MIN"
    if math.isfinite(value):
        return repr(float(value))
    return "NAN" if math.isnan(value) else "INFINITY" if value > 0 else "-INFINITY"


def dims(argument: Argument) -> str:
    """A tensor's sizes, from a struct of ``fields``; for '...' two leading ones."""
    sizes = [f"c.{s}" if s.isidentifier() else s for s in argument.shape or ()]
    return f"{{{', '.join(sizes)}}}".replace("...", f"c.{FOLDED}, 1")


def any_tensor(search: Search, i: int, argument: Argument) -> str:
    """A tensor with any values that the declaration allows, in C++."""
    if argument.name in search.entries:
        return f"entries({dims(argument)}, c.{argument.name})"
    kind = CPP.get(argument.type, argument.type)
    if argument.name in search.limits:
        low, high = search.limits[argument.name]
        return f"whole_numbers<{kind}>({i}, {dims(argument)}, {low}, {high})"
    return f"any<{kind}>({i}, {dims(argument)})"


def is_special(search: Search, argument: Argument) -> bool:
    """Whether a tensor of a fixed type has other values in each kind of test."""
    free = argument.name not in search.entries and argument.name not in search.limits
    return free and argument.type in ("float32", "float64", "int32", "int64")
