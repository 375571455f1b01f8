"""Bytes in native code: operators that PyTorch leaves to libtorch are compiled."""

from pathlib import Path
from typing import List, Tuple

import numpy as np
import torch
from torch import Tensor

from chiasm import runtime
from chiasm.export import Spec, TensorSpec, export


def side_by_side(x: Tensor, y: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor]:
    """Planes, negative dimensions, parts of one tensor, and unsigned and signed bytes."""
    return (
        torch.cat([x, y, x], 2),
        torch.cat([x[..., :1], y.flip(3), x[..., 1:]], -1),
        torch.cat([x]),
        torch.cat([x, y.to(torch.int8)], 1),
    )


def test_tensors_of_bytes_side_by_side_need_no_libtorch(tmp_path: Path) -> None:
    shape = ("B", "C", "H", "W")
    outputs = [TensorSpec(name) for name in ("rows", "columns", "alone", "signed")]
    spec = Spec(
        "test.side_by_side",
        [TensorSpec("x", shape, dtype="uint8"), TensorSpec("y", shape, dtype="uint8")],
        outputs,
        symbols={"B": (1, 64), "C": (1, 64), "H": (1, 4096), "W": (3, 4096)},
        gradients=(),
    )
    bundle = export(side_by_side, spec, tmp_path, formats=["native"])
    run = runtime.open(bundle).method("forward", backend="native")
    random = np.random.default_rng(0)
    for sizes in ((1, 1, 1, 3), (2, 3, 5, 7), (1, 4, 33, 129)):
        x, y = (random.integers(0, 256, sizes, dtype=np.uint8) for _ in range(2))
        rows, columns, alone, signed = run(x, y)
        np.testing.assert_array_equal(rows, np.concatenate([x, y, x], 2))
        np.testing.assert_array_equal(columns, np.concatenate([x[..., :1], y[..., ::-1], x[..., 1:]], 3))
        np.testing.assert_array_equal(alone, x)
        np.testing.assert_array_equal(signed, np.concatenate([x.astype(np.int16), y.astype(np.int8)], 1))
        assert signed.dtype == np.int16


def extremes(x: Tensor, y: Tensor) -> List[Tensor]:
    """Extremes of bytes beside numbers of 32 bits, so that loops take eight bytes at a time."""
    at = torch.arange(x.size(2), dtype=torch.int32)
    results = [torch.where(x == x.amin(2, keepdim=True), at, 9999).amin(2).to(torch.int64)]
    for t in (x, y):
        results += [t.amin(2).to(torch.int64), t.amax(2).to(torch.int64)]
        results += [t.argmin(2), t.argmax(2), t.to(torch.int32).sum(2).to(torch.int64)]
    for t in (x, y):
        results += [t.amin(1).to(torch.int64), t.amax(1).to(torch.int64)]
    return results


def test_extremes_of_bytes_in_loops_of_eight_lanes(tmp_path: Path) -> None:
    inputs = [TensorSpec("x", ("B", "C", "N"), "uint8"), TensorSpec("y", ("B", "C", "N"), "int8")]
    outputs = [TensorSpec(f"o{i}") for i in range(15)]
    spec = Spec("test.extremes", inputs, outputs, gradients=(), symbols={"N": (2, 4096)})
    run = runtime.open(export(extremes, spec, tmp_path, formats=["native"])).method(backend="native")
    random = np.random.default_rng(0)
    for count in (2, 7, 8, 31, 32, 33, 100, 1000):
        x = random.integers(40, 200, (2, 3, count), dtype=np.uint8)
        y = random.integers(-120, -20, (2, 3, count), dtype=np.int8)
        expected = [x.argmin(2)]
        for t in (x, y):
            expected += [t.min(2), t.max(2), t.argmin(2), t.argmax(2), t.sum(2, dtype=np.int64)]
        for t in (x, y):
            expected += [t.min(1), t.max(1)]
        for actual, wanted in zip(run(x, y), expected, strict=True):
            np.testing.assert_array_equal(actual, wanted)
