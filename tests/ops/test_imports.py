"""Each package of ops can be imported first: there are no circular imports."""

from __future__ import annotations

import pkgutil
import subprocess
import sys

import pytest

import chiasm

PACKAGES = sorted(
    m.name
    for m in pkgutil.walk_packages(chiasm.__path__, "chiasm.")
    if m.ispkg and m.name.split(".")[1] not in ("data", "export", "onnx", "runtime", "triton")
)
#: One process that imports torch, and forks for each package.
FORKS = """
import importlib, os, sys, torch
for name in sys.argv[1:]:
    child = os.fork()
    if child == 0:
        importlib.import_module(name)
        os._exit(0)
    print(name, os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""


@pytest.fixture(scope="module")
def codes() -> dict[str, str]:
    done = subprocess.run(
        [sys.executable, "-c", FORKS, *PACKAGES], capture_output=True, text=True, check=True
    )
    return dict(line.split() for line in done.stdout.splitlines())


@pytest.mark.parametrize("name", PACKAGES)
def test_a_package_is_imported_first(codes: dict[str, str], name: str) -> None:
    assert codes[name] == "0"
