"""Index proposals against a loop over windows in NumPy, and against the softmax of windows."""

import math

import numpy as np
import pytest
import torch
from torch import Tensor

from chiasm import feature
from chiasm.geometry.subpix import conv_soft_argmax2d


def made(batch: int, height: int, width: int, dtype: torch.dtype = torch.float64) -> Tensor:
    return torch.rand(
        (batch, 1, height, width), generator=torch.Generator().manual_seed(height), dtype=torch.float64
    ).to(dtype)


def by_windows(response: np.ndarray, window: int, base: float) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates (h, w, 2) and scores (h, w) of one image."""
    height, width = response.shape
    places, scores = [], []
    for top in range(0, height, window):
        for left in range(0, width, window):
            tile = response[top : top + window, left : left + window]
            weight = base ** (tile - tile.max())
            weight = weight / weight.sum()
            y, x = np.mgrid[: tile.shape[0], : tile.shape[1]]
            places.append((left + (weight * x).sum(), top + (weight * y).sum()))
            scores.append(tile.max())
    shape = (-(-height // window), -(-width // window))
    return np.array(places).reshape(*shape, 2), np.array(scores).reshape(shape)


@pytest.mark.parametrize("base", [math.e, 1e6])
@pytest.mark.parametrize(
    ("batch", "height", "width", "window"),
    [(1, 16, 24, 8), (3, 17, 23, 8), (2, 5, 9, 7), (1, 3, 4, 1), (2, 6, 5, 40), (1, 1, 1, 3)],
)
def test_windows(batch: int, height: int, width: int, window: int, base: float) -> None:
    response = made(batch, height, width)
    coordinates, scores = feature.index_proposal(response, window, base)
    for b in range(batch):
        places, largest = by_windows(response[b, 0].numpy(), window, base)
        np.testing.assert_allclose(coordinates[b], places, atol=1e-12)
        np.testing.assert_array_equal(scores[b], largest)


def test_default_base_is_the_softmax_of_windows() -> None:
    response = 9 * made(2, 18, 30)
    coordinates, _ = feature.index_proposal(response, 6)
    softmax = conv_soft_argmax2d(response, (6, 6), (6, 6), (0, 0), normalized_coordinates=False)[:, 0]
    torch.testing.assert_close(coordinates, softmax.movedim(1, -1))


def test_sizes_in_a_row() -> None:
    response = made(2, 45, 70)
    coordinates, scores, size = feature.multi_scale_index_proposal(response, base=50.0)
    assert size.dtype == torch.int64
    begin = 0
    for k, window in enumerate((8, 16, 24, 32, 40)):
        places, largest = feature.index_proposal(response, window, 50.0)
        end = begin + largest[0].numel()
        assert torch.equal(coordinates[:, begin:end], places.flatten(1, 2)) and torch.equal(
            scores[:, begin:end], largest.flatten(1)
        )
        assert (size[:, begin:end] == k).all()
        begin = end
    assert begin == scores.size(1) == 6 * 9 + 3 * 5 + 2 * 3 + 2 * 3 + 2 * 2


def test_large_responses_and_pixels_without_one() -> None:
    """Exponents in the thousands; a window with one valid pixel, and a window without any, which gives its
    centre."""
    response = torch.full([1, 1, 8, 6], -math.inf)
    response[0, 0, 3, 1] = 5000.0
    response[0, 0, 2, 5] = -5000.0
    response[0, 0, 6, :3] = 5000.0
    response.requires_grad_(True)
    coordinates, scores = feature.index_proposal(response, 4)
    assert coordinates.tolist() == [[[[1.0, 3.0], [5.0, 2.0]], [[1.0, 6.0], [4.5, 5.5]]]]
    assert scores.tolist() == [[[5000.0, -5000.0], [5000.0, -math.inf]]]
    coordinates.sum().backward()
    assert response.grad is not None and torch.isfinite(response.grad).all()


@pytest.mark.parametrize("dtype", [torch.float32, torch.float16, torch.bfloat16])
def test_dtypes(dtype: torch.dtype) -> None:
    response = made(2, 21, 34, dtype)
    coordinates, scores = feature.index_proposal(response, 8, 100.0)
    exact, largest = feature.index_proposal(response.double(), 8, 100.0)
    assert coordinates.dtype == torch.float32 and scores.dtype == dtype
    torch.testing.assert_close(coordinates, exact.float(), atol=1e-5, rtol=1e-6)
    assert torch.equal(scores.double(), largest)


@pytest.mark.parametrize(("height", "width", "window"), [(9, 11, 4), (5, 6, 8)])
def test_gradient(height: int, width: int, window: int) -> None:
    response = made(2, height, width).requires_grad_(True)
    assert torch.autograd.gradcheck(
        lambda r: feature.index_proposal(r, window, 20.0), [response], fast_mode=True
    )
    assert torch.autograd.gradcheck(
        lambda r: feature.multi_scale_index_proposal(r, [2, window])[:2], [response], fast_mode=True
    )


def test_proposals_move_to_where_they_are_pulled() -> None:
    """The layer's purpose: a response can be trained with the wanted positions of its maxima."""
    response = (0.1 * made(1, 16, 16)).requires_grad_(True)
    target = torch.tensor([[[[2.0, 5.0], [13.0, 1.0]], [[4.0, 12.0], [9.0, 14.0]]]], dtype=torch.float64)
    optimiser = torch.optim.Adam([response], lr=0.4)
    for _ in range(60):
        optimiser.zero_grad()
        (feature.index_proposal(response, 8)[0] - target).square().sum().backward()
        optimiser.step()
    assert (feature.index_proposal(response, 8)[0] - target).abs().max() < 0.05


RESPONSE = torch.zeros(1, 1, 8, 8)
WRONG = [
    (lambda: feature.index_proposal(RESPONSE[0], 4), ValueError, r"response: expected shape \(B, C, H, W\)"),
    (
        lambda: feature.index_proposal(RESPONSE.expand(1, 3, 8, 8), 4),
        ValueError,
        r"response: expected shape \(B, 1, H, W\), got \[1, 3, 8, 8\]",
    ),
    (
        lambda: feature.index_proposal(RESPONSE.int(), 4),
        TypeError,
        "response: expected a floating-point tensor",
    ),
    (lambda: feature.index_proposal(RESPONSE, 0), ValueError, "window: expected a positive number, got 0"),
    (lambda: feature.index_proposal(RESPONSE, 4, 1.0), ValueError, "base: expected more than 1, got 1.0"),
    (
        lambda: feature.multi_scale_index_proposal(RESPONSE, []),
        ValueError,
        "windows: expected at least one size, got none",
    ),
    (
        lambda: feature.multi_scale_index_proposal(RESPONSE, [8, 0]),
        ValueError,
        "window: expected a positive number, got 0",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
