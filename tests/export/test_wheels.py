"""Which sources are in the wheel of chiasm and which in that of chiasm-ops. tests/consumer/pip_install.sh
builds and installs them."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import tomllib

from chiasm.extras import OPS, advice

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ROOT / "python"
BUILT = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["scikit-build"]
#: What the wheel of chiasm leaves out.
LEFT_OUT = [path for path in BUILT["wheel"]["exclude"] if path.startswith("chiasm/")]
#: Modules of the wheel of chiasm that run in an engine: Ray, PyTorch, a server.
ENGINES = {"chiasm.data.on_ray", "chiasm.data.tensors", "chiasm.onnx.network", "chiasm.triton.network"}


def is_left_out(file: Path) -> bool:
    return any((SOURCES / path) in (file, *file.parents) for path in LEFT_OUT)


@pytest.fixture(scope="module")
def runtime(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with links to what the wheel of chiasm has, without PyTorch's part."""
    folder = tmp_path_factory.mktemp("runtime")
    for file in (SOURCES / "chiasm").rglob("*"):
        if file.suffix in (".py", ".so", ".json") and not is_left_out(file):
            link = folder / file.relative_to(SOURCES)
            link.parent.mkdir(parents=True, exist_ok=True)
            link.symlink_to(file)
    return folder


def python(folder: Path, code: str) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)


def test_the_parts_are_there() -> None:
    assert [path for path in LEFT_OUT if not (SOURCES / path).exists()] == []
    assert {path.split("/")[1] for path in LEFT_OUT} == {*OPS, "export"}


def test_the_runtime_imports_nothing_of_the_ops(runtime: Path) -> None:
    names = {
        ".".join(file.relative_to(runtime).with_suffix("").parts).removesuffix(".__init__")
        for file in (runtime / "chiasm").rglob("*.py")
        if file.name != "__main__.py"
    }
    assert {"chiasm.runtime", "chiasm.export.cli", "chiasm.onnx.merging", "chiasm.triton.parts"} <= names
    imports = "".join(f"import {name}\n" for name in sorted(names - ENGINES))
    done = python(runtime, f"import sys\nsys.modules['torch'] = None\n{imports}print(chiasm.__path__)")
    assert done.stdout == f"[{str(runtime / 'chiasm')!r}]\n", done.stderr


@pytest.mark.parametrize(
    ("code", "module", "extra"),
    [
        ("import chiasm.filters", "chiasm.filters", "ops"),
        ("from chiasm import filters", "chiasm.filters", "ops"),
        ("import chiasm; chiasm.primitives", "chiasm.primitives", "ops"),
        ("from chiasm.geometry.transform import resize", "chiasm.geometry", "ops"),
        ("from chiasm.export import Spec", "chiasm.export.spec", "export"),
        ("import chiasm.export; chiasm.export.export", "chiasm.export.pipeline", "export"),
    ],
)
def test_without_the_ops_an_error_says_what_to_install(
    runtime: Path, code: str, module: str, extra: str
) -> None:
    assert python(runtime, code).stderr.splitlines()[-1] == (
        f"ModuleNotFoundError: {module} belongs to the distribution chiasm-ops, which is not installed: pip"
        f' install "chiasm[{extra}]" (bundles run without it: chiasm.runtime)'
    )


def test_other_modules_are_simply_missing(runtime: Path) -> None:
    last = python(runtime, "import chiasm.no_such_module").stderr.splitlines()[-1]
    assert last == "ModuleNotFoundError: No module named 'chiasm.no_such_module'"


def test_the_command_without_the_ops(runtime: Path) -> None:
    done = python(
        runtime,
        "import sys; sys.argv[1:] = ['export', 'filters.sobel']; from chiasm.__main__ import main; main()",
    )
    assert done.returncode == 1 and done.stderr.count("\n") == 1
    assert done.stderr.startswith("Error: chiasm.export.catalog belongs to the distribution chiasm-ops")


def test_with_the_ops_their_modules_are_as_any_other() -> None:
    assert advice(ModuleNotFoundError("", name="chiasm.filters")) is None
