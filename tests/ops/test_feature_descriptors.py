"""SIFT, orientation and shape of patches against loops in NumPy, OpenCV's SIFT and scenes with known
results."""

import cv2
import numpy as np
import pytest
import torch
from photos import load, photo
from torch import Tensor

from chiasm import feature
from chiasm.filters import gaussian_blur2d


def gradients(patch: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    p = np.pad(patch, 1, "edge")
    dx, dy = (p[1:-1, 2:] - p[1:-1, :-2]) / 2, (p[2:, 1:-1] - p[:-2, 1:-1]) / 2
    return np.hypot(dx, dy), np.arctan2(dy, dx)


def window(size: int, sigma: float) -> np.ndarray:
    r = np.arange(size) - (size - 1) / 2
    return np.exp(-(r[:, None] ** 2 + r**2) / (2 * sigma**2))


def sift_by_votes(patch: np.ndarray, angles: int, places: int, root: bool, clip: float) -> np.ndarray:
    """SIFT in which every pixel votes for its two nearest directions and up to four nearest cells."""
    size = len(patch)
    length, direction = gradients(patch)
    length = length * window(size, size / 2)
    histogram = np.zeros((angles, places, places))
    for i, j in np.ndindex(size, size):
        o = direction[i, j] / (2 * np.pi) * angles
        y, x = (i + 0.5) * places / size - 0.5, (j + 0.5) * places / size - 0.5
        for a in (int(np.floor(o)), int(np.floor(o)) + 1):
            for r in (int(np.floor(y)), int(np.floor(y)) + 1):
                for c in (int(np.floor(x)), int(np.floor(x)) + 1):
                    if 0 <= r < places and 0 <= c < places:
                        histogram[a % angles, r, c] += (
                            length[i, j] * (1 - abs(o - a)) * (1 - abs(y - r)) * (1 - abs(x - c))
                        )
    vector = histogram.ravel() / np.linalg.norm(histogram)
    vector = np.minimum(vector, clip)
    vector = vector / np.linalg.norm(vector)
    return np.sqrt(vector / vector.sum()) if root else vector


@pytest.mark.parametrize(
    ("size", "angles", "places", "root", "clip"),
    [(32, 8, 4, True, 0.2), (17, 6, 3, False, 0.3), (16, 8, 4, False, 0.2)],
)
def test_sift(size: int, angles: int, places: int, root: bool, clip: float) -> None:
    patches = photo(3, 1, size, size, torch.float64)
    described = feature.sift_describe(patches, angles, places, root, clip)
    for n in range(3):
        np.testing.assert_allclose(
            described[n], sift_by_votes(patches[n, 0].numpy(), angles, places, root, clip), atol=1e-12
        )


def blurred_sift(patches: Tensor) -> Tensor:
    return feature.sift_describe(gaussian_blur2d(patches, 21, (41 / 12, 41 / 12)), rootsift=False)


def test_sift_is_as_opencv_describes() -> None:
    """OpenCV describes the image blurred by sigma, in a window of 12 sigma, and rounds to bytes."""
    grey = cv2.cvtColor(load("astronaut.png"), cv2.COLOR_RGB2GRAY)
    sift = cv2.SIFT_create(80, sigma=1.6)
    found = [
        k for k in sift.detect(grey, None) if 4 < k.size < 40 and 60 < k.pt[0] < 450 and 60 < k.pt[1] < 450
    ][:40]
    found, theirs = sift.compute(grey, found)
    # The window has 4 cells of 3 sigma, and the size is 2 sigma; OpenCV's angles are clockwise on the screen.
    xy = torch.tensor([[k.pt for k in found]])
    scale, angle = (
        torch.tensor([[f(k) for k in found]]) for f in (lambda k: 3.0 * k.size, lambda k: -k.angle)
    )
    laf = feature.laf_from_center_scale_ori(xy, scale[..., None, None], angle[..., None])
    ours = feature.get_laf_descriptors(torch.from_numpy(grey)[None, None] / 255.0, laf, blurred_sift, 41)
    converted = feature.convert_sift_descriptor_layout(torch.from_numpy(theirs), "opencv", "kornia")
    alike = torch.nn.functional.cosine_similarity(ours[0], converted)
    assert alike.median() > 0.95, alike
    matches = feature.match_mnn(ours[0], converted / converted.norm(dim=1, keepdim=True))
    assert (
        matches[2].float().mean() > 0.9
        and (matches[1][matches[2]][:, 0] == matches[1][matches[2]][:, 1]).float().mean() > 0.9
    )


def test_layouts() -> None:
    x = torch.rand(5, 6 * 9, generator=torch.Generator().manual_seed(0))
    moved = feature.convert_sift_descriptor_layout(x, "kornia", "vlfeat", 6, 3)
    np.testing.assert_array_equal(moved, x.reshape(5, 6, 9).mT.reshape(5, 54))
    for source in ("kornia", "opencv", "vlfeat"):
        for target in ("kornia", "opencv", "vlfeat"):
            there = feature.convert_sift_descriptor_layout(x, source, target, 6, 3)
            assert torch.equal(feature.convert_sift_descriptor_layout(there, target, source, 6, 3), x)


def test_flat_patches_have_zeros_and_gradients() -> None:
    patches = torch.zeros(2, 1, 16, 16, requires_grad=True)
    described, angle, shape = (
        feature.sift_describe(patches),
        feature.dominant_orientation(patches),
        feature.affine_shape(patches),
    )
    assert (described == 0).all() and (angle == 0).all() and shape.tolist() == [[1, 0, 1]] * 2
    (described.sum() + angle.sum() + shape.sum()).backward()
    assert patches.grad is not None and torch.isfinite(patches.grad).all()


@pytest.mark.parametrize(
    ("batch", "size", "stride", "padding"),
    [(1, 4, 1, 0), (3, 3, 2, 0), (1, 1, 3, 0), (2, 4, 2, 3), (1, 3, 1, 4)],
)
def test_dense_sift(batch: int, size: int, stride: int, padding: int) -> None:
    x = photo(batch, 1, 21, 26, torch.float64)
    described = feature.dense_sift(x, 8, 4, size, False, 0.2, stride, padding)
    shape = [(n + 2 * padding - 4 * size) // stride + 1 for n in (21, 26)]
    assert list(described.shape) == [batch, 128, *shape]
    if padding >= size // 2:
        module = feature.DenseSIFTDescriptor(8, 4, size, False, 0.2, stride, padding - size // 2)
        assert module(x).equal(described)
    for b in range(batch):
        length, direction = gradients(x[b, 0].numpy())
        votes = (
            np.maximum(
                0, 1 - np.abs((direction[None] / (2 * np.pi) * 8 - np.arange(8)[:, None, None] + 4) % 8 - 4)
            )
            * length
        )
        for i, j in ((0, 0), (1, 2), (described.size(2) - 1, described.size(3) - 1)):
            centres = [[s * stride - padding + (k + 0.5) * size - 0.5 for k in range(4)] for s in (i, j)]
            near = [
                [np.maximum(0, 1 - np.abs(np.arange(n) - c) / size) for c in cs]
                for n, cs in zip((21, 26), centres, strict=True)
            ]
            vector = np.einsum("aij,ri,cj->arc", votes, *map(np.array, near)).ravel()
            vector = np.minimum(vector / np.linalg.norm(vector), 0.2)
            np.testing.assert_allclose(described[b, :, i, j], vector / np.linalg.norm(vector), atol=1e-12)


def test_mean_patch() -> None:
    x = photo(2, 3, 8, 8, torch.float64)
    np.testing.assert_allclose(feature.mean_patch(x), x.numpy().mean((2, 3)))


# --- orientation and shape ----------------------------------------------------------------------------------


def orientation_by_votes(patch: np.ndarray) -> float:
    length, direction = gradients(patch)
    length = length * window(len(patch), len(patch) / 6)
    histogram = np.zeros(36)
    for w, o in zip(length.ravel(), direction.ravel() / (2 * np.pi) * 36, strict=True):
        k = int(np.floor(o))
        histogram[k % 36] += w * (k + 1 - o)
        histogram[(k + 1) % 36] += w * (o - k)
    smooth = sum(
        w * np.roll(histogram, s) for w, s in zip(np.array([1, 4, 6, 4, 1]) / 16, range(-2, 3), strict=True)
    )
    k = int(np.argmax(smooth))
    a, b, c = smooth[k - 1], smooth[k], smooth[(k + 1) % 36]
    turn = -2 * np.pi / 36 * (k + 0.5 * (a - c) / (a - 2 * b + c))
    return float((turn + np.pi) % (2 * np.pi) - np.pi)


@pytest.mark.parametrize("size", [15, 32])
def test_orientation(size: int) -> None:
    patches = photo(3, 1, size, size, torch.float64)
    expected = [orientation_by_votes(p[0].numpy()) for p in patches]
    np.testing.assert_allclose(feature.dominant_orientation(patches), expected, atol=1e-12)


def wedge() -> Tensor:
    """A smooth image whose gradient at the centre points along x."""
    grid = torch.arange(101, dtype=torch.float64) - 50
    return torch.sigmoid((grid + 0.004 * grid[:, None] ** 2) / 6.0)[None, None]


def test_orientation_follows_the_frame() -> None:
    angles = torch.tensor([[[0.0], [37.0], [-100.0], [175.0]]], dtype=torch.float64)
    laf = feature.laf_from_center_scale_ori(
        torch.full([1, 4, 2], 50.0).double(), torch.full([1, 4, 1, 1], 20.0), angles
    )
    oriented = feature.orient_laf(laf, wedge())
    assert feature.get_laf_orientation(oriented).abs().max() < 2.0
    patches = feature.extract_patches_from_pyramid(wedge(), oriented, 32).flatten(0, 1)
    assert torch.rad2deg(feature.dominant_orientation(patches)).abs().max() < 2.0


def test_shape() -> None:
    patches = photo(3, 1, 19, 19, torch.float64)
    for patch, found in zip(patches[:, 0].numpy(), feature.affine_shape(patches), strict=True):
        length, direction = gradients(patch)
        dx, dy, w = length * np.cos(direction), length * np.sin(direction), window(19, 19 / 6)
        moments = np.array([(dx * dx * w).sum(), (dx * dy * w).sum(), (dy * dy * w).sum()])
        np.testing.assert_allclose(found, moments / max(moments[0], moments[2]), atol=1e-12)


@pytest.mark.parametrize("batch", [1, 3])
def test_adaptation_finds_the_shape_of_a_blob(batch: int) -> None:
    """A stretched and rotated Gaussian: the adapted ellipse has its axes."""
    grid = torch.arange(129, dtype=torch.float64) - 64
    turn = torch.tensor([[0.8, -0.6], [0.6, 0.8]], dtype=torch.float64)
    covariance = turn @ torch.diag(torch.tensor([400.0, 150.0], dtype=torch.float64)) @ turn.mT
    x, y = grid.expand(129, 129), grid[:, None].expand(129, 129)
    inverse = torch.linalg.inv(covariance)
    blob = torch.exp(-0.5 * (inverse[0, 0] * x * x + 2 * inverse[0, 1] * x * y + inverse[1, 1] * y * y))
    laf = torch.tensor([[20.0, 0.0, 64.0], [0.0, 20.0, 64.0]], dtype=torch.float64).expand(batch, 1, 2, 3)
    adapted = feature.adapt_laf_shape(laf, blob.expand(batch, 1, 129, 129), 32, 10)
    shape = adapted[0, 0, :, :2] @ adapted[0, 0, :, :2].mT
    torch.testing.assert_close(
        shape / torch.linalg.det(shape) ** 0.5,
        covariance / torch.linalg.det(covariance) ** 0.5,
        rtol=0.05,
        atol=0.05,
    )
    torch.testing.assert_close(feature.get_laf_scale(adapted), feature.get_laf_scale(laf))
    torch.testing.assert_close(adapted[..., 2], laf[..., 2])


PATCH, IMAGE, FRAME = torch.zeros(1, 1, 8, 8), torch.zeros(1, 1, 16, 16), torch.zeros(1, 2, 2, 3)
WRONG = [
    (
        lambda: feature.sift_describe(PATCH[..., :7]),
        ValueError,
        r"patches: expected shape \(N, 1, PS, PS\), got \[1, 1, 8, 7\]",
    ),
    (
        lambda: feature.sift_describe(PATCH, 8, 9),
        ValueError,
        r"patches: expected at least 9 x 9 pixels, got \[1, 1, 8, 8\]",
    ),
    (lambda: feature.sift_describe(PATCH, 1), ValueError, "num_ang_bins: expected at least 2, got 1"),
    (lambda: feature.sift_describe(PATCH, 8, 0), ValueError, "num_spatial_bins: expected a positive number"),
    (lambda: feature.sift_describe(PATCH, clipval=0.0), ValueError, "clipval: expected a positive number"),
    (
        lambda: feature.dense_sift(IMAGE.expand(1, 3, 16, 16)),
        ValueError,
        r"input: expected shape \(B, 1, H, W\)",
    ),
    (lambda: feature.dense_sift(IMAGE, padding=-1), ValueError, "padding: expected a number >= 0, got -1"),
    (
        lambda: feature.dense_sift(IMAGE, stride=0),
        ValueError,
        "spatial_bin_size, stride: expected positive numbers, got 4 and 0",
    ),
    (lambda: feature.mean_patch(PATCH[0]), ValueError, "patches: expected shape"),
    (
        lambda: feature.convert_sift_descriptor_layout(torch.zeros(128), "lowe", "opencv"),
        ValueError,
        "source: expected one of",
    ),
    (
        lambda: feature.convert_sift_descriptor_layout(torch.zeros(127), "opencv", "opencv"),
        ValueError,
        r"descriptors: expected shape \(\*, 128\)",
    ),
    (
        lambda: feature.dominant_orientation(PATCH, 4),
        ValueError,
        "num_angular_bins: expected at least 5, got 4",
    ),
    (lambda: feature.affine_shape(PATCH.int()), TypeError, "patches: expected a floating-point tensor"),
    (lambda: feature.orient_laf(FRAME[0], IMAGE), ValueError, "laf: expected shape"),
    (
        lambda: feature.adapt_laf_shape(FRAME, IMAGE, 8, 0),
        ValueError,
        "iterations: expected a positive number, got 0",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
