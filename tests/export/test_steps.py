"""Functions that compute gradients themselves: an optimisation step as one graph."""

from __future__ import annotations

from pathlib import Path
from typing import Tuple

import pytest
import torch
from torch import Tensor

from chiasm import runtime
from chiasm.export import Spec, export
from chiasm.export.manifest import read_manifest
from chiasm.export.spec import TensorSpec


def descent(x: Tensor, a: Tensor, lr: Tensor) -> Tuple[Tensor, Tensor]:
    """A gradient step on the sum of (a x - 1)^2."""
    at = x.detach().requires_grad_(True)
    loss = ((a * at - 1.0) ** 2).sum()
    gradient = torch.autograd.grad([loss], [at])[0]
    assert gradient is not None
    return x - lr * gradient, loss.detach()


@pytest.fixture(scope="module")
def bundle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    inputs = [TensorSpec("x", ("N",)), TensorSpec("a", ("N",)), TensorSpec("lr", ())]
    return export(
        descent,
        Spec("my.descent", inputs, [TensorSpec("next"), TensorSpec("loss")], takes_gradients=True),
        tmp_path_factory.mktemp("steps"),
    )


def test_has_no_vjp(bundle: Path) -> None:
    assert list(read_manifest(bundle)["methods"]) == ["forward"]


@pytest.mark.parametrize("backend", ["native", "torch", "onnx"])
@pytest.mark.parametrize("n", [1, 7])
def test_goes_down_as_the_closed_form(bundle: Path, backend: str, n: int) -> None:
    step = runtime.open(bundle).method("forward", backend=backend)
    generator = torch.Generator().manual_seed(n)
    x, a, lr = torch.rand(n, generator=generator), torch.rand(n, generator=generator) + 0.5, torch.tensor(0.1)
    expected = x.double()
    for _ in range(5):
        before = ((a.double() * expected - 1.0) ** 2).sum()
        expected = expected - 0.1 * 2.0 * a.double() * (a.double() * expected - 1.0)
        x, loss = step(x, a, lr)
        torch.testing.assert_close(loss.double(), before, rtol=1e-5, atol=1e-6)
    torch.testing.assert_close(x.double(), expected, rtol=1e-5, atol=1e-6)
