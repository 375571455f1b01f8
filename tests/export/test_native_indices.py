"""Native indices of operators that reject negative ones. Indices in PyTorch's own graphs are trusted."""

from __future__ import annotations

from pathlib import Path

import pytest
import torch
from torch import Tensor

from chiasm import runtime
from chiasm.export import Spec, TensorSpec, export

SIZE = 16
SPEC = Spec(
    "test.places",
    [TensorSpec("table", (SIZE,)), TensorSpec("index", (SIZE,), "int64")],
    gradients=(),
    make_inputs=lambda g, sizes, dtype: {
        "table": torch.rand(SIZE, generator=g, dtype=dtype),
        "index": torch.randperm(SIZE, generator=g),
    },
)


def beside_another(table: Tensor, index: Tensor) -> Tensor:
    """In one loop with an operator that counts negative indices from the end."""
    return table.index_select(0, index) + table[index - SIZE // 2]


def test_an_index_is_refused_beside_another(tmp_path: Path) -> None:
    method = runtime.open(export(beside_another, SPEC, tmp_path, formats=("native",))).method(
        "forward", backend="native"
    )
    table, index = torch.rand(SIZE), torch.randperm(SIZE)
    torch.testing.assert_close(torch.as_tensor(method(table, index)), beside_another(table, index))
    index[3] = -1
    with pytest.raises((IndexError, RuntimeError)):
        beside_another(table, index)
    with pytest.raises(runtime.ChiasmError, match=r"index -1 is out of range for an axis of size 16"):
        method(table, index)


def unpooled(table: Tensor, index: Tensor) -> Tensor:
    places = index.reshape(1, 1, 4, 4)
    return torch.nn.functional.max_unpool2d(table.reshape(1, 1, 4, 4), places, 1, 1, output_size=(4, 4))


@pytest.mark.parametrize("format", ["native", "onnx"])
def test_places_of_maxima_are_checked(format: str, tmp_path: Path) -> None:
    method = runtime.open(export(unpooled, SPEC, tmp_path, formats=(format,))).method("forward")
    table, index = torch.rand(SIZE), torch.randperm(SIZE)
    torch.testing.assert_close(torch.as_tensor(method(table, index)), unpooled(table, index))
    for wrong in (-1, SIZE, 1 << 40):
        index[3] = wrong
        with pytest.raises(RuntimeError, match="invalid max index"):
            unpooled(table, index)
        with pytest.raises(runtime.ChiasmError, match=r"out of (range|data bounds)"):
            method(table, index)
