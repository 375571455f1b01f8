"""Shifts of whole numbers in ONNX are NumPy's."""

from pathlib import Path

import numpy as np
import pytest
import torch
from torch import Tensor

import chiasm.runtime
from chiasm.export import Spec, TensorSpec, export


def shifted(x: Tensor, y: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor, Tensor]:
    return (x >> 1) | y, x << 3, x >> y, torch.bitwise_left_shift(x, y), (x >> 7) + (x << 0)


@pytest.mark.parametrize("dtype", ["uint8", "int32"])
def test_shifts(dtype: str, tmp_path: Path) -> None:
    spec = Spec(
        "test.shifted",
        [TensorSpec(name, ("N",), dtype) for name in "xy"],
        [TensorSpec(f"o{i}", ("N",), dtype) for i in range(5)],
        sample=lambda generator, sizes, _: {
            name: torch.randint(0, 8, (sizes["N"],), generator=generator).to(getattr(torch, dtype))
            for name in "xy"
        },
    )
    method = chiasm.runtime.open(export(shifted, spec, tmp_path, formats=["onnx"])).method(backend="onnx")
    lowest = 0 if dtype == "uint8" else -256
    x = np.repeat(np.arange(lowest, 256).astype(dtype), 8)
    y = np.tile(np.arange(8), len(x) // 8).astype(dtype)
    expected = (x >> 1) | y, x << 3, x >> y, x << y, (x >> 7) + x
    for actual, wanted in zip(method(x, y), expected, strict=True):
        np.testing.assert_array_equal(actual, wanted)


def test_bytes_shifted_further_than_their_bits(tmp_path: Path) -> None:
    spec = Spec(
        "test.far", [TensorSpec(n, ("N",), "uint8") for n in "xy"], [TensorSpec("o", ("N",), "uint8")]
    )
    bundle = export(lambda x, y: (x >> y) + (x << y) + (x >> 9), spec, tmp_path, formats=["onnx"])
    method = chiasm.runtime.open(bundle).method(backend="onnx")
    x, y = np.full(5, 255, np.uint8), np.array([7, 8, 9, 33, 255], np.uint8)
    np.testing.assert_array_equal(method(x, y), [1 + 128, 0, 0, 0, 0])
