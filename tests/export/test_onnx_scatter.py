"""Sums by index in ONNX: all values for one place are added, in every run."""

from pathlib import Path

import numpy as np
import onnx
import onnxruntime
import pytest
import torch
from torch import Tensor

from chiasm.export import Spec, TensorSpec, export
from chiasm.export.manifest import read_manifest


def of_rows(table: Tensor, row: Tensor, value: Tensor) -> Tensor:
    """Whole rows, by indices from -R to R - 1."""
    return table.index_put([row], value, accumulate=True)


def of_places(table: Tensor, row: Tensor, value: Tensor) -> Tensor:
    return table.index_put([row, row.flip(0)], value[:, 0], accumulate=True)


@pytest.mark.parametrize("function", [of_rows, of_places])
def test_every_term_counts_in_every_run(function, tmp_path: Path) -> None:
    spec = Spec(
        f"test.{function.__name__}",
        [
            TensorSpec("table", ("R", "C")),
            TensorSpec("row", ("N",), dtype="int64", range=(-9, 9)),
            TensorSpec("value", ("N", "C")),
        ],
        symbols={"R": (9, 100), "C": (12, 1000), "N": (1, 1 << 20)},
        gradients=(),
    )
    bundle = export(function, spec, tmp_path, formats=["onnx"])
    [artifact] = [a for a in read_manifest(bundle)["methods"]["forward"]["artifacts"] if "function" not in a]
    nodes = onnx.load(bundle / artifact["file"]).graph.node
    assert [n for n in nodes if n.op_type == "ScatterND"] == []
    assert [n for n in nodes if n.op_type == "ScatterElements"] != []
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 4
    session = onnxruntime.InferenceSession(bundle / artifact["file"], options)
    random = np.random.default_rng(0)
    # Integers: the sum is exact in any order
    table = random.integers(0, 9, (11, 64)).astype(np.float32)
    row = random.integers(-11, 11, 20_000)
    value = random.integers(0, 9, (20_000, 64)).astype(np.float32)
    expected = table.copy()
    if function is of_rows:
        np.add.at(expected, row, value)
    else:
        np.add.at(expected, (row, row[::-1]), value[:, 0])
    for _ in range(10):
        [result] = session.run(None, {"table": table, "row": row, "value": value})
        assert np.array_equal(np.asarray(result), expected)
    assert torch.equal(
        function(torch.from_numpy(table), torch.from_numpy(row), torch.from_numpy(value)),
        torch.from_numpy(expected),
    )
