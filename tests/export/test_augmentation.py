"""A training pipeline as one bundle: bytes and seeds in, an augmented batch out, everywhere the same."""

from pathlib import Path

import pytest
import torch
from torch import Tensor, nn

from chiasm import runtime
from chiasm.augmentation import (
    AugmentationSequential,
    RandomAffine,
    RandomHorizontalFlip,
    RandomResizedCrop,
)
from chiasm.enhance import normalize
from chiasm.export import Spec, TensorSpec, Tolerance, export


class ToFloat(nn.Module):
    def forward(self, input: Tensor) -> Tensor:
        return normalize(input.to(torch.float32) / 255.0, torch.tensor([0.5]), torch.tensor([0.25]))


@pytest.fixture(scope="module")
def pipeline() -> nn.Module:
    return AugmentationSequential(
        RandomHorizontalFlip(),
        RandomResizedCrop((24, 20), scale=(0.3, 1.0)),
        RandomAffine(20.0, (0.1, 0.1), (0.8, 1.2)),
        ToFloat(),
    )


@pytest.fixture(scope="module")
def bundle(pipeline: nn.Module, tmp_path_factory: pytest.TempPathFactory) -> Path:
    spec = Spec(
        "my.augmentation",
        [
            TensorSpec("input", ("B", 3, "H", "W"), "uint8", "NCHW", "RGB", (0, 255), "images"),
            TensorSpec("seed", ("B",), "int64", range=(-(2**62), 2**62), description="one seed a sample"),
        ],
        gradients=(),
        # A position in the middle of two steps of 1/32 pixel is rounded to either (`warp_affine`): levels.
        tolerances={"float32": Tolerance(4 * 2 / 255, 0.0)},
    )
    return export(pipeline, spec, tmp_path_factory.mktemp("augmentation"))


@pytest.mark.parametrize("backend", ["native", "onnx", "torch"])
def test_every_backend_gives_eager_s_images(pipeline: nn.Module, bundle: Path, backend: str) -> None:
    generator = torch.Generator().manual_seed(7)
    images = torch.randint(0, 256, (3, 3, 31, 45), generator=generator, dtype=torch.uint8)
    seed = torch.tensor([12345678901234567, -5, 2**40 + 1])
    expected = pipeline.forward(images, seed)
    method = runtime.open(str(bundle)).method("forward", backend=backend)
    found = torch.as_tensor(method(images.numpy(), seed.numpy()))
    assert found.shape == expected.shape == (3, 3, 24, 20)
    level = 4.0 / 255.0
    off = (found - expected).abs()
    assert off.max() <= 2.5 * level
    assert (off > 1e-4).float().mean() < 0.001
