"""An op rejects a wrong tensor with a message that names the argument, the expected and the actual value. The
wrong tensors of every op are derived from its spec."""

import inspect
import re
from collections.abc import Iterator

import pytest
import torch
from torch import Tensor

from chiasm.export import example_inputs
from chiasm.export.catalog import Entry, catalog
from chiasm.export.spec import TensorSpec
from chiasm.export.tracing.module import bind_spec

ENTRIES = catalog()
SIZES = {"B": 2, "C": 3, "H": 12, "W": 9, "N": 5, "OH": 6, "OW": 7}


def wrong(tensor: TensorSpec, right: Tensor) -> Iterator[tuple[str, Tensor]]:
    """Tensors that differ from `right` in one way that the spec forbids, each with a name."""
    fixed = [i for i, size in enumerate(tensor.shape) if isinstance(size, int) and size > 1]
    if fixed:
        yield "size", torch.cat([right, right], fixed[-1])
    if not tensor.sizes:  # the shape of such a tensor is a value
        yield "rank", right.reshape(right.shape + (1, 1, 1)).expand(*right.shape, 2, 2, 2)
    if tensor.dtype == "T":
        yield "dtype", right.to(torch.complex64)


def argument_names(entry: Entry) -> list[str]:
    """The names that a message may have: the op's arguments, and the inputs that form an argument."""
    function = entry.function()
    called = function.forward if isinstance(function, torch.nn.Module) else function
    return [*inspect.signature(called).parameters, *(t.name for t in entry.spec.inputs)]


@pytest.mark.parametrize("entry", ENTRIES.values(), ids=ENTRIES)
def test_wrong_tensor_is_named(entry: Entry) -> None:
    spec = entry.spec
    module = bind_spec(entry.function(), spec)
    inputs = example_inputs.make(spec, example_inputs.fit(spec, SIZES), spec.variants()[0])
    message = re.compile(rf"({'|'.join(argument_names(entry))}): expected .*got .*", re.DOTALL)
    unclear = []
    for tensor in spec.inputs:
        for kind, value in wrong(tensor, inputs[tensor.name]):
            try:
                module(**(inputs | {tensor.name: value}))
            except (TypeError, ValueError) as error:
                if not message.fullmatch(str(error)):
                    unclear.append(f"{tensor.name}, {kind}: {error}")
            except Exception as error:
                unclear.append(f"{tensor.name}, {kind}: {type(error).__name__}: {error}")
    assert not unclear


@pytest.mark.parametrize("size", [(1, 1), (2, 2), (3, 3), (1, 9), (9, 1)], ids=str)
@pytest.mark.parametrize(
    "entry",
    [e for e in ENTRIES.values() if {"H", "W"} & set(example_inputs.fit(e.spec, SIZES))],
    ids=lambda e: e.spec.name,
)
def test_small_images_work_or_are_refused_in_words(entry: Entry, size: tuple[int, int]) -> None:
    spec = entry.spec
    sizes = example_inputs.fit(spec, SIZES)
    sizes |= {k: n for k, n in zip("HWD", (*size, size[0]), strict=True) if k in sizes}
    try:
        inputs = example_inputs.make(spec, sizes, spec.variants()[0])
    except (ValueError, RuntimeError, IndexError):
        pytest.skip("the spec's make_inputs wants more pixels")
    assert_works_or_is_refused_in_words(entry, inputs)


@pytest.mark.parametrize(
    ("entry", "symbol"),
    [(e, symbol) for e in ENTRIES.values() for symbol in example_inputs.fit(e.spec, SIZES)],
    ids=lambda p: p if isinstance(p, str) else p.spec.name,
)
def test_empty_tensors_work_or_are_refused_in_words(entry: Entry, symbol: str) -> None:
    spec = entry.spec
    inputs = example_inputs.make(spec, example_inputs.fit(spec, SIZES), spec.variants()[0])
    for tensor in spec.inputs:
        for dim, size in enumerate(tensor.shape):
            if size == symbol and not tensor.sizes:  # the shape of such a tensor is a value
                inputs[tensor.name] = inputs[tensor.name].narrow(dim, 0, 0)
    assert_works_or_is_refused_in_words(entry, inputs)


def assert_works_or_is_refused_in_words(entry: Entry, inputs: dict[str, Tensor]) -> None:
    message = re.compile(rf"({'|'.join(argument_names(entry))}): expected .*got .*", re.DOTALL)
    try:
        bind_spec(entry.function(), entry.spec)(**inputs)
    except ValueError as error:
        assert message.fullmatch(str(error))
