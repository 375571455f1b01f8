"""torch's grid_sample in a user's op: the same numbers in every format, also at positions that are NaN or far
outside."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
import torch
import torch.nn.functional as F
from torch import Tensor

from chiasm import runtime
from chiasm.export import Spec, TensorSpec, export, image

MODES = [
    (mode, padding)
    for mode in ("bilinear", "nearest", "bicubic")
    for padding in ("zeros", "border", "reflection")
]
SIZES = (4, 64)
FAR = (math.nan, math.inf, -math.inf, 1e4, -1e4, 1e6, 3e38, -3e38)


class Sampled(torch.nn.Module):
    """The results in several modes."""

    def __init__(self, modes: list[tuple[str, str]], align_corners: bool) -> None:
        super().__init__()
        self.modes = modes
        self.align_corners = align_corners

    def forward(self, input: Tensor, grid: Tensor) -> tuple[Tensor, ...]:
        return tuple(
            F.grid_sample(input, grid, mode, padding, self.align_corners) for mode, padding in self.modes
        )


def exported(op: Sampled, folder: Path, axes: int, backend: str) -> runtime.Method:
    shape = ("D", "H", "W")[-axes:]
    spec = Spec(
        "test.sampled",
        [
            TensorSpec("input", ("B", 3, *shape)),
            TensorSpec("grid", ("B", *(size.lower() for size in shape), axes), range=(-1.2, 1.2)),
        ],
        [TensorSpec(f"{mode}_{padding}") for mode, padding in op.modes],
        symbols={"B": (1, 8)} | {name: SIZES for size in shape for name in (size, size.lower())},
        gradients=(),
    )
    return runtime.open(export(op, spec, folder, formats=[backend])).method("forward", backend=backend)


def hostile_grid(size: tuple[int, ...]) -> Tensor:
    """Each position far away along one axis or along all of them."""
    grid = torch.rand(2, *size, len(size)) * 2.4 - 1.2
    for i, value in enumerate(FAR):
        for axis in range(len(size)):
            grid[0, ..., i, axis, axis] = value
        grid[0, ..., i, -1, :] = value
    return grid


@pytest.mark.parametrize("align_corners", [False, True])
def test_images(align_corners: bool, tmp_path: Path) -> None:
    op = Sampled(MODES, align_corners)
    _compare(exported(op, tmp_path, 2, "onnx"), op, (9, 5))


def test_images_natively(tmp_path: Path) -> None:
    op = Sampled([("bilinear", "zeros"), ("nearest", "border"), ("bicubic", "reflection")], False)
    _compare(exported(op, tmp_path, 2, "native"), op, (9, 5))


@pytest.mark.parametrize(("backend", "modes"), [("onnx", MODES[:6]), ("native", [("nearest", "border")])])
def test_volumes(backend: str, modes: list[tuple[str, str]], tmp_path: Path) -> None:
    op = Sampled(modes, False)
    _compare(exported(op, tmp_path, 3, backend), op, (4, 8, 5))


def test_gradients(tmp_path: Path) -> None:
    op = Sampled([("bilinear", "border")], False)
    spec = Spec(
        "test.gradient",
        [image(channels=3), TensorSpec("grid", ("B", "h", "w", 2), range=(-1.2, 1.2))],
        symbols={"h": SIZES, "w": SIZES},
        gradients=("input", "grid"),
    )
    vjp = runtime.open(export(op, spec, tmp_path, formats=["onnx"])).method("vjp")
    input = torch.rand(2, 3, 6, 7, requires_grad=True)
    grid = (torch.rand(2, 4, 5, 2) * 2.4 - 1.2).requires_grad_()
    gradient = torch.rand(2, 3, 4, 5)
    op(input, grid)[0].backward(gradient)
    for answer, leaf in zip(vjp(input.detach(), grid.detach(), gradient), (input, grid), strict=True):
        torch.testing.assert_close(torch.as_tensor(answer), leaf.grad, rtol=1e-4, atol=1e-4)


def _compare(method: runtime.Method, op: Sampled, size: tuple[int, ...]) -> None:
    grid = hostile_grid(size)
    input = torch.rand(2, 3, *(7, 11, 13)[-len(size) :])
    answers = method(input, grid)
    for mode, answer, wanted in zip(
        op.modes, answers if len(op.modes) > 1 else [answers], op(input, grid), strict=True
    ):
        torch.testing.assert_close(
            torch.as_tensor(answer),
            wanted,
            rtol=1e-4,
            atol=1e-4,
            equal_nan=True,
            msg=lambda m, mode=mode: f"{mode}: {m}",
        )
