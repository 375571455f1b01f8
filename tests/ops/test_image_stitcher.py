"""Panoramas of parts of a photograph that OpenCV has cut and warped: the photograph again."""

from typing import Any

import cv2
import numpy as np
import pytest
import torch
from photos import load
from torch import Tensor, nn

from chiasm.contrib import ImageStitcher
from chiasm.feature import LocalFeatureMatcher, SIFTFeature

WHOLE: Any = cv2.resize(load("astronaut.png"), (360, 240), interpolation=cv2.INTER_AREA)
#: From the photograph's pixels to those of the part on the right.
SEEN = np.array([[1.02, 0.03, -140.0], [-0.02, 1.01, 2.0], [1e-4, 2e-5, 1.0]])


def tensor(image: np.ndarray) -> Tensor:
    return torch.from_numpy(np.ascontiguousarray(image)).permute(2, 0, 1)[None].float() / 255.0


class Known(nn.Module):
    """A matcher that knows where points of the photograph are."""

    def __init__(self, count: int = 40) -> None:
        super().__init__()
        self.count = count

    def forward(self, left: Tensor, right: Tensor) -> tuple[Tensor, ...]:
        points = torch.rand(left.size(0), self.count, 2, generator=torch.Generator().manual_seed(1))
        points = points * torch.tensor([80.0, 230.0]) + torch.tensor([145.0, 5.0])
        moved = cv2.perspectiveTransform(points.reshape(1, -1, 2).numpy(), SEEN).reshape(points.shape)
        valid = torch.ones(points.shape[:2], dtype=torch.bool)
        return points, torch.from_numpy(moved), valid, valid, points, points


def parts() -> tuple[Tensor, Tensor]:
    right = cv2.warpPerspective(WHOLE, SEEN, (230, 240), flags=cv2.INTER_CUBIC)
    return tensor(WHOLE[:, :240]), tensor(right)


@pytest.mark.parametrize("estimator", ["ransac", "vanilla"])
def test_two_parts_give_the_photograph(estimator: str) -> None:
    torch.manual_seed(0)
    panorama = ImageStitcher(Known(), estimator)(*parts())
    assert panorama.shape[:3] == (1, 3, 240) and 340 < panorama.size(3) < 470
    width = min(panorama.size(3), 360)
    apart = (panorama[..., :width] - tensor(WHOLE)[..., :width]).abs()[..., 8:-8, : width - 20]
    assert apart.mean() < 0.01
    assert panorama[..., :100].equal(tensor(WHOLE)[..., :100])  # what only the left part shows


def test_features_find_the_homography() -> None:
    torch.manual_seed(0)
    left, right = parts()
    matcher = LocalFeatureMatcher(SIFTFeature(800), "smnn")
    panorama = ImageStitcher(matcher)(left, right)
    apart = (panorama[..., :330] - tensor(WHOLE)[..., :330]).abs()[..., 8:-8, :]
    assert apart.mean() < 0.015


def test_each_sample_has_its_own_and_a_third_image_goes_on() -> None:
    class Shifted(nn.Module):
        """The next part begins 100 pixels after the one before, and 10 later in the second sample."""

        calls = 0

        def forward(self, left: Tensor, right: Tensor) -> tuple[Tensor, ...]:
            self.calls += 1
            points = torch.tensor([[0.0, 0.0], [50.0, 0.0], [0.0, 90.0], [60.0, 80.0]]).expand(2, 4, 2)
            begin = torch.tensor([100.0, 110.0])[:, None, None] * torch.tensor([1.0, 0.0]) * self.calls
            valid = torch.ones(2, 4, dtype=torch.bool)
            return points + begin, points, valid, valid, points, points

    image = tensor(WHOLE)
    cuts = [torch.cat([image[..., k * at : k * at + 120] for at in (100, 110)]) for k in range(3)]
    panorama = ImageStitcher(Shifted(), "vanilla")(*cuts)
    assert panorama.shape == (2, 3, 240, 340)
    torch.testing.assert_close(panorama[:1, ..., :320], image[..., :320], atol=2e-3, rtol=0)
    torch.testing.assert_close(panorama[1:], image[..., :340], atol=2e-3, rtol=0)
    assert (panorama[0, ..., 320:] == 0).all()


def test_what_is_refused() -> None:
    left, right = parts()
    stitch = ImageStitcher(Known(3))
    for message, call in {
        "expected at least 4 matches between neighbours, got 3 for sample 0": lambda: stitch(left, right),
        r"imgs: expected shape \(1, 3, 240, W\), got": lambda: stitch(left, right[:, :, :200]),
        "imgs: expected at least one image": lambda: stitch(),
        "estimator: expected one of": lambda: ImageStitcher(Known(), "lmeds"),
        "blending_method: expected": lambda: ImageStitcher(Known(), "ransac", "linear"),
    }.items():
        with pytest.raises(ValueError, match=message):
            call()
    with pytest.raises(TypeError, match="imgs: expected a floating-point tensor"):
        stitch((left * 255).byte())
