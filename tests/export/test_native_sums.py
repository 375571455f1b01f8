"""Sums of as many numbers as a large image has, against NumPy's in float64."""

from pathlib import Path

import numpy as np
import pytest
from torch import Tensor

import chiasm.runtime
from chiasm.export import Spec, TensorSpec, export
from chiasm.export.catalog import catalog


def sums(x: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    return x.sum([-2, -1]), x.mean([1, 3], keepdim=True), x.mean(), x.square().sum()


def scaled(x: Tensor, factor: Tensor) -> Tensor:
    return x * factor


def test_sums_of_a_large_image(tmp_path: Path) -> None:
    names = ("planes", "columns", "whole", "squares")
    spec = Spec("test.sums", [TensorSpec("x", ("B", "C", "H", "W"))], [TensorSpec(name) for name in names])
    bundle = chiasm.runtime.open(export(sums, spec, tmp_path, formats=("native",)))
    # The same number again and again is the worst case: each addition is rounded to the same side.
    for x in (np.full((1, 2, 1080, 1920), 0.1, np.float32), np.random.default_rng(0).random((3, 2, 9, 11))):
        x = x.astype(np.float32)
        wide = x.astype(np.float64)
        expected = (wide.sum((-2, -1)), wide.mean((1, 3), keepdims=True), wide.mean(), np.square(wide).sum())
        for name, made, right in zip(names, bundle.method("forward")(x), expected, strict=True):
            np.testing.assert_allclose(made, right, rtol=1e-5, err_msg=name)


def test_the_gradient_of_a_factor_is_such_a_sum(tmp_path: Path) -> None:
    inputs = [TensorSpec("x", ("B", "C", "H", "W")), TensorSpec("factor", ())]
    spec = Spec("test.scaled", inputs, gradients=("factor",))
    bundle = chiasm.runtime.open(export(scaled, spec, tmp_path, formats=("native",)))
    x, factor = np.full((1, 1, 1080, 1920), 0.1, np.float32), np.float32(2)
    made = bundle.method("vjp")(x, factor, np.ones_like(x))
    np.testing.assert_allclose(made, x.astype(np.float64).sum(), rtol=1e-5)


@pytest.mark.parametrize("backend", ["native", "torch", "onnx"])
def test_the_mean_position_in_a_frame(tmp_path: Path, backend: str) -> None:
    entry = catalog()["geometry.subpix.spatial_soft_argmax2d"]
    format = {"torch": "torchscript"}.get(backend, backend)
    bundle = export(entry.function(), entry.spec, tmp_path, formats=(format,), methods=("forward",))
    x = (5 * np.random.default_rng(0).random((1, 1, 600, 803))).astype(np.float32)
    weights = np.exp(x[0, 0].astype(np.float64) / entry.spec.config["temperature"])
    rows, columns = np.indices(weights.shape)
    expected = [np.average(columns, weights=weights), np.average(rows, weights=weights)]
    made = chiasm.runtime.open(bundle).method("forward", backend=backend, dtype="float32", fused=False)(x)
    np.testing.assert_allclose(made[0, 0], expected, atol=1e-3)
