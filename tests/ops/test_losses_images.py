"""Losses and metrics of two images against scikit-image, torchmetrics, SciPy and the papers' formulas in
NumPy."""

import math
from collections.abc import Callable

import numpy as np
import pytest
import scipy.ndimage
import scipy.spatial.distance
import scipy.special
import torch
import torchmetrics.functional.image as reference
from photos import photo
from skimage.metrics import peak_signal_noise_ratio, structural_similarity
from torch import Tensor

from chiasm import losses, metrics

SHAPES = [(1, 1, 37, 43), (3, 3, 40, 35), (1, 5, 36, 51)]
X = torch.rand(1, 2, 4, 5)

sizes = pytest.mark.parametrize("shape", SHAPES, ids=str)


def pair(shape: tuple[int, ...], max_val: float = 1.0) -> tuple[Tensor, Tensor]:
    x = photo(*shape, torch.float64)
    return x * max_val, (x.roll(1, 3) * 0.9 + 0.03) * max_val


@sizes
@pytest.mark.parametrize("max_val", [1.0, 255.0])
def test_psnr_equals_skimage(shape: tuple[int, ...], max_val: float) -> None:
    x, y = pair(shape, max_val)
    expected = peak_signal_noise_ratio(x.numpy(), y.numpy(), data_range=max_val)
    assert metrics.psnr(x, y, max_val).item() == pytest.approx(expected, abs=1e-10)
    assert losses.psnr_loss(x, y, max_val).item() == pytest.approx(-expected, abs=1e-10)
    assert metrics.psnr(x.float(), y.float(), max_val).item() == pytest.approx(expected, abs=1e-4)


def test_psnr_of_equal_images() -> None:
    x = X.clone().requires_grad_(True)
    value = metrics.psnr(x, X, 1.0)
    value.backward()
    assert value.item() == math.inf
    assert torch.equal(x.grad, torch.zeros_like(X))


def gaussian_mean(v: np.ndarray, sigma: float, reach: int) -> np.ndarray:
    """Convolved along all axes with a Gaussian of 2 reach + 1 taps, reflected at the border, by SciPy."""
    taps = np.exp(-(np.arange(-reach, reach + 1) ** 2) / (2 * sigma**2))
    for axis in range(v.ndim):
        v = scipy.ndimage.correlate1d(v, taps / taps.sum(), axis, mode="mirror")
    return v


def volumes(batch: int, channels: int, depth: int) -> tuple[Tensor, Tensor]:
    generator = torch.Generator().manual_seed(batch)
    x = torch.rand((batch, channels, depth, 17, 20), generator=generator, dtype=torch.float64)
    return x, (x + 0.3 * torch.rand(x.shape, generator=generator, dtype=torch.float64)).clamp(max=1.0)


@pytest.mark.parametrize(("batch", "channels", "depth"), [(1, 1, 13), (3, 3, 12), (1, 5, 15)])
def test_ssim3d_equals_skimage(batch: int, channels: int, depth: int) -> None:
    x, y = volumes(batch, channels, depth)
    actual = metrics.ssim3d(x, y, 11, 1.0)[..., 5:-5, 5:-5, 5:-5]
    assert torch.equal(metrics.ssim3d(x, y, 11, padding="valid"), actual)
    for b in range(batch):
        for c in range(channels):
            _, expected = structural_similarity(
                x[b, c].numpy(),
                y[b, c].numpy(),
                data_range=1.0,
                gaussian_weights=True,
                sigma=1.5,
                use_sample_covariance=False,
                full=True,
            )
            np.testing.assert_allclose(actual[b, c], expected[5:-5, 5:-5, 5:-5], atol=1e-9)


@pytest.mark.parametrize(
    ("batch", "channels", "depth", "window"), [(1, 5, 9, 3), (3, 1, 7, 5), (1, 3, 13, 7)]
)
def test_ssim3d_equals_the_formula(batch: int, channels: int, depth: int, window: int) -> None:
    x, y = volumes(batch, channels, depth)
    expected = np.empty(x.shape)
    for b in range(batch):
        for c in range(channels):
            p, q = x[b, c].numpy(), y[b, c].numpy()
            mp, mq, pp, qq, pq = (gaussian_mean(v, 1.5, window // 2) for v in (p, q, p * p, q * q, p * q))
            unlike = (mp**2 + mq**2 + 1e-4) * (pp - mp**2 + qq - mq**2 + 9e-4)
            expected[b, c] = (2 * mp * mq + 1e-4) * (2 * (pq - mp * mq) + 9e-4) / unlike
    np.testing.assert_allclose(metrics.ssim3d(x, y, window), expected, rtol=1e-9)
    loss = np.clip((1 - expected) / 2, 0, 1)
    np.testing.assert_allclose(losses.ssim3d_loss(x, y, window, reduction="none"), loss, atol=1e-9)
    assert losses.ssim3d_loss(x, y, window).item() == pytest.approx(loss.mean(), abs=1e-9)
    assert losses.ssim3d_loss(x, y, window, reduction="sum").item() == pytest.approx(loss.sum(), rel=1e-8)
    assert losses.ssim3d_loss(x, x, window).item() == pytest.approx(0.0, abs=1e-9)
    assert losses.ssim3d_loss(x.float(), y.float(), window).item() == pytest.approx(loss.mean(), abs=1e-5)


def ms_ssim_formula(
    x: np.ndarray, y: np.ndarray, sigmas: list[float], data_range: float, alpha: float, compensation: float
) -> np.ndarray:
    """The formula of Zhao et al. 2017 for a plane, in NumPy."""
    c1, c2 = (0.01 * data_range) ** 2, (0.03 * data_range) ** 2
    product = np.ones_like(x)
    for sigma in sigmas:

        def mean(v: np.ndarray, sigma: float = sigma) -> np.ndarray:
            return gaussian_mean(v, sigma, int(2 * sigmas[-1]))

        mx, my = mean(x), mean(y)
        product = (
            product * (2 * (mean(x * y) - mx * my) + c2) / (mean(x * x) - mx**2 + mean(y * y) - my**2 + c2)
        )
    luminance = (2 * mx * my + c1) / (mx**2 + my**2 + c1)
    return compensation * (alpha * (1 - luminance * product) + (1 - alpha) * mean(np.abs(x - y)) / data_range)


@sizes
@pytest.mark.parametrize(
    ("sigmas", "data_range", "alpha", "compensation"),
    [(None, 1.0, 0.025, 200.0), ([0.7, 1.5, 3.0], 255.0, 0.84, 1.0)],
    ids=["default", "paper"],
)
def test_ms_ssim_equals_the_formula(shape, sigmas, data_range, alpha, compensation) -> None:
    x, y = pair(shape, data_range)
    planes = [
        ms_ssim_formula(
            a.numpy(), b.numpy(), sigmas or [0.5, 1.0, 2.0, 4.0, 8.0], data_range, alpha, compensation
        )
        for a, b in zip(x.flatten(0, 1), y.flatten(0, 1), strict=True)
    ]
    expected = np.stack(planes).reshape(shape)
    actual = losses.ms_ssim_loss(
        x, y, sigmas, data_range, alpha=alpha, compensation=compensation, reduction="none"
    )
    np.testing.assert_allclose(actual, expected, rtol=1e-8, atol=1e-8)
    settings = {"sigmas": sigmas, "data_range": data_range, "alpha": alpha, "compensation": compensation}
    assert losses.ms_ssim_loss(x, y, **settings).item() == pytest.approx(expected.mean(), rel=1e-8)
    assert losses.ms_ssim_loss(x, y, **settings, reduction="sum").item() == pytest.approx(
        expected.sum(), rel=1e-8
    )
    assert losses.ms_ssim_loss(x.float(), y.float(), **settings).item() == pytest.approx(
        expected.mean(), rel=1e-3
    )
    assert isinstance(losses.MS_SSIMLoss(**settings)(x, y), Tensor)


@sizes
def test_total_variation_equals_torchmetrics(shape: tuple[int, ...]) -> None:
    x = photo(*shape, torch.float64)
    actual = losses.total_variation(x)
    assert actual.shape == shape[:2]
    torch.testing.assert_close(actual.sum(1), reference.total_variation(x, "none"))
    a = x.numpy()
    expected = np.abs(np.diff(a, axis=2)).mean((2, 3)) + np.abs(np.diff(a, axis=3)).mean((2, 3))
    np.testing.assert_allclose(losses.total_variation(x, "mean"), expected, rtol=1e-12)
    assert losses.total_variation(x[0, 0, :1]).item() == pytest.approx(np.abs(np.diff(a[0, 0, 0])).sum())


ROBUST = [
    (losses.charbonnier_loss, lambda d: np.sqrt(d**2 + 1) - 1),
    (losses.welsch_loss, lambda d: 1 - np.exp(-(d**2) / 2)),
    (losses.cauchy_loss, lambda d: np.log(d**2 / 2 + 1)),
    (losses.geman_mcclure_loss, lambda d: 2 * d**2 / (d**2 + 4)),
]


@sizes
@pytest.mark.parametrize(("loss", "formula"), ROBUST, ids=lambda f: getattr(f, "__name__", "formula"))
def test_robust_losses_equal_their_formulas(
    loss: Callable, formula: Callable, shape: tuple[int, ...]
) -> None:
    x, y = pair(shape, 5.0)
    expected = formula((x - y).numpy())
    np.testing.assert_allclose(loss(x, y), expected, rtol=1e-12, atol=1e-15)
    assert loss(x, y, "mean").item() == pytest.approx(expected.mean(), rel=1e-12)
    assert loss(x, y, "sum").item() == pytest.approx(expected.sum(), rel=1e-12)
    np.testing.assert_allclose(loss(x.float(), y.float()), expected, rtol=1e-5, atol=1e-6)


def test_no_reduction_has_two_names() -> None:
    x, y = torch.rand(2, 3, 4), torch.rand(2, 3, 4)
    for name in ("Charbonnier", "Cauchy", "GemanMcclure", "Welsch"):
        made = getattr(losses, f"{name}Loss")(reduction=None)
        for module in (made, torch.jit.script(made)):
            assert torch.equal(module(x, y), getattr(losses, f"{name}Loss")(reduction="none")(x, y))


@pytest.mark.parametrize("loss", [f for f, _ in ROBUST], ids=lambda f: f.__name__)
def test_robust_losses_keep_small_differences(loss: Callable) -> None:
    small = torch.tensor([1e-4, 1e-3, 1e-2])
    torch.testing.assert_close(loss(small, torch.zeros(3)), 0.5 * small * small, rtol=1e-4, atol=0.0)


def heatmaps(shape: tuple[int, ...]) -> list[Tensor]:
    generator = torch.Generator().manual_seed(shape[0])
    made = [torch.rand(shape, generator=generator, dtype=torch.float64) for _ in range(2)]
    made[1][..., :2] = 0.0  # zeros contribute no divergence
    return [x / x.sum([-2, -1], keepdim=True) for x in made]


@sizes
def test_divergences_equal_scipy(shape: tuple[int, ...]) -> None:
    p, q = heatmaps(shape)
    expected = scipy.special.rel_entr(q.numpy(), p.numpy()).sum((2, 3))
    np.testing.assert_allclose(losses.kl_div_loss_2d(p, q, "none"), expected, rtol=1e-12)
    assert losses.kl_div_loss_2d(p, q).item() == pytest.approx(expected.mean())
    assert losses.kl_div_loss_2d(p, q, "sum").item() == pytest.approx(expected.sum())
    expected = scipy.spatial.distance.jensenshannon(p.flatten(2).numpy(), q.flatten(2).numpy(), axis=2) ** 2
    np.testing.assert_allclose(losses.js_div_loss_2d(p, q, "none"), expected, rtol=1e-10)
    np.testing.assert_allclose(losses.js_div_loss_2d(q, p, "none"), expected, rtol=1e-10)


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16, torch.float32, torch.float64])
def test_divergence_of_the_least_numbers_is_finite(dtype: torch.dtype) -> None:
    least = torch.finfo(dtype).smallest_normal * torch.finfo(dtype).eps  # the subnormal number next to 0
    p = torch.tensor([[[[least, 1.0]]]], dtype=dtype)
    q = torch.tensor([[[[0.0, 1.0]]]], dtype=dtype)
    assert p[0, 0, 0, 0] > 0
    for value in (losses.js_div_loss_2d(p, q), losses.js_div_loss_2d(q, p)):
        assert value.dtype == dtype and 0.0 <= value.item() < 1e-6
    assert losses.js_div_loss_2d(p, p).item() == 0.0


def test_divergence_of_what_is_impossible() -> None:
    pred, target = (
        torch.tensor(v).reshape(1, 1, 1, 3).requires_grad_(True) for v in ([0.0, 1.0, 0.0], [0.5, 0.5, 0.0])
    )
    value = losses.kl_div_loss_2d(pred, target)
    assert value.item() == math.inf
    for loss in (losses.kl_div_loss_2d, losses.js_div_loss_2d):
        for gradient in torch.autograd.grad(loss(pred, target), [pred, target]):
            assert torch.isfinite(gradient).all()


@sizes
def test_inverse_depth_smoothness_equals_the_formula(shape: tuple[int, ...]) -> None:
    image, depth = photo(*shape, torch.float64), photo(shape[0], 1, *shape[2:], torch.float64).roll(3, 2)
    expected = 0.0
    for axis in (2, 3):
        edge = np.abs(np.diff(image.numpy(), axis=axis)).mean(1, keepdims=True)
        expected += (np.abs(np.diff(depth.numpy(), axis=axis)) * np.exp(-edge)).mean()
    assert losses.inverse_depth_smoothness_loss(depth, image).item() == pytest.approx(expected, rel=1e-12)


WRONG = [
    (lambda: metrics.psnr(X.int(), X, 1.0), TypeError, "image: expected a floating-point"),
    (
        lambda: metrics.psnr(X, X[:, :1], 1.0),
        ValueError,
        r"target: expected image's shape \[1, 2, 4, 5\], got \[1, 1, 4, 5\]",
    ),
    (lambda: losses.psnr_loss(X, X, 0.0), ValueError, "max_val: expected a positive number, got 0.0"),
    (lambda: metrics.ssim3d(X, X, 3), ValueError, r"img1: expected shape \(B, C, D, H, W\)"),
    (lambda: metrics.ssim3d(X[None], X[None, ..., 1:], 3), ValueError, "img2: expected img1's shape"),
    (
        lambda: metrics.ssim3d(X[None], X[None], 2),
        ValueError,
        "window_size: expected a positive odd size, got 2",
    ),
    (
        lambda: metrics.ssim3d(X[None], X[None], 5),
        ValueError,
        "img1: expected more than 2 voxels along each side for window_size 5",
    ),
    (
        lambda: losses.ssim3d_loss(X[None], X[None], 3, reduction="max"),
        ValueError,
        "reduction: expected one of",
    ),
    (
        lambda: losses.ms_ssim_loss(X, X),
        ValueError,
        "img1: expected more than 16 pixels along each side for sigma 8.0",
    ),
    (
        lambda: losses.ms_ssim_loss(X, X, [2.0, 1.0]),
        ValueError,
        "sigmas: expected ascending positive numbers",
    ),
    (
        lambda: losses.ms_ssim_loss(X, X, []),
        ValueError,
        "sigmas: expected the largest to be half a pixel or more",
    ),
    (lambda: losses.ms_ssim_loss(X, X[..., 1:]), ValueError, "img2: expected img1's shape"),
    (lambda: losses.total_variation(X[0, 0, 0]), ValueError, r"img: expected shape \(\*, H, W\)"),
    (lambda: losses.total_variation(X, "none"), ValueError, "reduction: expected one of"),
    (lambda: losses.total_variation(X[..., :1], "mean"), ValueError, "img: expected at least 2 x 2 pixels"),
    (lambda: losses.welsch_loss(X, X[0]), ValueError, "img2: expected img1's shape"),
    (lambda: losses.cauchy_loss(X, X, "max"), ValueError, "reduction: expected one of"),
    (lambda: losses.kl_div_loss_2d(X[0], X[0]), ValueError, r"pred: expected shape \(B, C, H, W\)"),
    (lambda: losses.js_div_loss_2d(X, X[:, :1]), ValueError, "target: expected pred's shape"),
    (
        lambda: losses.inverse_depth_smoothness_loss(X, X),
        ValueError,
        r"idepth: expected shape \(B, 1, H, W\)",
    ),
    (
        lambda: losses.inverse_depth_smoothness_loss(X[:, :1], X[..., 1:]),
        ValueError,
        r"image: expected shape \(B, C, H, W\) for idepth",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
