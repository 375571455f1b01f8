"""What holds for every op: it scripts, its target forms agree, its gradient is right, it keeps the dtype."""

from typing import Callable

import pytest
import torch
from cases import CASES, Case, correspondences, rotations
from test_catalog import TARGETS, outputs
from torch import Tensor

from chiasm.primitives.core.target import exporting

SHAPES = ((2, 20, 24), (3, 17, 33), (1, 29, 12))


def assert_same(actual: object, expected: object, tolerance: float) -> None:
    for a, e in zip(outputs(actual), outputs(expected), strict=True):
        torch.testing.assert_close(a, e, rtol=tolerance, atol=tolerance)


def inputs(case: Case, dtype: torch.dtype = torch.float32) -> list[tuple[Tensor, ...]]:
    return [
        case.make(b, case.channels[k % len(case.channels)], h, w, dtype) for k, (b, h, w) in enumerate(SHAPES)
    ]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_script_equals_eager(case: Case) -> None:
    scripted = torch.jit.script(case.function)
    for arguments in inputs(case):
        expected = case.function(*arguments)
        for _ in range(3):  # the profiling executor specialises after the first runs
            assert_same(scripted(*arguments), expected, 1e-6)


@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_target_forms_equal_eager(case: Case, target: str) -> None:
    for arguments in inputs(case, torch.float64):
        expected = case.function(*arguments)
        with exporting(target):
            assert_same(case.function(*arguments), expected, 1e-9)


def of_differentiable(case: Case, arguments: tuple[Tensor, ...]) -> Callable[..., tuple[Tensor, ...]]:
    def call(*active: Tensor) -> tuple[Tensor, ...]:
        full = list(arguments)
        for position, value in zip(case.differentiable, active, strict=True):
            full[position] = value
        return tuple(o for o in outputs(case.function(*full)) if o.requires_grad)

    return call


@pytest.mark.parametrize("case", [c for c in CASES if c.differentiable], ids=lambda case: case.name)
def test_gradient(case: Case) -> None:
    arguments = tuple(
        jittered(a, k) for k, a in enumerate(case.make(2, case.channels[-1], 8, 9, torch.float64))
    )
    if case.make is correspondences:
        arguments = case.make(2, 1, 7, 0, torch.float64)
    if case.make is rotations:
        arguments = case.make(2, 2, 8, 9, torch.float64)
    call = of_differentiable(case, arguments)
    active = [arguments[k].clone().requires_grad_(True) for k in case.differentiable]
    assert torch.autograd.gradcheck(call, active, eps=1e-6, atol=1e-5, rtol=1e-3, fast_mode=True)


def jittered(value: Tensor, seed: int) -> Tensor:
    """Moved off ties: photographs have equal neighbours, where minima, maxima and medians have no
    derivative."""
    generator = torch.Generator().manual_seed(seed)
    if value.dim() != 4:
        return value
    return value + 0.05 * torch.rand(value.shape, generator=generator, dtype=value.dtype)


@pytest.mark.parametrize("dtype", [torch.float64, torch.float16, torch.bfloat16])
@pytest.mark.parametrize("case", [c for c in CASES if c.pure_image], ids=lambda case: case.name)
def test_dtype_is_kept(case: Case, dtype: torch.dtype) -> None:
    arguments = case.make(2, case.channels[0], 20, 24, dtype)
    result = case.function(*arguments)
    assert result.dtype == dtype
    assert torch.isfinite(result).all()
    assert not torch.allclose(result.double(), torch.zeros([], dtype=torch.float64))
