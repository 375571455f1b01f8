"""Corner and blob responses against their definitions in NumPy and SciPy, and OpenCV."""

import cv2
import numpy as np
import pytest
import scipy.ndimage as ndi
import torch
from photos import hwc, photo

from chiasm import feature


def smoothed(plane: np.ndarray, sigma: float, radius: int) -> np.ndarray:
    return ndi.gaussian_filter(plane, sigma, mode="mirror", radius=radius)


def structure(x: np.ndarray, mode: str) -> np.ndarray:
    """(H, W, 2, 2)."""
    if mode == "sobel":
        gx, gy = (ndi.sobel(x, axis=a, mode="nearest") / 8 for a in (1, 0))
    else:
        gx, gy = (ndi.correlate1d(x, [-0.5, 0, 0.5], axis=a, mode="nearest") for a in (1, 0))
    xx, yy, xy = (smoothed(p, 1.0, 3) for p in (gx * gx, gy * gy, gx * gy))
    return np.stack([np.stack([xx, xy], -1), np.stack([xy, yy], -1)], -2)


@pytest.mark.parametrize("mode", ["sobel", "diff"])
@pytest.mark.parametrize("batch", [1, 3])
def test_gftt_is_the_smaller_eigenvalue(batch: int, mode: str) -> None:
    x = photo(batch, 2, 35, 29, torch.float64)
    sigmas = torch.linspace(0.7, 1.4, batch, dtype=torch.float64)
    actual = feature.gftt_response(x, mode, sigmas)
    for b in range(batch):
        for c in range(2):
            expected = np.linalg.eigvalsh(structure(x[b, c].numpy(), mode))[..., 0] * float(sigmas[b]) ** 4
            np.testing.assert_allclose(actual[b, c], expected, atol=1e-14)


def test_gftt_ranks_corners_as_opencv_does() -> None:
    """cornerMinEigenVal weights by a box, not by a Gaussian, and does not divide its Sobel sums."""
    x = photo(1, 1, 61, 75)
    ours, theirs = feature.gftt_response(x)[0, 0].numpy(), cv2.cornerMinEigenVal(hwc(x), 5, ksize=3)
    inner = (slice(4, -4), slice(4, -4))
    assert np.corrcoef(ours[inner].ravel(), theirs[inner].ravel())[0, 1] > 0.9
    best = np.unravel_index(np.argmax(theirs[inner]), theirs[inner].shape)
    assert ours[inner][best] > 0.5 * ours[inner].max()


def test_gftt_of_isotropic_pixels_has_a_gradient() -> None:
    x = torch.zeros(1, 1, 9, 9, requires_grad=True)
    feature.gftt_response(x).sum().backward()
    assert x.grad is not None and torch.isfinite(x.grad).all()


@pytest.mark.parametrize("mode", ["sobel", "diff"])
@pytest.mark.parametrize("batch", [1, 3])
def test_hessian(batch: int, mode: str) -> None:
    x = photo(batch, 1, 27, 33, torch.float64)
    if mode == "sobel":
        smooth, slope, curve = (
            np.array([1, 4, 6, 4, 1]),
            np.array([-1, -2, 0, 2, 1]),
            np.array([1, 0, -2, 0, 1]),
        )
    else:
        smooth, slope, curve = np.array([0, 1, 0]), np.array([-1, 0, 1]), np.array([1, -2, 1])
    scales = (64, 64, 64) if mode == "sobel" else (1, 4, 1)
    kernels = [
        np.outer(down, across) / scale
        for (down, across), scale in zip(((smooth, curve), (slope, slope), (curve, smooth)), scales)
    ]
    actual = feature.hessian_response(x, mode, torch.full([batch], 1.5, dtype=torch.float64))
    for b in range(batch):
        xx, xy, yy = (ndi.correlate(x[b, 0].numpy(), k, mode="nearest") for k in kernels)
        np.testing.assert_allclose(actual[b, 0], (xx * yy - xy * xy) * 1.5**4, atol=1e-14)


def test_hessian_finds_blobs_dark_and_bright() -> None:
    grid = torch.arange(31, dtype=torch.float64) - 15
    blob = torch.exp(-(grid[:, None] ** 2 + grid**2) / 18.0)
    for sign in (1.0, -1.0):
        response = feature.hessian_response(sign * blob[None, None])
        assert int(response.argmax()) == 15 * 31 + 15


@pytest.mark.parametrize(("sigma1", "sigma2", "radii"), [(1.0, 1.6, (4, 6)), (0.8, 2.3, (3, 9))])
def test_dog_single(sigma1: float, sigma2: float, radii: tuple[int, int]) -> None:
    x = photo(3, 2, 26, 31, torch.float64)
    actual = feature.dog_response_single(x, sigma1, sigma2)
    for b in range(3):
        for c in range(2):
            plane = x[b, c].numpy()
            np.testing.assert_allclose(
                actual[b, c],
                smoothed(plane, sigma2, radii[1]) - smoothed(plane, sigma1, radii[0]),
                atol=1e-14,
            )


def test_fast_is_opencv() -> None:
    """cv2 keeps only the key points whose response exceeds the threshold."""
    x = (photo(3, 1, 61, 75) * 255).round()
    response = feature.fast_response(x)[:, 0].numpy()
    detector = cv2.FastFeatureDetector_create(12, nonmaxSuppression=False)
    scored = cv2.FastFeatureDetector_create(12, nonmaxSuppression=True)
    for b in range(3):
        grey = x[b, 0].numpy().astype(np.uint8)
        of_bytes = feature.fast_response(torch.from_numpy(grey)[None, None])
        assert of_bytes.dtype == torch.uint8
        np.testing.assert_array_equal(of_bytes[0, 0], response[b])
        found = {(round(k.pt[1]), round(k.pt[0])) for k in detector.detect(grey, None)}
        ours = {tuple(p) for p in np.argwhere(response[b] > 12).tolist() if 3 <= p[0] < 58 and 3 <= p[1] < 72}
        assert found == ours and len(found) > 20
        for k in scored.detect(grey, None):
            assert k.response == response[b][round(k.pt[1]), round(k.pt[0])] - 1


WRONG = [
    (lambda: feature.fast_response(torch.zeros(8, 8)), ValueError, "input: expected shape"),
    (
        lambda: feature.gftt_response(torch.zeros(3, 8, 8)),
        ValueError,
        r"input: expected shape \(B, C, H, W\)",
    ),
    (
        lambda: feature.gftt_response(torch.zeros(1, 1, 8, 8), sigmas=torch.ones(1, 1)),
        ValueError,
        r"sigmas: expected shape \(B,\)",
    ),
    (
        lambda: feature.hessian_response(torch.zeros(1, 1, 8, 8), "prewitt"),
        ValueError,
        "mode: expected one of",
    ),
    (
        lambda: feature.dog_response(torch.zeros(1, 1, 1, 8, 8)),
        ValueError,
        "input: expected at least 2 levels",
    ),
    (
        lambda: feature.dog_response_single(torch.zeros(1, 1, 8, 8), 0.0),
        ValueError,
        "sigma1, sigma2: expected positive numbers",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
