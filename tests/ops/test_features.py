"""Harris and keypoints against SciPy and NumPy."""

import numpy as np
import pytest
import scipy.ndimage as ndi
import torch
from photos import photo

from chiasm.feature import harris_keypoints, harris_response
from chiasm.geometry.subpix import nms2d
from chiasm.primitives.core.target import exporting
from chiasm.primitives.filters.rank import rank_candidates, select_ranks, sorting_network
from chiasm.primitives.numbers.ranking import stable_topk


def harris_by_definition(x: np.ndarray, k: float) -> np.ndarray:
    gx, gy = (ndi.sobel(x, axis=a, mode="nearest") / 8 for a in (1, 0))
    taps = np.exp(-(np.arange(-3, 4) ** 2) / 2.0)
    taps /= taps.sum()
    xx, yy, xy = (
        ndi.correlate1d(ndi.correlate1d(p, taps, 0, mode="mirror"), taps, 1, mode="mirror")
        for p in (gx * gx, gy * gy, gx * gy)
    )
    return xx * yy - xy * xy - k * (xx + yy) ** 2


@pytest.mark.parametrize("channels", [1, 3])
def test_harris_equals_scipy(channels: int) -> None:
    x = photo(2, channels, 40, 33, torch.float64)
    sigmas = torch.tensor([1.0, 1.5], dtype=torch.float64)
    actual = harris_response(x, 0.05, sigmas=sigmas)
    for b in range(2):
        for c in range(channels):
            expected = harris_by_definition(x[b, c].numpy(), 0.05) * float(sigmas[b]) ** 4
            np.testing.assert_allclose(actual[b, c], expected, atol=1e-14)


def test_keypoints_are_the_strongest_maxima() -> None:
    x = photo(2, 1, 60, 71, torch.float64)
    response = nms2d(harris_response(x), 5)[:, 0].numpy()
    keypoints, scores, valid = harris_keypoints(x, 20)
    assert valid.all()
    for b in range(2):
        rows, columns = np.nonzero(response[b] > 0)
        order = np.argsort(-response[b][rows, columns], kind="stable")[:20]
        np.testing.assert_array_equal(keypoints[b], np.stack([columns[order], rows[order]], 1))
        np.testing.assert_array_equal(scores[b], response[b][rows, columns][order])


def test_few_corners_leave_canonical_slots() -> None:
    x = torch.zeros(1, 1, 20, 20)
    x[..., 10:, 10:] = 1.0
    keypoints, scores, valid = harris_keypoints(x, 1000)
    count = int(valid.sum())
    assert 1 <= count < 10 and valid[0, :count].all()
    assert (keypoints[0, count:] == -1).all() and (scores[0, count:] == 0).all()
    assert not harris_keypoints(x, 5, threshold=1.0)[2].any()


def test_equal_scores_keep_row_major_order() -> None:
    """A tiled corner has the same response at every tile."""
    tile = torch.zeros(12, 12)
    tile[4:8, 4:8] = 1.0
    keypoints, scores, valid = harris_keypoints(tile.repeat(4, 5)[None, None], 48)
    inner = scores[0] == scores[0].max()
    positions = keypoints[0][inner]
    assert valid.all() and int(inner.sum()) > 10
    linear = positions[:, 1] * 60 + positions[:, 0]
    assert (linear[1:] > linear[:-1]).all()


@pytest.mark.parametrize("seed", range(3))
def test_stable_topk_equals_numpy(seed: int) -> None:
    x = torch.randint(0, 5, (3, 200), generator=torch.Generator().manual_seed(seed)).float()
    order = np.argsort(-x.numpy(), axis=1, kind="stable")[:, :50]
    values, indices = stable_topk(x, 50)
    np.testing.assert_array_equal(indices, order)
    np.testing.assert_array_equal(values, np.take_along_axis(x.numpy(), order, 1))
    for target in ("onnx", "native"):  # for these, the runtime guarantees the order of equals
        with exporting(target):
            torch.testing.assert_close(stable_topk(x, 50)[0], values)


@pytest.mark.parametrize("size", range(1, 9))
def test_sorting_network_sorts(size: int) -> None:
    """By the 0-1 principle, a network that sorts every 0-1 sequence sorts all sequences."""
    for bits in range(2**size):
        values = [bits >> i & 1 for i in range(size)]
        for low, high in sorting_network(size):
            values[low], values[high] = min(values[low], values[high]), max(values[low], values[high])
        assert values == sorted(values)


@pytest.mark.parametrize("size", [2, 5, 13, 25, 49])
def test_select_ranks(size: int) -> None:
    x = torch.rand(size, 50, generator=torch.Generator().manual_seed(size))
    ranks = sorted({0, size // 2, size - 1})
    selected = select_ranks(list(x), ranks)
    np.testing.assert_array_equal(torch.stack(selected), np.sort(x.numpy(), axis=0)[ranks])


def test_rank_candidates_hold_the_rank() -> None:
    generator = np.random.default_rng(0)
    for rows, columns in ((1, 1), (3, 3), (3, 5), (5, 5), (7, 4)):
        # rows sorted, then columns, which keeps the rows sorted; few distinct values, which give ties
        matrix = np.sort(np.sort(generator.integers(0, 9, (200, rows, columns)), axis=2), axis=1)
        flat = np.sort(matrix.reshape(200, -1), axis=1)
        for rank in range(rows * columns):
            keep, below = rank_candidates(rows, columns, rank)
            left = np.stack([matrix[:, i, j] for i in range(rows) for j in keep[i]], axis=1)
            np.testing.assert_array_equal(np.sort(left, axis=1)[:, rank - below], flat[:, rank])
