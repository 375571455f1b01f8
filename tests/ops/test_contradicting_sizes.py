"""An op rejects inputs whose sizes contradict each other, where its spec gives them the same symbol: by a
message that names an argument. It may also broadcast them."""

from collections import Counter
from collections.abc import Iterator

import pytest
import torch
from test_catalog import SMALL
from test_not_a_tensor import call_of, expect_argument_named

from chiasm.export.catalog import Entry, catalog


def contradicting(entry: Entry) -> Iterator[tuple[str, int]]:
    """The inputs and axes whose size is a symbol that another input has, too."""
    uses = Counter(size for t in entry.spec.inputs for size in set(t.shape) if isinstance(size, str))
    for tensor in entry.spec.inputs:
        for axis, size in enumerate(tensor.shape):
            if isinstance(size, str) and uses[size] > 1:
                yield tensor.name, axis


CASES = {
    f"{name} {argument}[{axis}]": (entry, argument, axis)
    for name, entry in catalog().items()
    if not entry.spec.interleaved
    for argument, axis in contradicting(entry)
}


@pytest.mark.parametrize("batch", [1, 2])
@pytest.mark.parametrize(("entry", "argument", "axis"), CASES.values(), ids=CASES)
def test_contradicting_sizes_are_named(entry: Entry, argument: str, axis: int, batch: int) -> None:
    function = entry.function()
    given = call_of(entry, SMALL | {"B": batch})
    longer = torch.cat([given[argument], given[argument].narrow(axis, 0, 1)], axis)
    try:
        function(**given | {argument: longer})
    except (TypeError, ValueError) as error:
        expect_argument_named(error, function)
