"""Dilation against SciPy and OpenCV."""

import cv2
import numpy as np
import pytest
import scipy.ndimage as ndi
import torch
from photos import chw, hwc, photo

from chiasm.morphology import dilation

KERNELS = {
    "box": np.ones((3, 3)),
    "cross": np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]]),
    "lopsided": np.array([[1, 1, 0, 0, 0], [0, 1, 1, 0, 0], [0, 0, 1, 0, 1]]),
    "row": np.ones((1, 5)),
}
SCIPY_MODE = {"reflect": "mirror", "replicate": "nearest", "circular": "wrap", "constant": "constant"}


@pytest.mark.parametrize("kernel", KERNELS.values(), ids=KERNELS)
@pytest.mark.parametrize("shape", [(1, 1, 23, 31), (2, 3, 16, 17), (3, 5, 9, 30)])
def test_flat_geodesic_equals_opencv(kernel: np.ndarray, shape: tuple[int, ...]) -> None:
    x = photo(*shape)
    actual = dilation(x, torch.from_numpy(kernel).float())
    for b in range(shape[0]):
        expected = cv2.dilate(hwc(x, b), np.ascontiguousarray(kernel[::-1, ::-1]).astype(np.uint8))
        np.testing.assert_array_equal(actual[b], chw(expected))


@pytest.mark.parametrize("border", SCIPY_MODE)
@pytest.mark.parametrize("kernel", KERNELS.values(), ids=KERNELS)
@pytest.mark.parametrize("flat", [True, False])
def test_equals_scipy(kernel: np.ndarray, border: str, flat: bool) -> None:
    x = photo(2, 3, 16, 19, torch.float64)
    heights = None if flat else np.linspace(-0.2, 0.3, kernel.size).reshape(kernel.shape)
    actual = dilation(
        x,
        torch.from_numpy(kernel).double(),
        None if heights is None else torch.from_numpy(heights),
        border_type=border,
        border_value=0.4,
    )
    for b in range(2):
        for c in range(3):
            expected = ndi.grey_dilation(
                x[b, c].numpy(), footprint=kernel, structure=heights, mode=SCIPY_MODE[border], cval=0.4
            )
            np.testing.assert_allclose(actual[b, c], expected, atol=1e-12)


def test_origin_moves_the_element() -> None:
    x = torch.zeros(1, 1, 1, 7)
    x[..., 3] = 1.0
    spread = dilation(x, torch.ones(1, 3), origin=[0, 0])[0, 0, 0]
    centred = dilation(x, torch.ones(1, 3))[0, 0, 0]
    assert centred.tolist() == [0, 0, 1, 1, 1, 0, 0]
    assert spread.tolist() == [0, 1, 1, 1, 0, 0, 0]
