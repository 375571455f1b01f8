"""The kernels' declarations: an error is one sentence, and docs/kernels.md matches the current
declarations."""

from __future__ import annotations

import re
import runpy
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import torch

from chiasm.primitives.kernels import operators
from chiasm.primitives.kernels.declarations import ENUMERATIONS, KERNELS
from chiasm.primitives.kernels.schema import DeclarationError, kernel

ROOT = Path(__file__).resolve().parents[2]
GENERATE = ROOT / "runtime" / "artifact" / "generate.py"


@pytest.mark.parametrize(
    ("schema", "where", "message"),
    [
        ("half(x) -> T[N]", [], "kernel half: expected 'type[shape] name' or 'type name', got 'x'"),
        (
            "half(T[N] x)",
            [],
            "kernel 'half(T[N] x)': expected name(type[shape] argument, type argument, ...) -> type[shape]",
        ),
        (
            "half(float16[N] x) -> float32[N]",
            [],
            "kernel half: argument x: unknown type float16, known are T, I, U, P, float32",
        ),
        (
            "half(T[N] x, Corner corner) -> T[N]",
            [],
            "kernel half: argument corner: unknown type Corner, known are int, float, bool, Border",
        ),
        ("half(T[N] x) -> I[N]", [], "kernel half: result: unknown type I"),
        ("half(T[N] x, I[N] y) -> T[N]", [], "kernel half: one of the type variables T, I, U, P at most"),
        ("half(T[N] x, int n) -> T[N]", [], "kernel half: two arguments or sizes named n"),
        (
            "half(T[N - 1] x) -> T[N]",
            [],
            "kernel half: argument x: a size is a name, a number, or '...' at the beginning, got 'N - 1'",
        ),
        ("half(T[N] x) -> T[...]", [], "kernel half: '...' stands in one argument's shape"),
        ("half(T[N] x) -> T[M]", [], "kernel half: 'M' names M, which is no size, number or int64 tensor"),
        ("half(T[N] x) -> T[N]", ["M > 2"], "kernel half: 'M > 2' names M"),
        ("half(T[N] x) -> T[N]", ["x > 2"], "kernel half: 'x > 2' names x"),
        ("half(T[N] x) -> T[N]", ["N >"], "kernel half: 'N >' is no expression"),
    ],
)
def test_a_wrong_declaration_is_one_sentence(schema: str, where: list[str], message: str) -> None:
    with pytest.raises(DeclarationError, match="^" + re.escape(message)):
        kernel(schema, "half.cpp", "", where, enumerations=ENUMERATIONS)


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """A copy of the declarations, their generator and the sources, for changes."""
    for folder in ("runtime/artifact", "python/chiasm/primitives/kernels"):
        shutil.copytree(
            ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__", "aoti")
        )
    return tmp_path


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            '"medians.cpp",\n    "The median',
            '"median.cpp",\n    "The median',
            "kernel median_filter: there is no source runtime/artifact/kernels/median.cpp",
        ),
        (
            '"medians.cpp",\n    "The median',
            '"integral.cpp",\n    "The median',
            "kernel median_filter: runtime/artifact/kernels/integral.cpp does not have"
            " 'CHIASM_INSTANTIATE(median_filter)'",
        ),
        (
            "median_filter(P[N, H, L] x",
            "median_filter(Image[N, H, L] x",
            "kernel median_filter: argument x: unknown type Image",
        ),
        (
            "border != 'circular'",
            "border != 'round'",
            "kernel resize_blurred: \"border != 'round'\": border has no enumerator round",
        ),
    ],
)
def test_a_wrong_declaration_stops_the_build(tree: Path, old: str, new: str, message: str) -> None:
    file = tree / "python/chiasm/primitives/kernels/declarations.py"
    assert old in file.read_text()
    file.write_text(file.read_text().replace(old, new))
    done = subprocess.run(
        [sys.executable, "-S", tree / "runtime/artifact/generate.py", "build", tree / "made"],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].removeprefix("error: ").startswith(message)
    assert not (tree / "made").exists()


def test_the_page_of_kernels_is_todays() -> None:
    page = runpy.run_path(str(GENERATE))["page"]()
    assert (ROOT / "docs" / "kernels.md").read_text() == page, "docs/kernels.md: run `make docs`"


def test_operators_have_the_declared_shapes() -> None:
    meta = {"device": "meta", "dtype": torch.float64}
    x = torch.empty(2, 3, 7, 9, **meta)
    assert operators.median_filter(x[0], 3, 5, "circular").shape == x[0].shape
    assert operators.canny_hysteresis(x, 0.1, 0.2).dtype == torch.bool
    assert operators.two_smallest(x[0], True).shape == (3, 7, 2)
    assert operators.two_smallest(x[0], False).shape == (3, 9, 2)
    assert operators.real_roots(x[0, 0]).shape == (2, 6, 9)
    assert operators.quantize_u8(x).dtype == torch.uint8
    with pytest.raises(ValueError, match=r"two_smallest: x: expected shape \(B, N, M\), got \[2, 3, 7, 9\]"):
        operators.two_smallest(x, True)
    with pytest.raises(
        ValueError,
        match="median_filter: border: expected one of reflect, replicate, circular, constant, got 'wrap'",
    ):
        operators.median_filter(x[0], 1, 3, "wrap")
    with pytest.raises(AttributeError, match="there is no kernel 'blur'"):
        operators.blur  # noqa: B018


def test_every_kernel_is_a_lowering() -> None:
    """A primitive or the exporter of networks calls each kernel."""
    sources = "".join(file.read_text() for file in (ROOT / "python/chiasm/primitives").rglob("*.py"))
    called = {name for name in KERNELS if f"kernels.{name}" in sources}
    networks = (ROOT / "python/chiasm/export/formats/networks.py").read_text()
    called |= set(re.findall(r"torch\.ops\.chiasm\.(\w+)", networks))
    assert called == set(KERNELS)


def test_every_kernel_has_its_tests_and_its_benchmark() -> None:
    """The tests: against a reference, in guarded memory, of refused calls; and the benchmark."""
    folder = ROOT / "tests" / "kernels"
    sources = {file.name: file.read_text() for file in folder.glob("*_test.cpp")}
    against_references = "".join(
        text for name, text in sources.items() if name not in ("guarded_test.cpp", "refused_calls_test.cpp")
    )
    for name in KERNELS:
        assert re.search(rf"\b{name}\(", against_references), f"{name}: no test against a reference"
        assert re.search(rf"BENCHMARK\({name}(_\w+)?,", against_references), f"{name}: no benchmark"
        assert f"aoti_torch_cpu_{name}," in sources["guarded_test.cpp"], f"{name}: no call in guarded memory"


def test_no_kernel_has_the_name_of_an_operator_of_pytorchs() -> None:
    """The calls of both are C functions in one namespace."""
    folder = Path(torch.__file__).parent / "include/torch/csrc/inductor/aoti_torch"
    declared = set(
        re.findall(r"\baoti_torch_cpu_(\w+)", "".join(file.read_text() for file in folder.rglob("*.h")))
    )
    assert declared and not declared & set(KERNELS)
