"""Masks of instances: against torchvision, F.interpolate and F.grid_sample."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import torch
import torchvision
from torch import Tensor
from torch.autograd import gradcheck
from torch.nn import functional as F
from torchvision.models.detection.roi_heads import paste_masks_in_image

from chiasm import ops


def numbers(*shape: int, seed: int = 0) -> Tensor:
    return torch.rand(shape, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


@pytest.mark.parametrize("share", [0.02, 0.5])
@pytest.mark.parametrize("dtype", [torch.bool, torch.uint8, torch.int64, torch.float32])
def test_boxes_of_masks_are_torchvisions(share: float, dtype: torch.dtype) -> None:
    masks = (numbers(20, 13, 17) < share).to(dtype)
    assert torch.equal(ops.masks_to_boxes(masks), torchvision.ops.masks_to_boxes(masks))


def test_boxes_of_empty_and_single_masks() -> None:
    masks = torch.zeros(4, 5, 7)
    masks[1, 4, 6], masks[2, 0, 0], masks[3, 2, 3] = -1.0, 1.0, torch.nan
    expected = torch.tensor([[0.0] * 4, [6.0, 4.0, 6.0, 4.0], [0.0] * 4, [3.0, 2.0, 3.0, 2.0]])
    assert torch.equal(ops.masks_to_boxes(masks), expected)
    assert ops.masks_to_boxes(masks[:0]).shape == (0, 4)


def test_prototypes() -> None:
    random = np.random.default_rng(0)
    prototypes, coefficients = random.normal(size=(2, 4, 9, 12)), random.normal(size=(2, 5, 4))
    corner = random.uniform(-10, 30, (2, 5, 2))
    boxes = np.concatenate([corner, corner + random.uniform(0, 30, (2, 5, 2))], 2)
    boxes[0, 0] = [3.0, 4.0, 20.0, 25.0]
    boxes[0, 1] = [9.0, 9.0, 9.0, 20.0]
    p, c, k = map(torch.from_numpy, (prototypes, coefficients, boxes))
    actual = ops.masks_from_prototypes(p, c, k, (36, 48))
    for b in range(2):
        for n in range(5):
            mixed = sum(coefficients[b, n, p] * prototypes[b, p] for p in range(4))
            small = torch.from_numpy(1 / (1 + np.exp(-mixed)))[None, None]
            expected = F.interpolate(small, size=(36, 48), mode="bilinear", align_corners=False)[0, 0].numpy()
            for y in range(36):
                for x in range(48):
                    x1, y1, x2, y2 = boxes[b, n]
                    if not (x1 <= x < x2 and y1 <= y < y2):
                        expected[y, x] = 0.0
            np.testing.assert_allclose(actual[b, n], expected, atol=1e-12)
    assert actual[0, 0].count_nonzero() == 17 * 21 and not actual[0, 1].any()


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16])
def test_columns_that_half_precision_lacks(dtype: torch.dtype) -> None:
    boxes = torch.tensor([[[0.0, 300.0, 4.0, 302.0], [2048.0, 0.0, 2064.0, 3.0]]]).to(dtype)
    masks = ops.masks_from_prototypes(
        torch.ones(1, 1, 2, 2, dtype=dtype), torch.ones(1, 2, 1, dtype=dtype), boxes, (310, 2070)
    )
    assert masks[0].count_nonzero((1, 2)).tolist() == [8, 48]


def boxes_in(size: tuple[int, int], count: int) -> Tensor:
    height, width = size
    corner = (numbers(count, 2, seed=1) - 0.2) * torch.tensor([width, height])
    extent = 2 + numbers(count, 2, seed=2) * torch.tensor([width, height])
    return torch.cat([corner, corner + extent], 1)


def test_pasting_is_grid_sampling() -> None:
    masks, size = numbers(12, 1, 14, 11), (31, 44)
    boxes = boxes_in(size, 12)
    actual = ops.paste_masks(masks, boxes, size)
    y, x = torch.meshgrid(torch.arange(31).double() + 0.5, torch.arange(44).double() + 0.5, indexing="ij")
    for n in range(12):
        x1, y1, x2, y2 = boxes[n].tolist()
        grid = torch.stack([(x - x1) / (x2 - x1) * 2 - 1, (y - y1) / (y2 - y1) * 2 - 1], -1)[None]
        expected = F.grid_sample(masks[n : n + 1], grid, align_corners=False)[0]
        torch.testing.assert_close(actual[n], expected, rtol=0, atol=1e-12)


def test_pasting_is_near_torchvisions() -> None:
    """For a smooth mask in large boxes, for which the rounding of boxes changes little."""
    y, x = torch.meshgrid(torch.linspace(-1, 1, 28), torch.linspace(-1, 1, 28), indexing="ij")
    masks = torch.exp(-2 * (x * x + y * y)).expand(3, 1, 28, 28).contiguous()
    boxes = torch.tensor([[10.0, 20.0, 150.0, 180.0], [-30.0, 60.0, 120.0, 260.0], [5.5, 5.2, 199.7, 190.1]])
    expected = paste_masks_in_image(masks, boxes, (200, 210))
    assert ((ops.paste_masks(masks, boxes, (200, 210)) - expected).abs() < 0.05).double().mean() > 0.99


def test_pasting_a_box_without_area() -> None:
    nothing = torch.tensor([[3.0, 3.0, 3.0, 9.0], [5.0, 9.0, 9.0, 2.0], [torch.nan, 1.0, 9.0, 9.0]])
    assert not ops.paste_masks(torch.ones(3, 1, 4, 4), nothing, (12, 12)).any()
    assert ops.paste_masks(torch.ones(0, 1, 4, 4), nothing[:0], (12, 12)).shape == (0, 1, 12, 12)


def test_gradients() -> None:
    masks, boxes = numbers(2, 1, 4, 3).requires_grad_(), boxes_in((7, 8), 2).requires_grad_()
    assert gradcheck(lambda m, b: ops.paste_masks(m, b, (7, 8)), (masks, boxes))
    whole = torch.tensor([[[0.5, 1.5, 6.5, 5.5]] * 3], dtype=torch.float64)
    inputs = numbers(1, 2, 3, 4).requires_grad_(), numbers(1, 3, 2).requires_grad_()
    assert gradcheck(lambda p, c: ops.masks_from_prototypes(p, c, whole, (6, 8)), inputs)


P, C, B = torch.rand(1, 4, 3, 3), torch.rand(1, 2, 4), torch.rand(1, 2, 4)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: ops.masks_to_boxes(P), ValueError, r"masks: expected shape \(N, H, W\)"),
        (lambda: ops.masks_to_boxes(P[0, :, :0]), ValueError, "masks: expected H and W of at least 1"),
        (lambda: ops.masks_from_prototypes(P, C[..., :3], B, (6, 6)), ValueError, "coefficients: expected"),
        (lambda: ops.masks_from_prototypes(P, C, B[:, :1], (6, 6)), ValueError, "boxes: expected shape"),
        (
            lambda: ops.masks_from_prototypes(P.half(), C, B, (6, 6)),
            TypeError,
            "coefficients: expected",
        ),
        (lambda: ops.masks_from_prototypes(P, C, B, (0, 6)), ValueError, r"size: expected .* got \(0, 6\)"),
        (lambda: ops.paste_masks(P, B[0], (6, 6)), ValueError, r"masks: expected shape \(N, 1, M, M\)"),
        (lambda: ops.paste_masks(P[:, :1], B[0], (6, 6)), ValueError, r"boxes: expected shape \(N, 4\)"),
        (lambda: ops.paste_masks(P[:, :1], B[0, :1].int(), (6, 6)), TypeError, "boxes: expected a floating"),
    ],
)
def test_errors(call: Callable[[], Tensor], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
