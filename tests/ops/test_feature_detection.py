"""Key points in scale space: scenes with known results, a loop in NumPy, OpenCV's SIFT."""

import cv2
import numpy as np
import pytest
import scipy.ndimage as ndi
import torch
from photos import load, photo
from test_feature_responses import structure
from torch import Tensor

from chiasm import feature


def blob(height: int, width: int, x: float, y: float, sigma: float) -> Tensor:
    across, down = (
        torch.arange(width, dtype=torch.float64) - x,
        torch.arange(height, dtype=torch.float64)[:, None] - y,
    )
    return torch.exp(-(across**2 + down**2) / (2 * sigma * sigma))[None, None]


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    ("response", "sigma"), [("hessian", 4.2), ("hessian", 9.0), ("dog", 3.0), ("dog", 7.7)]
)
def test_blob_has_its_place_and_scale(response: str, sigma: float, sign: float) -> None:
    """det H is largest at the blob's scale. A difference of Gaussians is largest if this scale lies between
    its two scales; the finer one counts."""
    lafs, scores, valid = feature.detect_keypoints(
        sign * blob(121, 143, 70.3, 58.6, sigma), 5, response, mr_size=1.0
    )
    assert valid[0, 0] and scores[0, 0] > 5 * scores[0, 1]
    found = float(lafs[0, 0, 0, 0]) * (2 ** (1 / 6) if response == "dog" else 1.0)
    # The detector assumes that an image is blurred by half a pixel, which this one is not; the Hessian's
    # kernels blur too.
    assert abs(found / np.sqrt(sigma**2 + 0.25) - 1) < 0.07
    assert (lafs[0, 0, :, 2] - torch.tensor([70.3, 58.6])).abs().max() < 0.12
    assert (lafs[0, 0, 0, 1] == 0) and lafs[0, 0, 0, 0] == lafs[0, 0, 1, 1]


# --- a loop in NumPy ----------------------------------------------------------------------------------------


def at_a_level(plane: np.ndarray, response: str) -> np.ndarray:
    if response == "hessian":
        smooth, slope, curve = (
            np.array([1, 4, 6, 4, 1]) / 16,
            np.array([-1, -2, 0, 2, 1]) / 8,
            np.array([1, 0, -2, 0, 1]) / 4,
        )
        taps = ((smooth, curve), (slope, slope), (curve, smooth))
        xx, xy, yy = (
            ndi.correlate1d(ndi.correlate1d(plane, d, 0, mode="nearest"), a, 1, mode="nearest")
            for d, a in taps
        )
        return xx * yy - xy * xy
    s = structure(plane, "sobel")
    if response == "gftt":
        return np.linalg.eigvalsh(s)[..., 0]
    return np.linalg.det(s) - 0.04 * np.trace(s, axis1=-2, axis2=-1) ** 2


def response_octaves(
    plane: np.ndarray, response: str, octaves: int, levels: int, sigma: float
) -> list[np.ndarray]:
    def blurred(p: np.ndarray, s: float) -> np.ndarray:
        return ndi.gaussian_filter(p, s, mode="nearest", radius=int(np.ceil(4 * s)))

    first, out = blurred(plane, np.sqrt(sigma**2 - 0.25)), []
    for _ in range(octaves):
        space = [first]
        for k in range(1, levels + 3):
            space.append(blurred(space[-1], sigma * 2 ** ((k - 1) / levels) * np.sqrt(2 ** (2 / levels) - 1)))
        if response == "dog":
            out.append(np.diff(space, axis=0))
        else:
            out.append(
                np.stack(
                    [
                        at_a_level(p, response) * (sigma * 2 ** (k / levels)) ** 4
                        for k, p in enumerate(space[: levels + 2])
                    ]
                )
            )
        first = space[levels][::2, ::2]
    return out


def refined(v: np.ndarray, z: int, y: int, x: int) -> tuple[np.ndarray, float]:
    """(scale, y, x) and value."""
    at = np.array([z, y, x])
    for tries in range(3):
        n = v[tuple(slice(k - 1, k + 2) for k in at)]
        gradient = np.array([n[2, 1, 1] - n[0, 1, 1], n[1, 2, 1] - n[1, 0, 1], n[1, 1, 2] - n[1, 1, 0]]) / 2
        hessian = np.empty((3, 3))
        for i in range(3):
            for j in range(3):
                e, f = np.eye(3, dtype=int)[i], np.eye(3, dtype=int)[j]
                one = np.ones(3, dtype=int)
                hessian[i, j] = (
                    n[tuple(one + e)] - 2 * n[1, 1, 1] + n[tuple(one - e)]
                    if i == j
                    else (
                        n[tuple(one + e + f)]
                        - n[tuple(one + e - f)]
                        - n[tuple(one - e + f)]
                        + n[tuple(one - e - f)]
                    )
                    / 4
                )
        if abs(np.linalg.det(hessian)) <= 1e-7 * np.abs(hessian).max() ** 3:
            break
        shift = -np.linalg.solve(hessian, gradient)
        if np.abs(shift).max() <= 0.6:
            return at + shift, n[1, 1, 1] + gradient @ shift / 2
        if tries < 2:
            at = np.clip(
                at + np.where(np.abs(shift) > 0.6, np.sign(shift), 0).astype(int), 1, np.array(v.shape) - 2
            )
    return np.array([z, y, x], float), v[z, y, x]


def by_loops(plane: np.ndarray, response: str, octaves: int, mr_size: float) -> np.ndarray:
    """Rows of x, y, radius, score."""
    rows, around = [], np.ones((3, 3, 3))
    around[1, 1, 1] = 0
    for octave, v in enumerate(response_octaves(plane, response, octaves, 3, 1.6)):
        highest = v > ndi.maximum_filter(v, footprint=around, mode="constant", cval=np.inf)
        lowest = v < ndi.minimum_filter(v, footprint=around, mode="constant", cval=-np.inf)
        for z, y, x in np.argwhere((highest & (v > 0)) | (lowest & (v < 0) & (response == "dog"))):
            radius = mr_size * 1.6 * 2 ** (z / 3)
            if min(x, y) >= radius and x <= v.shape[2] - 1 - radius and y <= v.shape[1] - 1 - radius:
                (s, r, c), value = refined(v, z, y, x)
                rows.append((c * 2**octave, r * 2**octave, mr_size * 1.6 * 2 ** (octave + s / 3), abs(value)))
    return np.array(sorted(rows, key=lambda row: -row[3]))


@pytest.mark.parametrize(("batch", "response"), [(1, "harris"), (3, "gftt"), (1, "hessian"), (3, "dog")])
def test_detection_is_the_loop(batch: int, response: str) -> None:
    image = photo(batch, 1, 91, 104, torch.float64)
    lafs, scores, valid = feature.detect_keypoints(image, 300, response, 3, mr_size=2.0)
    for b in range(batch):
        expected = by_loops(image[b, 0].numpy(), response, 3, 2.0)
        count = int(valid[b].sum())
        assert 15 < count == len(expected) and valid[b, :count].all()
        actual = np.stack(
            [lafs[b, :count, 0, 2], lafs[b, :count, 1, 2], lafs[b, :count, 0, 0], scores[b, :count]], 1
        )
        np.testing.assert_allclose(actual, expected, rtol=1e-5, atol=1e-6)
        assert (lafs[b, count:] == 0).all() and (scores[b, count:] == 0).all()


def test_dog_finds_what_opencv_finds() -> None:
    """OpenCV doubles the image first, and drops edges and weak extrema: all its larger key points are among
    ours."""
    grey = cv2.cvtColor(load("coffee.png"), cv2.COLOR_RGB2GRAY)[:340, :400]
    theirs = [k for k in cv2.SIFT_create().detect(np.ascontiguousarray(grey), None) if 2.2 < k.size / 2 < 10]
    lafs, _, valid = feature.detect_keypoints(
        torch.from_numpy(grey.copy())[None, None] / 255.0, 1000, "dog", 4, mr_size=1.0
    )
    ours = torch.cat([lafs[0, :, :, 2], lafs[0, :, :1, 0]], 1)[valid[0]].numpy()
    inner = [k for k in theirs if 12 < k.pt[0] < 388 and 12 < k.pt[1] < 328]
    found = [
        np.any(
            (np.hypot(ours[:, 0] - k.pt[0], ours[:, 1] - k.pt[1]) < 1.0)
            & (np.abs(np.log(2 * ours[:, 2] / k.size)) < 0.15)
        )
        for k in inner
    ]
    assert len(inner) > 30 and np.mean(found) > 0.85


# --- slots --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("response", ["harris", "gftt", "hessian", "dog"])
def test_slots(response: str) -> None:
    image = photo(2, 1, 70, 83)
    many, few = feature.detect_keypoints(image, 500, response), feature.detect_keypoints(image, 5, response)
    assert (many[1][:, 1:] <= many[1][:, :-1]).all()
    assert (feature.laf_is_filled(many[0]) == many[2]).all() and few[2].all()
    assert feature.laf_is_inside_image(many[0], image)[many[2]].float().mean() > 0.9
    scripted = torch.jit.script(feature.detect_keypoints)(image, 5, response)
    for a, b in zip(scripted, few, strict=True):
        torch.testing.assert_close(a, b)
    alone = feature.detect_keypoints(image[1:], 500, response)
    torch.testing.assert_close(alone[0][0], many[0][1])
    high = float(few[1][0, 2])
    assert int(feature.detect_keypoints(image, 500, response, threshold=high)[2][0].sum()) == 2
    assert not feature.detect_keypoints(torch.full([1, 1, 8, 9], 0.5), 600, response)[2].any()


def test_equal_scores_keep_their_order() -> None:
    """Blobs on a grid whose positions stay equivalent after halving."""
    one = blob(48, 48, 24, 24, 4.0)[0, 0].float()
    lafs, scores, valid = feature.detect_keypoints(one.repeat(3, 4)[None, None], 12, "dog", mr_size=3.0)
    equal = scores[0] == scores[0, 0]
    centres = lafs[0, equal][:, :, 2].round()
    linear = centres[:, 1] * 192 + centres[:, 0]
    assert valid[0, 0] and int(equal.sum()) >= 2 and (linear[1:] > linear[:-1]).all()


def test_gradient() -> None:
    image = (blob(48, 52, 24.3, 25.6, 4.0) + 0.01 * photo(1, 1, 48, 52, torch.float64)).requires_grad_(True)

    def best(x: Tensor) -> tuple[Tensor, Tensor]:
        lafs, scores, _ = feature.detect_keypoints(x, 1, "hessian", 2)
        return lafs, scores

    assert torch.autograd.gradcheck(best, image, eps=1e-6, atol=1e-5, fast_mode=True)


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16])
def test_positions_of_half_precision_are_float32(dtype: torch.dtype) -> None:
    image = torch.zeros(1, 1, 64, 700)
    image[..., 24:40, 531:547] = 1.0
    points, scores, valid = feature.harris_keypoints(image.to(dtype), 4)
    assert points.dtype == torch.float32 and scores.dtype == dtype and valid.all()
    assert torch.equal(points, feature.harris_keypoints(image, 4)[0])
    spot = blob(64, 700, 541.0, 31.3, 4.2)
    found, exact = (feature.detect_keypoints(x, 1, mr_size=1.0)[0] for x in (spot.to(dtype), spot))
    assert found.dtype == torch.float32
    torch.testing.assert_close(found.double(), exact, rtol=0, atol=0.1)


def test_a_maximum_that_two_pixels_share_is_none() -> None:
    """As the docstring says; those beside it are a seventh as strong."""
    for x, count in ((40.0, 1), (40.3, 1), (40.5, 0)):
        image = blob(80, 82, x, 40.0, 2.5)
        scores = feature.detect_keypoints(image, 5, "dog", mr_size=1.0, num_octaves=1)[1]
        assert int((scores > 0.05).sum()) == count


IMAGE = torch.zeros(1, 1, 16, 16)
WRONG = [
    (
        lambda: feature.detect_keypoints(IMAGE.expand(1, 3, 16, 16), 5),
        ValueError,
        r"img: expected shape \(B, 1, H, W\)",
    ),
    (lambda: feature.detect_keypoints(IMAGE[..., :7], 5), ValueError, "img: expected at least 8 x 8 pixels"),
    (lambda: feature.detect_keypoints(IMAGE, 5, "fast"), ValueError, "response: expected one of"),
    (
        lambda: feature.detect_keypoints(IMAGE, 0),
        ValueError,
        "max_keypoints, num_octaves, n_levels: expected positive numbers, got 0, 4 and 3",
    ),
    (
        lambda: feature.detect_keypoints(IMAGE, 5, init_sigma=0.5),
        ValueError,
        "init_sigma: expected more than 0.5",
    ),
    (
        lambda: feature.detect_keypoints(IMAGE, 5, threshold=-1.0),
        ValueError,
        "threshold: expected a number >= 0",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
