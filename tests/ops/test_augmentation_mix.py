"""Mixes of a batch's images and labels against loops in NumPy with the drawn numbers; policies."""

import math

import numpy as np
import pytest
import torch
from scipy import stats
from torch import Tensor

from chiasm import augmentation as A
from chiasm.augmentation.distributions import beta, gamma
from chiasm.primitives.random.draws import uniform

SEED = torch.arange(20, 28)
LABEL = torch.tensor([3, 1, 4, 1, 5, 9, 2, 6])
MANY = torch.arange(4000)
P = 0.6


def images(batch: int = 8, channels: int = 3, height: int = 12, width: int = 15) -> Tensor:
    return torch.rand(batch, channels, height, width, generator=torch.Generator().manual_seed(3)).double()


def permutation(keys: Tensor) -> list[int]:
    """Sample b gets the sample whose index is the rank of b's key."""
    return [sorted(keys.tolist()).index(key) for key in keys.tolist()]


def test_mix_up() -> None:
    x, u = images(), uniform(SEED, 3)
    mixed, labels = A.random_mix_up(x, LABEL, SEED, (0.1, 0.6), P)
    partner = permutation(u[:, 2])
    assert sorted(partner) == list(range(8)) and 0 < int((u[:, 0] < P).sum()) < 8
    for b in range(8):
        share = float(u[b, 1]) * 0.5 + 0.1 if u[b, 0] < P else 0.0
        for index in np.ndindex(*x.shape[1:]):
            expected = float(x[b][index]) * (1 - share) + float(x[partner[b]][index]) * share
            assert float(mixed[b][index]) == pytest.approx(expected, abs=1e-6)
        assert labels[b].tolist() == pytest.approx([int(LABEL[b]), int(LABEL[partner[b]]), share], abs=1e-6)


@pytest.mark.parametrize("correct", [False, True])
def test_cut_mix(correct: bool) -> None:
    x, u = images(), uniform(SEED, 7)
    mixed, labels = A.random_cut_mix(x, LABEL, SEED, 2, (0.1, 0.8), 1.0, correct, P)
    kept = beta(SEED, 1.0, 2, 1).clamp(0.1, 0.8)
    expected = x.numpy().copy()
    for i in range(2):
        partner = permutation(u[:, 1 + 3 * i])
        for b in range(8):
            side = math.sqrt(1 - float(kept[b, i])) if u[b, 0] < P else 0.0
            high, wide = int(side * 12), int(side * 15)
            top, left = int(float(u[b, 2 + 3 * i]) * (13 - high)), int(float(u[b, 3 + 3 * i]) * (16 - wide))
            for y in range(top, top + high):
                for column in range(left, left + wide):
                    expected[b, :, y, column] = x[partner[b], :, y, column]
            share = high * wide / (12 * 15)
            share = 1 - share if correct else share
            assert labels[i, b].tolist() == pytest.approx(
                [int(LABEL[b]), int(LABEL[partner[b]]), share], abs=1e-6
            )
    np.testing.assert_array_equal(mixed.numpy(), expected)


def test_rectangles_lie_anywhere_within_the_image() -> None:
    x = torch.arange(len(MANY), dtype=torch.float64).reshape(-1, 1, 1, 1).expand(-1, 1, 4, 4)
    mixed, _ = A.random_cut_mix(x, MANY, MANY, cut_size=(0.75, 0.75))  # 2 x 2 pixels
    pasted = mixed != x
    found = pasted.flatten(1).to(torch.int64).argmax(1)[pasted.flatten(1).any(1)]
    _, counts = found.unique(return_counts=True)
    assert len(counts) == 9
    assert stats.chisquare(counts.numpy()).pvalue > 0.01


def test_jigsaw_puts_tiles_into_an_order() -> None:
    x, u, keys = images(height=12, width=16), uniform(SEED, 1), uniform(SEED, 6, 1)
    y = A.random_jigsaw(x, SEED, (3, 2), p=P)
    for b in range(8):
        order = permutation(keys[b]) if u[b, 0] < P else list(range(6))
        for place, tile in enumerate(order):
            to = (
                slice(None),
                slice(place // 2 * 4, place // 2 * 4 + 4),
                slice(place % 2 * 8, place % 2 * 8 + 8),
            )
            of = (slice(None), slice(tile // 2 * 4, tile // 2 * 4 + 4), slice(tile % 2 * 8, tile % 2 * 8 + 8))
            assert y[b][to].equal(x[b][of])


def test_jigsaw_orders_are_equally_likely_and_the_old_one_can_be_excluded() -> None:
    x = torch.arange(3.0).reshape(1, 1, 1, 3).expand(len(MANY), 1, 1, 3)
    _, counts = A.random_jigsaw(x, MANY, (1, 3), False, 1.0).flatten(1).unique(dim=0, return_counts=True)
    assert len(counts) == 6 and stats.chisquare(counts.numpy()).pvalue > 0.01
    changed = A.random_jigsaw(x, MANY, (1, 3), True, 1.0).flatten(1)
    assert (changed != x.flatten(1)).any(1).all()
    alone = torch.cat([A.random_jigsaw(images()[b : b + 1], SEED[b : b + 1], (3, 3), p=P) for b in range(8)])
    assert A.random_jigsaw(images(), SEED, (3, 3), p=P).equal(alone)


def test_transplantation() -> None:
    x, u = images(), uniform(SEED, 2)
    mask = torch.randint(0, 5, (8, 12, 15), generator=torch.Generator().manual_seed(1))
    mask[5] = 2
    mixed, labels = A.random_transplantation(x, mask, SEED, [2], P)
    partner = permutation(u[:, 1])
    for b in range(8):
        candidates = [label for label in mask[partner[b]].unique().tolist() if label != 2]
        if u[b, 0] >= P or not candidates:
            assert mixed[b].equal(x[b]) and labels[b].equal(mask[b])
            continue
        fits = []
        for label in candidates:
            expected_x, expected_mask = x[b].clone(), mask[b].clone()
            for y, column in np.ndindex(12, 15):
                if mask[partner[b], y, column] == label:
                    expected_x[:, y, column] = x[partner[b], :, y, column]
                    expected_mask[y, column] = label
            fits.append(mixed[b].equal(expected_x) and labels[b].equal(expected_mask))
        assert any(fits)


def test_every_label_is_transplanted_equally_often() -> None:
    # one pixel of 7, two of -1, five of 1e12: the choice does not depend on the number of pixels
    own = torch.zeros(1, 1, 8, dtype=torch.int64)
    donor = torch.tensor([[[7, -1, -1, 10**12, 10**12, 10**12, 10**12, 10**12]]])
    counts = {7: 0, -1: 0, 10**12: 0}
    for seed in range(600):
        pair = torch.tensor([2 * seed, 2 * seed + 1])
        mask = torch.cat([own, donor])
        _, labels = A.random_transplantation(torch.zeros(2, 1, 1, 8), mask, pair, [], 1.0)
        for label in labels[0].unique().tolist():
            if label != 0:
                counts[label] += 1
    assert sum(counts.values()) > 200
    assert stats.chisquare(list(counts.values())).pvalue > 0.01


@pytest.mark.parametrize("alpha", [0.3, 1.0, 2.5, 20.0])
def test_gamma_and_beta(alpha: float) -> None:
    numbers = gamma(MANY, alpha, 2, 0).double()
    assert stats.kstest(numbers.flatten().numpy(), stats.gamma(alpha).cdf).pvalue > 0.01
    shares = beta(MANY, alpha, 2, 0).double()
    assert stats.kstest(shares.flatten().numpy(), stats.beta(alpha, alpha).cdf).pvalue > 0.01
    assert beta(MANY[:5], alpha, 2, 0).equal(beta(MANY, alpha, 2, 0)[:5])


def test_replay_and_probability_of_zero() -> None:
    x, mask = images(), torch.randint(0, 5, (8, 12, 15))
    for op, more in (
        (A.random_mix_up, [LABEL, SEED]),
        (A.random_cut_mix, [LABEL, SEED]),
        (A.random_transplantation, [mask, SEED, [0]]),
    ):
        first, again = op(x, *more), op(x, *more)
        assert all(a.equal(b) for a, b in zip(first, again, strict=True))
        assert op(x, *more, p=0.0)[0].equal(x)
    assert A.random_jigsaw(x, SEED, (3, 3), p=0.0).equal(x)


def test_what_is_refused() -> None:
    x = images()
    with pytest.raises(ValueError, match=r"label: expected shape \(8,\), got \[7\]"):
        A.random_mix_up(x, LABEL[:7], SEED)
    with pytest.raises(ValueError, match="num_mix: expected at least 1, got 0"):
        A.random_cut_mix(x, LABEL, SEED, 0)
    with pytest.raises(ValueError, match="beta: expected a positive number"):
        A.random_cut_mix(x, LABEL, SEED, beta=0.0)
    with pytest.raises(ValueError, match="grid: expected numbers that divide the image 12 x 15, got"):
        A.random_jigsaw(x, SEED, (4, 4))
    with pytest.raises(TypeError, match="mask: expected an int64 tensor"):
        A.random_transplantation(x, x[:, 0], SEED, [])
    with pytest.raises(ValueError, match="mask: expected shape"):
        A.random_transplantation(x, torch.zeros(8, 3, 3, dtype=torch.int64), SEED, [])
    with pytest.raises(TypeError, match="seed: expected an int64 tensor"):
        A.random_mix_up(x, LABEL, SEED.float())
