"""Boxes and non-maximum suppression against loops in NumPy."""

import cv2
import numpy as np
import pytest
import torch
from torch import Tensor

from chiasm.geometry import bbox as b

RANDOM = np.random.default_rng(0)


def starts(axes: int, whole: bool = True) -> list[Tensor]:
    """Starts, then sizes, of a few boxes."""
    made = [*RANDOM.uniform(-4, 12, (axes, 6)), *RANDOM.uniform(1, 9, (axes, 6))]
    return [torch.from_numpy(np.round(m) if whole else m) for m in made]


def test_generated_boxes() -> None:
    x, y, w, h = starts(2)
    made = b.bbox_generator(x, y, w, h)
    for k in range(6):
        (left, top), (right, bottom) = (x[k], y[k]), (x[k] + w[k] - 1, y[k] + h[k] - 1)
        np.testing.assert_array_equal(made[k], [[left, top], [right, top], [right, bottom], [left, bottom]])
    assert b.bbox_generator(*[torch.tensor(3)] * 4).tolist() == [[[3, 3], [5, 3], [5, 5], [3, 5]]]


def test_generated_boxes_in_space() -> None:
    x, y, z, w, h, d = starts(3)
    made = b.bbox_generator3d(x, y, z, w, h, d)
    face = b.bbox_generator(x, y, w, h)
    np.testing.assert_array_equal(made[..., :2], torch.cat([face, face], 1))
    np.testing.assert_array_equal(made[..., 2], torch.stack([z] * 4 + [z + d - 1] * 4, 1))


@pytest.mark.parametrize("whole", [True, False])
def test_masks(whole: bool) -> None:
    x, y, z, w, h, d = starts(3, whole)
    mask = b.bbox_to_mask(b.bbox_generator(x, y, w, h), 13, 11)
    volume = b.bbox_to_mask3d(b.bbox_generator3d(x, y, z, w, h, d), (9, 11, 13))
    assert mask.shape == (6, 11, 13) and volume.shape == (6, 1, 9, 11, 13)
    for k in range(6):
        inside = [
            [(n >= start[k]) & (n <= start[k] + size[k] - 1) for n in range(count)]
            for start, size, count in ((z, d, 9), (y, h, 11), (x, w, 13))
        ]
        np.testing.assert_array_equal(
            mask[k],
            np.multiply.outer(*np.array([np.array(i, dtype=float) for i in inside[1:]], dtype=object)),
        )
        expected = np.einsum("z,y,x->zyx", *(np.array(i, dtype=float) for i in inside))
        np.testing.assert_array_equal(volume[k, 0], expected)


def test_shapes() -> None:
    x, y, z, w, h, d = starts(3)
    for made, expected in zip(b.infer_bbox_shape(b.bbox_generator(x, y, w, h)), (h, w), strict=True):
        np.testing.assert_array_equal(made, expected)
    for made, expected in zip(
        b.infer_bbox_shape3d(b.bbox_generator3d(x, y, z, w, h, d)), (d, h, w), strict=True
    ):
        np.testing.assert_array_equal(made, expected)


def homographies() -> Tensor:
    scale = np.array([[0.3, 0.3, 9.0], [0.3, 0.3, 9.0], [1e-3, 1e-3, 0.0]])
    made = np.eye(3) + RANDOM.uniform(-1, 1, (3, 3, 3)) * scale
    made[0, 0] *= -1.0  # mirrored
    return torch.from_numpy(made)


@pytest.mark.parametrize("restore", [None, True, False])
def test_transformed_boxes(restore: bool) -> None:
    m, boxes = homographies(), torch.from_numpy(RANDOM.uniform(0, 50, (3, 5, 4)))
    moved = np.stack(
        [
            cv2.perspectiveTransform(boxes[k].reshape(1, -1, 2).numpy(), m[k].numpy()).reshape(-1, 2, 2)
            for k in range(3)
        ]
    )
    if restore is not False:
        moved = np.sort(moved, 2)
    np.testing.assert_allclose(b.transform_bbox(m, boxes, "xyxy", restore), moved.reshape(3, 5, 4), atol=1e-9)
    sized = torch.cat([boxes[..., :2], boxes[..., 2:] - boxes[..., :2]], -1)
    expected = np.concatenate([moved[:, :, 0], moved[:, :, 1] - moved[:, :, 0]], -1)
    np.testing.assert_allclose(b.transform_bbox(m, sized, "xywh", restore), expected, atol=1e-9)
    np.testing.assert_allclose(
        b.transform_bbox(m, boxes[:, 2], "xyxy", restore), moved.reshape(3, 5, 4)[:, 2], atol=1e-9
    )


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16, torch.float64])
def test_a_matrix_of_another_dtype(dtype: torch.dtype) -> None:
    """As a letterbox's, which is float32 whatever the network computes in."""
    m = torch.tensor([[[3.0, 0.0, -8.0], [0.0, 3.0, 4.0], [0.0, 0.0, 1.0]]])
    moved = b.transform_bbox(m, torch.tensor([[1.0, 2.0, 30.0, 40.0]], dtype=dtype))
    assert moved.dtype == dtype and moved.tolist() == [[-5.0, 10.0, 82.0, 124.0]]


def test_valid_boxes() -> None:
    boxes, volumes = b.bbox_generator(*starts(2)), b.bbox_generator3d(*starts(3))
    for function, whole, good in (
        (b.is_bbox, b.validate_bbox, boxes),
        (b.is_bbox3d, b.validate_bbox3d, volumes),
    ):
        scripted = torch.jit.script(whole)
        assert function(good).all() and whole(good) and whole(good[None]) and scripted(good)
        for corner in range(good.size(1)):
            wrong = good.clone()
            wrong[3, corner, 0] += 0.5
            assert function(wrong).tolist() == [True, True, True, False, True, True]
            assert not whole(wrong) and not scripted(wrong)
        assert not whole(good[0]) and not whole(good[..., :1])
    shifted = volumes.clone()
    shifted[2, 4:6, 2] += 1.0  # the back is not parallel to the front
    assert b.is_bbox3d(shifted).tolist() == [True, True, False, True, True, True]


# --- non-maximum suppression --------------------------------------------------------------------------------


def suppressed(boxes: np.ndarray, scores: np.ndarray, threshold: float) -> list[int]:
    """The definition, box by box."""
    kept: list[int] = []
    for i in sorted(range(len(boxes)), key=lambda k: -scores[k]):
        for j in kept:
            width, height = (
                max(0.0, min(boxes[i][a + 2], boxes[j][a + 2]) - max(boxes[i][a], boxes[j][a]))
                for a in (0, 1)
            )
            areas = [(q[2] - q[0]) * (q[3] - q[1]) for q in (boxes[i], boxes[j])]
            common = width * height
            if common > threshold * (sum(areas) - common):
                break
        else:
            kept.append(i)
    return kept


@pytest.mark.parametrize("threshold", [0.0, 0.2, 0.5, 0.9])
@pytest.mark.parametrize("count", [1, 2, 30, 150])
def test_nms(count: int, threshold: float) -> None:
    corner = RANDOM.uniform(0, 60, (count, 2))
    boxes = np.concatenate([corner, corner + RANDOM.uniform(5, 20, (count, 2))], 1)
    scores = np.round(RANDOM.uniform(0, 1, count), 1)  # some are equal
    expected = suppressed(boxes, scores, threshold)
    arguments = torch.from_numpy(boxes), torch.from_numpy(scores), threshold
    assert b.nms(*arguments).tolist() == expected
    assert torch.jit.script(b.nms)(*arguments).tolist() == expected
    order, kept = b.nms_fixed(*arguments)
    assert order.tolist() == sorted(range(count), key=lambda k: -scores[k])
    assert order[kept].tolist() == expected


def test_nms_of_a_long_chain() -> None:
    """Each box overlaps only its neighbours: every second one is kept, which takes as many steps as there are
    boxes."""
    left = np.arange(101.0)
    boxes = np.stack([left, 0 * left, left + 1.7, 0 * left + 1.0], 1)
    scores = torch.linspace(1.0, 0.0, 101)
    assert b.nms(torch.from_numpy(boxes), scores, 0.2).tolist() == list(range(0, 101, 2))


def test_nms_of_nothing_and_of_empty_boxes() -> None:
    assert b.nms(torch.zeros(0, 4), torch.zeros(0), 0.5).tolist() == []
    assert b.nms(torch.zeros(3, 4), torch.tensor([0.1, 0.3, 0.2]), 0.5).tolist() == [1, 2, 0]


WRONG = [
    (
        lambda: b.bbox_generator(*[torch.zeros(2, 2)] * 4),
        ValueError,
        r"x_start: expected shape \(B,\) or a scalar, got \[2, 2\]",
    ),
    (
        lambda: b.bbox_to_mask(torch.zeros(1, 4, 3), 5, 5),
        ValueError,
        r"boxes: expected shape \(B, 4, 2\), got \[1, 4, 3\]",
    ),
    (lambda: b.bbox_to_mask(torch.zeros(1, 4, 2).int(), 5, 5), TypeError, "boxes: expected a floating-point"),
    (
        lambda: b.bbox_to_mask3d(torch.zeros(1, 4, 2), (5, 5, 5)),
        ValueError,
        r"boxes: expected shape \(B, 8, 3\)",
    ),
    (lambda: b.infer_bbox_shape(torch.zeros(4, 2)), ValueError, r"boxes: expected shape \(B, 4, 2\)"),
    (lambda: b.is_bbox3d(torch.zeros(4, 2)), ValueError, r"boxes: expected shape \(B, 8, 3\)"),
    (
        lambda: b.transform_bbox(torch.eye(3), torch.zeros(1, 4)),
        ValueError,
        r"trans_mat: expected shape \(B, 3, 3\)",
    ),
    (
        lambda: b.transform_bbox(torch.eye(3)[None], torch.zeros(4)),
        ValueError,
        r"boxes: expected shape \(B, 4\) or \(B, N, 4\)",
    ),
    (
        lambda: b.transform_bbox(torch.eye(3)[None], torch.zeros(1, 4), "cxcywh"),
        ValueError,
        "mode: expected one of",
    ),
    (
        lambda: b.nms(torch.zeros(3, 4), torch.zeros(2), 0.5),
        ValueError,
        r"scores: expected shape \(N,\) for boxes \[3, 4\], got \[2\]",
    ),
    (lambda: b.nms(torch.zeros(1, 3, 4), torch.zeros(2), 0.5), ValueError, r"boxes: expected shape \(N, 4\)"),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
