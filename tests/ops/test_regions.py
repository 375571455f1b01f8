"""Pooling of regions: against torchvision."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
import torch
import torchvision
from torch import Tensor
from torch.autograd import gradcheck

from chiasm import ops

# torchvision accepts pairs, although its annotations allow only one number.
SIZES: list[Any] = [(3, 3), (2, 3), (1, 1)]
SHAPES = [(2, 18, 11, 13, 40), (1, 18, 1, 1, 9), (3, 18, 40, 7, 60), (2, 18, 6, 5, 0)]


def images(*shape: int, seed: int = 0) -> Tensor:
    generator = torch.Generator().manual_seed(seed)
    return torch.randn(shape, generator=generator, dtype=torch.float64)


def regions(count: int, batch: int, seed: int = 0) -> Tensor:
    """Regions in an image of 40 pixels; many extend beyond it, some lie outside."""
    generator = torch.Generator().manual_seed(seed)
    corner = (torch.rand((count, 2), generator=generator, dtype=torch.float64) - 0.3) * 60
    size = torch.rand((count, 2), generator=generator, dtype=torch.float64) ** 2 * 60
    number = torch.randint(0, batch, (count, 1), generator=generator)
    return torch.cat([number, corner, corner + size], 1)


def tolerance(dtype: torch.dtype) -> dict[str, Any]:
    return {"rtol": 1e-11, "atol": 1e-12} if dtype == torch.float64 else {"rtol": 1e-4, "atol": 2e-5}


@pytest.mark.parametrize("dtype", [torch.float64, torch.float32])
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("sampling_ratio", [-1, 1, 2, 3])
def test_align_is_torchvisions(
    dtype: torch.dtype, shape: tuple[int, int, int, int, int], sampling_ratio: int
) -> None:
    x, boxes = images(*shape[:4]).to(dtype), regions(shape[4], shape[0]).to(dtype)
    for size in SIZES:
        for scale in (1.0, 0.37):
            for aligned in (False, True):
                settings = (size, scale, sampling_ratio, aligned)
                expected = torchvision.ops.roi_align(x, boxes, *settings)
                torch.testing.assert_close(ops.roi_align(x, boxes, *settings), expected, **tolerance(dtype))
            expected = torchvision.ops.ps_roi_align(x, boxes, size, scale, sampling_ratio)
            actual = ops.ps_roi_align(x, boxes, size, scale, sampling_ratio)
            torch.testing.assert_close(actual, expected, **tolerance(dtype))


@pytest.mark.parametrize("dtype", [torch.float64, torch.float32])
@pytest.mark.parametrize("shape", SHAPES)
def test_pool_is_torchvisions(dtype: torch.dtype, shape: tuple[int, int, int, int, int]) -> None:
    x, boxes = images(*shape[:4]).to(dtype), regions(shape[4], shape[0]).to(dtype)
    halves = torch.cat([boxes[:, :1], (boxes[:, 1:] * 2).round() / 2], 1)
    for each in (boxes, halves):
        for size in SIZES:
            for scale in (1.0, 0.37):
                expected = torchvision.ops.roi_pool(x, each, size, scale)
                assert torch.equal(ops.roi_pool(x, each, size, scale), expected)
                expected = torchvision.ops.ps_roi_pool(x, each, size, scale)
                torch.testing.assert_close(
                    ops.ps_roi_pool(x, each, size, scale), expected, **tolerance(dtype)
                )


FUNCTIONS: dict[str, tuple[Any, ...]] = {
    "roi_align": (3, 0.7, 2, False),
    "roi_align adaptive": (3, 0.7, -1, True),
    "roi_pool": (3, 0.7),
    "ps_roi_align": (3, 0.7, 2),
    "ps_roi_align adaptive": (3, 0.7, -1),
    "ps_roi_pool": (3, 0.7),
}


@pytest.mark.parametrize("case", FUNCTIONS)
def test_gradients_are_torchvisions(case: str) -> None:
    name, settings = case.split()[0], FUNCTIONS[case]
    ours, theirs = images(2, 9, 12, 10).requires_grad_(), images(2, 9, 12, 10).requires_grad_()
    boxes = regions(15, 2)
    outputs = (
        getattr(ops, name)(ours, boxes, *settings),
        getattr(torchvision.ops, name)(theirs, boxes, *settings),
    )
    slope = images(*outputs[0].shape, seed=1)
    for output in outputs:
        (output * slope).sum().backward()
    assert theirs.grad is not None and theirs.grad.abs().sum() > 1
    # The backward pass of torchvision's ps_roi_pool also reads the last row and column, which its forward
    # pass omits.
    if name != "ps_roi_pool":
        torch.testing.assert_close(ours.grad, theirs.grad, rtol=1e-9, atol=1e-11)
    small = images(1, 9, 5, 4).requires_grad_()
    assert gradcheck(lambda x: getattr(ops, name)(x, regions(3, 1), *settings), (small,))


@pytest.mark.parametrize("case", FUNCTIONS)
def test_any_box_is_read_inside(case: str) -> None:
    """Invalid image numbers are clamped, and NaN is harmless."""
    call, settings = getattr(ops, case.split()[0]), FUNCTIONS[case]
    x = images(2, 9, 12, 10)
    box = torch.tensor([1.0, 1.0, 8.0, 7.0], dtype=torch.float64)
    numbers = torch.tensor([-3.0, 0.0, 1.9, 1.0, 99.0, torch.inf, torch.nan], dtype=torch.float64)
    boxes = torch.cat([numbers[:, None], box.expand(7, 4)], 1)
    expected = torch.tensor([0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0], dtype=torch.float64)
    right = torch.cat([expected[:, None], box.expand(7, 4)], 1)
    assert torch.equal(call(x, boxes, *settings), call(x, right, *settings))
    for wrong in (torch.nan, torch.inf, -torch.inf, 1e300):
        for k in range(1, 5):
            strange = right.clone()
            strange[:, k] = wrong
            assert call(x, strange, *settings).shape == (7, 9 if "ps" not in case else 1, 3, 3)


def test_reversed_and_empty_boxes() -> None:
    x = images(1, 9, 12, 10)
    boxes = torch.tensor([[0.0, 7.0, 8.0, 3.0, 2.0], [0.0, 4.0, 4.0, 4.0, 4.0]], dtype=torch.float64)
    for case in ("roi_align", "roi_pool", "ps_roi_align", "ps_roi_pool"):
        expected = getattr(torchvision.ops, case)(x, boxes, *FUNCTIONS[case])
        torch.testing.assert_close(getattr(ops, case)(x, boxes, *FUNCTIONS[case]), expected)
    assert not ops.ps_roi_align(x, boxes, 3).any() and not ops.roi_align(x, boxes, 3, aligned=True).any()


def test_maxima_of_special_values() -> None:
    x = torch.zeros(1, 1, 4, 4)
    x[0, 0, 0, 0], x[0, 0, 3, 3], x[0, 0, 0, 2:], x[0, 0, 1, 2:] = torch.nan, torch.inf, -1.0, -2.0
    pooled = ops.roi_pool(x, torch.tensor([[0.0, 0.0, 0.0, 3.0, 3.0]]), 2)[0, 0]
    assert pooled[0, 0].isnan() and pooled[1, 1] == torch.inf
    assert pooled[0, 1] == -1.0 and pooled[1, 0] == 0.0


X, R = torch.rand(1, 9, 6, 6), torch.zeros(2, 5)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: ops.roi_align(X, R[:, :4], 3), ValueError, r"boxes: expected shape \(K, 5\), got \[2, 4\]"),
        (lambda: ops.roi_align(X, R.int(), 3), TypeError, "boxes: expected a floating-point"),
        (lambda: ops.roi_align(X[0], R, 3), ValueError, r"input: expected shape \(B, C, H, W\)"),
        (lambda: ops.roi_pool(X, R, (0, 3)), ValueError, r"output_size: expected positive sizes, got \(0, 3"),
        (lambda: ops.ps_roi_align(X, R, 2), ValueError, r"input: expected a multiple of 2 \* 2 channels"),
        (lambda: ops.ps_roi_pool(X, R, 2), ValueError, r"input: expected a multiple of 2 \* 2 channels"),
    ],
)
def test_errors(call: Callable[[], Tensor], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()


@pytest.mark.parametrize("name", ["roi_align", "roi_pool", "ps_roi_align", "ps_roi_pool"])
def test_boxes_of_each_image_as_torchvision_takes_them(name: str) -> None:
    x = images(3, 18, 11, 13)
    boxes = [regions(n, 1, n)[:, 1:] for n in (4, 0, 7)]
    expected = getattr(torchvision.ops, name)(x, boxes, (3, 3), 0.5)
    for call in (getattr(ops, name), torch.jit.script(getattr(ops, name))):
        torch.testing.assert_close(call(x, boxes, (3, 3), 0.5), expected, rtol=1e-11, atol=1e-12)
    with pytest.raises(ValueError, match=r"boxes: expected boxes of each of 3 images, got 2"):
        getattr(ops, name)(x, boxes[:2], (3, 3))
    with pytest.raises(ValueError, match=r"boxes: expected shape \(\*, 4\), got \[2, 5\]"):
        getattr(ops, name)(x[:1], [torch.zeros(2, 5)], (3, 3))
    with pytest.raises(TypeError, match=r"boxes: expected a tensor or a list of tensors, got int"):
        getattr(ops, name)(x, 3, (3, 3))
