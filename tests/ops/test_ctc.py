"""CTC's decoders: against all alignments, torch's loss, and the search with dictionaries of prefixes."""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Callable

import numpy as np
import pytest
import torch
import torch.nn.functional as F
from torch import Tensor

from chiasm import ops


def collapsed(path: tuple[int, ...], blank: int) -> tuple[int, ...]:
    return tuple(c for c, _ in itertools.groupby(path) if c != blank)


def all_sequences(log_probs: np.ndarray, blank: int) -> dict[tuple[int, ...], float]:
    """The probability of each sequence of labels, by adding up all alignments."""
    sums: dict[tuple[int, ...], float] = defaultdict(float)
    steps, classes = log_probs.shape
    for path in itertools.product(range(classes), repeat=steps):
        sums[collapsed(path, blank)] += math.exp(sum(log_probs[t, c] for t, c in enumerate(path)))
    return sums


def searched(log_probs: np.ndarray, beam: int, blank: int) -> list[tuple[tuple[int, ...], float]]:
    """Hannun's algorithm 1 without a language model: a dictionary of prefixes, each with two
    probabilities."""
    prefixes: dict[tuple[int, ...], tuple[float, float]] = {(): (1.0, 0.0)}
    for step in np.exp(log_probs):
        found: dict[tuple[int, ...], list[float]] = defaultdict(lambda: [0.0, 0.0])
        for prefix, (with_blank, with_label) in prefixes.items():
            for c, p in enumerate(step):
                if c == blank:
                    found[prefix][0] += p * (with_blank + with_label)
                elif prefix and c == prefix[-1]:
                    found[prefix][1] += p * with_label
                    found[(*prefix, c)][1] += p * with_blank
                else:
                    found[(*prefix, c)][1] += p * (with_blank + with_label)
        ranked = sorted(found.items(), key=lambda item: -sum(item[1]))[:beam]
        prefixes = {prefix: (b, n) for prefix, (b, n) in ranked}
    return [(prefix, b + n) for prefix, (b, n) in prefixes.items()]


def log_probabilities(seed: int, *shape: int, sharpness: float = 1.5) -> Tensor:
    generator = torch.Generator().manual_seed(seed)
    return (torch.randn(shape, generator=generator, dtype=torch.float64) * sharpness).log_softmax(-1)


def sequence(labels: Tensor, length: Tensor) -> tuple[int, ...]:
    return tuple(labels[: int(length)].tolist())


@pytest.mark.parametrize("blank", [0, 2])
@pytest.mark.parametrize("seed", range(4))
def test_a_wide_beam_has_every_sequence_with_its_probability(seed: int, blank: int) -> None:
    log_probs = log_probabilities(seed, 2, 5, 3)
    lengths = torch.tensor([5, 4])
    labels, counts, scores = ops.ctc_beam_decode(log_probs, lengths, 80, blank)
    for b in range(2):
        expected = all_sequences(log_probs[b, : lengths[b]].numpy(), blank)
        used = scores[b] > -math.inf
        found = [sequence(labels[b, k], counts[b, k]) for k in range(80) if used[k]]
        assert len(found) == len(set(found)) == len(expected) < 80
        for k, each in enumerate(found):
            assert math.exp(scores[b, k]) == pytest.approx(expected[each], rel=1e-12)
        assert (scores[b].diff()[: len(found) - 1] <= 0).all()
        assert (labels[b, len(found) :] == blank).all() and not counts[b, len(found) :].any()
        assert all((labels[b, k, counts[b, k] :] == blank).all() for k in range(80))


def test_scores_are_torchs_loss() -> None:
    log_probs = log_probabilities(0, 3, 6, 4)
    lengths = torch.tensor([6, 5, 3])
    labels, counts, scores = ops.ctc_beam_decode(log_probs, lengths, 400)
    for k in range(10):
        loss = F.ctc_loss(
            log_probs.transpose(0, 1), labels[:, k], lengths, counts[:, k], blank=0, reduction="none"
        )
        torch.testing.assert_close(scores[:, k], -loss, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("beam", [1, 2, 5, 16])
@pytest.mark.parametrize("sharpness", [0.5, 3.0])
def test_a_narrow_beam_is_the_search_with_dictionaries(beam: int, sharpness: float) -> None:
    log_probs = log_probabilities(beam, 3, 25, 9, sharpness=sharpness)
    labels, counts, scores = ops.ctc_beam_decode(log_probs, torch.full([3], 25), beam, 4)
    for b in range(3):
        expected = searched(log_probs[b].numpy(), beam, 4)
        assert [sequence(labels[b, k], counts[b, k]) for k in range(beam)] == [each for each, _ in expected]
        np.testing.assert_allclose(scores[b], np.log([p for _, p in expected]), rtol=1e-10)


def test_long_sequences_do_not_underflow() -> None:
    log_probs = log_probabilities(1, 1, 400, 50, sharpness=0.2).float()
    labels, counts, scores = ops.ctc_beam_decode(log_probs, torch.tensor([400]), 4)
    assert torch.isfinite(scores).all() and (scores < -745).all() and scores.dtype == torch.float32
    assert labels.shape == (1, 4, 400) and (counts > 0).all()


def test_ties_go_to_what_comes_first() -> None:
    log_probs = torch.full((1, 2, 3), 1 / 3).log()
    labels, counts, scores = ops.ctc_beam_decode(log_probs, torch.tensor([2]), 8)
    # [1] and [2] have three alignments each, the others one
    found = [sequence(labels[0, k], counts[0, k]) for k in range(5)]
    assert found == [(1,), (2,), (), (1, 2), (2, 1)]
    torch.testing.assert_close(scores[0, :5].exp() * 9, torch.tensor([3.0, 3.0, 1.0, 1.0, 1.0]))


@pytest.mark.parametrize("blank", [0, 3])
@pytest.mark.parametrize("classes", [4, 20])
def test_greedy(classes: int, blank: int) -> None:
    random = np.random.default_rng(classes)
    # Few levels, which give ties and repetitions
    log_probs = -random.integers(0, 4, (8, 30, classes)).astype(np.float64)
    lengths = np.array([30, 29, 1, 0, 17, -2, 99, 2])
    labels, counts, scores = ops.ctc_greedy_decode(
        torch.from_numpy(log_probs), torch.from_numpy(lengths), blank
    )
    for b in range(8):
        valid = log_probs[b, : max(lengths[b], 0)]
        expected = collapsed(tuple(valid.argmax(1)), blank)
        assert sequence(labels[b], counts[b]) == expected
        assert (labels[b, len(expected) :] == blank).all()
        assert scores[b] == valid.max(1).sum() if len(valid) else scores[b] == 0


def test_no_steps_and_no_samples() -> None:
    for decode in (ops.ctc_greedy_decode, ops.ctc_beam_decode):
        assert decode(torch.zeros(0, 4, 3), torch.zeros(0, dtype=torch.int64))[1].numel() == 0
    labels, counts, scores = ops.ctc_beam_decode(torch.zeros(1, 4, 3), torch.tensor([0]), 2)
    assert not labels.any() and not counts.any() and scores.tolist() == [[0.0, -math.inf]]


X, L = torch.rand(2, 5, 3), torch.tensor([5, 5])


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: ops.ctc_greedy_decode(X[0], L), ValueError, r"log_probs: expected shape \(B, T, C\)"),
        (lambda: ops.ctc_greedy_decode(X.int(), L), TypeError, "log_probs: expected a floating-point"),
        (lambda: ops.ctc_greedy_decode(X, L[:1]), ValueError, r"lengths: expected shape \(B,\)"),
        (lambda: ops.ctc_beam_decode(X, L.int()), TypeError, "lengths: expected dtype int64"),
        (lambda: ops.ctc_beam_decode(X, L, 0), ValueError, "beam: expected a positive"),
        (lambda: ops.ctc_beam_decode(X, L, 3, 3), ValueError, "blank: expected one of 3 classes, got 3"),
        (lambda: ops.ctc_greedy_decode(X, L, -1), ValueError, "blank: expected one of"),
    ],
)
def test_errors(call: Callable[[], Tensor], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
