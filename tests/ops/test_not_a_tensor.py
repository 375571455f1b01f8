"""For every op, an argument that must be a tensor and is not raises a TypeError that names it."""

import inspect
import re
from collections.abc import Callable
from typing import Any

import pytest
from test_catalog import SMALL
from torch import Tensor

from chiasm.export import example_inputs
from chiasm.export.catalog import Entry, catalog

#: One spec of each function.
FUNCTIONS = {entry.path: entry for entry in catalog().values() if not entry.spec.interleaved}


def call_of(entry: Entry, sizes: dict[str, int] = SMALL) -> dict[str, Any]:
    """The arguments of a call in eager Python."""
    made = example_inputs.make(entry.spec, example_inputs.fit(entry.spec, sizes), entry.spec.variants()[0])
    given: dict[str, Any] = dict(entry.spec.config)
    for t in entry.spec.inputs:
        if not t.sizes:
            in_frames = entry.spec.interleaved and t.layout == "NHWC"
            given[t.name] = made[t.name].permute(0, 3, 1, 2) if in_frames else made[t.name]
        elif len(t.sizes) == 1:
            given[t.sizes[0]] = tuple(made[t.name].shape)
        else:
            given |= zip(t.sizes, made[t.name].shape, strict=True)
    return given


def expect_argument_named(error: Exception, function: Callable[..., Any]) -> None:
    """Assert that an error begins with an argument's name, and has the expected and the actual value."""
    names = "|".join(inspect.signature(function).parameters)
    assert re.match(rf"({names})\b.*: expected .*, got ", str(error)), str(error)


@pytest.mark.parametrize("entry", FUNCTIONS.values(), ids=FUNCTIONS)
def test_what_is_no_tensor_is_named(entry: Entry) -> None:
    function, given = entry.function(), call_of(entry)
    parameters = inspect.signature(function).parameters
    required = [p.name for p in parameters.values() if p.annotation is Tensor and p.default is p.empty]
    for name in required:
        for wrong, kind in (([1.0, 2.0], "list"), (None, "NoneType")):
            with pytest.raises(
                TypeError, match=f"^{name}: expected a (tensor|number or a tensor), got {kind}"
            ):
                function(**given | {name: wrong})
