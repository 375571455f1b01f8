"""Indices in ONNX: an index that eager Python rejects is an error, and an index that cannot be negative costs
nothing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import onnx
import pytest
import torch
import torch.nn.functional as F
from torch import Tensor

from chiasm import runtime
from chiasm.export import Spec, TensorSpec, export
from chiasm.export.manifest import read_manifest

ROWS, COLUMNS = 16, 4


def ones_of(table: Tensor, index: Tensor) -> Tensor:
    return torch.ones_like(index).to(table.dtype)[:, None].expand(index.shape[0], table.shape[1])


def gathered(table: Tensor, index: Tensor) -> Tensor:
    return table.gather(0, index[:, None].expand(index.shape[0], table.shape[1]))


def selected(table: Tensor, index: Tensor) -> Tensor:
    return table.index_select(0, index)


def embedded(table: Tensor, index: Tensor) -> Tensor:
    return F.embedding(index, table)


def scattered(table: Tensor, index: Tensor) -> Tensor:
    written = table.clone()
    written.scatter_(0, index[:, None], 3.0)
    return written.scatter(0, index[:, None].expand(index.shape[0], table.shape[1]), ones_of(table, index))


def added(table: Tensor, index: Tensor) -> Tensor:
    return table.scatter_add(
        0, index[:, None].expand(index.shape[0], table.shape[1]), ones_of(table, index)
    ) + table.index_add(0, index, ones_of(table, index))


def copied(table: Tensor, index: Tensor) -> Tensor:
    return table.index_copy(0, index, ones_of(table, index))


def marked(table: Tensor, index: Tensor) -> Tensor:
    return F.one_hot(index, 16)


def classified(table: Tensor, index: Tensor) -> Tensor:
    """A loss whose classes are the table's rows."""
    scores = table.t()[:1].expand(index.shape[0], ROWS)
    return F.nll_loss(scores, index, reduction="none") + F.cross_entropy(scores, index, label_smoothing=0.1)


def exported(fn: Callable, folder: Path, format: str = "onnx", most: int = ROWS) -> Path:
    spec = Spec(
        f"test.{fn.__name__}",
        [TensorSpec("table", (ROWS, COLUMNS)), TensorSpec("index", ("P",), "int64")],
        symbols={"P": (1, 12)},
        gradients=(),
        make_inputs=lambda g, sizes, dtype: {
            "table": torch.rand(ROWS, COLUMNS, generator=g, dtype=dtype),
            "index": torch.randperm(ROWS, generator=g)[: sizes["P"]] % most,
        },
    )
    return export(fn, spec, folder, formats=[format])


def method_of(bundle: Path, backend: str = "onnx") -> runtime.Method:
    return runtime.open(bundle).method("forward", backend=backend)


@pytest.mark.parametrize("fn", [gathered, selected, embedded, scattered, added, copied, marked, classified])
def test_operators_that_take_no_negative_index_refuse_it(fn: Callable, tmp_path: Path) -> None:
    method, table = method_of(exported(fn, tmp_path)), torch.rand(ROWS, COLUMNS)
    right = torch.tensor([2, 0, ROWS - 1])
    torch.testing.assert_close(torch.as_tensor(method(table, right)), fn(table, right))
    for wrong in (-1, -ROWS, -ROWS - 1, ROWS, 1 << 40):
        index = torch.tensor([2, wrong, 1])
        with pytest.raises((IndexError, RuntimeError)):
            fn(table, index)
        with pytest.raises(runtime.ChiasmError, match=r"out of data bounds|Out of range|invalid indice"):
            method(table, index)


def test_one_hot_natively(tmp_path: Path) -> None:
    method, table = method_of(exported(marked, tmp_path, "native"), "native"), torch.rand(ROWS, COLUMNS)
    right = torch.tensor([2, 0, ROWS - 1])
    torch.testing.assert_close(torch.as_tensor(method(table, right)), marked(table, right))
    for wrong in (-1, ROWS):
        with pytest.raises(
            runtime.ChiasmError, match=f"index {wrong} is out of range for an axis of size 16"
        ):
            method(table, torch.tensor([2, wrong]))


def placed(table: Tensor, index: Tensor) -> Tensor:
    """Only in row 0, whose fifth column would be the first of row 1."""
    ones = torch.ones_like(index).to(table.dtype)
    return table.index_put([torch.zeros_like(index), index], ones, accumulate=True)


def test_a_wrong_column_is_not_in_the_next_row(tmp_path: Path) -> None:
    method, table = method_of(exported(placed, tmp_path, most=COLUMNS)), torch.rand(ROWS, COLUMNS)
    right = torch.tensor([2, 0, -1, -COLUMNS])
    torch.testing.assert_close(torch.as_tensor(method(table, right)), placed(table, right))
    for wrong in (COLUMNS, -COLUMNS - 1, ROWS * COLUMNS, 1 << 40):
        with pytest.raises((IndexError, RuntimeError)):
            placed(table, torch.tensor([2, wrong]))
        with pytest.raises(runtime.ChiasmError, match="out of data bounds"):
            method(table, torch.tensor([2, wrong]))


def short(table: Tensor, index: Tensor) -> Tensor:
    return table[index.to(torch.int32)]


def test_an_index_of_32_bits(tmp_path: Path) -> None:
    method, table = method_of(exported(short, tmp_path)), torch.rand(ROWS, COLUMNS)
    index = torch.tensor([2, -1, -ROWS])
    torch.testing.assert_close(torch.as_tensor(method(table, index)), short(table, index))


def from_the_end(table: Tensor, index: Tensor) -> Tensor:
    column = torch.arange(table.shape[1] - 1, -1, -1)
    row = torch.minimum(index.clamp(0, table.shape[0] - 1) * 2 % ROWS, torch.argmax(table, 0)[0] + 100)
    return table.index_select(1, column).index_select(0, row.clamp(max=table.shape[0] - 1))


@pytest.mark.parametrize(("fn", "checked"), [(from_the_end, False), (selected, True)])
def test_what_cannot_be_negative_costs_nothing(fn: Callable, checked: bool, tmp_path: Path) -> None:
    bundle = exported(fn, tmp_path)
    [artifact] = [a for a in read_manifest(bundle)["methods"]["forward"]["artifacts"] if "function" not in a]
    constants = [
        onnx.numpy_helper.to_array(i) for i in onnx.load(bundle / artifact["file"]).graph.initializer
    ]
    # What replaces a negative index
    assert any((c == torch.iinfo(torch.int64).min).any() for c in constants) == checked


def taken(table: Tensor, index: Tensor) -> Tensor:
    return torch.take_along_dim(table.reshape(-1), index)


def test_flat_places_are_not_counted_from_the_end(tmp_path: Path) -> None:
    method, table = method_of(exported(taken, tmp_path)), torch.rand(ROWS, COLUMNS)
    right = torch.tensor([2, 0, ROWS * COLUMNS - 1])
    torch.testing.assert_close(torch.as_tensor(method(table, right)), taken(table, right))
    for wrong in (-1, ROWS * COLUMNS):
        with pytest.raises((IndexError, RuntimeError)):
            taken(table, torch.tensor([2, wrong]))
        with pytest.raises(runtime.ChiasmError, match="Out of range"):
            method(table, torch.tensor([2, wrong]))


def labelled(scores: Tensor, labels: Tensor) -> Tensor:
    return F.multilabel_margin_loss(scores, labels, reduction="none")


def test_labels_end_at_the_first_minus_one(tmp_path: Path) -> None:
    def sample(generator: torch.Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        rows = sizes["N"]
        return {
            "scores": torch.rand(rows, 6, generator=generator, dtype=dtype),
            "labels": torch.randint(-1, 6, (rows, 6), generator=generator),
        }

    tensors = [TensorSpec("scores", ("N", 6)), TensorSpec("labels", ("N", 6), "int64")]
    spec = Spec("test.labelled", tensors, symbols={"N": (2, 99)}, gradients=(), make_inputs=sample)
    bundle = export(labelled, spec, tmp_path, formats=["onnx", "native"])
    scores = torch.rand(4, 6)
    labels = torch.tensor([[3, 0, -1, 1, 2, 5], [-1] * 6, [5, 4, 3, 2, 1, 0], [2, -1, -1, -1, -1, 4]])
    for backend in ("onnx", "native"):
        made = method_of(bundle, backend)(scores, labels)
        torch.testing.assert_close(torch.as_tensor(made), labelled(scores, labels))
        with pytest.raises(runtime.ChiasmError, match="out of"):
            method_of(bundle, backend)(scores, torch.full((4, 6), 6))
