"""Random light and weather: definitions in NumPy, OpenCV and published colours, for given draws."""

import cv2
import numpy as np
import pytest
import torch
from scipy import stats
from torch import Tensor

from chiasm import augmentation as A
from chiasm.augmentation.planckian import planckian_gains
from chiasm.primitives.random.draws import integers, uniform

SEED = torch.arange(20, 28)
P = 0.6


def images(height: int = 18, width: int = 23) -> Tensor:
    return torch.rand(8, 3, height, width, generator=torch.Generator().manual_seed(3)).double()


def at(u: Tensor, low: float, high: float) -> float:
    return float(u) * (high - low) + low


def test_linear_illumination() -> None:
    x, u, side = images(), uniform(SEED, 3), integers(SEED, 4, 1, 1)
    sides = A.random_linear_illumination(x, SEED, p=P)
    corners = A.random_linear_corner_illumination(x, SEED, p=P)
    down = np.tile(np.linspace(0, 1, 18)[:, None], (1, 23))
    across = np.tile(np.linspace(0, 1, 23), (18, 1))
    for b in range(8):
        s = int(side[b, 0])
        vertical, horizontal = (down[::-1] if s >= 2 else down), (across[:, ::-1] if s % 2 else across)
        light = at(u[b, 1], 0.01, 0.2) * (1 if at(u[b, 2], -1, 1) >= 0 else -1) * float(u[b, 0] < P)
        for made, ramp in (
            (sides, horizontal if s % 2 else vertical),
            (corners, (vertical + horizontal) / 2),
        ):
            expected = np.clip(x[b].numpy() + light * ramp, 0, 1)
            np.testing.assert_allclose(made[b].numpy(), expected, atol=1e-7)


def test_gaussian_illumination() -> None:
    x, u = images(), uniform(SEED, 7)
    made = A.random_gaussian_illumination(x, SEED, p=P)
    y, column = np.linspace(0, 1, 18)[:, None], np.linspace(0, 1, 23)
    for b in range(8):
        light = at(u[b, 1], 0.01, 0.15) * (1 if at(u[b, 2], -1, 1) >= 0 else -1) * float(u[b, 0] < P)
        down = stats.norm(at(u[b, 3], 0.1, 0.9), at(u[b, 5], 0.2, 1.0))
        across = stats.norm(at(u[b, 4], 0.1, 0.9), at(u[b, 6], 0.2, 1.0))
        spot = down.pdf(y) / down.pdf(down.mean()) * across.pdf(column) / across.pdf(across.mean())
        np.testing.assert_allclose(made[b].numpy(), np.clip(x[b].numpy() + light * spot, 0, 1), atol=1e-7)


def test_plasma() -> None:
    """Images of one value, from whose result the plasma can be computed."""
    u, grey = uniform(SEED, 4), torch.full((8, 1, 30, 40), 0.5, dtype=torch.float64)
    lit = A.random_plasma_brightness(grey, SEED, intensity=(0.2, 0.4), p=1.0)
    for b in range(8):
        strength = at(u[b, 2], 0.2, 0.4)
        assert float(lit[b].min()) == pytest.approx(0.5 - strength, abs=1e-5)
        assert float(lit[b].max()) == pytest.approx(0.5 + strength, abs=1e-5)
    strength = (u[:, 2] * 0.2 + 0.2).double().reshape(8, 1, 1, 1)
    plasma = (lit - 0.5) / (2 * strength) + 0.5
    stretched = A.random_plasma_contrast(grey + 0.1, SEED, p=1.0)
    torch.testing.assert_close(stretched, (0.4 * plasma + 0.5).clamp(0, 1), rtol=0, atol=1e-6)
    shaded = A.random_plasma_shadow(grey, SEED, shade_intensity=(-0.3, -0.1), p=1.0)
    for b in range(8):
        shadow = plasma[b] < float(u[b, 3])
        added = at(u[b, 2], -0.3, -0.1)
        torch.testing.assert_close(
            shaded[b], torch.where(shadow, 0.5 + added, 0.5).double(), rtol=0, atol=1e-6
        )
    # Neighbours are similar, unlike in white noise.
    steps = (plasma[..., 1:] - plasma[..., :-1]).abs().mean()
    assert steps < 0.25 * (plasma - plasma.flatten().flip(0).reshape(plasma.shape)).abs().mean()


@pytest.mark.parametrize(
    ("mode", "kelvin", "xy", "tolerance"),
    [
        # Wyszecki and Stiles, Color Science: the Planckian locus; Wyman's fit is within 0.004
        ("blackbody", 3000, (0.4369, 0.4041), 0.004),
        ("blackbody", 6500, (0.3135, 0.3237), 0.004),
        ("blackbody", 10000, (0.2807, 0.2884), 0.004),
        # CIE 15: D55 is 5503 K, D65 6504 K, D75 7504 K
        ("CIED", 5500, (0.33242, 0.34743), 2e-4),
        ("CIED", 6500, (0.31272, 0.32903), 2e-4),
        ("CIED", 7500, (0.29902, 0.31485), 2e-4),
    ],
)
def test_colours_of_radiators(mode: str, kelvin: int, xy: tuple[float, float], tolerance: float) -> None:
    first = 3000 if mode == "blackbody" else 4000
    gains = planckian_gains(mode, torch.device("cpu"))
    rgb = gains[(kelvin - first) // 500].numpy()
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    xyz = to_xyz @ rgb
    np.testing.assert_allclose(xyz[:2] / xyz.sum(), xy, atol=tolerance)
    assert len(gains) == (25 if mode == "blackbody" else 23)


def test_planckian_jitter() -> None:
    x, u, which = images(), uniform(SEED, 1), integers(SEED, 25, 1, 1)
    gains = planckian_gains("blackbody", torch.device("cpu"))
    made = A.random_planckian_jitter(x, SEED, p=P)
    for b in range(8):
        gain = gains[int(which[b, 0])] if u[b, 0] < P else torch.ones(3, dtype=torch.float64)
        torch.testing.assert_close(made[b], (x[b] * gain[:, None, None]).clamp(0, 1))


def test_snow() -> None:
    x, u = images().float(), uniform(SEED, 3)
    made = A.random_snow(x, SEED, (0.3, 0.7), (1.5, 2.5), P)
    for b in range(8):
        if u[b, 0] >= P:
            assert made[b].equal(x[b])
            continue
        hls = cv2.cvtColor(x[b].permute(1, 2, 0).contiguous().numpy(), cv2.COLOR_RGB2HLS)
        lightness = hls[..., 1]
        dark = lightness < at(u[b, 1], 0.3, 0.7)
        hls[..., 1] = np.clip(np.where(dark, lightness * at(u[b, 2], 1.5, 2.5), lightness), 0, 1)
        expected = cv2.cvtColor(hls, cv2.COLOR_HLS2RGB)
        np.testing.assert_allclose(made[b].permute(1, 2, 0).numpy(), expected, atol=1e-4)


def test_no_rain() -> None:
    assert torch.equal(A.random_rain(images(), SEED, (0, 0), p=1.0), images())


def test_rain() -> None:
    x, u, place = images(30, 40), uniform(SEED, 4), uniform(SEED, 24, 1).reshape(8, 12, 2)
    made = A.random_rain(x, SEED, (4, 12), (5, 9), (-4, 4), P)
    for b in range(8):
        expected = x[b].clone()
        if u[b, 0] < P:
            drops, high = 4 + int(float(u[b, 1]) * 9), 5 + int(float(u[b, 2]) * 5)
            wide = -4 + int(float(u[b, 3]) * 9)
            for k in range(drops):
                top = int(float(place[b, k, 0]) * (30 - high + 1))
                left = int(float(place[b, k, 1]) * (40 - abs(wide))) - min(wide, 0)
                for step in range(high):
                    column = left + int(np.floor(step * wide / high + 0.5))
                    expected[:, top + step, column] = 200 / 255
        torch.testing.assert_close(made[b], expected)


@pytest.mark.parametrize(
    "name",
    [
        "random_linear_illumination",
        "random_linear_corner_illumination",
        "random_gaussian_illumination",
        "random_plasma_brightness",
        "random_plasma_contrast",
        "random_plasma_shadow",
        "random_planckian_jitter",
        "random_snow",
        "random_rain",
    ],
)
def test_a_sample_hangs_on_its_own_seed_alone(name: str) -> None:
    op, x = getattr(A, name), images().float()
    together = op(x, SEED, p=0.5)
    assert op(x, SEED.clone(), p=0.5).equal(together)
    alone = torch.cat([op(x[b : b + 1], SEED[b : b + 1], p=0.5) for b in range(8)])
    torch.testing.assert_close(together, alone, rtol=0, atol=1e-6)
    assert op(x, SEED, p=0.0).equal(x)
    assert (op(x, SEED, p=1.0) != x).flatten(1).any(1).all()
    with pytest.raises(TypeError, match="seed: expected an int64 tensor"):
        op(x, SEED.float())
    with pytest.raises(ValueError, match="p: expected a probability"):
        op(x, SEED, p=-0.5)


def test_settings_that_are_refused() -> None:
    x = images()
    for op, settings, message in (
        (A.random_rain, {"drop_height": (0, 4)}, "drop_height: expected"),
        (A.random_rain, {"drop_width": (-6, 4)}, "drop_width: expected"),
        (A.random_rain, {"number_of_drops": (5, 4)}, "number_of_drops: expected"),
        (A.random_snow, {"brightness": (0.5, 2.0)}, "brightness: expected"),
        (A.random_planckian_jitter, {"select_from": [25]}, "select_from: expected numbers in 0 to 24"),
        (A.random_planckian_jitter, {"mode": "neon"}, "mode: expected one of"),
        (A.random_linear_illumination, {"gain": (0.0, 2.0)}, "gain: expected"),
        (A.random_plasma_shadow, {"shade_intensity": (0.0, 0.5)}, "shade_intensity: expected"),
    ):
        with pytest.raises(ValueError, match=message):
            op(x, SEED, **settings)
