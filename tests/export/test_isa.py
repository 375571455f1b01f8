"""Native code for several instruction sets in one bundle: its content, and the choice at run time."""

import os
import re
import subprocess
import zipfile
from pathlib import Path

import pytest

import chiasm.runtime as runtime
from chiasm.export import export
from chiasm.export.catalog import catalog

BUILD = Path(__file__).resolve().parents[2] / "build" / "release"
ISAS = ("x86-64-v2", "x86-64-v3")


@pytest.fixture(scope="module", params=["filters.gaussian_blur2d.frames", "enhance.adjust_log"])
def bundle(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bundle with a kernel of bytes, and with Inductor's loops that call a function of libm."""
    entry = catalog()[request.param]
    folder = tmp_path_factory.mktemp("bundles")
    return export(entry.function(), entry.spec, folder, ["native"], ISAS, methods=["forward"])


def instructions(bundle: Path, isa: str) -> str:
    [artifact] = bundle.glob(f"forward*.{isa}.pt2")
    library = zipfile.ZipFile(artifact).extract("chiasm/op.so", bundle.parent / isa)
    return subprocess.run(
        ["objdump", "-d", "--no-show-raw-insn", library], capture_output=True, text=True, check=True
    ).stdout


def test_code_for_v2_has_no_instruction_of_avx(bundle: Path) -> None:
    of_avx = re.compile(r"^ +[0-9a-f]+:\t(v(?!err|erw)\w+ .*|.*%[yz]mm.*)$", re.MULTILINE)
    assert of_avx.search(instructions(bundle, "x86-64-v3"))
    code = instructions(bundle, "x86-64-v2")
    assert "%xmm" in code
    assert [found[0] for found in of_avx.finditer(code)][:5] == []


def test_the_best_that_the_cpu_has_is_taken(bundle: Path) -> None:
    opened = runtime.open(bundle)
    assert "x86-64-v3" in opened.method("forward").artifact
    rows = opened.self_test(backend="native")
    assert {row.artifact for row in rows if row.passed} == {file.name for file in bundle.glob("*.pt2")}


def test_a_cpu_without_avx2_runs_the_other(bundle: Path) -> None:
    environment = os.environ | {"CHIASM_BACKEND_PATH": str(BUILD / "lib"), "OMP_NUM_THREADS": "1"}
    done = subprocess.run(
        ["qemu-x86_64", "-cpu", "Nehalem", str(BUILD / "bin" / "replay"), str(bundle)],
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0 and "replay: 1 bundles, 0 failed" in done.stdout, done.stdout + done.stderr
