"""Subsampled chroma against scikit-image, OpenCV and NumPy."""

from typing import Callable

import cv2
import numpy as np
import pytest
import skimage.color
import torch
from photos import hwc, photo

from chiasm import color


def reference_yuv(x: torch.Tensor) -> np.ndarray:
    return skimage.color.rgb2yuv(x.numpy(), channel_axis=1)


@pytest.mark.parametrize("size", [(36, 54), (64, 30), (2, 2)])
def test_even_sizes_equal_means(size: tuple[int, int]) -> None:
    x = photo(3, 3, *size, torch.float64)
    yuv = reference_yuv(x)
    h, w = size
    y, uv = color.rgb_to_yuv420(x)
    np.testing.assert_allclose(y, yuv[:, :1], atol=3e-5)
    np.testing.assert_allclose(uv, yuv[:, 1:].reshape(3, 2, h // 2, 2, w // 2, 2).mean((3, 5)), atol=3e-5)
    y, uv = color.rgb_to_yuv422(x)
    np.testing.assert_allclose(y, yuv[:, :1], atol=3e-5)
    np.testing.assert_allclose(uv, yuv[:, 1:].reshape(3, 2, h, w // 2, 2).mean(4), atol=3e-5)


@pytest.mark.parametrize("size", [(37, 53), (36, 31), (1, 8), (5, 1)])
def test_odd_sizes_repeat_the_edge(size: tuple[int, int]) -> None:
    x = photo(2, 3, *size, torch.float64)
    h, w = size
    padded = np.pad(reference_yuv(x), ((0, 0), (0, 0), (0, h % 2), (0, w % 2)), mode="edge")
    _, uv = color.rgb_to_yuv420(x)
    rows, columns = (h + 1) // 2, (w + 1) // 2
    np.testing.assert_allclose(uv, padded[:, 1:].reshape(2, 2, rows, 2, columns, 2).mean((3, 5)), atol=3e-5)
    _, uv = color.rgb_to_yuv422(x)
    np.testing.assert_allclose(uv, padded[:, 1:, :h].reshape(2, 2, h, columns, 2).mean(4), atol=3e-5)


@pytest.mark.parametrize("size", [(36, 54), (37, 53), (1, 7)])
def test_back_repeats_chroma(size: tuple[int, int]) -> None:
    x = photo(3, 3, *size, torch.float64)
    h, w = size
    for there, back, rows in (
        (color.rgb_to_yuv420, color.yuv420_to_rgb, 2),
        (color.rgb_to_yuv422, color.yuv422_to_rgb, 1),
    ):
        y, uv = there(x)
        chroma = uv.numpy().repeat(rows, 2).repeat(2, 3)[:, :, :h, :w]
        expected = skimage.color.yuv2rgb(np.concatenate([y, chroma], 1), channel_axis=1)
        np.testing.assert_allclose(back(y, uv), expected, atol=1e-4)
        np.testing.assert_allclose(color.planar_yuv_to_rgb(y, uv), expected, atol=1e-4)


def test_frame_equals_opencv() -> None:
    """A camera's planar 4:2:0 frame (I420: limited range), scaled to chiasm's range."""
    rgb = np.rint(hwc(photo(1, 3, 36, 54)) * 255).astype(np.uint8)
    i420 = cv2.cvtColor(rgb, cv2.COLOR_RGB2YUV_I420).astype(np.float32)
    y = (torch.from_numpy(i420[:36]) - 16) / 219
    u, v = ((torch.from_numpy(part.reshape(18, 27)) - 128) / 224 for part in (i420[36:45], i420[45:]))
    uv = torch.stack([u * 2 * 0.436, v * 2 * 0.615])
    actual = color.yuv420_to_rgb(y[None], uv).clamp(0, 1) * 255
    expected = cv2.cvtColor(i420.astype(np.uint8), cv2.COLOR_YUV2RGB_I420)
    assert np.abs(actual.permute(1, 2, 0).numpy() - expected).max() < 1.1


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16, torch.float32])
def test_dtype_is_kept(dtype: torch.dtype) -> None:
    x = photo(2, 3, 9, 12, dtype)
    for there, back in (
        (color.rgb_to_yuv420, color.yuv420_to_rgb),
        (color.rgb_to_yuv422, color.yuv422_to_rgb),
    ):
        y, uv = there(x)
        assert (y.dtype, uv.dtype, back(y, uv).dtype) == (dtype, dtype, dtype)


Y, UV = torch.zeros(1, 1, 6, 8), torch.zeros(1, 2, 3, 4)
WRONG = [
    (lambda: color.rgb_to_yuv420(Y), ValueError, r"image: expected shape \(\*, 3, H, W\)"),
    (lambda: color.rgb_to_yuv422(torch.zeros(3, 4, 4).int()), TypeError, "image: expected a floating-point"),
    (
        lambda: color.yuv420_to_rgb(UV, UV),
        ValueError,
        r"imagey: expected shape \(\*, 1, H, W\), got \[1, 2, 3, 4\]",
    ),
    (
        lambda: color.yuv420_to_rgb(Y, Y),
        ValueError,
        r"imageuv: expected shape \(\*, 2, H, W\), got \[1, 1, 6, 8\]",
    ),
    (
        lambda: color.yuv420_to_rgb(Y, UV[..., :3]),
        ValueError,
        "imageuv: expected a width of 4 for an imagey of 8, got 3",
    ),
    (
        lambda: color.yuv420_to_rgb(Y, UV[:, :, :2]),
        ValueError,
        "imageuv: expected a height of 3 for an imagey of 6, got 2",
    ),
    (lambda: color.yuv422_to_rgb(Y, UV), ValueError, "imageuv: expected the height 6 of imagey, got 3"),
    (lambda: color.yuv422_to_rgb(Y[:, :, :3], UV[..., :3]), ValueError, "imageuv: expected a width of 4"),
    (lambda: color.planar_yuv_to_rgb(Y.int(), UV), TypeError, "imagey: expected a floating-point"),
    (lambda: color.planar_yuv_to_rgb(Y, UV.int()), TypeError, "imageuv: expected a floating-point"),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=range(len(WRONG)))
def test_message(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
