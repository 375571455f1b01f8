"""An op rejects the values of arguments that its spec calls errors: each with the spec's message, which names
the argument, the expected and the actual value."""

import pytest
import torch
from test_not_a_tensor import call_of

from chiasm.export.catalog import Entry, catalog
from chiasm.export.spec import ErrorInput

REJECTED = {
    f"{name} {wrong.argument}={wrong.value}": (entry, wrong)
    for name, entry in catalog().items()
    for wrong in entry.spec.errors
}


@pytest.mark.parametrize(("entry", "wrong"), REJECTED.values(), ids=REJECTED)
def test_errors_of_the_spec(entry: Entry, wrong: ErrorInput) -> None:
    for settings in ({}, *entry.spec.also):
        with pytest.raises(wrong.error) as caught:
            entry.function()(**call_of(entry) | settings | {wrong.argument: wrong.value})
        assert str(caught.value).startswith(wrong.message) and ", got " in str(caught.value)


#: The arguments that are several whole numbers.
SIZES = {n: (e, wrong.argument) for n, (e, wrong) in REJECTED.items() if "whole numbers" in wrong.message}


@pytest.mark.parametrize(("entry", "argument"), SIZES.values(), ids=SIZES)
def test_sizes_may_be_a_list(entry: Entry, argument: str) -> None:
    function, given = entry.function(), call_of(entry)
    actual = function(**given | {argument: list(given.get(argument, (3, 3)))})
    torch.testing.assert_close(actual, function(**{argument: (3, 3)} | given), rtol=0, atol=0, equal_nan=True)
