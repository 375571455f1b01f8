"""Tiles of large images, and detections in them: against loops in NumPy and torchvision."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import torch
import torchvision
from torch import Tensor
from torch.autograd import gradcheck

from chiasm import ops

CASES = [
    ((13, 17), 5, 0),
    ((13, 17), (5, 7), (2, 3)),
    ((13, 17), (13, 17), 4),
    ((13, 17), (5, 17), (4, 16)),
    ((13, 17), 1, 0),
    ((12, 15), (4, 5), 0),
    ((12, 15), (4, 5), (3, 1)),
    ((40, 33), 16, 8),
    ((40, 33), (31, 32), (30, 5)),
]


def pair(value: int | tuple[int, int]) -> tuple[int, int]:
    return (value, value) if isinstance(value, int) else value


def starts(length: int, size: int, overlap: int) -> list[int]:
    """The starts of tiles, from the left, each as far from the one before as allowed; the last is moved into
    the image."""
    found = [0]
    while found[-1] + size < length:
        found.append(min(found[-1] + size - overlap, length - size))
    return found


@pytest.mark.parametrize(("shape", "size", "overlap"), CASES)
@pytest.mark.parametrize("dtype", [torch.float64, torch.uint8])
def test_tiles(shape, size, overlap, dtype: torch.dtype) -> None:
    image = (torch.rand(2, 3, *shape) * 255).to(dtype)
    tiles, positions = ops.tile(image, size, overlap)
    (rows, columns), (down, right) = pair(size), pair(overlap)
    expected = [(x, y) for y in starts(shape[0], rows, down) for x in starts(shape[1], columns, right)]
    assert [tuple(p) for p in positions.tolist()] == expected
    assert tiles.dtype == dtype and tiles.shape == (2, len(expected), 3, rows, columns)
    for t, (x, y) in enumerate(expected):
        assert torch.equal(tiles[:, t], image[:, :, y : y + rows, x : x + columns])


@pytest.mark.parametrize(("shape", "size", "overlap"), CASES)
def test_an_image_of_its_tiles(shape, size, overlap) -> None:
    image = torch.rand(2, 3, *shape)
    merged = ops.merge(ops.tile(image, size, overlap)[0], shape, overlap)
    torch.testing.assert_close(merged, image, rtol=1e-6, atol=0)


@pytest.mark.parametrize(("shape", "size", "overlap"), CASES)
def test_seams_are_blended(shape, size, overlap) -> None:
    """Tiles with different values, against a loop that sums them."""
    (rows, columns), (down, right) = pair(size), pair(overlap)
    corners = [(y, x) for y in starts(shape[0], rows, down) for x in starts(shape[1], columns, right)]
    tiles = np.random.default_rng(0).random((1, len(corners), 2, rows, columns))
    sums, weights = np.zeros((2, *shape)), np.zeros(shape)
    for t, (y, x) in enumerate(corners):
        for i in range(rows):
            for j in range(columns):
                weight = min(i + 1, rows - i, down + 1) * min(j + 1, columns - j, right + 1)
                sums[:, y + i, x + j] += weight * tiles[0, t, :, i, j]
                weights[y + i, x + j] += weight
    merged = ops.merge(torch.from_numpy(tiles), shape, overlap)
    np.testing.assert_allclose(merged[0], sums / weights, rtol=1e-12)


def test_a_seam_is_a_ramp() -> None:
    """Two tiles, 0 and 1: the seam goes from one to the other in equal steps."""
    tiles = torch.stack([torch.zeros(1, 2, 8), torch.ones(1, 2, 8)])[None]
    merged = ops.merge(tiles, (2, 12), (0, 4))
    expected = torch.tensor([0.0, 0.0, 0.0, 0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.0, 1.0, 1.0])
    torch.testing.assert_close(merged[0, 0], expected.expand(2, -1))


def test_gradients() -> None:
    image = torch.rand(1, 2, 7, 8, dtype=torch.float64, requires_grad=True)
    assert gradcheck(lambda x: ops.tile(x, (4, 3), 1)[0], image)
    tiles = torch.rand(1, 8, 1, 4, 4, dtype=torch.float64, requires_grad=True)
    assert gradcheck(lambda x: ops.merge(x, (7, 9), (1, 2)), tiles)


@pytest.mark.parametrize("seed", range(10))
def test_detections_are_suppressed_across_tiles(seed: int) -> None:
    random = np.random.default_rng(seed)
    b, t, n = 2, 4, 30
    corner = random.uniform(0, 40, (b, t, n, 2))
    boxes = np.concatenate([corner, corner + random.uniform(10, 30, (b, t, n, 2))], 3)
    scores = random.permutation(b * t * n).reshape(b, t, n) / 300 - 0.1
    labels, found = random.integers(0, 3, (b, t, n)), random.random((b, t, n)) < 0.7
    origins = np.array([[0, 0], [35, 0], [0, 30], [35, 30]])
    arguments = [torch.from_numpy(a) for a in (boxes, scores, labels, found, origins)]
    result = ops.merge_detections(*arguments, iou_threshold=0.4, max_output=100)
    for i in range(b):
        moved = (boxes[i] + np.tile(origins, 2)[:, None])[found[i]]
        inside = [torch.from_numpy(a) for a in (moved, scores[i][found[i]], labels[i][found[i]])]
        kept = torchvision.ops.batched_nms(*inside, iou_threshold=0.4)
        count = len(kept)
        assert 10 < count < found[i].sum()
        assert result[3][i].tolist() == [True] * count + [False] * (100 - count)
        np.testing.assert_allclose(result[0][i, :count], moved[kept], rtol=1e-14)
        assert np.array_equal(result[1][i, :count], scores[i][found[i]][kept])
        assert np.array_equal(result[2][i, :count], labels[i][found[i]][kept])
        assert all(not part[i, count:].any() for part in result)


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16])
def test_large_images_exceed_half_precision(dtype: torch.dtype) -> None:
    origins = torch.tensor([[0, 0], [4001, 3003]])
    boxes = torch.tensor([0.0, 0.0, 5.0, 7.0], dtype=dtype).expand(1, 2, 1, 4)
    scores = torch.tensor([[[0.75], [0.5]]], dtype=dtype)
    classes, found = torch.zeros(1, 2, 1, dtype=torch.int64), torch.ones(1, 2, 1, dtype=torch.bool)
    merged = ops.merge_detections(boxes, scores, classes, found, origins, max_output=2)
    assert merged[0][0, 1].tolist() == [4001.0, 3003.0, 4006.0, 3010.0] and merged[1].dtype == dtype


def test_nothing_is_found() -> None:
    nothing = ops.merge_detections(*NOTHING, torch.zeros(2, 2), max_output=3)
    assert all(not part.any() for part in nothing) and nothing[0].shape == (1, 3, 4)


X = torch.rand(1, 2, 8, 9)
NOTHING = (
    torch.rand(1, 2, 3, 4),
    torch.rand(1, 2, 3),
    torch.zeros(1, 2, 3, dtype=torch.int64),
    torch.zeros(1, 2, 3, dtype=torch.bool),
)


def merged(place: int, value: Tensor, origins: Tensor | None = None, most: int = 3) -> Tensor:
    boxes, scores, labels, found = (value if i == place else each for i, each in enumerate(NOTHING))
    where = torch.zeros(2, 2) if origins is None else origins
    return ops.merge_detections(boxes, scores, labels, found, where, max_output=most)[0]


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: ops.tile(X[0], 3), ValueError, r"image: expected shape \(B, C, H, W\)"),
        (lambda: ops.tile(X.int(), 3), TypeError, "image: expected a floating-point or uint8"),
        (lambda: ops.tile(X, 0), ValueError, "size: expected positive"),
        (lambda: ops.tile(X, (9, 9)), ValueError, "size: expected one within the image"),
        (lambda: ops.tile(X, 4, 4), ValueError, "overlap: expected 0 to less than"),
        (lambda: ops.tile(X, 4, (0, -1)), ValueError, "overlap: expected 0 to less than"),
        (lambda: ops.tile(X, 4, (1,)), ValueError, "overlap: expected 2 numbers, got 1"),
        (lambda: ops.tile(X, 4, 0.5), TypeError, "overlap: expected 2 numbers, got float"),
        (lambda: ops.merge(X[None], 9), TypeError, "image_size: expected 2 numbers, got int"),
        (lambda: ops.merge(X, (4, 5)), ValueError, r"tiles: expected shape \(B, T, C, rows, columns\)"),
        (lambda: ops.merge(X[None].int(), (9, 9)), TypeError, "tiles: expected a floating-point"),
        (lambda: ops.merge(X[None], (7, 9)), ValueError, "tiles: expected tiles of a pixel or more, within"),
        (lambda: ops.merge(X[None], (16, 18)), ValueError, "tiles: expected 4 of them, 2 x 2, got"),
        (lambda: ops.merge(X[None], (9, 9), 8), ValueError, "overlap: expected 0 to less than"),
        (lambda: merged(0, NOTHING[0][..., :3]), ValueError, r"boxes: expected shape \(B, T, N, 4\)"),
        (lambda: merged(0, NOTHING[0].int()), TypeError, "boxes: expected a floating-point"),
        (lambda: merged(1, NOTHING[1][0]), ValueError, r"scores: expected shape \[1, 2, 3\]"),
        (lambda: merged(2, NOTHING[2].int()), TypeError, "labels: expected dtype int64"),
        (lambda: merged(3, NOTHING[2]), TypeError, "found: expected dtype bool"),
        (lambda: merged(0, NOTHING[0], torch.zeros(3, 2)), ValueError, r"origins: expected shape \(T, 2\)"),
        (
            lambda: merged(0, NOTHING[0], torch.zeros(2, 2).int()),
            TypeError,
            "origins: expected dtype",
        ),
        (lambda: merged(0, NOTHING[0], None, 0), ValueError, "max_output: expected a positive"),
    ],
)
def test_errors(call: Callable[[], Tensor], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
