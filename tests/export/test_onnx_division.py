"""Remainders in ONNX are exact for all integers, and take sizes as divisors."""

from __future__ import annotations

from typing import Tuple

import pytest
import torch
from torch import Tensor

from chiasm import runtime
from chiasm.export import Spec, TensorSpec, export


def remainders(x: Tensor, y: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor, Tensor, Tensor]:
    size = x.shape[0]
    short = x.to(torch.int32)
    return (
        torch.fmod(x, 7),
        torch.fmod(x, y),
        torch.remainder(x, size),
        torch.fmod(short, size) + torch.remainder(short, 5),
        torch.fmod(x / 3, 2.5),
        torch.remainder(x / 3, size),
    )


@pytest.fixture(scope="module")
def method(tmp_path_factory: pytest.TempPathFactory) -> runtime.Method:
    spec = Spec(
        "test.remainders",
        [TensorSpec(name, ("N",), "int64", range=(1, 99)) for name in "xy"],
        [TensorSpec(f"y{i}") for i in range(6)],
        symbols={"N": (1, 100)},
        gradients=(),
    )
    bundle = export(remainders, spec, tmp_path_factory.mktemp("remainders"), formats=["onnx"])
    return runtime.open(bundle).method("forward")


def test_remainders_are_exact(method: runtime.Method) -> None:
    x = torch.tensor([0, 1, -1, 7, -8, 2**53 + 1, -(2**53) - 1, 2**63 - 1, -(2**63), -(2**63)])
    y = torch.tensor([3, -3, 5, -7, 3, 7, 7, -5, 10, -1])
    wanted = remainders(x, y)
    for mine, eager in zip(method(x, y)[:4], wanted, strict=False):
        assert torch.equal(torch.as_tensor(mine), eager)
    small = torch.arange(-5, 5)
    for mine, eager in zip(method(small, y), remainders(small, y), strict=True):
        torch.testing.assert_close(torch.as_tensor(mine), eager)


def test_a_divisor_of_zero_is_an_error(method: runtime.Method) -> None:
    with pytest.raises(RuntimeError, match="ZeroDivisionError"):
        torch.fmod(torch.ones(2, dtype=torch.int64), torch.tensor([1, 0]))
    with pytest.raises(runtime.ChiasmError):
        method(torch.ones(2, dtype=torch.int64), torch.tensor([1, 0]))
