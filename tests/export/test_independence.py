"""The exporter finds the ops that treat the samples of a batch independently, and native code gives the same
results for a batch in parts."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
import torch
from torch import Tensor

from chiasm import runtime
from chiasm.export import Spec, export, image
from chiasm.export.checks.independence import has_samples, independent
from chiasm.export.manifest import read_manifest
from chiasm.export.spec import TensorSpec, Tolerance


def halves(input: Tensor) -> Tensor:
    return input * 0.5


def by_mean(input: Tensor) -> Tensor:
    return input - input.mean()


def by_greatest(input: Tensor) -> Tensor:
    """The result of a sample in [0, 1] depends only on samples that are not in [0, 1]."""
    return torch.where(input.max() > 1.0, input / 255.0, input)


def by_any_nan(input: Tensor) -> Tensor:
    return torch.where(input.isnan().any(), torch.zeros_like(input), input)


def by_least(input: Tensor) -> Tensor:
    return torch.where(input.min() < 0.0, 0.5 * input + 0.5, input)


def by_place(input: Tensor) -> Tensor:
    return input * torch.arange(input.size(0)).to(input.dtype)[:, None, None, None]


def of_the_next(input: Tensor) -> Tensor:
    return input.roll(1, 0)


@pytest.mark.parametrize("op", [by_mean, by_greatest, by_any_nan, by_least, by_place, of_the_next])
def test_sees_samples_that_depend_on_each_other(op: Callable) -> None:
    made = {"input": torch.rand(3, 2, 5, 4, generator=torch.Generator().manual_seed(0))}
    assert not independent(lambda t: (op(**t),), [image()], made, [Tolerance(1e-5, 1e-5)])


def test_sees_a_label_of_another_sample() -> None:
    inputs = [TensorSpec("label", ("B",), "int64")]
    made = {"label": torch.tensor([2, 5, 1])}
    assert independent(lambda t: (t["label"] + 1,), inputs, made, [None])
    assert not independent(
        lambda t: (t["label"] + (t["label"] == 2).sum() * 0 + (t["label"] == 5).sum(),), inputs, made, [None]
    )


@pytest.mark.parametrize(
    ("inputs", "outputs", "expected"),
    [
        ([("B", "C")], [("B",)], True),
        ([("B", "C"), ("C",)], [("B", "C"), ("B",)], True),
        ([("B", "C")], [()], False),  # a sum over the batch
        ([("B", "C")], [("B",), ("C",)], False),
        ([("B", "B")], [("B",)], False),
        ([("B", "C")], [("B", "B*C")], False),
        ([("N", "C")], [("N",)], False),
    ],
)
def test_samples_are_the_first_dimension(inputs: list, outputs: list, expected: bool) -> None:
    assert (
        has_samples([TensorSpec("x", s) for s in inputs], [TensorSpec("y", s) for s in outputs]) == expected
    )


@pytest.mark.parametrize(("op", "samples"), [(halves, "B"), (by_mean, None)])
def test_a_large_batch_is_what_eager_code_gives(op: Callable, samples: str | None, tmp_path: Path) -> None:
    bundle = export(op, Spec(f"my.{op.__name__}", [image()]), tmp_path, formats=["native"])
    methods = read_manifest(bundle)["methods"]
    assert methods["forward"].get("samples") == methods["vjp"].get("samples") == samples
    x = torch.rand(11, 3, 211, 197, generator=torch.Generator().manual_seed(1))  # parts have a few images
    torch.testing.assert_close(runtime.open(bundle).method("forward", backend="native")(x), op(x))
