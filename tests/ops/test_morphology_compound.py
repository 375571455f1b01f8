"""Erosion and ops composed of it, reconstruction, patterns and skeletons, against SciPy, OpenCV and
scikit-image."""

import cv2
import numpy as np
import pytest
import scipy.ndimage as ndi
import skimage.morphology as skm
import torch
from photos import chw, hwc, load, photo
from torch import Tensor

from chiasm.morphology import (
    bottom_hat,
    closing,
    dilation,
    erosion,
    gradient,
    hit_or_miss,
    max_filter2d,
    min_filter2d,
    opening,
    reconstruction,
    skeletonize,
    thin,
    top_hat,
)

KERNELS = {
    "box": np.ones((3, 3)),
    "cross": np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]]),
    "lopsided": np.array([[1, 1, 0, 0, 0], [0, 1, 1, 0, 0], [0, 0, 1, 0, 1]]),
    "even": np.array([[1, 0, 1, 1], [1, 1, 1, 0]]),
}
SCIPY_MODE = {"reflect": "mirror", "replicate": "nearest", "circular": "wrap", "constant": "constant"}
COMPOUND = {
    "erosion": (erosion, ndi.grey_erosion, None),
    "opening": (opening, ndi.grey_opening, cv2.MORPH_OPEN),
    "closing": (closing, ndi.grey_closing, cv2.MORPH_CLOSE),
    "top_hat": (top_hat, ndi.white_tophat, cv2.MORPH_TOPHAT),
    "bottom_hat": (bottom_hat, ndi.black_tophat, cv2.MORPH_BLACKHAT),
    "gradient": (gradient, ndi.morphological_gradient, cv2.MORPH_GRADIENT),
}
X = torch.zeros(1, 3, 8, 8)
BYTES = torch.zeros(1, 3, 8, 8, dtype=torch.uint8)
BOX = torch.ones(3, 3)


def per_plane(x: Tensor, function: object) -> np.ndarray:
    planes = x.numpy().reshape(-1, *x.shape[2:])
    return np.stack([function(p) for p in planes]).reshape(x.shape)


# For even sizes, Kornia's dilation, unlike SciPy's, uses the same window as its erosion.
@pytest.mark.parametrize(
    ("name", "kernel"), [(n, k) for n in COMPOUND for k in KERNELS if (n, k) != ("gradient", "even")]
)
@pytest.mark.parametrize("border", SCIPY_MODE)
@pytest.mark.parametrize("flat", [True, False])
def test_equals_scipy(name: str, kernel: str, border: str, flat: bool) -> None:
    op, reference, _ = COMPOUND[name]
    footprint = KERNELS[kernel]
    x = photo(2, 7, 12, 17, torch.float64)
    heights = None if flat else np.linspace(-0.2, 0.3, footprint.size).reshape(footprint.shape)
    arguments = (torch.from_numpy(footprint).double(), None if heights is None else torch.from_numpy(heights))
    actual = op(x, *arguments, border_type=border, border_value=0.4)
    expected = per_plane(
        x, lambda p: reference(p, footprint=footprint, structure=heights, mode=SCIPY_MODE[border], cval=0.4)
    )
    np.testing.assert_allclose(actual, expected, atol=1e-12)


@pytest.mark.parametrize("name", ["erosion", "opening", "closing"])
@pytest.mark.parametrize("origin", [[0, 0], [2, 0], [1, 4]])
def test_origin_equals_scipy(name: str, origin: list[int]) -> None:
    op, reference, _ = COMPOUND[name]
    footprint = KERNELS["lopsided"]
    x = photo(1, 3, 14, 13, torch.float64)
    first = (origin[0] - 1, origin[1] - 2)  # SciPy counts from the centre
    if name == "erosion":
        expected = per_plane(x, lambda p: reference(p, footprint=footprint, mode="nearest", origin=first))
    else:
        # SciPy's grey_opening has no origin
        order = (
            [ndi.grey_erosion, ndi.grey_dilation]
            if name == "opening"
            else [ndi.grey_dilation, ndi.grey_erosion]
        )
        expected = x.numpy()
        for step in order:
            expected = per_plane(
                torch.from_numpy(expected),
                lambda p, step=step: step(p, footprint=footprint, mode="nearest", origin=first),
            )
    np.testing.assert_array_equal(
        op(x, torch.from_numpy(footprint), origin=origin, border_type="replicate"), expected
    )


@pytest.mark.parametrize("name", [n for n in COMPOUND if COMPOUND[n][2] is not None])
@pytest.mark.parametrize("kernel", ["box", "cross"])
@pytest.mark.parametrize("shape", [(1, 1, 23, 31), (2, 3, 16, 17), (3, 5, 9, 30)])
def test_geodesic_equals_opencv(name: str, kernel: str, shape: tuple[int, ...]) -> None:
    x = photo(*shape)
    op, _, code = COMPOUND[name]
    for b in range(shape[0]):
        expected = cv2.morphologyEx(hwc(x, b), code, KERNELS[kernel].astype(np.uint8))
        np.testing.assert_array_equal(op(x, torch.from_numpy(KERNELS[kernel]))[b], chw(expected))


@pytest.mark.parametrize("kernel", KERNELS.values(), ids=KERNELS)
def test_geodesic_erosion_equals_opencv(kernel: np.ndarray) -> None:
    x = photo(2, 3, 16, 17)
    for b in range(2):
        np.testing.assert_array_equal(
            erosion(x, torch.from_numpy(kernel))[b], chw(cv2.erode(hwc(x, b), kernel.astype(np.uint8)))
        )


def test_opening_never_exceeds_the_image() -> None:
    x = photo(1, 1, 30, 31)
    for origin in (None, [0, 0], [1, 3]):
        element = torch.from_numpy(KERNELS["even"])
        assert torch.all(opening(x, element, origin=origin) <= x) and torch.all(
            closing(x, element, origin=origin) >= x
        )


@pytest.mark.parametrize("border", SCIPY_MODE)
@pytest.mark.parametrize("size", [(1, 1), (3, 3), (5, 9), (1, 7), (15, 13)])
def test_extreme_filters_equal_scipy(size: tuple[int, int], border: str) -> None:
    x = photo(2, 7, 17, 22)
    for op, reference in ((max_filter2d, ndi.maximum_filter), (min_filter2d, ndi.minimum_filter)):
        np.testing.assert_array_equal(
            op(x, size, border), per_plane(x, lambda p, f=reference: f(p, size, mode=SCIPY_MODE[border]))
        )
    np.testing.assert_array_equal(max_filter2d(x, size), dilation(x, torch.ones(size)))


# --- reconstruction -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["dilation", "erosion"])
@pytest.mark.parametrize("kernel", [None, KERNELS["cross"]])
def test_reconstruction_equals_skimage(method: str, kernel: np.ndarray | None) -> None:
    mask = photo(3, 5, 41, 33, torch.float64)
    seed = mask - 0.15 if method == "dilation" else mask + 0.15
    seed[:, :, 8:20] = 0.0 if method == "dilation" else 1.0
    actual = reconstruction(seed, mask, None if kernel is None else torch.from_numpy(kernel), method)
    footprint = np.ones((3, 3)) if kernel is None else kernel
    for b, c in np.ndindex(3, 5):
        np.testing.assert_array_equal(
            actual[b, c], skm.reconstruction(seed[b, c].numpy(), mask[b, c].numpy(), method, footprint)
        )
    assert not torch.equal(actual, reconstruction(seed, mask, None, method, 3))


def test_reconstruction_steps() -> None:
    mask = torch.ones(1, 1, 1, 9)
    seed = torch.zeros(1, 1, 1, 9)
    seed[..., 2] = 0.5
    assert reconstruction(seed, mask, num_iters=3)[0, 0, 0].tolist() == [0.5] * 6 + [0.0] * 3
    assert reconstruction(2.0 * mask, mask, num_iters=0).equal(mask)


def test_reconstruction_ends_in_spite_of_nan() -> None:
    mask = torch.ones(1, 1, 5, 9)
    mask[0, 0, 2, 4] = torch.nan
    assert reconstruction(0.5 * mask, mask).isnan().any()


def test_reconstruction_gradient() -> None:
    mask = photo(1, 1, 7, 8, torch.float64).requires_grad_(True)
    seed = (mask.detach() - 0.1).requires_grad_(True)
    assert torch.autograd.gradcheck(lambda s, m: reconstruction(s, m), [seed, mask], fast_mode=True)


# --- binary shapes ------------------------------------------------------------------------------------------


def shapes() -> list[np.ndarray]:
    generator = np.random.default_rng(0)
    grey = load("coffee.png").mean(2)
    return [
        grey[40:140, 100:231] > 110,
        grey[140:231, 200:331] < 90,
        generator.random((61, 70)) < 0.6,
        ndi.binary_dilation(generator.random((90, 81)) < 0.02, iterations=3),
        np.ones((23, 40), bool),
    ]


def as_batch(image: np.ndarray) -> Tensor:
    return torch.from_numpy(np.stack([[image, ~image], [image[::-1], image[:, ::-1]]]).astype(np.float32))


@pytest.mark.parametrize("index", range(5))
def test_thin_equals_skimage(index: int) -> None:
    x = as_batch(shapes()[index])
    np.testing.assert_array_equal(thin(x), per_plane(x, lambda p: skm.thin(p > 0)))
    np.testing.assert_array_equal(thin(x, 2), per_plane(x, lambda p: skm.thin(p > 0, 2)))


def zhang_suen_by_definition(image: np.ndarray) -> np.ndarray:
    """The paper's conditions, pixel by pixel: P2 is north, then clockwise to P9."""
    p = np.pad(image.astype(int), 1)
    changed = True
    while changed:
        changed = False
        for first in (True, False):
            deleted = []
            for i, j in zip(*np.nonzero(p), strict=True):
                p2, p3, p4, p5, p6, p7, p8, p9 = (
                    p[i + u, j + v]
                    for u, v in ((-1, 0), (-1, 1), (0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1))
                )
                ring = [p2, p3, p4, p5, p6, p7, p8, p9, p2]
                a = sum(ring[n] == 0 and ring[n + 1] == 1 for n in range(8))
                c, d = (p2 * p4 * p6, p4 * p6 * p8) if first else (p2 * p4 * p8, p2 * p6 * p8)
                if 2 <= sum(ring[:8]) <= 6 and a == 1 and c == 0 and d == 0:
                    deleted.append((i, j))
            for i, j in deleted:
                p[i, j] = 0
            changed = changed or bool(deleted)
    return p[1:-1, 1:-1]


@pytest.mark.parametrize("index", [1, 2, 3, 4])
def test_skeletonize_by_definition(index: int) -> None:
    image = shapes()[index][:50, :60]
    actual = skeletonize(torch.from_numpy(image[None, None]).double())[0, 0].numpy()
    np.testing.assert_array_equal(actual, zhang_suen_by_definition(image))
    assert actual.sum() < image.sum()


def test_skeleton_lies_near_that_of_skimage() -> None:
    image = shapes()[3]
    actual = skeletonize(torch.from_numpy(image[None, None]).float())[0, 0].numpy() > 0
    other = skm.skeletonize(image, method="zhang")
    for a, b in ((actual, other), (other, actual)):
        assert ndi.distance_transform_edt(~b)[a].max() < 3.0


def signed(hit: np.ndarray, miss: np.ndarray) -> np.ndarray:
    """The pattern in OpenCV's form."""
    return hit.astype(np.int32) - miss.astype(np.int32)


@pytest.mark.parametrize("index", range(4))
def test_hit_or_miss(index: int) -> None:
    hit = np.array([[0, 1, 0], [0, 1, 1], [0, 0, 0]])
    miss = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0]])
    x = as_batch(shapes()[index])
    framed = torch.nn.functional.pad(x, (2, 2, 2, 2))  # 0 outside for the other libraries too
    inside = np.s_[..., 2:-2, 2:-2]
    expected = per_plane(framed, lambda p: ndi.binary_hit_or_miss(p > 0, hit, miss))[inside]
    actual = hit_or_miss(x, torch.from_numpy(hit), torch.from_numpy(miss))
    np.testing.assert_array_equal(actual, expected)
    opencv = per_plane(
        framed, lambda p: cv2.morphologyEx((p > 0).astype(np.uint8), cv2.MORPH_HITMISS, signed(hit, miss))
    )[inside]
    np.testing.assert_array_equal(actual, opencv)
    assert 0 < actual.sum() < actual.numel()
    wide = np.array([[1, 1, 1, 0]])
    expected = per_plane(framed, lambda p: ndi.binary_hit_or_miss(p > 0, wide))[inside]
    np.testing.assert_array_equal(hit_or_miss(x, torch.from_numpy(wide)), expected)


WRONG = [
    (lambda: erosion(X, torch.ones(3)), ValueError, r"kernel: expected shape \(kh, kw\), got \[3\]"),
    (lambda: opening(BYTES.long(), BOX), TypeError, "tensor: expected a floating-point, uint8, int16 or"),
    (lambda: closing(X, BOX, torch.ones(3, 2)), ValueError, "structuring_element: expected"),
    (lambda: top_hat(X, BOX, origin=[0, 3]), ValueError, r"origin: .* got \[0, 3\]"),
    (lambda: bottom_hat(X, BOX, border_type="none"), ValueError, "border_type: expected"),
    (lambda: gradient(X[0], BOX), ValueError, "tensor: expected shape"),
    (lambda: max_filter2d(X, 4), ValueError, r"kernel_size: expected odd .* got \(4, 4\)"),
    (lambda: min_filter2d(X, 3, "geodesic"), ValueError, "border_type: expected"),
    (lambda: reconstruction(X, X[:, :1]), ValueError, "mask: expected seed's shape"),
    (lambda: reconstruction(X, X, method="opening"), ValueError, "method: expected one of"),
    (lambda: reconstruction(X, X, num_iters=-1), ValueError, "num_iters: expected at least 0, got -1"),
    (lambda: hit_or_miss(X, torch.ones(3)), ValueError, r"hit: expected shape \(kh, kw\), got \[3\]"),
    (
        lambda: hit_or_miss(X, BOX, torch.ones(3, 2)),
        ValueError,
        r"miss: expected hit's shape \(3, 3\), got \[3, 2\]",
    ),
    (lambda: skeletonize(BYTES), TypeError, "input: expected a floating-point"),
    (lambda: thin(X, -1), ValueError, "num_iters: expected at least 0, got -1"),
]


@pytest.mark.parametrize("call, error, message", WRONG)
def test_wrong_arguments(call, error, message) -> None:
    with pytest.raises(error, match=message):
        call()
