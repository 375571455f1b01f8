"""Bytes in native code: operators that PyTorch leaves to libtorch are compiled."""

from pathlib import Path
from typing import Tuple

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
