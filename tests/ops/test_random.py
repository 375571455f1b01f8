"""Random draws: the published vectors of Philox, a reference in integers, and distributions."""

import numpy as np
import pytest
import torch
from scipy import stats

from chiasm.primitives.random.draws import integers, normal, ranks, split, uniform, uniform_like, words
from chiasm.primitives.random.philox import philox4x32

#: Counter, key and result of philox4x32-10: the known answers of Random123.
KNOWN = [
    ("00000000 00000000 00000000 00000000", "00000000 00000000", "6627e8d5 e169c58d bc57ac4c 9b00dbd8"),
    ("ffffffff ffffffff ffffffff ffffffff", "ffffffff ffffffff", "408f276d 41c83b0e a20bc7c6 6d5451fd"),
    ("243f6a88 85a308d3 13198a2e 03707344", "a4093822 299f31d0", "d16cfe09 94fdcceb 5001e420 24126ea1"),
]


def reference(counter: list[int], key: list[int]) -> list[int]:
    """The definition, in integers of any size."""
    mask = 2**32 - 1
    c, k = list(counter), list(key)
    for _ in range(10):
        first, third = 0xD2511F53 * c[0], 0xCD9E8D57 * c[2]
        c = [(third >> 32) ^ c[1] ^ k[0], third & mask, (first >> 32) ^ c[3] ^ k[1], first & mask]
        k = [(k[0] + 0x9E3779B9) & mask, (k[1] + 0xBB67AE85) & mask]
    return c


@pytest.mark.parametrize(("counter", "key", "expected"), KNOWN)
def test_known_answers(counter: str, key: str, expected: str) -> None:
    c = [torch.tensor([int(w, 16)]) for w in counter.split()]
    k = [torch.tensor([int(w, 16)]) for w in key.split()]
    assert [f"{int(w):08x}" for w in philox4x32(c, k)] == expected.split()


def test_whole_numbers_of_any_size() -> None:
    drawn = np.random.default_rng(0).integers(0, 2**32, (100, 6))
    found = philox4x32(
        [torch.from_numpy(drawn[:, i]) for i in range(4)], list(torch.from_numpy(drawn[:, 4:]).T)
    )
    for i, row in enumerate(drawn.tolist()):
        assert [int(w[i]) for w in found] == reference(row[:4], row[4:])


@pytest.mark.parametrize("seed", [0, -1, 2**63 - 1, -(2**63), 123456789012345])
def test_words_and_seeds_are_those_of_the_counters(seed: int) -> None:
    key = [seed & (2**32 - 1), (seed >> 32) & (2**32 - 1)]
    expected = reference([0, 7, 0, 0], key) + reference([1, 7, 0, 0], key)
    assert words(torch.tensor([seed]), 6, 7).tolist() == [expected[:6]]
    low, high = reference([3, 0, 1, 0], key)[:2]
    assert int(split(torch.tensor([seed]), 5)[3]) % 2**64 == high * 2**32 + low


def test_the_first_of_more() -> None:
    seed = torch.tensor([4, 5])
    assert torch.equal(uniform(seed, 9)[:, :3], uniform(seed, 3))
    assert torch.equal(normal(seed, 9)[:, :4], normal(seed, 4))
    assert torch.equal(uniform_like(torch.zeros(2, 3, 5), seed).reshape(2, 15), uniform(seed, 15))


def test_distributions() -> None:
    seed = torch.arange(200)
    u = uniform(seed, 100)
    assert u.min() >= 0.0
    assert u.max() < 1.0
    assert stats.kstest(u.flatten(), "uniform").pvalue > 0.01
    assert stats.kstest(u[:, 0], "uniform").pvalue > 0.01  # for consecutive seeds
    assert stats.kstest(normal(seed, 101).flatten(), "norm").pvalue > 0.01
    counts = torch.bincount(integers(seed, 6, 100, 1).flatten(), minlength=6)
    assert stats.chisquare(counts).pvalue > 0.01
    orders = ranks(words(torch.arange(6000), 3))
    assert torch.equal(orders.sort(1).values, torch.arange(3).expand(6000, 3))
    assert (
        stats.chisquare(torch.bincount(orders @ torch.tensor([9, 3, 1]))[[5, 7, 11, 15, 19, 21]]).pvalue
        > 0.01
    )


def test_streams_samples_and_splits_are_independent() -> None:
    seed = torch.arange(500)
    draws = torch.stack(
        [uniform(seed, 1)[:, 0], uniform(seed, 1, 1)[:, 0], uniform(split(seed, 1)[0], 1)[:, 0]]
    )
    assert torch.corrcoef(draws)[torch.triu(torch.ones(3, 3), 1).bool()].abs().max() < 0.12
