"""The calls of kernels that tests/kernels makes from the declarations: every kernel has some, and they are
allowed or forbidden as they should be."""

from __future__ import annotations

import re
import runpy
from pathlib import Path
from types import SimpleNamespace

import pytest

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
