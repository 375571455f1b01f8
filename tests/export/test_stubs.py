"""The stubs that editors and type checkers read match the package at run time."""

from __future__ import annotations

import ast
import importlib
import json
import subprocess
import sys
from pathlib import Path

import pytest

import chiasm
from chiasm import _runtime

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tools"))

from stubs import PACKAGE, families, stub  # noqa: E402


@pytest.mark.parametrize("family", families(), ids=lambda file: file.parent.name)
def test_the_stubs_are_of_todays_signatures(family: Path) -> None:
    assert family.with_suffix(".pyi").read_text() == stub(family), "make stubs"


def test_type_checkers_know_each_generated_class() -> None:
    for family in families():
        package = importlib.import_module(".".join(["chiasm", *family.parent.relative_to(PACKAGE).parts]))
        declared: set[str] = set()
        for node in ast.parse(family.with_suffix(".pyi").read_text()).body:
            if isinstance(node, ast.ImportFrom):
                declared |= {a.asname or a.name for a in node.names}
            elif isinstance(node, ast.ClassDef):
                declared.add(node.name)
            elif isinstance(node, ast.Assign):
                declared.add(ast.unparse(node.targets[0]))
        assert set(dir(package)) <= declared, package


def test_type_checkers_know_each_submodule() -> None:
    tree = ast.parse((PACKAGE / "__init__.py").read_text())
    froms = [n for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)]
    [imported] = [n for n in froms if n.level == 1 and n.module is None]
    assert ["__version__", *(a.name for a in imported.names)] == dir(chiasm)


def test_type_checkers_read_augmentations(tmp_path: Path) -> None:
    code = """
from torch import Tensor
import chiasm
from chiasm.augmentation import ColorJitter, RandomGaussianBlur

def change(x: Tensor) -> Tensor:
    jitter = ColorJitter(0.2, (0.8, 1.2), hue=0.1, p=0.5)
    low, high = jitter.brightness
    print(low + high, chiasm.filters.GaussianBlur2d((3, 3), (1.0, 1.0))(x).shape)
    return RandomGaussianBlur(3, (0.1, 2.0))(jitter(x))

ColorJitter(brightnes=0.2)
RandomGaussianBlur(3)
ColorJitter("a")
"""
    (tmp_path / "given.py").write_text(code)
    settings = {
        "extraPaths": [str(PACKAGE.parent)],
        "typeCheckingMode": "strict",
        "venv": ".venv",
        "venvPath": str(ROOT),
    }
    (tmp_path / "pyrightconfig.json").write_text(json.dumps(settings))
    command = [sys.executable, "-m", "basedpyright", "--level", "error", "--outputjson"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    found = json.loads(done.stdout)["generalDiagnostics"]
    assert [(f["range"]["start"]["line"], f["rule"]) for f in found] == [
        (11, "reportCallIssue"),
        (12, "reportCallIssue"),
        (13, "reportArgumentType"),
    ]


def test_the_runtimes_stub_names_what_is_bound() -> None:
    tree = ast.parse((Path(chiasm.__file__).parent / "_runtime.pyi").read_text())
    classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
    functions = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    bound = {name for name in dir(_runtime) if not name.startswith("_")}
    assert bound == functions | set(classes)
    codes = {
        ast.unparse(m.targets[0]): m.value for m in classes.pop("Code").body if isinstance(m, ast.Assign)
    }
    assert {name: ast.literal_eval(value) for name, value in codes.items()} == dict(_runtime.Code.__members__)
    del classes["ChiasmError"]  # its only member is one of each exception
    for name, node in classes.items():
        members = {
            getattr(m, "name", None) or ast.unparse(m.target)
            for m in node.body
            if isinstance(m, (ast.FunctionDef, ast.AnnAssign))
        }
        there = {member for member in vars(getattr(_runtime, name)) if not member.startswith("_")}
        assert {member for member in members if not member.startswith("_")} == there, name
