"""Integers of 64 bits keep their order in ONNX, also above 2**31, and their sums above 2**53."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Tuple

import onnx
import pytest
import torch
from torch import Tensor

from chiasm import runtime
from chiasm.export import Spec, TensorSpec, export


def ordered(x: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor, Tensor, Tensor, Tensor]:
    other = x.flip(0)
    return (
        x.clamp(0, 7),
        x.clamp(min=9),
        torch.maximum(x, other) - torch.minimum(x, other),
        x.sign(),
        x.amax(1) - x.amin(1),
        x.max(),
        torch.arange(64)[x.clamp(-5, 20)],
    )


@pytest.mark.parametrize(
    "value", [2**31 - 1, 2**31, 2**32 - 1, 2**33 + 2**31, 2**63 - 1, -(2**31), -(2**31) - 1, -(2**63)]
)
def test_integers_keep_their_order(value: int, method: runtime.Method) -> None:
    x = torch.arange(45).reshape(5, 9)
    for place in (0, 3, 8):
        x[2, place] = value
        for mine, eager in zip(method(x), ordered(x), strict=True):
            assert torch.equal(torch.as_tensor(mine), eager)


def narrow(x: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    above = x > 3
    return above.all(1), above.any(0), x.to(torch.int64).amax(1)


def test_numbers_of_32_bits_are_compared_by_the_usual_operators(tmp_path: Path) -> None:
    spec = Spec(
        "test.narrow",
        [TensorSpec("x", ("H", "W"), "int32", range=(-9, 99))],
        [TensorSpec(f"y{i}") for i in range(3)],
        gradients=(),
    )
    bundle = export(narrow, spec, tmp_path, formats=["onnx"])
    assert "TopK" not in [node.op_type for node in onnx.load(bundle / "forward.onnx").graph.node]
    x = torch.full((3, 5), 7, dtype=torch.int32)
    x[0, 1], x[1, 2], x[2, 4] = -(2**31), 2**31 - 1, -1
    for values in (x, x.flip(0), x.clamp(max=-5)):
        for mine, eager in zip(runtime.open(bundle).method("forward")(values), narrow(values), strict=True):
            assert torch.equal(torch.as_tensor(mine), eager)


def sums(x: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    return x.sum(), x.sum(1), x.sum([0], keepdim=True)


def counts(x: Tensor) -> Tensor:
    return (x > 3).sum(1) + x.clamp(0, 1000).sum(1)


@pytest.mark.parametrize("fn", [sums, counts])
def test_sums_are_those_of_integers(fn: Callable, tmp_path: Path) -> None:
    """ONNX Runtime adds them as float64; only where that is not exact, they are added in parts."""
    spec = Spec(
        f"test.{fn.__name__}",
        [TensorSpec("x", ("H", "W"), "int64", range=(-9, 99))],
        [TensorSpec(f"y{i}") for i in range(3)] if fn is sums else [TensorSpec("output")],
        gradients=(),
    )
    bundle = export(fn, spec, tmp_path, formats=["onnx"])
    operators = [node.op_type for node in onnx.load(bundle / "forward.onnx").graph.node]
    assert ("BitShift" in operators) == (fn is sums)
    method = runtime.open(bundle).method("forward")
    generator = torch.Generator().manual_seed(0)
    for x in (
        torch.full((4, 5), 2**53 + 1),
        torch.full((4, 5), -(2**63)),
        torch.randint(-(2**62), 2**62, (7, 9), generator=generator),
        torch.randint(-(2**63), 2**63 - 1, (1, 300), generator=generator),
    ):
        made, expected = method(x), fn(x)
        pairs = zip(made, expected, strict=True) if fn is sums else [(made, expected)]
        for mine, eager in pairs:
            assert torch.equal(torch.as_tensor(mine), eager)


@pytest.fixture(scope="module")
def method(tmp_path_factory: pytest.TempPathFactory) -> runtime.Method:
    spec = Spec(
        "test.ordered",
        [TensorSpec("x", ("H", "W"), "int64", range=(-9, 99))],
        [TensorSpec(f"y{i}") for i in range(7)],
        gradients=(),
    )
    bundle = export(ordered, spec, tmp_path_factory.mktemp("order"), formats=["onnx"])
    return runtime.open(bundle).method("forward")
