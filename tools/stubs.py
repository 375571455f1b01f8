"""Write `python/chiasm/FAMILY/__init__.pyi`: the declarations, for editors and type checkers, of the classes
that are generated at run time: module classes and augmentations.

usage: tools/stubs.py        `make stubs`; tests/export/test_stubs.py compares.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Any, get_origin

from chiasm.primitives.core.modules import class_name, has_class, is_tensor, settings_of

PACKAGE = Path(__file__).resolve().parents[1] / "python" / "chiasm"
HEAD = "# Written by `make stubs` from the signatures of the functions; do not edit.\n"


def families() -> list[Path]:
    """The packages that have generated classes."""
    return sorted(
        file
        for file in PACKAGE.rglob("__init__.py")
        if re.search(r"= lazy_modules\(|^from .*\bCLASSES$", file.read_text(), re.M)
    )


def stub(family: Path) -> str:
    """The text of a family's stub, formatted."""
    package = importlib.import_module(".".join(["chiasm", *family.parent.relative_to(PACKAGE).parts]))
    lines = [
        HEAD,
        "import enum",
        "import typing",
        "from typing import List, Optional, Sequence, Tuple, Union",
        "",
        "import torch",
        "from torch import Tensor, nn",
        "",
    ]
    public: list[str] = package.__all__
    for node in ast.parse(family.read_text()).body:
        if isinstance(node, ast.ImportFrom) and node.level == 1:
            names = [f"{a.name} as {a.asname or a.name}" for a in node.names if a.name != "CLASSES"]
            lines += [f"from .{node.module or ''} import {', '.join(names)}"] if names else []
    for made in getattr(package, "CLASSES", {}).values():
        lines += _class(made, made.__base__.__name__, made.stored)
    functions = [n for n in public if has_class(getattr(package, n))]
    lazy = hasattr(package, "__getattr__")
    classes = [class_name(name) for name in functions if lazy and class_name(name) not in public]
    for function in functions:
        if class_name(function) in classes:
            made = getattr(package, class_name(function))
            lines += _module_class(made, getattr(package, function))
            lines += [f"{other} = {made.__name__}" for other in made.form.also]
            classes += made.form.also
    lines += ["", f"__all__ = {[*public, *sorted(classes)]!r}", ""]
    file = str(family.with_suffix(".pyi"))
    rules = ("--select", "I,F401,RUF022", "--fix")
    text = _ruff("\n".join(lines), "check", *rules, "--stdin-filename", file, "-")
    return _ruff(text, "format", "--stdin-filename", file, "-")


def _ruff(text: str, *arguments: str) -> str:
    command = [sys.executable, "-m", "ruff", *arguments, "--quiet"]
    return subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout


def _module_class(made: Any, function: Any) -> list[str]:
    """A module class with its constructor, its attributes and its `forward`."""
    signature = inspect.signature(function)
    settings = settings_of(function, made.form)
    tensors = [p for p in signature.parameters.values() if p.name not in {s.name for s in settings}]
    assert all(is_tensor(p.annotation) for p in tensors), function
    returned = _annotation(signature.return_annotation)
    arguments = ", ".join(["self", *map(_parameter, tensors)])
    return [
        *_class(made, "nn.Module", {p.name: p.annotation for p in settings}),
        f"    def forward({arguments}) -> {returned}: ...",
        f"    def __call__({arguments}) -> {returned}: ...",
    ]


def _class(made: Any, base: str, attributes: dict[str, Any]) -> list[str]:
    """A class with its first paragraphs of documentation, its attributes and its constructor."""
    head, first = [" ".join(text.split()) for text in made.__doc__.split("\n\n")[:2]]
    parameters = inspect.signature(made).parameters.values()
    return [
        "",
        f"class {made.__name__}({base}):",
        *_docstring(f"{head.removesuffix('.')}: {first}"),
        *(f"    {name}: {_annotation(annotation)}" for name, annotation in attributes.items()),
        f"    def __init__({', '.join(['self', *map(_parameter, parameters)])}) -> None: ...",
    ]


def _docstring(text: str) -> list[str]:
    """The docstring as the body of a class."""
    return textwrap.fill(f'"""{text}"""', 105, initial_indent="    ", subsequent_indent="    ").splitlines()


def _parameter(p: inspect.Parameter) -> str:
    plain = isinstance(p.default, (int, float, str, bool, tuple, type(None)))
    if isinstance(p.default, tuple) and get_origin(p.annotation) is list:
        plain = False  # as TorchScript has it, but not type checkers
    default = "" if p.default is p.empty else f" = {p.default!r}" if plain else " = ..."
    return f"{p.name}: {_annotation(p.annotation)}{default}"


def _annotation(annotation: object) -> str:
    text = re.sub(r"\btorch\.Tensor\b", "Tensor", inspect.formatannotation(annotation))
    return text.replace("typing.", "").replace("NoneType", "None")


if __name__ == "__main__":
    for file in families():
        file.with_suffix(".pyi").write_text(stub(file))
