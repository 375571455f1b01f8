"""Windows of images against NumPy, and images joined from windows against a loop."""

import numpy as np
import pytest
import torch
from photos import photo
from torch import Tensor
from torch.autograd import gradcheck

from chiasm.contrib import (
    CombineTensorPatches,
    ExtractTensorPatches,
    combine_tensor_patches,
    compute_padding,
    extract_tensor_patches,
)

X = torch.zeros(2, 3, 8, 9)
LAYOUTS = [
    # window, stride, padding
    (3, 1, 0),
    ((4, 3), (2, 3), 0),
    ((2, 5), (3, 5), 1),
    ((5, 4), 2, (1, 2)),
    ((1, 6), (4, 1), (0, 2, 3, 1)),
    ((7, 9), 7, (3, 0, 1, 1)),
]


def pair(value: object) -> tuple[int, int]:
    return (value, value) if isinstance(value, int) else value


def margins(padding: object) -> tuple[tuple[int, int], tuple[int, int]]:
    """The padding in NumPy's form: before and after, for rows and for columns."""
    if isinstance(padding, int):
        return (padding, padding), (padding, padding)
    return ((padding[0],) * 2, (padding[1],) * 2) if len(padding) == 2 else (padding[:2], padding[2:])


def windows(x: np.ndarray, window: object, stride: object, padding: object) -> np.ndarray:
    """(B, N, C, rows, columns)"""
    padded = np.pad(x, ((0, 0), (0, 0), *margins(padding)))
    view = np.lib.stride_tricks.sliding_window_view(padded, pair(window), (2, 3))[
        :, :, :: pair(stride)[0], :: pair(stride)[1]
    ]
    return view.transpose(0, 2, 3, 1, 4, 5).reshape(x.shape[0], -1, x.shape[1], *pair(window))


@pytest.mark.parametrize("size", [(8, 9), (5, 31), (3, 7)])
@pytest.mark.parametrize(("window", "stride"), [(3, None), ((4, 3), (2, 3)), ((5, 2), (3, 2)), ((9, 12), 4)])
def test_padding_makes_the_last_windows_end_with_the_image(
    size: tuple[int, int], window: object, stride: object
) -> None:
    top, bottom, left, right = compute_padding(size, window, stride)
    for length, before, after, one, step in zip(
        size, (top, left), (bottom, right), pair(window), pair(stride or window)
    ):
        total = before + length + after
        fitting = [n for n in range(length, length + one + step) if n >= one and (n - one) % step == 0]
        assert total == fitting[0] and after - before in (0, 1)
    x = photo(1, 2, *size)
    cut = extract_tensor_patches(x, window, stride or window, (top, bottom, left, right))
    assert combine_tensor_patches(cut, size, window, stride, unpadding=(top, bottom, left, right)).allclose(
        x, atol=1e-6
    )


def put_together(
    patches: np.ndarray, size: tuple[int, int], window: object, stride: object, padding: object
) -> np.ndarray:
    (top, bottom), (left, right) = margins(padding)
    total = np.zeros((*patches.shape[:1], patches.shape[2], size[0] + top + bottom, size[1] + left + right))
    count = np.zeros(total.shape)
    n = 0
    for y in range(0, total.shape[2] - pair(window)[0] + 1, pair(stride)[0]):
        for x in range(0, total.shape[3] - pair(window)[1] + 1, pair(stride)[1]):
            here = np.s_[:, :, y : y + pair(window)[0], x : x + pair(window)[1]]
            total[here] += patches[:, n]
            count[here] += 1
            n += 1
    assert n == patches.shape[1]
    return (total / np.maximum(count, 1))[:, :, top : top + size[0], left : left + size[1]]


@pytest.mark.parametrize(("window", "stride", "padding"), LAYOUTS)
@pytest.mark.parametrize("shape", [(1, 1, 9, 11), (3, 5, 23, 17), (2, 3, 14, 30)])
def test_windows_equal_numpy(shape: tuple[int, ...], window: object, stride: object, padding: object) -> None:
    x = photo(*shape, torch.float64) + 0.1
    np.testing.assert_array_equal(
        extract_tensor_patches(x, window, stride, padding), windows(x.numpy(), window, stride, padding)
    )


@pytest.mark.parametrize(("window", "stride", "padding"), LAYOUTS)
@pytest.mark.parametrize("shape", [(1, 1, 9, 11), (3, 5, 23, 17)])
def test_together_equals_a_loop(
    shape: tuple[int, ...], window: object, stride: object, padding: object
) -> None:
    x = photo(*shape, torch.float64)
    patches = extract_tensor_patches(x, window, stride, padding)
    patches = patches + torch.rand(
        patches.shape, generator=torch.Generator().manual_seed(0), dtype=torch.float64
    )
    actual = combine_tensor_patches(patches, shape[2:], window, stride, unpadding=padding)
    np.testing.assert_allclose(
        actual, put_together(patches.numpy(), shape[2:], window, stride, padding), rtol=1e-13
    )


@pytest.mark.parametrize(("window", "stride", "padding"), LAYOUTS)
@pytest.mark.parametrize("shape", [(1, 1, 9, 11), (3, 5, 23, 17)])
def test_fitted_windows_go_there_and_back(
    shape: tuple[int, ...], window: object, stride: object, padding: object
) -> None:
    x = photo(*shape, torch.float64)
    patches = extract_tensor_patches(x, window, stride, padding, allow_auto_padding=True)
    (top, bottom), (left, right) = margins(padding)
    extra = [
        -(size - w) % s
        for size, w, s in zip(
            (shape[2] + top + bottom, shape[3] + left + right), pair(window), pair(stride), strict=True
        )
    ]
    padding = (
        top + extra[0] // 2,
        bottom + (extra[0] + 1) // 2,
        left + extra[1] // 2,
        right + (extra[1] + 1) // 2,
    )
    np.testing.assert_array_equal(patches, windows(x.numpy(), window, stride, padding))
    back = combine_tensor_patches(
        patches, shape[2:], window, stride, allow_auto_unpadding=True, unpadding=(top, bottom, left, right)
    )
    if all(s <= w for s, w in zip(pair(stride), pair(window), strict=True)):
        np.testing.assert_allclose(back, x, rtol=1e-14)


@pytest.mark.parametrize("window", [2, (2, 3)])
def test_windows_side_by_side_need_no_stride(window: int | tuple[int, int]) -> None:
    x = torch.rand(2, 3, 8, 12, generator=torch.Generator().manual_seed(0))
    patches = extract_tensor_patches(x, window, window)
    combine = CombineTensorPatches((8, 12), window)
    assert torch.equal(combine(patches), x)
    assert torch.equal(torch.jit.script(combine)(patches), x)
    assert torch.equal(combine_tensor_patches(patches, (8, 12), window), x)


def test_what_no_window_has_is_zero() -> None:
    patches = extract_tensor_patches(X + 1.0, (2, 2), 3)
    together = combine_tensor_patches(patches, (8, 9), (2, 2), 3)
    expected = (torch.arange(8) % 3 < 2)[:, None] & (torch.arange(9) % 3 < 2)
    assert torch.equal(together, expected.float().expand(2, 3, 8, 9))
    assert torch.allclose(combine_tensor_patches(patches, (8, 9), (2, 2), 3, eps=1.0), 0.5 * together)


def test_gradients() -> None:
    x = photo(1, 2, 7, 6, torch.float64).requires_grad_(True)
    assert gradcheck(lambda v: extract_tensor_patches(v, (3, 2), (2, 3), (1, 0, 0, 2), True), x)
    patches = torch.rand(1, 12, 2, 3, 2, dtype=torch.float64, requires_grad=True)
    assert gradcheck(
        lambda v: combine_tensor_patches(v, (7, 6), (3, 2), (2, 1), False, (1, 0), 0.5)[..., :5],
        torch.cat([patches] * 2, 1)[:, :20],
    )


@pytest.mark.parametrize("padding", [1, (1, 2), (1, 0, 2, 3)])
def test_modules_script_whatever_the_padding(padding: object) -> None:
    cut = ExtractTensorPatches((4, 3), 2, padding, True)
    join = CombineTensorPatches((8, 9), (4, 3), 2, padding, True)
    for module in (torch.nn.Sequential(cut, join), torch.jit.script(torch.nn.Sequential(cut, join))):
        torch.testing.assert_close(module(X + 1.0), X + 1.0)


def patched(count: int = 12) -> Tensor:
    return torch.zeros(2, count, 3, 2, 3)


WRONG = [
    (lambda: extract_tensor_patches(X[0], 2), ValueError, r"input: expected shape \(B, C, H, W\)"),
    (lambda: extract_tensor_patches(X.int(), 2), TypeError, "input: expected a floating-point"),
    (
        lambda: extract_tensor_patches(X, (0, 2)),
        ValueError,
        r"window_size: expected positive sizes, got \(0, 2\)",
    ),
    (lambda: extract_tensor_patches(X, 2, 0), ValueError, r"stride: expected positive sizes, got \(0, 0\)"),
    (
        lambda: extract_tensor_patches(X, 2, 1, (0, -1)),
        ValueError,
        r"padding: expected no negative number, got \(0, 0, -1, -1\)",
    ),
    (
        lambda: extract_tensor_patches(X, (11, 2), 1, (1, 0)),
        ValueError,
        r"window_size: expected one within the padded input .*, got \(11, 2\)",
    ),
    (
        lambda: combine_tensor_patches(patched()[0], 8, 2, 2),
        ValueError,
        r"patches: expected shape \(B, N, C, rows, columns\)",
    ),
    (
        lambda: combine_tensor_patches(patched().int(), 8, 2, 2),
        TypeError,
        "patches: expected a floating-point",
    ),
    (
        lambda: combine_tensor_patches(patched(), (8, 9), (2, 3), (0, 1)),
        ValueError,
        r"stride: expected positive",
    ),
    (
        lambda: combine_tensor_patches(patched(), (0, 9), (2, 3), 1),
        ValueError,
        r"original_size: expected positive",
    ),
    (
        lambda: combine_tensor_patches(patched(), (1, 9), (2, 3), 1),
        ValueError,
        r"window_size: expected one within .* of \(1, 9\), got \(2, 3\)",
    ),
    (
        lambda: combine_tensor_patches(patched(11), (8, 9), (2, 3), (2, 3)),
        ValueError,
        r"patches: .*\(B, 12, C, 2, 3\), got \[2, 11, 3, 2, 3\]",
    ),
    (
        lambda: combine_tensor_patches(patched(12), (8, 9), (2, 2), 2),
        ValueError,
        r"patches: expected shape \(B, 16, C, 2, 2\)",
    ),
    (
        lambda: combine_tensor_patches(patched(), (8, 9), (2, 3), (2, 3), False, -1),
        ValueError,
        "unpadding: expected no negative number",
    ),
]


@pytest.mark.parametrize("call, error, message", WRONG)
def test_wrong_arguments(call, error, message) -> None:
    with pytest.raises(error, match=message):
        call()


@pytest.mark.parametrize(
    ("padding", "error", "message"),
    [
        ([1, 2, 3], ValueError, "expected a whole number, or 2 or 4, got 3"),
        ((), ValueError, "expected a whole number, or 2 or 4, got 0"),
        (None, TypeError, "expected a whole number, or 2 or 4, got NoneType"),
        ("ab", TypeError, "expected a whole number, or 2 or 4, got str"),
        ((1.0, 2.0), TypeError, "expected whole numbers, got"),
        ([1, -1], ValueError, "expected no negative number, got"),
    ],
)
def test_a_wrong_padding_is_named(padding: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=f"^padding: {message}"):
        extract_tensor_patches(X, 3, padding=padding)
    with pytest.raises(error, match=f"^unpadding: {message}"):
        combine_tensor_patches(torch.zeros(2, 4, 3, 3, 3), (8, 9), 3, unpadding=padding)


@pytest.mark.parametrize("padding", [[1, 2], [0, 2, 3, 1], (np.int64(1), np.int64(2))])
def test_a_padding_may_be_a_list(padding: list[int]) -> None:
    expected = extract_tensor_patches(X, 3, padding=tuple(map(int, padding)))
    assert torch.equal(extract_tensor_patches(X, 3, padding=padding), expected)
