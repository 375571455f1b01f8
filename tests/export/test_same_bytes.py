"""Ops on frames give the same bytes with ONNX's operators as in eager Python, on images that are large enough
to reveal a slightly wrong constant."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import skimage
import torch

import chiasm.runtime
from chiasm.geometry.transform import resize

SIZES = [(255, 351), (600, 700)]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("lanczos_antialias", {"interpolation": "lanczos", "antialias": True}),
        ("area", {"interpolation": "area"}),
    ],
)
def test_resizing(light: Callable[[str], Path], name: str, settings: dict, size: tuple[int, int]) -> None:
    photo = skimage.data.astronaut()
    bundle = light(f"geometry.transform.resize.{name}.frames")
    method = chiasm.runtime.open(bundle).method(backend="onnx", fused=False)
    expected = resize(torch.from_numpy(photo).permute(2, 0, 1)[None], size, **settings)[0].permute(1, 2, 0)
    np.testing.assert_array_equal(method(photo, np.zeros(size, np.uint8)), expected)
