"""Augmentations of intensities: other libraries' values for the drawn numbers, and the distribution of these
numbers."""

import math
from collections.abc import Callable

import cv2
import numpy as np
import pytest
import torch
from scipy import stats
from torch import Tensor
from torchvision.transforms.v2 import functional as tv

from chiasm import augmentation as A
from chiasm import enhance
from chiasm.filters import get_motion_kernel2d
from chiasm.primitives.random.draws import uniform

SEED = torch.arange(20, 28)
P = 0.6
#: Enough to detect a difference of a few percent between distributions; the seeds are fixed.
MANY = torch.arange(4000)
#: torchvision's weight of red is 0.2989, BT.601's is 0.299; factors of up to 1.5 amplify the difference.
GREY = 2e-4


def images(batch: int = 8, channels: int = 3, height: int = 18, width: int = 22) -> Tensor:
    """Values that are whole levels, so that forms for bytes and for floats get the same image."""
    generator = torch.Generator().manual_seed(3)
    levels = torch.randint(0, 256, (batch, channels, height, width), generator=generator)
    return levels.to(torch.float64) / 255.0


def bytes_of(x: Tensor) -> Tensor:
    return (x * 255.0).round().to(torch.uint8)


def at(u: Tensor, low: float, high: float) -> float:
    return float(u) * (high - low) + low


def clipped(x: Tensor) -> Tensor:
    return x.clamp(0.0, 1.0)


def by_opencv_saturation(x: Tensor, factor: float) -> Tensor:
    hsv = cv2.cvtColor(x.permute(1, 2, 0).float().numpy(), cv2.COLOR_RGB2HSV)
    hsv[..., 1] = np.clip(hsv[..., 1] * factor, 0, 1)
    return torch.from_numpy(cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)).permute(2, 0, 1).double()


def solarized(x: Tensor, threshold: float, addition: float) -> Tensor:
    moved = clipped(x + addition)
    return torch.where(moved < threshold, moved, 1 - moved)


def smooth(x: Tensor, sigma: float) -> Tensor:
    return tv.gaussian_blur(x, [5, 3], [sigma, sigma])


def moved(x: Tensor, angle: float, direction: float, length: float) -> Tensor:
    size = 3 + 2 * min(int(length * 3), 2)
    kernel = get_motion_kernel2d(size, angle, direction, dtype=torch.float64)[0].numpy()
    planes = [cv2.filter2D(plane.numpy(), -1, kernel, borderType=cv2.BORDER_CONSTANT) for plane in x]
    return torch.from_numpy(np.stack(planes))


def contrast_limited(x: Tensor, limit: float) -> Tensor:
    made = cv2.createCLAHE(float(np.float32(limit)), (3, 2))
    planes = [made.apply(plane) for plane in bytes_of(x).numpy()]
    return torch.from_numpy(np.stack(planes)) / 255.0


#: For each op: its settings, the bounds of the numbers that it draws after its probability, and another
#: library's result for a sample with these numbers.
CASES: dict[str, tuple[dict, list[tuple[float, float]], Callable]] = {
    "brightness": ({"brightness": (0.5, 1.5)}, [(0.5, 1.5)], lambda x, b: clipped(x + b - 1)),
    "contrast": ({"contrast": (0.5, 1.5)}, [(0.5, 1.5)], tv.adjust_brightness),
    "saturation": ({"saturation": (0.0, 2.0)}, [(0.0, 2.0)], by_opencv_saturation),
    "hue": ({"hue": (-0.4, 0.5)}, [(-0.4, 0.5)], tv.adjust_hue),
    "gamma": ({"gamma": (0.5, 2.0), "gain": (0.5, 1.5)}, [(0.5, 2.0), (0.5, 1.5)], tv.adjust_gamma),
    "grayscale": ({}, [], lambda x: tv.rgb_to_grayscale(x, 3)),
    "rgb_shift": (
        {},
        [(-0.5, 0.5)] * 3,
        lambda x, r, g, b: clipped(x + torch.tensor([r, g, b])[:, None, None]),
    ),
    "invert": ({}, [], tv.invert),
    "equalize": ({}, [], lambda x: tv.equalize(bytes_of(x)).double() / 255.0),
    "auto_contrast": ({}, [], tv.autocontrast),
    "clahe": ({"clip_limit": (1.0, 9.0), "grid_size": (2, 3)}, [(1.0, 9.0)], contrast_limited),
    "posterize": (
        {"bits": (1, 6)},
        [(0.0, 6.0)],
        lambda x, u: tv.posterize(bytes_of(x), 1 + int(u)).double() / 255.0,
    ),
    "solarize": ({}, [(0.4, 0.6), (-0.1, 0.1)], solarized),
    "sharpness": ({"sharpness": (0.0, 3.0)}, [(0.0, 3.0)], tv.adjust_sharpness),
    "box_blur": (
        {"kernel_size": (5, 3)},
        [],
        lambda x: torch.from_numpy(
            np.stack([cv2.blur(c.numpy(), (3, 5), borderType=cv2.BORDER_REFLECT_101) for c in x])
        ),
    ),
    "gaussian_blur": ({"kernel_size": (3, 5), "sigma": (0.3, 2.0)}, [(0.3, 2.0)], smooth),
    "median_blur": (
        {"border_type": "replicate"},
        [],
        lambda x: torch.from_numpy(np.stack([cv2.medianBlur(c.float().numpy(), 3) for c in x])).double(),
    ),
    "motion_blur": (
        {"kernel_size": (3, 7), "angle": (-50.0, 50.0), "direction": (-1.0, 1.0)},
        [(-50.0, 50.0), (-1.0, 1.0), (0.0, 1.0)],
        moved,
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_values_given_the_draws(name: str) -> None:
    settings, bounds, reference = CASES[name]
    x, u = images(), uniform(SEED, 1 + len(bounds))
    assert 0 < int((u[:, 0] < P).sum()) < len(SEED)  # both changed and unchanged samples
    actual = getattr(A, f"random_{name}")(x, SEED, **settings, p=P)
    for b in range(len(SEED)):
        numbers = [at(u[b, 1 + i], *bound) for i, bound in enumerate(bounds)]
        expected = reference(x[b], *numbers) if u[b, 0] < P else x[b]
        # OpenCV's HSV and torchvision's Gaussian windows are float32
        tolerance = GREY if name == "grayscale" else 2e-5
        torch.testing.assert_close(actual[b], expected.double(), rtol=0, atol=tolerance)


ADJUST = {
    "jitter": (
        lambda x, b: tv.adjust_brightness(x, b),
        lambda x, c: tv.adjust_contrast(x, c),
        lambda x, s: tv.adjust_saturation(x, s),
        lambda x, h: tv.adjust_hue(x, h),
    ),
    "jiggle": (
        lambda x, b: clipped(x + b - 1),
        lambda x, c: clipped(x * c),
        by_opencv_saturation,
        lambda x, h: tv.adjust_hue(x, h),
    ),
}


@pytest.mark.parametrize("order", [None, [2, 0, 3, 1]])
@pytest.mark.parametrize("kind", ADJUST)
def test_jitter_in_the_drawn_order(kind: str, order: list[int] | None) -> None:
    bounds = {"brightness": (0.6, 1.3), "contrast": (0.6, 1.3), "saturation": (0.5, 1.5), "hue": (-0.3, 0.3)}
    x, u = images(), uniform(SEED, 9)
    actual = getattr(A, f"random_color_{kind}")(x, SEED, **bounds, order=order, p=P)
    for b in range(len(SEED)):
        expected = x[b]
        if u[b, 0] < P:
            for i in order or u[b, 5:].argsort().tolist():
                expected = ADJUST[kind][i](expected, at(u[b, 1 + i], *list(bounds.values())[i]))
        torch.testing.assert_close(actual[b], expected, rtol=0, atol=GREY)


def test_photometric_distort_as_drawn() -> None:
    x, u = images(), uniform(SEED, 13)
    actual = A.random_photometric_distort(x, SEED)
    for b in range(len(SEED)):
        hits = (u[b] < 0.5).tolist()
        y = x[b]
        if hits[0]:
            y = tv.adjust_brightness(y, at(u[b, 5], 0.875, 1.125))
        if hits[1] and hits[2]:
            y = tv.adjust_contrast(y, at(u[b, 6], 0.5, 1.5))
        if hits[3]:
            y = tv.adjust_saturation(y, at(u[b, 7], 0.5, 1.5))
        if hits[4]:
            y = tv.adjust_hue(y, at(u[b, 8], -0.05, 0.05))
        if hits[1] and not hits[2]:
            y = tv.adjust_contrast(y, at(u[b, 6], 0.5, 1.5))
        if hits[12]:
            y = tv.permute_channels(y, u[b, 9:12].argsort().argsort().tolist())
        torch.testing.assert_close(actual[b], y, rtol=0, atol=GREY)


#: Ops on bytes. For each op: its settings, the bounds of the numbers that it draws after its probability,
#: another library's result for bytes with these numbers, and the tolerance in levels. torchvision rounds
#: products down, chiasm to the nearest.
BYTES: dict[str, tuple[dict, list[tuple[float, float]], Callable, int]] = {
    "brightness": (
        {"brightness": (0.5, 1.5)},
        [(0.5, 1.5)],
        lambda x, b: (x.double() + (b - 1) * 255).round().clamp(0, 255).byte(),
        0,
    ),
    "contrast": ({"contrast": (0.5, 1.5)}, [(0.5, 1.5)], tv.adjust_brightness, 1),
    "saturation": (
        {"saturation": (0.0, 2.0)},
        [(0.0, 2.0)],
        lambda x, s: (by_opencv_saturation(x / 255.0, s) * 255).round().byte(),
        0,
    ),
    "hue": ({"hue": (-0.4, 0.5)}, [(-0.4, 0.5)], tv.adjust_hue, 1),
    "gamma": ({"gamma": (0.5, 2.0), "gain": (0.5, 1.5)}, [(0.5, 2.0), (0.5, 1.5)], tv.adjust_gamma, 1),
    "grayscale": (
        {},
        [],
        lambda x: torch.from_numpy(cv2.cvtColor(x.permute(1, 2, 0).numpy(), cv2.COLOR_RGB2GRAY)).expand(
            3, -1, -1
        ),
        0,
    ),
    "rgb_shift": (
        {},
        [(-0.5, 0.5)] * 3,
        lambda x, r, g, b: (
            (x.double() + 255 * torch.tensor([r, g, b]).double()[:, None, None]).round().clamp(0, 255).byte()
        ),
        0,
    ),
    "invert": ({}, [], tv.invert, 0),
    "equalize": ({}, [], tv.equalize, 0),
    "auto_contrast": ({}, [], tv.autocontrast, 1),
    "clahe": (
        {"clip_limit": (1.0, 9.0), "grid_size": (2, 3)},
        [(1.0, 9.0)],
        lambda x, limit: bytes_of(contrast_limited(x / 255.0, limit)),
        0,
    ),
    "posterize": ({"bits": (1, 6)}, [(0.0, 6.0)], lambda x, u: tv.posterize(x, 1 + int(u)), 0),
    "solarize": (
        {},
        [(0.4, 0.6), (-0.1, 0.1)],
        lambda x, t, a: bytes_of(solarized(x.double() / 255.0, t, a)),
        0,
    ),
    "sharpness": ({"sharpness": (0.0, 3.0)}, [(0.0, 3.0)], tv.adjust_sharpness, 2),
    "box_blur": (
        {"kernel_size": (5, 3)},
        [],
        lambda x: torch.from_numpy(
            np.stack([cv2.blur(c.numpy(), (3, 5), borderType=cv2.BORDER_REFLECT_101) for c in x])
        ),
        0,
    ),
    "gaussian_blur": ({"kernel_size": (3, 5), "sigma": (0.3, 2.0)}, [(0.3, 2.0)], smooth, 1),
    "median_blur": (
        {"border_type": "replicate"},
        [],
        lambda x: torch.from_numpy(np.stack([cv2.medianBlur(c.numpy(), 3) for c in x])),
        0,
    ),
    "motion_blur": (
        {"kernel_size": (3, 7), "angle": (-50.0, 50.0), "direction": (-1.0, 1.0)},
        [(-50.0, 50.0), (-1.0, 1.0), (0.0, 1.0)],
        lambda x, *n: moved(x.double(), *n).round().clamp(0, 255).byte(),
        1,
    ),
}


@pytest.mark.parametrize("name", BYTES)
def test_bytes_given_the_draws(name: str) -> None:
    settings, bounds, reference, levels = BYTES[name]
    x, u = bytes_of(images()), uniform(SEED, 1 + len(bounds))
    actual = getattr(A, f"random_{name}")(x, SEED, **settings, p=P)
    assert actual.dtype == torch.uint8
    different = []
    for b in range(len(SEED)):
        numbers = [at(u[b, 1 + i], *bound) for i, bound in enumerate(bounds)]
        expected = reference(x[b], *numbers) if u[b, 0] < P else x[b]
        off = (actual[b].int() - expected.int()).abs()
        assert off.max() <= max(levels, 1)
        different.append((off > levels).double().mean())
    # The other libraries compute in float32, whose rounding sometimes crosses a half.
    assert max(different) <= 1e-3


@pytest.mark.parametrize("kind", ["color_jitter", "color_jiggle", "photometric_distort"])
def test_bytes_are_rounded_once_after_several_changes(kind: str) -> None:
    bounds = {"brightness": (0.6, 1.3), "contrast": (0.6, 1.3), "saturation": (0.5, 1.5), "hue": (-0.3, 0.3)}
    x = images()
    numbers = getattr(A, f"random_{kind}")(x, SEED, **bounds, p=P)
    made = getattr(A, f"random_{kind}")(bytes_of(x), SEED, **bounds, p=P)
    np.testing.assert_array_equal(made.numpy(), np.rint(numbers.numpy() * 255).astype(np.uint8))


def test_bytes_of_torchvision_s_jitter() -> None:
    """torchvision rounds down after each change, so each change may differ by one level."""
    x, u = bytes_of(images()), uniform(SEED, 9)
    bounds = [(0.6, 1.3), (0.6, 1.3), (0.5, 1.5), (-0.3, 0.3)]
    actual = A.random_color_jitter(x, SEED, *bounds)
    for b in range(len(SEED)):
        expected = x[b]
        for i in u[b, 5:].argsort().tolist():
            expected = ADJUST["jitter"][i](expected, at(u[b, 1 + i], *bounds[i]))
        assert (actual[b].int() - expected.int()).abs().max() <= 4


def test_noise_and_channels_of_bytes() -> None:
    x = images()
    noisy = A.random_salt_and_pepper_noise(bytes_of(x), SEED, p=P)
    assert noisy.equal(bytes_of(A.random_salt_and_pepper_noise(x, SEED, p=P)))
    dropped = A.random_channel_dropout(bytes_of(x), SEED, 2, 51.0, P)
    assert dropped.equal(bytes_of(A.random_channel_dropout(x, SEED, 2, 0.2, P)))
    shuffled = A.random_channel_shuffle(bytes_of(x), SEED, P)
    assert shuffled.equal(bytes_of(A.random_channel_shuffle(x, SEED, P)))


def test_what_bytes_have_not() -> None:
    x = bytes_of(images())
    with pytest.raises(ValueError, match="max_val: expected 1 for an image of bytes"):
        A.random_invert(x, SEED, 255.0)
    with pytest.raises(TypeError, match="max_val: expected a number, 1, for an image of bytes"):
        A.random_invert(x, SEED, torch.tensor(1.0))
    with pytest.raises(TypeError, match="rgb_weights: expected None for an image of bytes"):
        A.random_grayscale(x, SEED, torch.ones(3), 1.0)
    for name, more in (
        ("gaussian_noise", ()),
        ("linear_illumination", ()),
        ("plasma_shadow", ()),
        ("planckian_jitter", ()),
        ("jpeg", ()),
        ("snow", ()),
        ("rain", ()),
        ("normalize", (torch.ones(3), torch.ones(3))),
    ):
        with pytest.raises(TypeError, match="input: expected a floating-point tensor"):
            getattr(A, f"random_{name}")(x, SEED, *more)


def test_normalize_and_back() -> None:
    x, mean, std = images(), torch.tensor([0.5, 0.4, 0.3]).double(), torch.tensor([0.2, 0.3, 0.4]).double()
    y = A.random_normalize(x, SEED, mean, std)
    torch.testing.assert_close(y, tv.normalize(x, mean.tolist(), std.tolist()), rtol=0, atol=1e-12)
    torch.testing.assert_close(A.random_denormalize(y, SEED, mean, std), x, rtol=0, atol=1e-12)


def test_jpeg_of_the_drawn_quality() -> None:
    """The drawn quality is used; test_jpeg.py compares the codec with Pillow's."""
    x, quality = images(), uniform(SEED, 2)[:, 1] * 65.0 + 30.0
    expected = enhance.jpeg_codec_differentiable(x, quality.double())
    torch.testing.assert_close(A.random_jpeg(x, SEED, (30.0, 95.0)), expected, rtol=0, atol=1e-9)


# --- distributions ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "settings", "value", "bounds"),
    [
        ("brightness", {"brightness": (0.4, 1.7), "clip_output": False}, lambda y: y + 0.5, (0.4, 1.7)),
        ("contrast", {"contrast": (0.2, 3.0), "clip_output": False}, lambda y: y / 0.5, (0.2, 3.0)),
        ("gamma", {"gamma": (0.5, 2.5)}, lambda y: y.log2().neg(), (0.5, 2.5)),
        ("hue", {"hue": (-0.1, 0.05)}, None, (-0.1, 0.05)),
    ],
)
def test_numbers_are_uniform(name: str, settings: dict, value: Callable | None, bounds: tuple) -> None:
    if value is None:
        x = torch.tensor([1.0, 0.0, 0.0], dtype=torch.float64).reshape(1, 3, 1, 1).expand(len(MANY), 3, 1, 1)
        y = getattr(A, f"random_{name}")(x, MANY, **settings)
        # near red, green or blue, the other channel rises by six times the rotation
        found = torch.where(y[:, 1] > 0, y[:, 1], -y[:, 2]).flatten() / 6.0
    else:
        x = torch.full((len(MANY), 1, 1, 1), 0.5, dtype=torch.float64)
        found = value(getattr(A, f"random_{name}")(x, MANY, **settings)).flatten()
    law = stats.uniform(bounds[0], bounds[1] - bounds[0])
    assert stats.kstest(found.numpy(), law.cdf).pvalue > 0.01


def test_the_share_of_changed_samples() -> None:
    x = torch.zeros(len(MANY), 1, 1, 1)
    changed = int(A.random_invert(x, MANY, p=0.3).sum())
    assert stats.binomtest(changed, len(MANY), 0.3).pvalue > 0.01


def test_every_number_of_bits_is_equally_likely() -> None:
    x = torch.ones(len(MANY), 1, 1, 1, dtype=torch.float64)
    levels = (A.random_posterize(x, MANY, (2, 5), 1.0) * 255).round().flatten().to(torch.int64)
    counts = torch.stack([(levels == 256 - 2 ** (8 - bits)).sum() for bits in range(2, 6)])
    assert int(counts.sum()) == len(MANY)
    assert stats.chisquare(counts.numpy()).pvalue > 0.01


def test_every_order_of_channels_is_equally_likely() -> None:
    x = torch.tensor([0.0, 1.0, 2.0]).reshape(1, 3, 1, 1).expand(len(MANY), 3, 1, 1)
    y = A.random_channel_shuffle(x, MANY, 1.0).flatten(1).to(torch.int64)
    assert y.sort(1).values.unique(dim=0).tolist() == [[0, 1, 2]]
    _, counts = y.unique(dim=0, return_counts=True)
    assert len(counts) == 6
    assert stats.chisquare(counts.numpy()).pvalue > 0.01


def test_dropped_channels() -> None:
    x = torch.ones(len(MANY), 4, 2, 2)
    y = A.random_channel_dropout(x, MANY, 2, 0.25, 1.0)
    dropped = (y == 0.25).all(-1).all(-1)
    assert ((y == 0.25) | (y == 1.0)).all() and (dropped.sum(1) == 2).all()
    _, counts = dropped.unique(dim=0, return_counts=True)
    assert len(counts) == 6
    assert stats.chisquare(counts.numpy()).pvalue > 0.01


def test_gaussian_noise_is_normal_and_independent() -> None:
    x = torch.zeros(4, 2, 30, 40, dtype=torch.float64)
    noise = A.random_gaussian_noise(x, SEED[:4], 0.5, 2.0, 1.0)
    assert stats.kstest(noise.flatten().numpy(), stats.norm(0.5, 2.0).cdf).pvalue > 0.01
    between = np.corrcoef(noise.reshape(8, -1).numpy()) - np.eye(8)
    assert np.abs(between).max() < 4.5 / math.sqrt(1200)


def test_salt_and_pepper() -> None:
    x = torch.full((4, 3, 60, 80), 0.5)
    y = A.random_salt_and_pepper_noise(x, SEED[:4], (0.2, 0.2), (0.7, 0.7), 1.0)
    assert y.unique().tolist() == [0.0, 0.5, 1.0]
    assert y.equal(y[:, :1].expand_as(y))
    for sample in y[:, 0]:
        changed, white = int((sample != 0.5).sum()), int((sample == 1.0).sum())
        assert stats.binomtest(changed, 4800, 0.2).pvalue > 0.001
        assert stats.binomtest(white, changed, 0.7).pvalue > 0.001


# --- what holds for all -------------------------------------------------------------------------------------

NEEDED: dict[str, dict] = {
    "random_normalize": {"mean": torch.tensor([0.5, 0.4, 0.3]), "std": torch.tensor(0.2)},
    "random_denormalize": {"mean": torch.tensor([0.5, 0.4, 0.3]), "std": torch.tensor(0.2)},
    "random_gaussian_blur": {"kernel_size": (3, 5), "sigma": (0.1, 2.0)},
    "random_motion_blur": {"kernel_size": (3, 7), "angle": (-30.0, 30.0), "direction": (-0.5, 0.5)},
    "random_brightness": {"brightness": (0.5, 1.5)},
    "random_contrast": {"contrast": (0.5, 1.5)},
    "random_saturation": {"saturation": (0.5, 1.5)},
    "random_hue": {"hue": (-0.2, 0.2)},
    "random_gamma": {"gamma": (0.5, 2.0)},
    "random_color_jitter": {"brightness": (0.5, 1.5), "saturation": (0.5, 1.5), "hue": (-0.2, 0.2)},
    "random_color_jiggle": {"contrast": (0.5, 1.5), "saturation": (0.5, 1.5), "hue": (-0.2, 0.2)},
}
OPS = [
    *(f"random_{name}" for name in CASES),
    "random_color_jitter",
    "random_color_jiggle",
    "random_photometric_distort",
    "random_normalize",
    "random_denormalize",
    "random_jpeg",
    "random_gaussian_noise",
    "random_salt_and_pepper_noise",
    "random_channel_dropout",
    "random_channel_shuffle",
]
every_op = pytest.mark.parametrize("name", OPS)


@every_op
def test_a_sample_hangs_on_its_own_seed_alone(name: str) -> None:
    op, settings, x, seed = getattr(A, name), NEEDED.get(name, {}), images()[:5].float(), SEED[:5]
    together = op(x, seed, **settings, p=0.5)
    assert op(x, seed.clone(), **settings, p=0.5).equal(together)
    alone = [op(x[b : b + 1], seed[b : b + 1], **settings, p=0.5) for b in range(5)]
    torch.testing.assert_close(together, torch.cat(alone), rtol=0, atol=1e-6)
    assert not op(x, seed + 100, **settings, p=0.5).equal(together)


@every_op
def test_probability_of_zero_and_one(name: str) -> None:
    op, settings, x = getattr(A, name), NEEDED.get(name, {}), images().float()
    assert op(x, SEED, **settings, p=0.0).equal(x)
    if name != "random_channel_shuffle":  # one of six orders is the original one
        assert (op(x, SEED, **settings, p=1.0) != x).flatten(1).any(1).all()


@every_op
def test_what_it_refuses(name: str) -> None:
    op, settings, x = getattr(A, name), NEEDED.get(name, {}), images().float()
    with pytest.raises(TypeError, match="seed: expected an int64 tensor"):
        op(x, SEED.float(), **settings)
    with pytest.raises(ValueError, match=r"seed: expected shape \(8,\), one seed a sample, got \[7\]"):
        op(x, SEED[:7], **settings)
    with pytest.raises(TypeError, match="input: expected a floating-point"):
        op(bytes_of(x).int(), SEED, **settings)
    with pytest.raises(ValueError, match=r"p: expected a probability, 0 to 1, got 1\.5"):
        op(x, SEED, **settings, p=1.5)


@pytest.mark.parametrize(
    ("name", "settings", "message"),
    [
        ("brightness", {"brightness": (0.5, 2.5)}, r"brightness: expected \(least, greatest\) within \[0"),
        ("contrast", {"contrast": (1.5, 0.5)}, r"contrast: expected .* got \(1\.5, 0\.5\)"),
        ("hue", {"hue": (-0.6, 0.0)}, "hue: expected"),
        ("posterize", {"bits": (3, 9)}, r"bits: expected .* got \(3, 9\)"),
        ("gaussian_noise", {"std": -1.0}, "std: expected"),
        ("channel_dropout", {"num_drop_channels": 4}, "num_drop_channels: expected 0 to 3, got 4"),
        ("color_jitter", {"order": [0, 1, 2, 2]}, "order: expected a permutation"),
        (
            "motion_blur",
            {"kernel_size": (4, 7), "angle": (0.0, 0.0), "direction": (0.0, 0.0)},
            "kernel_size: expected odd",
        ),
    ],
)
def test_settings_that_are_refused(name: str, settings: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        getattr(A, f"random_{name}")(images(), SEED, **settings)


def test_clahe_takes_a_limit_of_each_sample() -> None:
    x = images(3).float()
    together = enhance.equalize_clahe(x, torch.tensor([1.0, 3.0, 9.0]), (2, 3))
    for b, limit in enumerate([1.0, 3.0, 9.0]):
        assert together[b].equal(enhance.equalize_clahe(x[b], limit, (2, 3)))
    with pytest.raises(ValueError, match=r"clip_limit: expected a number, or shape \(3,\), got \[2\]"):
        enhance.equalize_clahe(x, torch.ones(2), (2, 3))
