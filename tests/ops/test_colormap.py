"""Colour maps against OpenCV."""

from typing import Callable

import cv2
import numpy as np
import pytest
import torch
from photos import photo

from chiasm.color import apply_colormap
from chiasm.color.colormap_tables import colormap_names

every_map = pytest.mark.parametrize("name", colormap_names())


def opencv(levels: np.ndarray, name: str) -> np.ndarray:
    """(3, H, W) RGB in [0, 255]."""
    return (
        cv2.applyColorMap(levels, getattr(cv2, f"COLORMAP_{name.upper()}"))[..., ::-1]
        .transpose(2, 0, 1)
        .astype(np.float64)
    )


@every_map
def test_bytes_equal_opencv(name: str) -> None:
    levels = torch.round(photo(3, 1, 37, 53) * 255).to(torch.uint8)
    levels[0, 0, :5].flatten()[:256] = torch.arange(256, dtype=torch.uint8)[: 5 * 53]
    actual = apply_colormap(levels, name)
    assert actual.dtype == torch.uint8
    for b in range(3):
        assert np.array_equal(actual[b], opencv(levels[b, 0].numpy(), name))


@every_map
def test_values_are_interpolated(name: str) -> None:
    table = opencv(np.arange(256, dtype=np.uint8)[None], name)[:, 0]
    x = torch.cat(
        [
            photo(1, 1, 19, 23, torch.float64).flatten() * 1.2 - 0.1,
            torch.linspace(0, 1, 1021, dtype=torch.float64),
        ]
    )
    expected = np.stack([np.interp(x.numpy() * 255, np.arange(256), channel) for channel in table]) / 255
    np.testing.assert_allclose(apply_colormap(x.reshape(1, 1, 1, -1), name)[0, :, 0], expected, atol=1e-12)


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16, torch.float32])
def test_dtype_and_leading_shape_are_kept(dtype: torch.dtype) -> None:
    x = photo(2, 1, 5, 7, dtype)
    out = apply_colormap(x, "jet")
    assert out.dtype == dtype and out.shape == (2, 3, 5, 7)
    assert torch.equal(apply_colormap(x[0], "jet"), out[0])


def test_scripted_equals_eager_for_every_map() -> None:
    scripted, x = torch.jit.script(apply_colormap), photo(1, 1, 5, 7)
    for name in colormap_names():
        assert torch.equal(scripted(x, name), apply_colormap(x, name))


X = torch.zeros(1, 1, 4, 4)
WRONG = [
    (lambda: apply_colormap(X, "grey"), ValueError, "colormap: expected one of .*'viridis'.*, got 'grey'"),
    (
        lambda: apply_colormap(X.expand(1, 3, 4, 4), "jet"),
        ValueError,
        r"input_tensor: expected shape \(\*, 1, H, W\), got \[1, 3, 4, 4\]",
    ),
    (
        lambda: apply_colormap(X.int(), "jet"),
        TypeError,
        "input_tensor: expected a floating-point or uint8 tensor, got dtype torch.int32",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=range(len(WRONG)))
def test_message(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
