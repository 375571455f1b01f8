"""Ops on frames give the same bytes with ONNX's operators as in eager Python, on images that are large enough
to reveal a slightly wrong constant."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import skimage
import torch

import chiasm.runtime
from chiasm.enhance import threshold
from chiasm.export import Spec, TensorSpec, export
from chiasm.filters import in_range
from chiasm.geometry.transform import remap, resize, warp_affine

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


def of_words(frame: torch.Tensor) -> tuple[torch.Tensor, ...]:
    """What kernels do with frames of 16 bits (B, H, W, C)."""
    x = frame.permute(0, 3, 1, 2)
    turn = torch.tensor([[[0.9, 0.3, -20.0], [-0.3, 0.9, 40.0]]])
    row, column = torch.meshgrid(torch.arange(50.0) * 3.3 - 9, torch.arange(70.0) * 2.7 - 7, indexing="ij")
    return (
        *(resize(x, (301, 97), name) for name in ("bilinear", "bicubic", "lanczos4", "area")),
        warp_affine(x, turn, (90, 140)),
        warp_affine(x, turn, (90, 140), "nearest", "reflection"),
        remap(x, column[None], row[None], padding_mode="border"),
        *(threshold(x, 9000.5, 20000.0, name) for name in ("binary", "trunc", "tozero", "tozero_inv")),
        in_range(x, [-5.0, 9000.0, 0.0], [30000.0, 40000.0, 20000.0]),
    )


@pytest.mark.parametrize("dtype", ["int16", "uint16"])
def test_kernels_of_16_bits(tmp_path: Path, dtype: str) -> None:
    low, high = (-32768, 32767) if dtype == "int16" else (0, 65535)
    spec = Spec(
        "my.words",
        [TensorSpec("frame", ("B", "H", "W", 3), dtype, "NHWC", range=(low, high))],
        [TensorSpec(f"output{i}") for i in range(12)],
        gradients=(),
    )
    bundle = chiasm.runtime.open(export(of_words, spec, tmp_path, formats=["native", "onnx"]))
    for size in ((2, 140, 171), (1, 37, 41)):
        noise = np.random.default_rng(2).integers(low, high + 1, (*size, 3)).astype(dtype)
        expected = of_words(torch.from_numpy(noise))
        for method in (bundle.method(backend="native"), bundle.method(backend="onnx")):
            for name, made, wanted in zip(spec.outputs, method(noise), expected, strict=True):
                np.testing.assert_array_equal(made, wanted, name.name)
