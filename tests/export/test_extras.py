"""The extras of pyproject.toml match the imports in the sources, and the requirements of the packages name
one version."""

import ast
import re
import sys
from pathlib import Path

import tomllib

from chiasm import __version__
from chiasm.extras import EXTRAS, advice

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
#: Distributions whose name differs from the imported module.
NAMES = {"PIL": "pillow"}


def requirements(extra: str) -> set[str]:
    """The distributions of an extra, including those of the extras and of our distributions that it names."""
    found = set()
    for text in PROJECT["optional-dependencies"][extra]:
        name, inner = re.fullmatch(r"([A-Za-z0-9-]+)(?:\[([a-z,]+)\])?.*", text).groups()
        if name == "chiasm":
            found = found.union(*(requirements(e) for e in inner.split(",")))
        elif name.startswith("chiasm-"):
            found |= {re.match("[A-Za-z0-9-]+", needed)[0] for needed in needs(name.removeprefix("chiasm-"))}
        else:
            found.add(name)
    return found


def needs(part: str) -> list[str]:
    """The dependencies of a distribution in packaging/."""
    text = (ROOT / "packaging" / part / "pyproject.toml").read_text()
    return tomllib.loads(text)["project"]["dependencies"]


def test_an_extra_brings_what_it_is_said_to() -> None:
    for extra, modules in EXTRAS.items():
        assert {NAMES.get(module, module) for module in modules} <= requirements(extra), extra
    assert set(PROJECT["optional-dependencies"]) == {*EXTRAS, "torch"}
    assert PROJECT["dependencies"] == ["numpy"]


def test_every_import_is_in_an_extra() -> None:
    known = {module for modules in EXTRAS.values() for module in modules} | {"numpy", "chiasm"}
    # Packages that torch and onnx install, that a server has, and engines that users install
    known |= {"sympy", "triton", "onnx_ir", "google", "typing_extensions"}
    known |= {"triton_python_backend_utils", "pyspark", "daft"}
    for file in (ROOT / "python" / "chiasm").rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
                names = [node.module]
            tops = {name.partition(".")[0] for name in names} - set(sys.stdlib_module_names)
            assert tops <= known, f"{file}: {tops - known}: of which extra?"


def test_versions_go_together() -> None:
    major, minor, _ = __version__.split(".")
    bound = f">={major}.{minor},<{major}.{int(minor) + 1}"
    for part in ("export", "ops", "torch"):
        assert f"chiasm-{part}{bound}" in PROJECT["optional-dependencies"][part]
        assert needs(part)[0] == f"chiasm{bound}"
    [torch] = [r for r in needs("ops") if r.startswith("torch")]
    assert torch in needs("torch")


def test_advice() -> None:
    assert advice(ModuleNotFoundError("", name="PIL.Image")) == (
        'this needs PIL, which is not installed: pip install "chiasm[cli]"'
    )
    assert advice(ModuleNotFoundError("", name="chiasm.no_such_module")) is None
    assert advice(ImportError("some library")) is None
