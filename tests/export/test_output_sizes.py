"""Sizes of outputs that an op computes: the manifest states them, and every engine computes the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch
import torch.nn.functional as F
from torch import Tensor

from chiasm import runtime
from chiasm.export import Spec, TensorSpec, export


def sized(x: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    height, width = x.shape
    image = x[None, None]
    return (
        x.new_zeros(1 + 50 * height // (2 * width)),
        # ONNX Runtime would divide by the divisor of one what is multiplied by it.
        x.new_zeros(height + (height - 3) * (1 // (1 + height // 20))),
        F.interpolate(image, scale_factor=1.5, mode="bilinear"),
        F.interpolate(image, scale_factor=(0.5, 0.375)),
    )


@pytest.fixture(scope="module")
def bundle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    spec = Spec(
        "test.sized",
        [TensorSpec("x", ("H", "W"))],
        [TensorSpec(f"y{i}") for i in range(4)],
        symbols={"H": (8, 512), "W": (8, 512)},
        gradients=(),
    )
    return export(sized, spec, tmp_path_factory.mktemp("sized"), formats=["onnx", "native"])


@pytest.mark.parametrize("backend", ["onnx", "native"])
@pytest.mark.parametrize(("height", "width"), [(8, 8), (19, 33), (20, 21), (45, 9), (101, 130)])
def test_computed_sizes(bundle: Path, backend: str, height: int, width: int) -> None:
    method = runtime.open(bundle).method("forward", backend=backend)
    x = torch.rand(height, width)
    expected = [
        (1 + 50 * height // (2 * width),),
        (2 * height - 3 if height < 20 else height,),
        (1, 1, int(1.5 * height), int(1.5 * width)),
        (1, 1, int(0.5 * height), int(0.375 * width)),
    ]
    assert [shape for shape, _ in method.output_shapes(x.numpy())] == expected
    results = method(x.numpy())
    assert [result.shape for result in results] == expected
    larger = F.interpolate(x[None, None].double(), scale_factor=1.5, mode="bilinear")
    np.testing.assert_allclose(results[2], larger, atol=3e-5)  # positions are float32
    np.testing.assert_array_equal(results[3], F.interpolate(x[None, None], scale_factor=(0.5, 0.375)))
