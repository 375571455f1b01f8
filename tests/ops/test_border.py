"""Borders around images against OpenCV's copyMakeBorder and NumPy's pad, in both layouts."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
import torch

from chiasm.geometry.transform import CopyMakeBorder, copy_make_border

BORDERS = {
    "constant": cv2.BORDER_CONSTANT,
    "replicate": cv2.BORDER_REPLICATE,
    "reflect": cv2.BORDER_REFLECT_101,
    "symmetric": cv2.BORDER_REFLECT,
    "circular": cv2.BORDER_WRAP,
}
DTYPES = [torch.uint8, torch.int16, torch.uint16, torch.float32, torch.float64]


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@pytest.mark.parametrize("border", BORDERS)
def test_values_are_opencvs(border: str, dtype: torch.dtype) -> None:
    module = torch.jit.script(CopyMakeBorder(4, 0, 6, 3, border, 9.0))
    numbers = np.random.default_rng(0).integers(0, 256 if dtype == torch.uint8 else 30000, (2, 5, 7, 3))
    frames = torch.from_numpy(numbers).to(dtype)
    expected = np.stack(
        [
            cv2.copyMakeBorder(f, 4, 0, 6, 3, BORDERS[border], value=(9.0, 9.0, 9.0, 9.0))
            for f in frames.numpy()
        ]
    )
    planes = frames.permute(0, 3, 1, 2)
    for x in (planes, planes.contiguous()):
        for made in (copy_make_border(x, 4, 0, 6, 3, border, 9.0), module(x)):
            assert made.dtype == dtype
            np.testing.assert_array_equal(made.permute(0, 2, 3, 1).numpy(), expected)


@pytest.mark.parametrize(("border", "rows"), [("reflect", 4), ("symmetric", 5), ("circular", 5)])
def test_a_border_is_no_wider_than_its_image(border: str, rows: int) -> None:
    x = torch.arange(35.0).reshape(1, 1, 5, 7)
    mode = "wrap" if border == "circular" else border
    expected = np.pad(x[0, 0].numpy(), [(rows, rows), (1, 0)], mode)  # pyright: ignore[reportCallIssue, reportArgumentType]
    np.testing.assert_array_equal(copy_make_border(x, rows, rows, 1, 0, border)[0, 0].numpy(), expected)
    with pytest.raises(ValueError, match=f"image: expected at least 6 rows for the border '{border}'"):
        copy_make_border(x, 0, rows + 1, 0, 0, border)
    columns = rows + 2
    assert copy_make_border(x, 0, 0, columns, 0, border).shape == (1, 1, 5, 7 + columns)
    with pytest.raises(ValueError, match=f"image: expected at least 8 columns for the border '{border}'"):
        copy_make_border(x, 0, 0, columns + 1, 0, border)


@pytest.mark.parametrize("border", BORDERS)
def test_gradients(border: str) -> None:
    x = torch.rand(1, 2, 4, 3, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(lambda x: copy_make_border(x, 1, 2, 0, 2, border, 0.5), x)


def test_what_is_refused() -> None:
    x = torch.zeros(1, 1, 3, 3, dtype=torch.uint8)
    with pytest.raises(ValueError, match=r"top, bottom, left, right: expected no negative number, got"):
        copy_make_border(x, 0, -1, 0, 0)
    with pytest.raises(TypeError, match=r"top, bottom, left, right: expected whole numbers, got"):
        copy_make_border(x, 0, 1.5, 0, 0)  # pyright: ignore[reportArgumentType]
    with pytest.raises(ValueError, match=r"value: expected a number of dtype torch.uint8, got 256.0"):
        copy_make_border(x, 1, 1, 1, 1, "constant", 256.0)
    assert copy_make_border(x, 1, 1, 1, 1, "replicate", 256.0).equal(torch.zeros(1, 1, 5, 5).to(torch.uint8))
    with pytest.raises(TypeError, match=r"image: expected a floating-point, uint8, int16 or uint16 tensor"):
        copy_make_border(x.long(), 1, 1, 1, 1)
