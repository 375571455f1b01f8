"""Deformable convolution: against torchvision and, without offsets, PyTorch's convolution."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
import torch
import torchvision
from torch import Tensor
from torch.autograd import gradcheck
from torch.nn import functional as F

from chiasm import ops

#: Channels in and out, groups of weights and of offsets, kernel size; stride, padding, dilation.
CASES: list[tuple[Any, ...]] = [
    (1, 1, 1, 1, (1, 1), (1, 1), (0, 0), (1, 1)),
    (4, 6, 2, 2, (3, 3), (1, 1), (1, 1), (1, 1)),
    (6, 6, 3, 1, (3, 2), (2, 1), (0, 2), (1, 2)),
    (6, 4, 1, 3, (2, 3), (1, 2), (3, 1), (2, 1)),
]


def numbers(*shape: int, seed: int = 0) -> Tensor:
    return torch.randn(shape, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


def inputs(case: tuple[Any, ...], batch: int, height: int, width: int) -> dict[str, Tensor]:
    c, o, groups, parts, (kh, kw), stride, padding, dilation = case
    rows = (height + 2 * padding[0] - dilation[0] * (kh - 1) - 1) // stride[0] + 1
    columns = (width + 2 * padding[1] - dilation[1] * (kw - 1) - 1) // stride[1] + 1
    return {
        "input": numbers(batch, c, height, width),
        # Some offsets lead outside.
        "offset": 3 * numbers(batch, 2 * parts * kh * kw, rows, columns, seed=1),
        "weight": numbers(o, c // groups, kh, kw, seed=2),
        "bias": numbers(o, seed=3),
        "mask": numbers(batch, parts * kh * kw, rows, columns, seed=4),
    }


def settings(case: tuple[Any, ...]) -> dict[str, Any]:
    return dict(zip(("stride", "padding", "dilation"), case[5:], strict=True))


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("left_out", [(), ("mask",), ("bias", "mask")])
def test_values_and_gradients_are_torchvisions(case: tuple[Any, ...], left_out: tuple[str, ...]) -> None:
    made = {k: v for k, v in inputs(case, 2, 9, 11).items() if k not in left_out}
    results = []
    for call in (ops.deform_conv2d, torchvision.ops.deform_conv2d, torch.jit.script(ops.deform_conv2d)):
        leaves = {k: v.clone().requires_grad_() for k, v in made.items()}
        output = call(**leaves, **settings(case))
        (output * numbers(*output.shape, seed=5)).sum().backward()
        results.append((output.detach(), *(v.grad for v in leaves.values())))
    for result in results[::2]:
        for actual, expected in zip(result, results[1], strict=True):
            torch.testing.assert_close(actual, expected, rtol=1e-9, atol=1e-10)
    single = {k: v.float() for k, v in made.items()}
    torch.testing.assert_close(
        ops.deform_conv2d(**single, **settings(case)), results[1][0].float(), rtol=1e-3, atol=1e-4
    )


@pytest.mark.parametrize("case", CASES)
def test_without_offsets_it_is_a_convolution(case: tuple[Any, ...]) -> None:
    made = inputs(case, 3, 8, 10)
    actual = ops.deform_conv2d(
        made["input"], made["offset"] * 0, made["weight"], made["bias"], **settings(case)
    )
    expected = F.conv2d(made["input"], made["weight"], made["bias"], groups=case[2], **settings(case))
    torch.testing.assert_close(actual, expected, rtol=1e-11, atol=1e-11)


def test_one_number_stands_for_both_axes() -> None:
    made = inputs((4, 6, 2, 1, (3, 3), (2, 2), (1, 1), (2, 2)), 2, 9, 11)
    expected = torchvision.ops.deform_conv2d(**made, stride=2, padding=1, dilation=2)
    for call in (ops.deform_conv2d, torch.jit.script(ops.deform_conv2d)):
        torch.testing.assert_close(
            call(**made, stride=2, padding=1, dilation=2), expected, rtol=1e-9, atol=1e-10
        )
    with pytest.raises(ValueError, match=r"padding: expected 2 numbers, got 3"):
        ops.deform_conv2d(**made, padding=(1, 1, 1))


def test_gradient() -> None:
    made = inputs((2, 2, 1, 2, (2, 2), (1, 1), (1, 1), (1, 1)), 1, 4, 3)
    leaves = [made[k].requires_grad_() for k in ("input", "offset", "weight", "bias", "mask")]
    assert gradcheck(
        lambda x, o, w, b, m: ops.deform_conv2d(x, o, w, b, padding=(1, 1), mask=m), leaves, fast_mode=True
    )


def test_an_offset_that_is_no_number_reads_nothing_elsewhere() -> None:
    x, offset = torch.ones(1, 1, 3, 3), torch.zeros(1, 2, 3, 3)
    offset[0, 0, 1, 1], offset[0, 1, 0, 0] = torch.inf, -1e30
    expected = torch.ones(1, 1, 3, 3)
    expected[0, 0, 1, 1], expected[0, 0, 0, 0] = 0.0, 0.0
    assert torch.equal(ops.deform_conv2d(x, offset, torch.ones(1, 1, 1, 1)), expected)


X, F2, W = torch.rand(1, 4, 5, 5), torch.zeros(1, 18, 3, 3), torch.rand(2, 4, 3, 3)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: ops.deform_conv2d(X[0], F2, W), ValueError, r"input: expected shape \(B, C, H, W\)"),
        (lambda: ops.deform_conv2d(X, F2[:, :17], W), ValueError, r"offset: expected shape \(B, 2 \* G"),
        (lambda: ops.deform_conv2d(X, F2, W[:, :3]), ValueError, r"weight: expected shape \(O, C / groups"),
        (lambda: ops.deform_conv2d(X, F2, W, W[0, 0, 0]), ValueError, r"bias: expected shape \(2,\)"),
        (lambda: ops.deform_conv2d(X, F2, W, mask=F2), ValueError, "mask: expected 9 channels"),
        (lambda: ops.deform_conv2d(X, F2, W, stride=(0, 1)), ValueError, "stride, dilation: expected"),
        (lambda: ops.deform_conv2d(X, F2, W, padding=(-1, 0)), ValueError, "padding: expected zero or more"),
        (lambda: ops.deform_conv2d(X, F2, W[:, :0]), ValueError, "weight: expected a channel and a tap"),
        (lambda: ops.deform_conv2d(X, F2, W[:, :, :0]), ValueError, "weight: expected a channel and a tap"),
        (lambda: ops.deform_conv2d(X, F2, W[..., :0]), ValueError, "weight: expected a channel and a tap"),
        (lambda: ops.deform_conv2d(X[:, :2], F2, W), ValueError, r"weight: expected shape \(O, C / groups"),
        (
            lambda: ops.deform_conv2d(X[:, :, :2], F2, W),
            ValueError,
            "input: expected at least 3 rows for a window inside it, got 2",
        ),
        (
            lambda: ops.deform_conv2d(X, F2, W, padding=(0, 1), dilation=(1, 4)),
            ValueError,
            "input: expected at least 9 columns for a window inside it, got 7",
        ),
        (lambda: ops.deform_conv2d(X, F2.int(), W), TypeError, "offset: expected a floating-point"),
    ],
)
def test_errors(call: Callable[[], Tensor], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
