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


@pytest.mark.parametrize("dtype", ["uint8", "int8", "int16", "int32", "int64"])
def test_shifts(dtype: str, tmp_path: Path) -> None:
    spec = Spec(
        "test.shifted",
        [TensorSpec(name, ("N",), dtype) for name in "xy"],
        [TensorSpec(f"o{i}", ("N",), dtype) for i in range(5)],
        make_inputs=lambda generator, sizes, _: {
            name: torch.randint(0, 8, (sizes["N"],), generator=generator).to(getattr(torch, dtype))
            for name in "xy"
        },
    )
    method = chiasm.runtime.open(export(shifted, spec, tmp_path, formats=["onnx"])).method(backend="onnx")
    limits = np.iinfo(dtype)
    x = np.array([limits.min, limits.min // 2 - 1, *range(-3, 4), limits.max // 3, limits.max], object)
    x = np.repeat(x[x >= limits.min].astype(dtype), 8)
    y = np.tile(np.arange(8), len(x) // 8).astype(dtype)
    expected = (x >> 1) | y, x << 3, x >> y, x << y, (x >> 7) + x
    for actual, wanted in zip(method(x, y), expected, strict=True):
        np.testing.assert_array_equal(actual, wanted)


@pytest.mark.parametrize("dtype", ["uint8", "int8", "int16", "int32", "int64"])
def test_shifted_further_than_their_bits(dtype: str, tmp_path: Path) -> None:
    """As in PyTorch: nothing is left but the sign."""
    spec = Spec(
        "test.far",
        [TensorSpec(n, ("N",), dtype) for n in "xy"],
        [TensorSpec(n, ("N",), dtype) for n in "abc"],
    )
    bundle = export(lambda x, y: (x >> y, x << y, x >> 99), spec, tmp_path, formats=["onnx"])
    method = chiasm.runtime.open(bundle).method(backend="onnx")
    bits, limits = np.iinfo(dtype).bits, np.iinfo(dtype)
    y = np.array([bits - 1, bits, bits + 1, 99] * 2, dtype)
    x = np.array([limits.max] * 4 + [limits.min] * 4, dtype)
    sign = -1 if limits.min < 0 else 0
    right, left, far = method(x, y)
    np.testing.assert_array_equal(right, [limits.max >> (bits - 1), 0, 0, 0, sign, sign, sign, sign])
    np.testing.assert_array_equal(left, [limits.min or 128, 0, 0, 0, 0, 0, 0, 0])
    np.testing.assert_array_equal(far, [0] * 4 + [sign] * 4)
