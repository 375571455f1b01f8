"""The calls of kernels that tests/kernels makes from the declarations: every kernel has some, they are
allowed or forbidden as they should be, and a kernel that cannot be called stops the build."""

from __future__ import annotations

import re
import runpy
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from chiasm.primitives.kernels.schema import DeclarationError, kernel

ROOT = Path(__file__).resolve().parents[2]
GENERATE = ROOT / "runtime" / "artifact" / "generate.py"


@pytest.fixture(scope="module")
def generate() -> SimpleNamespace:
    return SimpleNamespace(**runpy.run_path(str(GENERATE)))


def test_every_kernel_has_calls_in_guarded_memory(generate: SimpleNamespace) -> None:
    tests = generate.allowed_calls().split("TEST_F(GuardedCalls, ")[1:]
    assert [text.partition(")")[0] for text in tests] == list(generate.KERNELS)
    for text in tests:
        calls = re.findall(r"^      \{.*\},$", text, re.MULTILINE)
        assert len(calls) == len(set(calls)) >= 6, text


def test_calls_are_allowed(generate: SimpleNamespace) -> None:
    for declared in generate.KERNELS.values():
        for call in generate.allowed(declared, 6):
            listed = {name: values for name, values in call.items() if isinstance(values, list)}
            for i in range(generate.ENTRIES):
                known = {**call, **{name: values[i] for name, values in listed.items()}}
                known |= {"INT32_MAX": 2**31 - 1, **generate.CONSTANTS}
                empty = {t.name for t in declared.tensors if any(known.get(size) == 0 for size in t.shape)}
                for text in declared.conditions:
                    is_checked = not empty & set(listed) & set(re.findall(r"\w+", text))
                    assert not is_checked or eval(text, {}, known), (declared.name, text, call)


def test_every_condition_is_broken(generate: SimpleNamespace) -> None:
    """But for those that others imply."""
    tests = generate.forbidden_calls().split("TEST(RefusedCalls, ")[1:]
    missing = {
        (name, text)
        for test, (name, declared) in zip(tests, generate.KERNELS.items(), strict=True)
        for text in declared.conditions
        if f'"{text}"' not in test
    }
    assert missing == {
        ("grown_distances", "K <= INT32_MAX"),  # (H + K) * (W + K)
        ("sobel_derivatives", "1 <= H"),
        ("sobel_derivatives", "1 <= W"),
        ("resize_cubic_bytes", "1 <= H"),
        ("resample_bytes", "1 <= H"),
    }


@pytest.mark.parametrize("tried", [("y", 0, 1), ("scale", 0, 1), ("size", 2, 1)])
def test_limits_are_those_of_arguments(tried: tuple[str, int, int]) -> None:
    with pytest.raises(DeclarationError, match=f"^kernel half: tried: expected .*, got {tried[0]}, "):
        kernel("half(T[N] x, int size, float scale) -> T[N]", "half.cpp", "", tried=[tried])


def test_a_kernel_that_cannot_be_called_stops_the_build(tmp_path: Path) -> None:
    for folder in ("runtime/artifact", "python/chiasm/primitives/kernels"):
        shutil.copytree(
            ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__", "aoti")
        )
    file = tmp_path / "python/chiasm/primitives/kernels/declarations.py"
    old = '"KY % 2 == 1", "KX % 2 == 1"]'
    assert old in file.read_text()
    file.write_text(file.read_text().replace(old, '"KY % 2 == 1", "KY % 4 == 2"]', 1))
    done = subprocess.run(
        [sys.executable, "-S", tmp_path / "runtime/artifact/generate.py", "tests", tmp_path / "made"],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 1
    assert done.stderr == (
        "error: kernel separable: no small sizes and numbers meet its conditions together, so no test can"
        " call it\n"
    )
    assert not (tmp_path / "made").exists()
