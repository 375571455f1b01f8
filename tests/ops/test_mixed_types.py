"""An op whose inputs have different floating-point types promotes them, as PyTorch does, or rejects one by
its name."""

import pytest
from test_not_a_tensor import FUNCTIONS, call_of, expect_argument_named

from chiasm.export.catalog import Entry

CASES = {
    f"{path} {t.name}": (entry, t.name)
    for path, entry in FUNCTIONS.items()
    for t in entry.spec.inputs
    if t.dtype == "T" and sum(other.dtype == "T" for other in entry.spec.inputs) > 1
}


@pytest.mark.parametrize(("entry", "argument"), CASES.values(), ids=CASES)
def test_an_input_of_another_type(entry: Entry, argument: str) -> None:
    function, given = entry.function(), call_of(entry)
    try:
        function(**given | {argument: given[argument].double()})
    except (TypeError, ValueError) as error:
        expect_argument_named(error, function)
