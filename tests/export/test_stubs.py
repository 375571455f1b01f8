"""The stubs that editors and type checkers read match the package at run time."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import pytest

import chiasm
from chiasm import _runtime

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tools"))

from stubs import families, stub  # noqa: E402


@pytest.mark.parametrize("family", families(), ids=lambda file: file.parent.name)
def test_the_stubs_are_of_todays_signatures(family: Path) -> None:
    assert family.with_suffix(".pyi").read_text() == stub(family), "make stubs"


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
