"""The examples in the docstrings run and give the documented results."""

import doctest
import importlib
import pkgutil
from types import ModuleType

import pytest
import torch

import chiasm

MODULES = [
    m.name
    for m in pkgutil.walk_packages(chiasm.__path__, "chiasm.", onerror=lambda name: None)
    if m.name.split(".")[1] not in ("data", "export", "onnx", "runtime", "triton")
]


@pytest.mark.parametrize("name", MODULES)
def test_examples(name: str) -> None:
    result = doctest.testmod(importlib.import_module(name), extraglobs={"torch": torch})
    assert result.failed == 0


def test_public_functions_have_examples() -> None:
    for package in map(importlib.import_module, MODULES):
        for name in getattr(package, "__all__", ()):
            if isinstance(public := getattr(package, name), ModuleType):
                continue
            about = public.__doc__ or ""
            # A module class has its function's example.
            assert ">>>" in about or "` as a module" in about.partition("\n")[0], f"{package.__name__}.{name}"


def test_import_is_lazy() -> None:
    import subprocess
    import sys

    code = (
        "import sys, chiasm; assert 'torch' not in sys.modules; chiasm.color; assert 'torch' in sys.modules"
    )
    path = str(importlib.import_module("pathlib").Path(chiasm.__file__).parents[1])
    subprocess.run([sys.executable, "-c", code], check=True, env={"PYTHONPATH": path, "PATH": ""})
