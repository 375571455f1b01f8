"""Ops on frames give the same bytes with ONNX's operators as in eager Python, on images that are large enough
to reveal a slightly wrong constant."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import skimage
import torch

import chiasm.runtime
from chiasm.geometry.transform import resize, warp_affine

SIZES = [(255, 351), (600, 700)]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("lanczos_antialias", {"interpolation": "lanczos", "antialias": True}),
        ("area", {"interpolation": "area"}),
        ("lanczos4", {"interpolation": "lanczos4"}),
    ],
)
def test_resizing(light: Callable[[str], Path], name: str, settings: dict, size: tuple[int, int]) -> None:
    photo = skimage.data.astronaut()
    bundle = light(f"geometry.transform.resize.{name}.frames")
    method = chiasm.runtime.open(bundle).method(backend="onnx", fused=False)
    expected = resize(torch.from_numpy(photo).permute(2, 0, 1)[None], size, **settings)[0].permute(1, 2, 0)
    np.testing.assert_array_equal(method(photo, np.zeros(size, np.uint8)), expected)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("dtype", ["int16", "uint16"])
def test_16_bits(light: Callable[[str], Path], dtype: str, size: tuple[int, int]) -> None:
    """Noise over the whole range, of which the catalog's examples use 256 levels."""
    whole = np.random.default_rng(1).integers(0, 65536, (512, 512, 2))
    noise = (whole - (32768 if dtype == "int16" else 0)).astype(dtype)
    x, like = torch.from_numpy(noise).permute(2, 0, 1)[None], np.zeros(size, np.uint8)
    turn = np.array([[[0.9, 0.3, -20.0], [-0.3, 0.9, 40.0]]], np.float32)
    for name, inputs, expected in (
        ("resize.bilinear", (noise, like), resize(x, size)),
        ("warp_affine.bilinear_zeros", (noise, turn, like), warp_affine(x, torch.from_numpy(turn), size)),
    ):
        bundle = chiasm.runtime.open(light(f"geometry.transform.{name}.frames"))
        for method in (
            bundle.method(backend="onnx", dtype=dtype, fused=False),
            bundle.method(backend="torch", dtype=dtype),
        ):
            np.testing.assert_array_equal(method(*inputs), expected[0].permute(1, 2, 0))
