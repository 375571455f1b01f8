"""A training pipeline as one bundle: bytes and seeds in, an augmented batch out, the same on every
backend."""

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from PIL import Image
from torch import Tensor, nn
from torch.utils.data import DataLoader, Dataset

from chiasm import runtime
from chiasm.augmentation import (
    AugmentationSequential,
    RandomAffine,
    RandomHorizontalFlip,
    RandomIoUCrop,
    RandomResizedCrop,
    RandomZoomOut,
    ScaleJitter,
    random_color_jitter,
)
from chiasm.data import DataError, Map
from chiasm.enhance import normalize
from chiasm.export import Spec, TensorSpec, Tolerance, export, image
from chiasm.export.manifest import read_manifest


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
        # A position halfway between two steps of 1/32 pixel may round to either (`warp_affine`): a few
        # levels.
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


class Detected(nn.Module):
    """What a detector trains on: images of a drawn size on a canvas, or a crop that keeps a box."""

    def __init__(self, crops: bool) -> None:
        super().__init__()
        self.crops = crops
        self.scale = AugmentationSequential(
            ScaleJitter((20, 20), (0.5, 1.5), canvas=30), RandomZoomOut(canvas=40, p=0.7)
        )
        self.crop = RandomIoUCrop(size=(20, 24))

    def forward(self, input: Tensor, boxes: Tensor, seed: Tensor) -> Tensor:
        if self.crops:
            return self.crop.forward(input, seed, self.crop.draw_among(boxes, seed, list(input.shape)))
        return self.scale.forward(input, seed)


@pytest.mark.parametrize("crops", [False, True])
def test_drawn_sizes_on_a_canvas_and_crops_by_overlap_deploy(crops: bool, tmp_path: Path) -> None:
    inputs = [
        image("input"),
        TensorSpec("boxes", ("B", 3, 4), range=(0.0, 8.0)),
        TensorSpec("seed", ("B",), "int64", range=(-(2**62), 2**62)),
    ]
    module, images = Detected(crops), torch.rand(3, 3, 21, 25)
    tolerances = {"float32": Tolerance(1e-4, 1e-4)}
    bundle = export(module, Spec("my.detected", inputs, gradients=(), tolerances=tolerances), tmp_path)
    boxes = torch.tensor([[[1.0, 2.0, 9.0, 12.0], [3.0, 3.0, 20.0, 20.0], [15.0, 1.0, 24.0, 9.0]]])
    boxes, seed = boxes.expand(3, -1, -1).contiguous(), torch.tensor([5, -7, 2**40])
    expected = module(images, boxes, seed)
    for backend in ("native", "onnx", "torch"):
        method = runtime.open(str(bundle)).method("forward", backend=backend)
        found = torch.as_tensor(method(images.numpy(), boxes.numpy(), seed.numpy()))
        torch.testing.assert_close(found, expected, atol=1e-5, rtol=1e-5)


class Photos(Dataset):
    """Image files of several sizes, each with its label and its seed in an epoch."""

    def __init__(self, epoch: int) -> None:
        self.first = 10 * epoch

    def __len__(self) -> int:
        return 10

    def __getitem__(self, index: int) -> dict[str, Any]:
        small = np.random.default_rng(index).integers(0, 256, (4, 5, 3), np.uint8)
        file = io.BytesIO()
        Image.fromarray(small).resize((40 + index, 30 + 2 * index)).save(file, "PNG")
        return {"image": file.getvalue(), "label": index % 3, "seed": self.first + index, "name": f"{index}"}


@pytest.mark.parametrize("start", ["fork", "spawn"])
def test_a_loader_s_workers_run_the_pipeline(pipeline: nn.Module, bundle: Path, start: str) -> None:
    augment = Map(bundle, columns={"input": "image"}, outputs={"output": "image_batch"})
    assert augment.num_threads == 1
    method = runtime.open(str(bundle)).method("forward", num_threads=1)
    for epoch in (0, 3):
        data = Photos(epoch)
        loader = DataLoader(
            data, batch_size=4, num_workers=2, collate_fn=augment.collate, multiprocessing_context=start
        )
        batches = list(loader)
        assert [len(batch["label"]) for batch in batches] == [4, 4, 2]
        assert set(batches[0]) == {"label", "name", "image_batch"}
        assert batches[0]["name"] == ["0", "1", "2", "3"]
        assert torch.equal(torch.cat([batch["label"] for batch in batches]), torch.arange(10) % 3)
        images = torch.cat([batch["image_batch"] for batch in batches])
        assert images.dtype == torch.float32 and images.shape == (10, 3, 24, 20)
        for i in range(10):
            decoded = np.asarray(Image.open(io.BytesIO(data[i]["image"]))).transpose(2, 0, 1)[None]
            seed = np.array([10 * epoch + i])
            np.testing.assert_array_equal(images[i], method(np.ascontiguousarray(decoded), seed)[0])
            eager = pipeline.forward(torch.from_numpy(decoded.copy()), torch.from_numpy(seed))[0]
            assert ((images[i] - eager).abs() > 1e-4).float().mean() < 0.01


def test_what_a_loader_gives(bundle: Path) -> None:
    augment = Map(bundle)
    generator = torch.Generator().manual_seed(7)
    images = torch.randint(0, 256, (3, 3, 31, 45), generator=generator, dtype=torch.uint8)
    samples = [{"input": image, "seed": seed} for seed, image in enumerate(images)]
    expected = runtime.open(str(bundle)).method("forward")(images.numpy(), np.arange(3))
    np.testing.assert_allclose(augment.collate(samples)["output"], expected, atol=1e-6)
    with pytest.raises(DataError, match=r"sample 1: expected the columns .*'seed'\], got \['input'\]"):
        augment.collate([samples[0], {"input": images[1]}])
    with pytest.raises(DataError, match="sample 0: expected a dict of columns, got tuple"):
        augment.collate([(images[0], 1)])
    kept = Map(bundle, errors="column").collate([samples[0], {"input": b"no image", "seed": 1}])
    assert kept["error"][0] is None and "not an image" in kept["error"][1]
    assert not kept["output"][1].any()


def test_a_tensor_that_numpy_cannot_read_is_an_error_of_its_row(bundle: Path) -> None:
    photo = torch.zeros(3, 31, 45, dtype=torch.uint8)
    for wrong, why in ((photo.bfloat16(), "BFloat16"), (photo.float().requires_grad_(), "requires grad")):
        samples = [{"input": photo, "seed": 0}, {"input": wrong, "seed": 1}]
        expected = f"row 1: column 'input': expected an array, got Tensor: .*{why}"
        with pytest.raises(DataError, match=expected):
            Map(bundle).collate(samples)
        kept = Map(bundle, errors="column").collate(samples)
        assert kept["error"][0] is None and why in kept["error"][1]


def test_an_order_of_all_needs_no_libtorch(tmp_path: Path) -> None:
    order = {"brightness": (0.5, 1.5), "contrast": (0.5, 1.5), "order": [3, 0, 2, 1]}
    seed = TensorSpec("seed", ("B",), "int64", range=(-(2**62), 2**62))
    spec = Spec("my.jitter", [image(channels=3), seed], config=order, gradients=())
    made = export(random_color_jitter, spec, tmp_path, formats=["native"], methods=["forward"])
    [artifact] = read_manifest(made)["methods"]["forward"]["artifacts"]
    assert artifact["needs"] == []
    x, seeds = torch.rand(3, 3, 9, 11), torch.tensor([5, -7, 2**40])
    result = runtime.open(made).method("forward", backend="native")(x, seeds)
    expected = random_color_jitter(x, seeds, **order)
    torch.testing.assert_close(torch.as_tensor(result), expected, atol=1e-5, rtol=0)
