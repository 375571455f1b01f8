"""Layers that the compiler makes code for with one size alone: refused by name where the size is a symbol,
compiled where it is not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch
import torch.nn.functional as F
from torch import Tensor, nn

from chiasm import runtime
from chiasm.export import ExportError, Spec, TensorSpec, export
from chiasm.export.manifest import read_manifest


class Projected(nn.Module):
    """Columns of an image, read by an LSTM layer that projects its state."""

    def __init__(self) -> None:
        super().__init__()
        self.layer = nn.LSTM(3, 8, batch_first=True, proj_size=4)

    def forward(self, image: Tensor) -> Tensor:
        return self.layer(image.mean(2).transpose(1, 2))[0]


class Pooled(nn.Module):
    def forward(self, image: Tensor) -> Tensor:
        return F.adaptive_max_pool2d(image * 2, (3, 5)) + 1


def exported(network: nn.Module, width: int | str, folder: Path) -> Path:
    spec = Spec(
        "test.network",
        [TensorSpec("image", ("B", 3, 20, width))],
        [TensorSpec("result")],
        symbols={"W": (2, 5)} if width == "W" else {},
        gradients=(),
    )
    return export(network.eval(), spec, folder, formats=["native"])


REFUSED = r"because: .* for image\.shape\[3\] = \d+ alone\n  instead: write"


def test_a_symbol_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(ExportError, match=REFUSED):
        exported(Pooled(), "W", tmp_path)


def test_steps_of_a_fixed_number(tmp_path: Path) -> None:
    """Also after an export with symbols, for which layers have results without values."""
    network = Projected()
    with pytest.raises(ExportError, match=REFUSED):
        exported(network, "W", tmp_path)
    bundle = exported(network, 3, tmp_path)
    [artifact] = read_manifest(bundle)["methods"]["forward"]["artifacts"]
    assert artifact["needs"] == []
    image = torch.rand(2, 3, 20, 3)
    result = runtime.open(bundle).method("forward", backend="native")(image.numpy())
    np.testing.assert_allclose(result, network(image).detach(), atol=1e-6)
