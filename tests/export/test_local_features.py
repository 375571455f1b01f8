"""A user's own detector and descriptor in chiasm's modules: together they script, and export to one
bundle."""

from pathlib import Path
from typing import Tuple

import numpy as np
import onnxruntime
import pytest
import torch
import torch.nn.functional as F
from torch import Tensor, nn

from chiasm.export import Spec, TensorSpec, export
from chiasm.export.catalog.feature_detection import blobs
from chiasm.feature import LAFDescriptor, LocalFeature, LocalFeatureMatcher, match_adalam


class Corners(nn.Module):
    """Harris corners at one scale."""

    def __init__(self, count: int) -> None:
        super().__init__()
        self.count = count

    def forward(self, img: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
        dx, dy = img[:, :, 1:-1, 2:] - img[:, :, 1:-1, :-2], img[:, :, 2:, 1:-1] - img[:, :, :-2, 1:-1]
        a, b, c = (
            F.avg_pool2d(dx * dx, 5, 1, 2),
            F.avg_pool2d(dx * dy, 5, 1, 2),
            F.avg_pool2d(dy * dy, 5, 1, 2),
        )
        response = a * c - b * b - 0.05 * (a + c) * (a + c)
        peak = (response == F.max_pool2d(response, 7, 1, 3)) & (response > 1e-7)
        scores, index = torch.topk(
            torch.where(peak, response, torch.zeros_like(response)).flatten(1), self.count
        )
        valid = scores > 0
        width = response.size(3)
        row = index // width  # a remainder by a size has no ONNX form
        x, y = (index - row * width + 1).to(img.dtype), (row + 1).to(img.dtype)
        size, zero = torch.full_like(x, 6.0), torch.zeros_like(x)
        lafs = torch.stack([torch.stack([size, zero, x], -1), torch.stack([zero, size, y], -1)], -2)
        return torch.where(valid[..., None, None], lafs, torch.zeros_like(lafs)), scores, valid


class Network(nn.Module):
    """A descriptor of patches, with weights."""

    def __init__(self) -> None:
        super().__init__()
        torch.manual_seed(0)
        self.first, self.second, self.last = nn.Conv2d(1, 8, 3, 2), nn.Conv2d(8, 16, 3, 2), nn.Linear(144, 24)

    def forward(self, patches: Tensor) -> Tensor:
        patches = patches - patches.mean([1, 2, 3], keepdim=True)
        return F.normalize(self.last(self.second(self.first(patches).relu()).relu().flatten(1)), dim=1)


class Nearest(nn.Module):
    """A matcher."""

    def forward(
        self, desc1: Tensor, desc2: Tensor, lafs1: Tensor, lafs2: Tensor, mask1: Tensor, mask2: Tensor
    ) -> Tuple[Tensor, Tensor, Tensor]:
        far = (desc1[:, :, None] - desc2[:, None]).pow(2).sum(-1)
        far = torch.where(mask2[:, None], far, torch.full_like(far, 9.0))
        distance, index = far.min(2)
        own = torch.arange(index.size(1), device=index.device).expand_as(index)
        return distance[..., None], torch.stack([own, index], -1), mask1 & (distance < 0.01)


class Verified(nn.Module):
    """A matcher: one of chiasm's, with settings for few key points."""

    def forward(
        self, desc1: Tensor, desc2: Tensor, lafs1: Tensor, lafs2: Tensor, mask1: Tensor, mask2: Tensor
    ) -> Tuple[Tensor, Tensor, Tensor]:
        return match_adalam(
            desc1, desc2, lafs1, lafs2, area_ratio=5.0, min_inliers=4, mask1=mask1, mask2=mask2
        )


NAMES = ("points1", "points2", "distances", "valid", "lafs1", "lafs2")
SIZES = {"H": (24, 4096), "W": (24, 4096), "OH": (24, 4096), "OW": (24, 4096)}
VIEWS = [
    TensorSpec("img1", ("B", 1, "H", "W"), layout="NCHW"),
    TensorSpec("img2", ("B", 1, "OH", "OW"), layout="NCHW"),
]


def views(batch: int, height: int, width: int, seed: int = 0) -> list[Tensor]:
    """Two images of the same blobs, of different sizes."""
    return blobs(
        torch.Generator().manual_seed(seed),
        batch,
        [(height, width, 0), (height + 7, width + 3, 5)],
        torch.float32,
    )


def sample(generator: torch.Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    first, second = blobs(
        generator, sizes["B"], [(sizes["H"], sizes["W"], 0), (sizes["OH"], sizes["OW"], 5)], dtype
    )
    return {"img1": first, "img2": second}


@pytest.mark.parametrize("matcher", ["smnn", Verified(), Nearest()], ids=["smnn", "adalam", "own"])
def test_a_users_modules_are_one_bundle(tmp_path: Path, matcher: str | nn.Module) -> None:
    module = LocalFeatureMatcher(LocalFeature(Corners(40), LAFDescriptor(Network(), 16)), matcher).eval()
    spec = Spec("my.matches", VIEWS, [TensorSpec(name) for name in NAMES], symbols=SIZES, make_inputs=sample)
    bundle = export(module, spec, tmp_path, formats=["torchscript", "onnx"], methods=("forward",))
    scripted = torch.jit.load(bundle / "forward.pt")
    session = onnxruntime.InferenceSession(
        bundle / "forward.float32.onnx", providers=["CPUExecutionProvider"]
    )
    assert [o.name for o in session.get_outputs()] == list(NAMES)
    matched = 0
    for batch, height, width in ((1, 96, 121), (3, 70, 64), (2, 150, 43)):
        images = views(batch, height, width)
        with torch.no_grad():
            expected = module(*images)
            found = scripted(*images)
        assert [tuple(t.shape) for t in expected] == [
            (batch, 40, 2),
            (batch, 40, 2),
            (batch, 40),
            (batch, 40),
            (batch, 40, 2, 3),
            (batch, 40, 2, 3),
        ]
        by_onnx = session.run(None, {"img1": images[0].numpy(), "img2": images[1].numpy()})
        for e, t, o in zip(expected, found, by_onnx, strict=True):
            torch.testing.assert_close(t, e)
            np.testing.assert_allclose(o, e.numpy(), rtol=1e-4, atol=2e-5)
        points1, points2, _, valid = expected[:4]
        matched += int(((points1 - points2)[valid] == torch.tensor([5.0, 0.0])).all(-1).sum())
    assert matched > 20


def test_frames_and_descriptors_are_one_bundle(tmp_path: Path) -> None:
    module = LocalFeature(Corners(20), LAFDescriptor(Network(), 16)).eval()
    names = ("lafs", "scores", "valid", "descriptors")
    spec = Spec(
        "my.features",
        [TensorSpec("img", ("B", 1, "H", "W"), layout="NCHW")],
        [TensorSpec(name) for name in names],
        symbols=SIZES,
    )
    bundle = export(module, spec, tmp_path, formats=["torchscript", "onnx"], methods=("forward",))
    session = onnxruntime.InferenceSession(
        bundle / "forward.float32.onnx", providers=["CPUExecutionProvider"]
    )
    for batch, height, width in ((1, 96, 121), (3, 30, 64)):
        image = views(batch, height, width)[0]
        with torch.no_grad():
            expected = module(image)
        assert expected[3].shape == (batch, 20, 24) and expected[2].any()
        for e, t, o in zip(
            expected,
            torch.jit.load(bundle / "forward.pt")(image),
            session.run(None, {"img": image.numpy()}),
            strict=True,
        ):
            torch.testing.assert_close(t, e)
            np.testing.assert_allclose(o, e.numpy(), rtol=1e-4, atol=2e-5)
