"""Mutual information against scikit-learn, for values on the bins' centres, and against the definition in
NumPy float64."""

from collections.abc import Callable

import numpy as np
import pytest
import torch
from photos import photo
from scipy.stats import entropy
from sklearn.metrics import mutual_info_score
from torch import Tensor

from chiasm import losses

BINS = 8
SHAPES = [(1, 1, 17, 23), (3, 3, 13, 19), (1, 5, 9, 31)]
X = torch.rand(2, 4, 5)
MASK = torch.ones(2, 4, 5, dtype=torch.bool)

sizes = pytest.mark.parametrize("shape", SHAPES, ids=str)


def levels(shape: tuple[int, ...]) -> tuple[Tensor, Tensor]:
    """Pairs of dependent integers from 0 to BINS - 1, all of which occur."""
    generator = torch.Generator().manual_seed(shape[0])
    x = torch.randint(0, BINS, shape, generator=generator)
    y = (x + torch.randint(0, 3, shape, generator=generator)) // 2
    for v in (x, y):
        v[..., 0], v[..., 1] = 0, BINS - 1
    return x, y


@sizes
def test_of_levels_equals_scikit_learn(shape: tuple[int, ...]) -> None:
    x, y = levels(shape)
    information, normalised = np.empty(shape[:2]), np.empty(shape[:2])
    for at in np.ndindex(*shape[:2]):
        a, b = x[at].flatten().numpy(), y[at].flatten().numpy()
        information[at] = mutual_info_score(a, b)
        single = [entropy(np.bincount(v)) for v in (a, b)]
        normalised[at] = sum(single) / (sum(single) - information[at])
    # any range works
    p, q = x.double() * 0.3 - 7.0, y.double() * 25.0
    np.testing.assert_allclose(
        -losses.mutual_information_loss_2d(p, q, num_bins=BINS), information, rtol=1e-9
    )
    np.testing.assert_allclose(
        -losses.normalized_mutual_information_loss_2d(p, q, num_bins=BINS), normalised, rtol=1e-9
    )
    np.testing.assert_allclose(
        -losses.mutual_information_loss(p.flatten(2), q.flatten(2), num_bins=BINS), information, rtol=1e-9
    )
    np.testing.assert_allclose(
        -losses.mutual_information_loss_3d(p[:, :, None], q[:, :, None], num_bins=BINS),
        information,
        rtol=1e-9,
    )
    actual = losses.normalized_mutual_information_loss_3d(
        p[:, :, None].float(), q[:, :, None].float(), num_bins=BINS
    )
    np.testing.assert_allclose(-actual, normalised, rtol=1e-5)


KERNELS = {
    "xu": lambda d, r: np.select(
        [d / r <= 0.5, d < r], [1 - 0.1 * d / r - 1.8 * (d / r) ** 2, 1.9 - 3.7 * d / r + 1.8 * (d / r) ** 2]
    ),
    "rectangular": lambda d, r: (d < r).astype(float),
    "truncated_gaussian": lambda d, r: np.where(d < r, np.exp(-(d**2) / 2), 0),
}


def by_definition(x: np.ndarray, y: np.ndarray, kernel: str, bins: int, radius: float) -> tuple[float, float]:
    """The mutual information of pairs of values, and its normalised form, with a weight for every value and
    bin."""
    weights = []
    for v in (x, y):
        position = (v - v.min()) / (v.max() - v.min()) * (bins - 1)
        weights.append(KERNELS[kernel](np.abs(position[:, None] - np.arange(bins)), radius))
    joint = weights[0].T @ weights[1]
    single, both = [entropy(joint.sum(k)) for k in (0, 1)], entropy(joint.ravel())
    return sum(single) - both, sum(single) / both


@sizes
@pytest.mark.parametrize(
    ("kernel", "bins", "radius"),
    [("xu", 64, 1.0), ("xu", 9, 2.5), ("rectangular", 16, 0.7), ("truncated_gaussian", 20, 3.0)],
)
def test_equals_the_definition(shape: tuple[int, ...], kernel: str, bins: int, radius: float) -> None:
    x = photo(*shape, torch.float64) + 1e-3 * torch.rand(
        shape, generator=torch.Generator().manual_seed(1), dtype=torch.float64
    )
    y = (x * x).roll(1, 3)
    masks = [torch.rand(shape, generator=torch.Generator().manual_seed(k)) < 0.7 for k in (2, 3)]
    for given in ([None, None], masks, [masks[0], None]):
        counts = torch.ones_like(masks[0])
        for mask in given:
            counts = counts if mask is None else counts & mask
        expected = np.empty((*shape[:2], 2))
        for at in np.ndindex(*shape[:2]):
            expected[at] = by_definition(
                x[at][counts[at]].numpy(), y[at][counts[at]].numpy(), kernel, bins, radius
            )
        settings = (*given, kernel, bins, radius)
        np.testing.assert_allclose(
            -losses.mutual_information_loss_2d(x, y, *settings), expected[..., 0], rtol=1e-8, atol=1e-10
        )
        np.testing.assert_allclose(
            -losses.normalized_mutual_information_loss_2d(x, y, *settings), expected[..., 1], rtol=1e-8
        )


def test_masked_values_change_nothing() -> None:
    x, y = torch.rand(2, 30, dtype=torch.float64), torch.rand(2, 30, dtype=torch.float64)
    mask = torch.rand(2, 30) < 0.6
    wild = torch.where(mask, x, torch.full_like(x, float("nan"))).requires_grad_(True)
    value = losses.mutual_information_loss(wild, y, mask, num_bins=BINS)
    torch.testing.assert_close(value, losses.mutual_information_loss(x, y, mask, num_bins=BINS))
    value.sum().backward()
    assert torch.equal(wild.grad[~mask], torch.zeros_like(wild.grad[~mask]))
    assert torch.isfinite(wild.grad).all() and wild.grad.abs().sum() > 0


def test_of_constants_and_of_nothing() -> None:
    flat, x = torch.full((1, 20), 3.0), torch.rand(1, 20)
    for a, b, mask in ((flat, x, None), (flat, flat, None), (x, x, torch.zeros(1, 20, dtype=torch.bool))):
        a, b = a.clone().requires_grad_(True), b.clone().requires_grad_(True)
        plain, normalised = (
            loss(a, b, mask)
            for loss in (losses.mutual_information_loss, losses.normalized_mutual_information_loss)
        )
        assert plain.item() == pytest.approx(0.0, abs=1e-6)
        assert normalised.item() == pytest.approx(-1.0, abs=1e-6)
        for gradient in torch.autograd.grad(plain.sum() + normalised.sum(), [a, b]):
            assert torch.isfinite(gradient).all()


def test_descent_aligns_images() -> None:
    """The mutual information of an image and the same image in other colours decreases as one is moved."""
    x = photo(1, 1, 60, 70, torch.float64)
    values = [
        losses.mutual_information_loss_2d(x, (1.0 - x).pow(2).roll(k, 3), num_bins=32).item()
        for k in range(5)
    ]
    assert values == sorted(values)


WRONG = [
    (lambda: losses.mutual_information_loss(X.int(), X), TypeError, "input: expected a floating-point"),
    (lambda: losses.mutual_information_loss(X, X[:1]), ValueError, "target: expected input's shape"),
    (
        lambda: losses.mutual_information_loss(X[0, 0, 0], X[0, 0, 0]),
        ValueError,
        r"input: expected shape \(\*, N\), got a scalar",
    ),
    (lambda: losses.mutual_information_loss(X, X, X), TypeError, "input_mask: expected dtype torch.bool"),
    (
        lambda: losses.mutual_information_loss(X, X, MASK, MASK[..., :1]),
        ValueError,
        "target_mask: expected the signals' shape",
    ),
    (
        lambda: losses.mutual_information_loss(X, X, kernel_function="box"),
        ValueError,
        "kernel_function: expected one of",
    ),
    (
        lambda: losses.normalized_mutual_information_loss(X, X, num_bins=1),
        ValueError,
        "num_bins: expected at least 2, got 1",
    ),
    (
        lambda: losses.normalized_mutual_information_loss(X, X, window_radius=0.5),
        ValueError,
        "window_radius: expected more than half a bin",
    ),
    (
        lambda: losses.mutual_information_loss_2d(X[0, 0], X[0, 0]),
        ValueError,
        "input: expected at least 2 dimensions",
    ),
    (
        lambda: losses.normalized_mutual_information_loss_3d(X[0], X[0]),
        ValueError,
        "input: expected at least 3 dimensions",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
