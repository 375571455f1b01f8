"""An op rejects an input of another rank or of another fixed size than its spec's, by a message that names an
argument. It may also compute with it."""

from collections.abc import Iterator

import pytest
import torch
from test_catalog import SMALL
from test_not_a_tensor import call_of, expect_argument_named
from torch import Tensor

from chiasm.export.catalog import Entry, catalog
from chiasm.export.spec import TensorSpec

CASES = {
    f"{name} {tensor.name}": (entry, tensor)
    for name, entry in catalog().items()
    if not entry.spec.interleaved
    for tensor in entry.spec.inputs
    if not tensor.sizes
}


def misshapen(tensor: TensorSpec, x: Tensor) -> Iterator[Tensor]:
    """``x`` with other ranks, and with one more and one less of each size that the spec fixes."""
    yield x[None]
    if x.dim() > 0:
        yield x[0]
        yield x.flatten()[0]
    if x.dim() > 1:
        yield x[0, 0]
        yield x.flatten()
    for axis, size in enumerate(tensor.shape):
        if isinstance(size, int):
            yield torch.cat([x, x.narrow(axis, 0, 1)], axis)
            if size > 1:
                yield x.narrow(axis, 0, size - 1)


@pytest.mark.parametrize(("entry", "tensor"), CASES.values(), ids=CASES)
def test_wrong_shapes_are_named(entry: Entry, tensor: TensorSpec) -> None:
    function = entry.function()
    given = call_of(entry, SMALL | {"B": 2})
    for x in misshapen(tensor, given[tensor.name]):
        try:
            function(**given | {tensor.name: x})
        except (TypeError, ValueError) as error:
            expect_argument_named(error, function)
