"""Quotients of integers that have no result, or that overflow (the smallest integer by -1), end no process:
neither the exporter's nor that of any backend."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import torch
from torch import Tensor

from chiasm.export.checks.quotients import SafeQuotients
from chiasm.export.formats.torchscript_division import guard_quotients

#: Exports an op whose example has the smallest integer divided by -1, and runs it.
PROGRAM = """
import sys
import torch
import chiasm.runtime
from chiasm.export import Spec, TensorSpec, export
from test_quotients import quotients

LEAST = torch.iinfo(torch.int64).min


def sample(g, sizes, dtype):
    a = torch.arange(sizes["N"]) - 4
    b = torch.arange(sizes["N"]) % 3 + 1
    a[0], b[0] = LEAST, -1
    return {"a": a, "b": b}


spec = Spec("test.quotients", [TensorSpec(name, ("N",), "int64") for name in "ab"], make_inputs=sample)
bundle = chiasm.runtime.open(export(quotients, spec, sys.argv[1], formats=("torchscript", "onnx")))
for backend in ("torch", "onnx"):
    method = bundle.method("forward", backend=backend)
    a, b = torch.tensor([LEAST, LEAST, -7, 7, -7]), torch.tensor([-1, 3, 2, -2, -2])
    whole = torch.tensor([LEAST, -3074457345618258602, -3, -3, 3])
    print(torch.equal(torch.as_tensor(method(a, b)), whole * 2 - a))
    try:
        method(a, torch.zeros_like(b))
    except chiasm.runtime.ChiasmError:
        print("refused")
"""
CASES = [
    (torch.tensor([7, -7, 6, -6, 0]), torch.tensor([2, 2, -3, -3, 5])),
    (torch.tensor([7, -7, -128, 127], dtype=torch.int8), torch.tensor([-2, 3, -1, -1], dtype=torch.int8)),
    (torch.tensor([7, 255], dtype=torch.uint8), torch.tensor(-3)),
    (torch.tensor([7.5, -7.5, float("inf")]), torch.tensor([2.0, 2.0, 3.0])),
    (torch.tensor([7, -7]), torch.tensor(2.0)),
    (torch.tensor(-7, dtype=torch.int32), torch.tensor([2, -2], dtype=torch.int16)),
]


def quotients(a: Tensor, b: Tensor) -> Tensor:
    whole = a.clone()
    whole.div_(b, rounding_mode="trunc")
    return torch.div(a, b, rounding_mode="trunc") + whole + torch.divide(a, -1, rounding_mode="trunc")


def by_tensor(a: Tensor, b: Tensor) -> Tensor:
    return torch.div(a, b, rounding_mode="trunc")


def by_number(a: Tensor, b: Tensor) -> Tensor:
    return a.divide(b.flatten()[0].item(), rounding_mode="trunc")


def into(a: Tensor, b: Tensor) -> Tensor:
    out = torch.zeros_like(a + b)
    torch.div(a, b, rounding_mode="trunc", out=out)
    return out


def safe(a: Tensor, b: Tensor) -> Tensor:
    c = torch.div(a, 3, rounding_mode="trunc") + torch.div(a, b, rounding_mode="floor") + a // b
    return c + torch.div(a, -2.0, rounding_mode="trunc") + a.shape[0] // 2 + a.shape[0] % 3


def test_no_division_ends_a_process(tmp_path: Path) -> None:
    run = [sys.executable, "-X", "faulthandler", "-c", PROGRAM, str(tmp_path)]
    folders = ":".join([str(Path(__file__).parent), *filter(None, sys.path)])
    done = subprocess.run(
        run, env={**os.environ, "PYTHONPATH": folders}, capture_output=True, text=True, timeout=600
    )
    assert done.returncode == 0, (done.returncode, done.stderr)
    assert done.stdout.split() == ["True", "refused"] * 2


@pytest.mark.parametrize("op", [by_tensor, by_number, into])
@pytest.mark.parametrize(("a", "b"), CASES)
def test_other_quotients_are_pytorchs(op: object, a: Tensor, b: Tensor) -> None:
    expected = op(a, b)
    with SafeQuotients():
        torch.testing.assert_close(op(a, b), expected, rtol=0, atol=0)
    scripted = scripted_of(op)
    before = str(scripted.graph)
    guard_quotients(scripted)
    assert str(scripted.graph) != before
    torch.testing.assert_close(scripted(a, b), expected, rtol=0, atol=0)


def test_the_least_integer_by_minus_one_is_itself() -> None:
    for dtype in (torch.int32, torch.int64):
        least, divisor = (
            torch.full((40,), torch.iinfo(dtype).min, dtype=dtype),
            torch.full((40,), -1, dtype=dtype),
        )
        for op in (by_tensor, by_number, into):
            for a, b in ((least, divisor), (least[0], divisor[0])):
                scripted = scripted_of(op)
                guard_quotients(scripted)
                assert torch.equal(scripted(a, b), a)
                with SafeQuotients():
                    assert torch.equal(op(a, b), a)


def of_sizes(a: Tensor, b: Tensor) -> Tensor:
    size = a.shape[0] - 3
    return torch.zeros(1) + size // (b.shape[0] - 2) + 100 * (size % (b.shape[0] - 2))


def of_values(a: Tensor, b: Tensor) -> Tensor:
    x, y = int(a.item()), int(b.item())
    return torch.stack([torch.tensor(x // y), torch.tensor(x % y)])


def test_quotients_of_numbers() -> None:
    sizes, values = scripted_of(of_sizes), scripted_of(of_values)
    for scripted in (sizes, values):
        guard_quotients(scripted)
    for m in (0, 1, 2, 5, 9):
        for n in (0, 1, 3, 4, 5):  # the divisors -2, -1, 1, 2, 3
            a, b = torch.zeros(m), torch.zeros(n)
            assert torch.equal(sizes(a, b), of_sizes(a, b)), (m, n)
    with pytest.raises(RuntimeError, match="division by 0"):
        sizes(torch.zeros(5), torch.zeros(2))
    least = torch.tensor(torch.iinfo(torch.int64).min)
    assert values(least, torch.tensor(-1)).tolist() == [least.item(), 0]  # it wraps around, as in tensors
    with pytest.raises(RuntimeError, match="division by 0"):
        values(torch.tensor(5), torch.tensor(0))


def test_a_constant_divisor_costs_nothing() -> None:
    scripted = scripted_of(safe)
    before = str(scripted.graph)
    guard_quotients(scripted)
    assert str(scripted.graph) == before


def scripted_of(op: object) -> torch.jit.ScriptModule:
    """The program of a module that calls the op, as an export makes one."""
    from chiasm.export import Spec, TensorSpec
    from chiasm.export.tracing.module import bind_spec

    spec = Spec("test.quotients", [TensorSpec(name, ("N",), "int64") for name in "ab"])
    return torch.jit.script(bind_spec(op, spec))
