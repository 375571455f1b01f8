"""Matching against OpenCV's brute-force matcher and loops in NumPy."""

import cv2
import numpy as np
import pytest
import torch
from torch import Tensor

from chiasm import feature
from chiasm.export.catalog.feature_frames import frames


def descriptors(batch: int, count: int, others: int, size: int = 32) -> tuple[Tensor, Tensor]:
    """Unit vectors; most of the second set are noisy copies of the first."""
    generator = torch.Generator().manual_seed(count)
    first = torch.randn(batch, count, size, generator=generator)
    second = torch.randn(batch, others, size, generator=generator)
    shared = min(count, others) * 2 // 3
    second[:, :shared] = first[:, :shared].flip(1) + 0.5 * second[:, :shared]
    return first / first.norm(dim=-1, keepdim=True), second / second.norm(dim=-1, keepdim=True)


def pairs(found: tuple[Tensor, Tensor, Tensor], sample: int) -> dict[tuple[int, int], float]:
    distances, indices, valid = (part[sample] for part in found)
    assert (indices[~valid] == -1).all() and (distances[~valid] == 0).all()
    return {tuple(i): float(d) for i, d in zip(indices[valid].tolist(), distances[valid], strict=True)}


def assert_pairs(actual: dict, expected: dict) -> None:
    assert set(actual) == set(expected)
    np.testing.assert_allclose([actual[k] for k in expected], list(expected.values()), rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize(("batch", "count", "others"), [(1, 50, 41), (3, 23, 37)])
def test_nearest_and_mutual(batch: int, count: int, others: int) -> None:
    first, second = descriptors(batch, count, others)
    for function, cross in ((feature.match_nn, False), (feature.match_mnn, True)):
        found = function(first, second)
        for b in range(batch):
            matches = cv2.BFMatcher(cv2.NORM_L2, crossCheck=cross).match(first[b].numpy(), second[b].numpy())
            assert_pairs(pairs(found, b), {(m.queryIdx, m.trainIdx): m.distance for m in matches})


def ratios(first: np.ndarray, second: np.ndarray, th: float) -> dict[tuple[int, int], float]:
    both = cv2.BFMatcher(cv2.NORM_L2).knnMatch(first, second, k=2)
    return {
        (m.queryIdx, m.trainIdx): m.distance / n.distance for m, n in both if m.distance <= th * n.distance
    }


@pytest.mark.parametrize(("batch", "count", "others", "th"), [(1, 50, 41, 0.8), (3, 23, 37, 0.95)])
def test_ratios(batch: int, count: int, others: int, th: float) -> None:
    first, second = descriptors(batch, count, others)
    one_way, both_ways = feature.match_snn(first, second, th), feature.match_smnn(first, second, th)
    for b in range(batch):
        there = ratios(first[b].numpy(), second[b].numpy(), th)
        back = {(i, j): r for (j, i), r in ratios(second[b].numpy(), first[b].numpy(), th).items()}
        assert_pairs(pairs(one_way, b), there)
        assert_pairs(pairs(both_ways, b), {k: max(there[k], back[k]) for k in set(there) & set(back)})
    for actual, expected in zip(feature.match_smnn_batched(first, second, th), both_ways, strict=True):
        torch.testing.assert_close(actual, expected)


@pytest.mark.parametrize(
    "function", [feature.match_nn, feature.match_mnn, feature.match_snn, feature.match_smnn]
)
def test_without_a_batch_and_with_given_distances(function: object) -> None:
    first, second = descriptors(1, 30, 21)
    expected = function(first, second)
    for actual, part in zip(function(first[0], second[0]), expected, strict=True):
        torch.testing.assert_close(actual, part[0])
    dm = torch.cdist(first.double(), second.double()).float()
    scripted = torch.jit.script(function)
    for made in (function(first, second, dm=dm), scripted(first, second, dm=dm)):
        for actual, part in zip(made, expected, strict=True):
            torch.testing.assert_close(actual, part)


@pytest.mark.parametrize(
    "function", [feature.match_nn, feature.match_mnn, feature.match_snn, feature.match_smnn]
)
def test_masks_leave_descriptors_out(function: object) -> None:
    first, second = descriptors(1, 30, 21)
    mask1, mask2 = torch.arange(30)[None] % 4 != 0, torch.arange(21)[None] % 3 != 1
    actual = pairs(function(first, second, mask1=mask1, mask2=mask2), 0)
    rows, columns = mask1[0].nonzero()[:, 0], mask2[0].nonzero()[:, 0]
    expected = pairs(function(first[:, rows], second[:, columns]), 0)
    assert_pairs(actual, {(int(rows[i]), int(columns[j])): d for (i, j), d in expected.items()})
    assert not function(first, second, mask2=torch.zeros(1, 21, dtype=torch.bool))[2].any()


def test_equal_descriptors_go_to_the_first() -> None:
    """Hundreds of copies, whose products the library sums in different orders."""
    one = torch.randn(1, 1, 128, generator=torch.Generator().manual_seed(0))
    first, second = one.expand(1, 203, 128) + 0.0, one.expand(1, 317, 128) + 0.25
    _, indices, valid = feature.match_nn(first, second)
    assert valid.all() and (indices[..., 1] == 0).all()
    assert feature.match_mnn(first, second)[2].tolist() == [[True] + [False] * 202]
    assert not feature.match_snn(first, second, 0.999)[2].any()
    assert feature.match_snn(first, second, 1.0)[2].all()
    assert feature.match_snn(first, first.clone(), 1.0)[0].eq(1).all()  # 0 / 0


def test_distances_of_near_descriptors_keep_their_digits() -> None:
    first = torch.randn(1, 40, 128, generator=torch.Generator().manual_seed(0))
    first = first / first.norm(dim=-1, keepdim=True)
    second = first.flip(1) + 1e-5 * torch.randn(1, 40, 128, generator=torch.Generator().manual_seed(1))
    distances, indices, _ = feature.match_mnn(first, second)
    assert (indices[0, :, 1] == torch.arange(39, -1, -1)).all()
    exact = np.linalg.norm(first[0].double().numpy() - second.flip(1)[0].double().numpy(), axis=-1)
    np.testing.assert_allclose(distances[0, :, 0], exact, rtol=1e-6)


def test_one_descriptor_has_no_ratio() -> None:
    first, second = descriptors(1, 5, 1)
    assert feature.match_nn(first, second)[2].all()
    assert not feature.match_snn(first, second, 1.0)[2].any()


@pytest.mark.parametrize(("batch", "n1", "n2"), [(1, 5, 0), (1, 0, 5), (2, 0, 0), (0, 5, 4)])
def test_nothing_matches_an_empty_set(batch: int, n1: int, n2: int) -> None:
    first, second = torch.rand(batch, n1, 8), torch.rand(batch, n2, 8)
    laf1, laf2 = torch.rand(batch, n1, 2, 3), torch.rand(batch, n2, 2, 3)
    masks = {"mask1": torch.ones(batch, n1) > 0, "mask2": torch.ones(batch, n2) > 0}
    for found in (
        feature.match_nn(first, second, **masks),
        feature.match_mnn(first, second),
        feature.match_snn(first, second),
        feature.match_smnn(first, second, **masks),
        feature.match_fginn(first, second, laf1, laf2, mutual=True),
        feature.match_adalam(first, second, laf1, laf2, 20.0),
    ):
        distances, indices, valid = found
        assert distances.shape == (batch, n1, 1) and indices.shape == (batch, n1, 2)
        assert valid.shape == (batch, n1) and not valid.any()
        assert distances.eq(0).all() and indices.eq(-1).all()
    if batch == 1:
        assert len(feature.only_matches(*feature.match_nn(first[0], second[0]))[0]) == 0


@pytest.mark.parametrize("mutual", [False, True])
@pytest.mark.parametrize("batch", [1, 3])
def test_fginn(batch: int, mutual: bool) -> None:
    first, second = descriptors(batch, 31, 43)
    second[:, 30:36] = second[:, 0:6] + 0.01  # duplicates, some of them at the same position
    laf1, laf2 = (
        frames(torch.Generator().manual_seed(n), {"B": batch, "N": n, "H": 60, "W": 80}).float()
        for n in (31, 43)
    )
    laf2[:, 30:33, :, 2] = laf2[:, 0:3, :, 2] + 2.0
    found = feature.match_fginn(first, second, laf1, laf2, 0.85, 9.0, mutual)
    for b in range(batch):
        d = np.linalg.norm(first[b, :, None].double().numpy() - second[b].double().numpy(), axis=-1)
        expected = {}
        for i in range(31):
            j = int(np.argmin(d[i]))
            away = np.linalg.norm((laf2[b, :, :, 2] - laf2[b, j, :, 2]).numpy(), axis=-1) > 9.0
            ratio = d[i, j] / d[i][away].min()
            if ratio <= 0.85 and (not mutual or np.argmin(d[:, j]) == i):
                expected[i, j] = ratio
        assert_pairs(pairs(found, b), expected)
        assert len(expected) > len(pairs(feature.match_snn(first, second, 0.85), b)) or mutual


def test_zero_distances_have_gradients() -> None:
    first = torch.rand(1, 4, 8, requires_grad=True)
    feature.match_nn(first, first.detach().clone())[0].sum().backward()
    assert (first.grad == 0).all()


A, B, FRAME = torch.zeros(3, 4), torch.zeros(5, 4), torch.zeros(1, 5, 2, 3)
WRONG = [
    (lambda: feature.match_nn(A.int(), B), TypeError, "desc1: expected a floating-point tensor"),
    (
        lambda: feature.match_nn(A[0], B),
        ValueError,
        r"desc1: expected shape \(N1, D\) or \(B, N1, D\), got \[4\]",
    ),
    (
        lambda: feature.match_nn(A, B[:, :3]),
        ValueError,
        "desc2: expected descriptors like those of desc1",
    ),
    (lambda: feature.match_nn(A[None], B.expand(2, 5, 4)), ValueError, "desc2: expected desc1's batch of 1"),
    (lambda: feature.match_mnn(A, B, torch.zeros(5, 3)), ValueError, "dm: expected 3 x 5 distances"),
    (
        lambda: feature.match_nn(A[None], B[None], torch.zeros(2, 3, 5)),
        ValueError,
        "dm: expected desc1's batch of 1",
    ),
    (lambda: feature.match_snn(A, B, mask1=torch.ones(3)), TypeError, "mask1: expected dtype torch.bool"),
    (
        lambda: feature.match_smnn(A, B, mask2=torch.ones(3) > 0),
        ValueError,
        "mask2: expected one entry for each of 5",
    ),
    (lambda: feature.match_smnn_batched(A, B), ValueError, r"desc1: expected shape \(B, N1, D\)"),
    (
        lambda: feature.match_fginn(A, B, FRAME[:, :3], FRAME[:, :3]),
        ValueError,
        "lafs2: expected a frame for each of 5",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
