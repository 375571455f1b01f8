"""Means over windows that divide an axis: their number is fixed, the image's size is not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
import torch
import torch.nn.functional as F
from torch import Tensor, nn

from chiasm import runtime
from chiasm.export import ExportError, Spec, export, image

NAN, INFINITY = float("nan"), float("inf")


def by_area(input: Tensor) -> Tensor:
    return F.interpolate(input, size=(13, 9), mode="area")


def of_rows(input: Tensor) -> Tensor:
    return F.adaptive_avg_pool2d(input, (7, input.shape[3]))


def of_halves(input: Tensor) -> Tensor:
    return F.adaptive_avg_pool2d(input, (input.shape[2] // 2, 1))


def of_volumes(input: Tensor) -> Tensor:
    return F.adaptive_avg_pool3d(input, (2, 5, 4)) + F.adaptive_avg_pool1d(input[:, :, 0], 4)[:, :2, None, :]


def exported(fn: Callable, folder: Path, formats: list[str]) -> runtime.Bundle:
    spec = Spec(f"test.{fn.__name__}", [image(channels=3)], symbols={"H": (4, 64), "W": (4, 64)})
    return runtime.open(export(fn, spec, folder, formats=formats))


@pytest.mark.parametrize("fn", [by_area, of_rows, of_halves, of_volumes])
def test_every_size_has_its_own_windows(fn: Callable, tmp_path: Path) -> None:
    opened = exported(fn, tmp_path, ["onnx", "torchscript"])
    _compare(opened, fn, ["onnx", "torch"])


def test_natively(tmp_path: Path) -> None:
    _compare(exported(by_area, tmp_path, ["native"]), by_area, ["native"])


def test_none_has_no_form_in_torchscript(tmp_path: Path) -> None:
    spec = Spec("test.kept", [image(channels=3)], gradients=())
    with pytest.raises(ExportError, match="instead: give the size in place of None"):
        export(nn.AdaptiveAvgPool2d((7, None)), spec, tmp_path, formats=["torchscript"])


def _compare(opened: runtime.Bundle, fn: Callable, backends: list[str]) -> None:
    for height, width in ((4, 4), (13, 9), (14, 27), (64, 50)):
        x = torch.rand(2, 3, height, width)
        x[0, 0, 3, 3], x[1, 0, 0, 1] = NAN, INFINITY
        gradient = torch.rand_like(fn(x))
        leaf = x.clone().requires_grad_()
        fn(leaf).backward(gradient)
        for backend in backends:
            forward, vjp = (opened.method(name, backend=backend) for name in ("forward", "vjp"))
            torch.testing.assert_close(torch.as_tensor(forward(x)), fn(x), equal_nan=True)
            torch.testing.assert_close(torch.as_tensor(vjp(x, gradient)), leaf.grad)
