"""Tables of levels against OpenCV's LUT, in both layouts."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
import torch
from test_bytes import both_layouts, frame

from chiasm.enhance import Lut, lut

TABLES = np.random.default_rng(0).integers(0, 256, (2, 256)).astype(np.uint8)


@pytest.mark.parametrize(
    "table", [TABLES[0], TABLES[0] / np.float32(7), TABLES[0] / 7.0], ids=lambda t: str(t.dtype)
)
def test_values_are_opencvs(table: np.ndarray) -> None:
    image = frame(61, 83)
    for x in both_layouts(image):
        for made in (lut(x, torch.from_numpy(table)), torch.jit.script(Lut())(x, torch.from_numpy(table))):
            values = made[0].permute(1, 2, 0).numpy()
            assert values.dtype == table.dtype
            np.testing.assert_array_equal(values, cv2.LUT(image, table))


def test_a_table_for_each_image() -> None:
    x = torch.cat([torch.from_numpy(frame(9, 14)[None]), torch.from_numpy(frame(9, 14)[None, ::-1].copy())])
    planes = x.permute(0, 3, 1, 2)
    expected = np.stack([cv2.LUT(i, t) for i, t in zip(x.numpy(), TABLES, strict=True)])
    for of in (planes, planes.contiguous()):
        for dtype in (torch.uint8, torch.float32):
            made = lut(of, torch.from_numpy(TABLES).to(dtype)).permute(0, 2, 3, 1)
            np.testing.assert_array_equal(made.numpy(), expected)


def test_single_images() -> None:
    table = torch.from_numpy(TABLES[0])
    for shape in ((3, 5, 7), (5, 7)):
        x = torch.randint(0, 256, shape, dtype=torch.uint8)
        assert lut(x, table).equal(table[x.long()])


def test_an_entrys_gradient_counts_its_pixels() -> None:
    x = torch.randint(0, 4, (2, 3, 5, 7), dtype=torch.uint8)
    table = torch.zeros(256, requires_grad=True)
    lut(x, table).sum().backward()
    assert table.grad is not None
    assert table.grad.equal(torch.bincount(x.flatten(), minlength=256).float())


def test_what_is_refused() -> None:
    x, table = torch.zeros(2, 1, 3, 3, dtype=torch.uint8), torch.from_numpy(TABLES[0])
    with pytest.raises(TypeError, match=r"image: expected a uint8 tensor, got dtype torch.float32"):
        lut(x.float(), table)
    with pytest.raises(
        TypeError, match=r"table: expected a floating-point or uint8 tensor, got dtype torch.int64"
    ):
        lut(x, table.long())
    for shape in ((255,), (3, 256), (1, 2, 256)):
        with pytest.raises(ValueError, match=r"table: expected shape \(256,\) or \(B, 256\)"):
            lut(x, torch.zeros(shape))
