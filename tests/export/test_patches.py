"""The replaced parts of PyTorch are unchanged since the replacements were written, and elementwise results
that are remembered are those that would be computed."""

from __future__ import annotations

from importlib.metadata import version
from typing import Any

import pytest
import torch
from torch._dynamo.source import ConstantSource
from torch._subclasses import FakeTensorMode
from torch.fx.experimental.symbolic_shapes import DimDynamic, ShapeEnv, StatelessSymbolicContext

from chiasm.export.patches import PATCHES, VERSIONS, replaced, source_digest, tracing
from chiasm.export.patches.tracing import fast_tracing


@pytest.mark.parametrize("name", PATCHES)
def test_what_is_replaced_is_what_it_was(name: str) -> None:
    """If this fails, PyTorch's source has changed: read it, adapt the replacement in chiasm/export/patches,
    and record the new digest there."""
    assert source_digest(name) == PATCHES[name].source


@pytest.mark.parametrize("package", VERSIONS)
def test_the_versions_are_those_of_the_replacements(package: str) -> None:
    assert version(package).startswith(f"{VERSIONS[package]}.")


def test_what_is_replaced_comes_back_and_is_declared() -> None:
    from torch._inductor import cpp_builder

    before = cpp_builder.run_compile_cmd
    with pytest.raises(ZeroDivisionError), replaced({"torch._inductor.cpp_builder:run_compile_cmd": None}):
        assert cpp_builder.run_compile_cmd is None
        raise ZeroDivisionError
    assert cpp_builder.run_compile_cmd is before
    with (
        pytest.raises(AssertionError, match="is declared in chiasm/export/patches"),
        replaced({"torch._inductor.cpp_builder:get_cpp_compiler": None}),
    ):
        pass


def test_elementwise_results_are_remembered_as_they_would_be_computed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of operands with all kinds of layouts and types, in pairs, each pair twice."""

    def described(t: torch.Tensor) -> tuple[str, ...]:
        return str(t.shape), str(t.stride()), str(t.dtype), str(t.device), str(type(t).__name__)

    def results() -> list[tuple[str, ...]]:
        mode = FakeTensorMode(shape_env=ShapeEnv())
        dynamic = StatelessSymbolicContext(dynamic_sizes=[DimDynamic.DYNAMIC] * 4)
        x = mode.from_tensor(torch.zeros(2, 3, 9, 11), symbolic_context=dynamic, source=ConstantSource("x"))
        with mode:
            height, width = x.shape[2], x.shape[3]
            half = x[:, :, : height - 2, : width - 2]
            operands: list[Any] = [
                *(x, x.double(), x.int(), x > 0),
                *(half, x[:, :, 1 : height - 1, 2:], half.contiguous(), half.transpose(2, 3)),
                *(x.transpose(2, 3), x.permute(0, 2, 3, 1), x.contiguous(memory_format=torch.channels_last)),
                *(x[:, :1], x[:1], x[0, 0], x[:, :, :1, :1].expand(-1, -1, height, width), x.sum()),
                *(2, 2.5, True, height),
            ]
            found: list[tuple[str, ...]] = []
            for a in operands[:-4]:
                for b in operands:
                    for operator in (torch.mul, torch.div):
                        for _ in range(2):
                            try:
                                found.append(described(operator(a, b)))
                            except RuntimeError as error:
                                found.append((str(error).splitlines()[0],))
            return found

    with fast_tracing():
        remembered = results()
    monkeypatch.setattr(tracing, "_remembering", lambda operator: operator)
    with fast_tracing():
        assert remembered == results()
    assert len({r for r in remembered if len(r) > 1}) > 15
