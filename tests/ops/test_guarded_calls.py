"""The calls of kernels that tests/kernels makes from the declarations: every kernel has some, and they are
allowed or forbidden as they should be."""

from __future__ import annotations

import importlib
import re
import runpy
from pathlib import Path
from types import ModuleType

import pytest

from chiasm.primitives.kernels.declarations import CONSTANTS

ROOT = Path(__file__).resolve().parents[2]
GENERATE = ROOT / "runtime" / "artifact" / "generate.py"


@pytest.fixture(scope="module")
def example_tests() -> ModuleType:
    runpy.run_path(str(GENERATE))  # which says where its modules are
    return importlib.import_module("example_tests")


def test_every_kernel_has_calls_in_guarded_memory(example_tests: ModuleType) -> None:
    tests = example_tests.allowed_calls().split("TEST_F(GuardedCalls, ")[1:]
    assert [text.partition(")")[0] for text in tests] == list(example_tests.KERNELS)
    for text in tests:
        calls = re.findall(r"^      \{.*\},$", text, re.MULTILINE)
        assert len(calls) == len(set(calls)) >= 5, text  # 5 if there is but one size


def test_calls_are_allowed(example_tests: ModuleType) -> None:
    for declared in example_tests.KERNELS.values():
        for call in example_tests.allowed(declared, 6):
            listed = {name: values for name, values in call.items() if isinstance(values, list)}
            for i in range(example_tests.ENTRIES):
                known = {**call, **{name: values[i] for name, values in listed.items()}}
                known |= {"INT32_MAX": 2**31 - 1, **CONSTANTS}
                empty = {t.name for t in declared.tensors if any(known.get(size) == 0 for size in t.shape)}
                for text in declared.conditions:
                    is_checked = not empty & set(listed) & set(re.findall(r"\w+", text))
                    assert not is_checked or eval(text, {}, known), (declared.name, text, call)


def test_every_condition_is_broken(example_tests: ModuleType) -> None:
    """But for those that others imply."""
    tests = example_tests.forbidden_calls().split("TEST(RefusedCalls, ")[1:]
    missing = {
        (name, text)
        for test, (name, declared) in zip(tests, example_tests.KERNELS.items(), strict=True)
        for text in declared.conditions
        if f'"{text}"' not in test
    }
    assert missing == {
        ("grown_distances", "K <= INT32_MAX"),  # (H + K) * (W + K)
        ("derivatives_of_bytes", "1 <= H"),
        ("derivatives_of_bytes", "1 <= W"),
        ("lstm", "1 <= H"),
        ("gru", "1 <= H"),
        ("resize_cubic_bytes", "1 <= H"),
        ("resample_bytes", "1 <= H"),
    }
