"""Patches of local affine frames against SciPy's interpolation, and aliasing."""

import numpy as np
import pytest
import scipy.ndimage as ndi
import torch
from photos import photo
from torch import Tensor, nn

from chiasm import feature
from chiasm.export.catalog.feature_frames import frames


def regions(batch: int, largest: float) -> Tensor:
    return frames(torch.Generator().manual_seed(1), {"B": batch, "N": 9, "H": 61, "W": 83}, largest)


def positions(laf: np.ndarray, size: int) -> np.ndarray:
    """(2, PS, PS): x and y."""
    side = (2 * np.arange(size) + 1) / size - 1
    u, v = np.meshgrid(side, side)
    return laf[:, 0, None, None] * u + laf[:, 1, None, None] * v + laf[:, 2, None, None]


def halved(plane: np.ndarray) -> np.ndarray:
    plane, taps = np.pad(plane, ((0, 1), (0, 1)), "edge"), np.array([1, 4, 6, 4, 1]) / 16
    for axis in (0, 1):
        plane = ndi.correlate1d(plane, taps, axis, mode="nearest")
    return plane[::2, ::2]


@pytest.mark.parametrize(("batch", "size"), [(1, 11), (3, 16)])
def test_simple(batch: int, size: int) -> None:
    img, laf = photo(batch, 2, 61, 83, torch.float64), regions(batch, 12.0)
    patches = feature.extract_patches_simple(img, laf, size)
    assert patches.shape == (batch, 9, 2, size, size)
    for b in range(batch):
        for n in range(9):
            x, y = positions(laf[b, n].numpy(), size)
            for c in range(2):
                expected = ndi.map_coordinates(img[b, c].numpy(), [y, x], order=1, mode="nearest")
                np.testing.assert_allclose(patches[b, n, c], expected, atol=1e-10)
    normal = feature.normalize_laf(laf, img)
    torch.testing.assert_close(feature.extract_patches_simple(img, normal, size, False), patches)


@pytest.mark.parametrize(("batch", "size"), [(1, 5), (3, 8)])
def test_pyramid(batch: int, size: int) -> None:
    img, laf = photo(batch, 2, 61, 83, torch.float64), regions(batch, 60.0)
    patches = feature.extract_patches_from_pyramid(img, laf, size)
    chosen = set()
    for b in range(batch):
        for n in range(9):
            step = 2 * np.sqrt(np.abs(np.linalg.det(laf[b, n, :, :2].numpy()))) / size
            level = int(np.clip(np.floor(np.log2(step)), 0, 5))
            chosen.add(level)
            x, y = positions(laf[b, n].numpy(), size) / 2**level
            for c in range(2):
                plane = img[b, c].numpy()
                for _ in range(level):
                    plane = halved(plane)
                np.testing.assert_allclose(
                    patches[b, n, c], ndi.map_coordinates(plane, [y, x], order=1, mode="nearest"), atol=1e-10
                )
    assert len(chosen) > 2
    normal = feature.normalize_laf(laf, img)
    torch.testing.assert_close(feature.extract_patches_from_pyramid(img, normal, size, False), patches)


@pytest.mark.parametrize("size", [(1, 1), (2, 7), (5, 3)])
def test_small_images_have_a_pyramid(size: tuple[int, int]) -> None:
    patches = feature.extract_patches_from_pyramid(torch.full([1, 1, *size], 0.5), regions(1, 60.0), 4)
    torch.testing.assert_close(patches, torch.full_like(patches, 0.5))


def test_pyramid_removes_what_would_alias() -> None:
    """A large frame on fine stripes has their mean; without the pyramid, it has aliases."""
    stripes = (torch.arange(400) % 3 == 0).float().expand(1, 1, 400, 400)
    laf = torch.tensor([[[[150.0, 20.0, 200.0], [-20.0, 150.0, 200.0]]]])
    simple, smooth = (
        feature.extract_patches_simple(stripes, laf, 32),
        feature.extract_patches_from_pyramid(stripes, laf, 32),
    )
    assert simple.std() > 0.3 and smooth.std() < 0.01
    assert abs(float(smooth.mean()) - 1 / 3) < 0.01


def test_turned_frames_turn_patches() -> None:
    """A quarter turn of the frame moves whole pixels."""
    img = photo(1, 1, 61, 83, torch.float64)
    laf = torch.tensor([[[[9.0, 0.0, 40.0], [0.0, 9.0, 30.0]]]], dtype=torch.float64)
    upright = feature.extract_patches_simple(img, laf, 12)
    turned = feature.extract_patches_simple(img, feature.rotate_laf(laf, torch.full([1, 1, 1], 90.0)), 12)
    torch.testing.assert_close(turned, upright.rot90(-1, (-2, -1)))


def test_broken_frames_read_something() -> None:
    laf = torch.full([1, 2, 2, 3], float("nan"))
    laf[0, 1] = 1e30
    assert feature.extract_patches_from_pyramid(torch.rand(1, 1, 20, 20), laf, 4).shape == (1, 2, 1, 4, 4)


def test_descriptors_are_pluggable() -> None:
    img, laf = photo(2, 3, 61, 83), regions(2, 12.0).float()
    grey = feature.get_laf_descriptors(img, laf, nn.Flatten(), 8)
    assert grey.shape == (2, 9, 64)
    assert feature.get_laf_descriptors(img, laf, nn.Flatten(), 8, False).shape == (2, 9, 192)
    module = feature.LAFDescriptor(nn.Flatten(), 8)
    torch.testing.assert_close(module(img, laf), grey)
    torch.testing.assert_close(torch.jit.script(module)(img, laf), grey)


IMAGE, FRAME = torch.zeros(1, 1, 8, 8), torch.zeros(1, 2, 2, 3)
WRONG = [
    (lambda: feature.extract_patches_simple(IMAGE[0], FRAME), ValueError, "img: expected shape"),
    (
        lambda: feature.extract_patches_simple(IMAGE, FRAME, 0),
        ValueError,
        "PS: expected a positive number, got 0",
    ),
    (
        lambda: feature.extract_patches_from_pyramid(IMAGE, FRAME.expand(2, -1, -1, -1)),
        ValueError,
        "laf: expected img's batch of 1",
    ),
    (lambda: feature.get_laf_descriptors(IMAGE, FRAME[0], nn.Flatten()), ValueError, "lafs: expected shape"),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
