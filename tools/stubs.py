"""Write `python/chiasm/FAMILY/__init__.pyi`: the declarations, for editors and type checkers, of the module
classes, which are generated at run time.

usage: tools/stubs.py        `make stubs`; tests/ops/test_stubs.py compares.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import subprocess
import sys
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any

from chiasm.primitives.core.modules import class_name, is_tensor, settings_of

PACKAGE = Path(__file__).resolve().parents[1] / "python" / "chiasm"
HEAD = "# Written by `make stubs` from the signatures of the functions; do not edit.\n"


def families() -> list[Path]:
    """The packages whose functions have module classes."""
    return sorted(file for file in PACKAGE.rglob("__init__.py") if "= lazy_modules(" in file.read_text())


def stub(family: Path) -> str:
    """The text of a family's stub, formatted."""
    tree = ast.parse(family.read_text())
    name = ".".join(["chiasm", *family.parent.relative_to(PACKAGE).parts])
    package = importlib.import_module(name)
    lines = [
        HEAD,
        "import typing",
        "from typing import List, Optional, Tuple, Union",
        "",
        "import torch",
        "from torch import Tensor, nn",
        "",
    ]
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and node.level == 1:
            names = ", ".join(f"{a.name} as {a.asname or a.name}" for a in node.names)
            lines.append(f"from {'.' * node.level}{node.module or ''} import {names}")
    public = [n for n in package.__all__ if inspect.isfunction(getattr(package, n))]
    classes = [class_name(function) for function in public if class_name(function) not in package.__all__]
    for function in public:
        if class_name(function) in classes:
            made = getattr(package, class_name(function))
            lines += _class(made, getattr(package, function))
            lines += [f"{other} = {made.__name__}" for other in made.form.also]
            classes += made.form.also
    lines += ["", f"__all__ = {[*package.__all__, *sorted(classes)]!r}", ""]
    file = str(family.with_suffix(".pyi"))
    rules = ("--select", "I,F401,RUF022", "--fix")
    text = _ruff("\n".join(lines), "check", *rules, "--stdin-filename", file, "-")
    return _ruff(text, "format", "--stdin-filename", file, "-")


def _ruff(text: str, *arguments: str) -> str:
    command = [sys.executable, "-m", "ruff", *arguments, "--quiet"]
    return subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout


def _class(made: Any, function: Callable[..., Any]) -> list[str]:
    """A class with its constructor, its attributes and its `forward`."""
    signature = inspect.signature(function)
    form = made.form
    settings = settings_of(function, form)
    named = [p.replace(name=form.names.get(p.name, p.name)) for p in settings]
    tensors = [p for p in signature.parameters.values() if p.name not in {s.name for s in settings}]
    assert all(is_tensor(p.annotation) for p in tensors), function
    returned = _annotation(signature.return_annotation)
    first = (inspect.getdoc(function) or "").split("\n\n")[0]
    arguments = ", ".join(["self", *map(_parameter, tensors)])
    return [
        "",
        f"class {made.__name__}(nn.Module):",
        *_docstring(f"`{function.__name__}` as a module: {' '.join(first.split())}"),
        *(f"    {p.name}: {_annotation(p.annotation)}" for p in settings),
        f"    def __init__({', '.join(['self', *map(_parameter, named)])}) -> None: ...",
        f"    def forward({arguments}) -> {returned}: ...",
        f"    def __call__({arguments}) -> {returned}: ...",
    ]


def _docstring(text: str) -> list[str]:
    """The docstring as the body of a class."""
    return textwrap.fill(f'"""{text}"""', 105, initial_indent="    ", subsequent_indent="    ").splitlines()


def _parameter(p: inspect.Parameter) -> str:
    default = (
        ""
        if p.default is p.empty
        else f" = {p.default!r}"
        if isinstance(p.default, (int, float, str, bool, type(None)))
        else " = ..."
    )
    return f"{p.name}: {_annotation(p.annotation)}{default}"


def _annotation(annotation: object) -> str:
    text = re.sub(r"\btorch\.Tensor\b", "Tensor", inspect.formatannotation(annotation))
    return text.replace("typing.", "").replace("NoneType", "None")


if __name__ == "__main__":
    for file in families():
        file.with_suffix(".pyi").write_text(stub(file))
