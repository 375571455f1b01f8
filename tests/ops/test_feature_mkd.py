"""Kernel descriptors against the kernel itself, summed over all pairs of pixels in NumPy, and SciPy's Bessel
functions."""

from typing import Any

import numpy as np
import pytest
import torch
from photos import load, photo
from scipy.special import ive

from chiasm import feature
from chiasm.feature.mkd import von_mises_coefficients


def von_mises(difference: np.ndarray, kappa: float, frequencies: int) -> np.ndarray:
    """The kernel without its higher frequencies, by a Fourier transform of samples."""
    turn = 2 * np.pi * np.arange(512) / 512
    kernel = (np.exp(kappa * np.cos(turn)) - np.exp(-kappa)) / (2 * np.sinh(kappa))
    a = np.fft.rfft(kernel).real / 512
    return a[0] + sum(2 * a[k] * np.cos(k * difference) for k in range(1, frequencies + 1))


def pixels(patch: np.ndarray) -> dict[str, np.ndarray]:
    """The weight, the direction and the position of every pixel."""
    size = len(patch)
    p = np.pad(patch, 1, "edge")
    dx, dy = (p[1:-1, 2:] - p[1:-1, :-2]) / 2, (p[2:, 1:-1] - p[:-2, 1:-1]) / 2
    y, x = np.mgrid[:size, :size] - (size - 1) / 2
    r = np.hypot(x, y) / np.hypot((size - 1) / 2, (size - 1) / 2)
    made = {
        "w": np.hypot(dx, dy) ** 0.5 * np.exp(-(r**2)),
        "t": np.arctan2(dy, dx),
        "p": np.arctan2(y, x),
        "r": np.pi * r,
    }
    made |= {"x": np.pi * (x / (size - 1) + 0.5), "y": np.pi * (y / (size - 1) + 0.5)}
    return {k: v.ravel() for k, v in made.items()}


def match(one: np.ndarray, other: np.ndarray, kernel_type: str) -> float:
    """The match kernel of two patches."""
    p, q = pixels(one), pixels(other)
    d = {k: p[k][:, None] - q[k] for k in p}
    if kernel_type == "cart":
        k = von_mises(d["t"], 8, 3) * von_mises(d["x"], 1, 1) * von_mises(d["y"], 1, 1)
    else:
        k = von_mises(d["t"] - d["p"], 8, 3) * von_mises(d["p"], 8, 2) * von_mises(d["r"], 8, 2)
    return float(p["w"] @ k @ q["w"])


def similarity(patches: list[np.ndarray], kernel_type: str) -> np.ndarray:
    if kernel_type == "concat":
        return (similarity(patches, "polar") + similarity(patches, "cart")) / 2
    kernel = np.array([[match(a, b, kernel_type) for b in patches] for a in patches])
    return kernel / np.sqrt(np.outer(kernel.diagonal(), kernel.diagonal()))


@pytest.mark.parametrize("size", [2, 11, 16])
@pytest.mark.parametrize(("kernel_type", "dimensions"), [("concat", 238), ("cart", 63), ("polar", 175)])
def test_products_are_the_kernel(kernel_type: str, dimensions: int, size: int) -> None:
    patches = photo(4, 1, size, size, torch.float64)
    described = feature.mkd_describe(patches, kernel_type)
    assert described.shape == (4, dimensions)
    expected = similarity(list(patches[:, 0].numpy()), kernel_type)
    np.testing.assert_allclose(described @ described.T, expected, atol=1e-12)
    single = feature.mkd_describe(patches.float(), kernel_type)
    assert single.dtype == torch.float32
    torch.testing.assert_close(single.double(), described, atol=1e-6, rtol=0)
    half = feature.mkd_describe(patches.half(), kernel_type)
    torch.testing.assert_close(
        half, feature.mkd_describe(patches.half().double(), kernel_type).half(), atol=1e-3, rtol=0
    )


def test_order_of_the_entries() -> None:
    """Each entry is a sum over the pixels of products of three features."""
    patch = photo(1, 1, 12, 12, torch.float64)
    p = pixels(patch[0, 0].numpy())

    def features(angle: np.ndarray, kappa: float, frequencies: int) -> np.ndarray:
        a = ive(np.arange(frequencies + 1), kappa) * 2 / (1 - np.exp(-2 * kappa))
        a[0] = (ive(0, kappa) - np.exp(-2 * kappa)) / (1 - np.exp(-2 * kappa))
        waves = [np.ones_like(angle)] + [
            f(k * angle) for k in range(1, frequencies + 1) for f in (np.cos, np.sin)
        ]
        return np.sqrt(np.repeat(a, [1] + [2] * frequencies))[:, None] * np.array(waves)

    cart = np.einsum(
        "p,ap,bp,cp->abc", p["w"], features(p["t"], 8, 3), features(p["y"], 1, 1), features(p["x"], 1, 1)
    ).ravel()
    polar = np.einsum(
        "p,ap,bp,cp->abc",
        p["w"],
        features(p["t"] - p["p"], 8, 3),
        features(p["r"], 8, 2),
        features(p["p"], 8, 2),
    ).ravel()
    both = np.concatenate([polar / np.linalg.norm(polar), cart / np.linalg.norm(cart)]) / np.sqrt(2)
    np.testing.assert_allclose(feature.mkd_describe(patch)[0], both, atol=1e-13)


@pytest.mark.parametrize("kappa", [0.5, 1.0, 8.0, 30.0])
def test_coefficients(kappa: float) -> None:
    # exp(-kappa) I_k(kappa), and 2 exp(-kappa) sinh(kappa) = 1 - exp(-2 kappa)
    scaled, sinh = ive(np.arange(8), kappa), 0.5 * (1 - np.exp(-2 * kappa))
    expected = scaled / sinh
    expected[0] = (scaled[0] - np.exp(-2 * kappa)) / (2 * sinh)
    np.testing.assert_allclose(von_mises_coefficients(kappa, 7), expected, rtol=1e-13)


def test_a_turned_patch_turns_the_pixels_directions_only() -> None:
    """A quarter turn keeps the length of each frequency of the polar descriptor."""
    patch = photo(1, 1, 16, 16, torch.float64)
    one, other = (
        feature.mkd_describe(p, "polar").reshape(35, 5) for p in (patch, torch.rot90(patch, -1, [2, 3]))
    )
    torch.testing.assert_close(other[:, 0], one[:, 0])
    for k in (1, 2):
        # the picture rotated clockwise, that is from x towards y: every pixel's direction grows by a quarter
        # turn
        a, b = (
            torch.complex(one[:, 2 * k - 1], one[:, 2 * k]),
            torch.complex(other[:, 2 * k - 1], other[:, 2 * k]),
        )
        torch.testing.assert_close(b, a * 1j**k)


def test_projection_and_power() -> None:
    patches = photo(5, 1, 13, 13, torch.float64)
    generator = torch.Generator().manual_seed(0)
    projection, mean = (
        torch.randn((63, 10), generator=generator, dtype=torch.float64),
        0.1 * torch.rand(63, generator=generator, dtype=torch.float64),
    )
    raw = feature.mkd_describe(patches, "cart").numpy()
    projected = (raw - mean.numpy()) @ projection.numpy()
    expected = np.sign(projected) * np.abs(projected) ** 0.3
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    np.testing.assert_allclose(
        feature.mkd_describe(patches, "cart", projection, mean, 0.3), expected, atol=1e-12
    )
    module = feature.MKDDescriptor(13, "cart", torch.nn.Parameter(projection), mean=mean, power=0.3)
    assert module.output_dims == 10 and set(module.state_dict()) == {"whitening"}
    torch.testing.assert_close(torch.jit.script(module)(patches), module(patches))
    np.testing.assert_allclose(module(patches).detach(), expected, atol=1e-12)


def test_flat_patches_have_zeros_and_gradients() -> None:
    patches = torch.full([2, 1, 8, 8], 0.5, requires_grad=True)
    described = feature.mkd_describe(patches, power=0.5)
    assert (described == 0).all()
    described.sum().backward()
    assert patches.grad is not None and torch.isfinite(patches.grad).all()


@pytest.mark.parametrize("size", [5, 8])
@pytest.mark.parametrize("kernel_type", ["concat", "cart", "polar"])
def test_gradient(kernel_type: str, size: int) -> None:
    patches = torch.rand(
        (2, 1, size, size), generator=torch.Generator().manual_seed(1), dtype=torch.float64
    ).requires_grad_(True)
    assert torch.autograd.gradcheck(lambda p: feature.mkd_describe(p, kernel_type), [patches], fast_mode=True)


def test_frames_of_a_turned_image_match() -> None:
    """Descriptors of the same positions in an image and in the image rotated by ten degrees, with frames that
    are upright in both."""
    grey = torch.from_numpy(load("astronaut.png")).double().mean(-1)[None, None] / 255
    generator = torch.Generator().manual_seed(0)
    xy = 130 + 250 * torch.rand((1, 60, 2), generator=generator, dtype=torch.float64)
    turn = torch.deg2rad(torch.tensor(10.0, dtype=torch.float64))
    rotation = torch.stack([turn.cos(), -turn.sin(), turn.sin(), turn.cos()]).reshape(2, 2)
    scale, none = (
        torch.full((1, 60, 1, 1), 20.0, dtype=torch.float64),
        torch.zeros((1, 60, 1), dtype=torch.float64),
    )
    describe = torch.jit.script(feature.LAFDescriptor(feature.MKDDescriptor(32), 32))
    frames = feature.laf_from_center_scale_ori(xy, scale, none)
    turned = torch.cat([rotation @ frames[..., :2], frames[..., 2:]], -1)
    _, match, found = feature.match_mnn(describe(grey, frames)[0], describe(grey, turned)[0])
    assert (match[found][:, 0] == match[found][:, 1]).sum() >= 50


PATCH = torch.zeros(1, 1, 8, 8)
NAMED: Any = "pcawt"
WRONG = [
    (
        lambda: feature.mkd_describe(PATCH[..., :7]),
        ValueError,
        r"patches: expected shape \(N, 1, PS, PS\), got \[1, 1, 8, 7\]",
    ),
    (lambda: feature.mkd_describe(PATCH[..., :1, :1]), ValueError, "patches: expected at least 2 x 2 pixels"),
    (lambda: feature.mkd_describe(PATCH.int()), TypeError, "patches: expected a floating-point tensor"),
    (lambda: feature.mkd_describe(PATCH, "both"), ValueError, "kernel_type: expected one of"),
    (
        lambda: feature.mkd_describe(PATCH, "cart", torch.zeros(64, 8)),
        ValueError,
        r"whitening: expected shape \(D, d\) with D = 63, got \[64, 8\]",
    ),
    (
        lambda: feature.mkd_describe(PATCH, "cart", None, torch.zeros(63, 1)),
        ValueError,
        r"mean: expected shape \(D,\) with D = 63, got \[63, 1\]",
    ),
    (
        lambda: feature.mkd_describe(PATCH, "cart", torch.zeros(63, 8).int()),
        TypeError,
        "whitening: expected a floating-point tensor",
    ),
    (
        lambda: feature.mkd_describe(PATCH, power=0.0),
        ValueError,
        "power: expected a positive number, got 0.0",
    ),
    (lambda: feature.MKDDescriptor(16, "both"), ValueError, "kernel_type: expected one of"),
    (lambda: feature.MKDDescriptor(16, output_dims=0), ValueError, "output_dims: expected a positive number"),
    (
        lambda: feature.MKDDescriptor(16, whitening=NAMED),
        TypeError,
        r"whitening: expected None or a projection \(D, d\), .* got 'pcawt'",
    ),
    (
        lambda: feature.MKDDescriptor(16)(PATCH),
        ValueError,
        r"patches: expected shape \(N, 1, 16, 16\), got \[1, 1, 8, 8\]",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()


def test_the_first_dimensions_of_a_projection() -> None:
    projection = torch.linalg.qr(torch.randn(63, 63, generator=torch.Generator().manual_seed(0)))[0]
    module, patches = feature.MKDDescriptor(16, "cart", projection, "notredame", 20), photo(3, 1, 16, 16)
    raw = feature.mkd_describe(patches, "cart").numpy() @ projection[:, :20].numpy()
    np.testing.assert_allclose(module(patches), raw / np.linalg.norm(raw, axis=1, keepdims=True), atol=1e-5)
    assert module.output_dims == 20
    assert feature.MKDDescriptor(16, "cart", projection, output_dims=128).output_dims == 63
    assert feature.MKDDescriptor(16, "cart", training_set="liberty", output_dims=20).output_dims == 63
