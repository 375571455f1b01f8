"""Omitted operators and shorter instruction sequences do not change an export's results."""

from pathlib import Path
from typing import Callable, Tuple

import numpy as np
import pytest
import torch
from torch import Tensor

from chiasm import runtime
from chiasm.export import Spec, TensorSpec, example_inputs, export
from chiasm.export.tracing.graph import trace
from chiasm.export.tracing.module import bind_spec

VALUES = [np.nan, -np.nan, np.inf, -np.inf, 0.0, -0.0, 0.5, -0.5, 2.0, -2.0, 1e-45, 3e38]


def certain(x: Tensor, seed: Tensor) -> Tensor:
    return torch.where(torch.ones_like(seed, dtype=torch.bool)[:, None], x * 2.0, x)


def of_another_shape(x: Tensor, seed: Tensor) -> Tensor:
    return torch.where(torch.ones_like(seed, dtype=torch.bool)[:, None], x[:, :1], x)


def drawn(x: Tensor, seed: Tensor) -> Tensor:
    return torch.where((seed > 0)[:, None], x * 2.0, x)


def unchanged(x: Tensor, seed: Tensor) -> Tensor:
    return torch.where(torch.ones_like(seed, dtype=torch.bool)[:, None], x, x * 2.0)


@pytest.mark.parametrize("fn", [certain, unchanged, of_another_shape])
def test_without_a_choice_the_result_is_the_same(fn: Callable, tmp_path: Path) -> None:
    spec = Spec(
        "test.choice", [TensorSpec("x", ("B", "N")), TensorSpec("seed", ("B",), "int64")], gradients=("x",)
    )
    bundle = export(fn, spec, tmp_path, formats=["onnx", "native"])
    x, seed = torch.rand(3, 5), torch.arange(3)
    for backend in ("onnx", "native"):
        found = runtime.open(bundle).method("forward", backend=backend)(x, seed)
        torch.testing.assert_close(torch.as_tensor(found), fn(x, seed))


@pytest.mark.parametrize(("fn", "choices"), [(certain, 0), (unchanged, 1), (of_another_shape, 1), (drawn, 1)])
def test_a_choice_that_is_certain_is_not_computed(fn: Callable, choices: int) -> None:
    spec = Spec("test.choice", [TensorSpec("x", ("B", "N")), TensorSpec("seed", ("B",), "int64")])
    example = example_inputs.make(spec, example_inputs.fit(spec, example_inputs.EXAMPLE), spec.variants()[0])
    graph = trace(bind_spec(fn, spec), spec, list(spec.inputs), example, "native").graph
    assert len([n for n in graph.nodes if n.target is torch.ops.aten.where.self]) == choices


def limited(x: Tensor, y: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor, Tensor]:
    return (
        x.clamp(-1.0, 1.0),
        x.clamp(min=0.0),
        x.clamp(max=0.25),
        torch.minimum(x, y),
        torch.maximum(x, y),
    )


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_minima_and_maxima_pass_nan_on(dtype: type, tmp_path: Path) -> None:
    """This also holds for minima and maxima that take one instruction instead of three, in whole vectors and
    in the remainder."""
    names = ("both", "low", "high", "least", "most")
    spec = Spec(
        "test.limited",
        [TensorSpec("x", ("N",)), TensorSpec("y", ("N",))],
        [TensorSpec(name) for name in names],
        dtypes=("float32", "float64"),
        gradients=(),
    )
    bundle = export(limited, spec, tmp_path, formats=["native"])
    run = runtime.open(bundle).method("forward", backend="native", dtype=np.dtype(dtype).name)
    x, y = (a.ravel().astype(dtype) for a in np.meshgrid(VALUES, VALUES))
    for count in (len(x), 13):
        expected = (
            np.clip(x[:count], -1.0, 1.0),
            np.maximum(x[:count], 0.0),
            np.minimum(x[:count], 0.25),
            np.minimum(x[:count], y[:count]),
            np.maximum(x[:count], y[:count]),
        )
        for found, value, name in zip(run(x[:count], y[:count]), expected, names, strict=True):
            np.testing.assert_array_equal(found, value.astype(dtype), name)
