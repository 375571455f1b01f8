"""Photographs that ship inside scikit-image, as tensors (B, C, H, W) in [0, 1]."""

import functools
from pathlib import Path

import cv2
import numpy as np
import skimage
import torch
from torch import Tensor

FOLDER = Path(skimage.__file__).parent / "data"


@functools.cache
def load(name: str) -> np.ndarray:
    """uint8 (H, W, 3), RGB."""
    bgr = cv2.imread(str(FOLDER / name), cv2.IMREAD_COLOR)
    assert bgr is not None, f"{name} is not in the installed scikit-image"
    return bgr[..., ::-1].copy()


def photo(batch: int, channels: int, height: int, width: int, dtype: torch.dtype = torch.float32) -> Tensor:
    """Crops of three photographs; channels beyond the third come from elsewhere in the same photograph."""
    samples = []
    for b in range(batch):
        image = load(("astronaut.png", "chelsea.png", "coffee.png")[b % 3])
        planes = []
        for c in range(channels):
            top, left = 40 + 23 * (c // 3) + 31 * (b // 3), 130 + 11 * (c // 3)
            planes.append(image[top : top + height, left : left + width, c % 3])
        samples.append(np.stack(planes))
    return torch.from_numpy(np.stack(samples)).to(dtype) / 255.0


def frame(height: int, width: int) -> Tensor:
    """A camera frame, uint8 (H, W, 3), BGR."""
    return torch.from_numpy(load("coffee.png")[:height, :width, ::-1].copy())


def hwc(x: Tensor, sample: int = 0) -> np.ndarray:
    """One sample in OpenCV's layout: (H, W, C), or (H, W) for one channel."""
    array = np.ascontiguousarray(x[sample].permute(1, 2, 0).numpy())
    return array[..., 0] if array.shape[2] == 1 else array


def chw(array: np.ndarray) -> np.ndarray:
    """The inverse of ``hwc``."""
    return array[None] if array.ndim == 2 else array.transpose(2, 0, 1)
