"""The examples in the docstrings run and give the documented results."""

import doctest
import importlib
import pkgutil

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
    packages = [
        "augmentation",
        "color",
        "contrib",
        "enhance",
        "filters",
        "morphology",
        "feature",
        "losses",
        "metrics",
        "ops",
        "pipelines",
    ]
    packages += [
        f"geometry.{name}"
        for name in (
            "bbox",
            "conversions",
            "grid",
            "lie",
            "line",
            "plane",
            "quaternion",
            "ransac",
            "registration",
            "solvers",
            "subpix",
            "transform",
        )
    ]
    for package in packages:
        module = importlib.import_module(f"chiasm.{package}")
        for name in module.__all__:
            about = getattr(module, name).__doc__ or ""
            # A module class has its function's example.
            assert ">>>" in about or "` as a module" in about.partition("\n")[0], f"{package}.{name}"


def test_import_is_lazy() -> None:
    import subprocess
    import sys

    code = (
        "import sys, chiasm; assert 'torch' not in sys.modules; chiasm.color; assert 'torch' in sys.modules"
    )
    path = str(importlib.import_module("pathlib").Path(chiasm.__file__).parents[1])
    subprocess.run([sys.executable, "-c", code], check=True, env={"PYTHONPATH": path, "PATH": ""})
