"""Integers of 64 bits keep their order in ONNX, also above 2**31."""

from __future__ import annotations

from typing import Tuple

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
