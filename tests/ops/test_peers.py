"""The values of every op that another library has too: the spec's peer."""

from __future__ import annotations

import warnings

import pytest
from test_catalog import module, outputs

from chiasm.export import example_inputs
from chiasm.export.catalog import Entry, catalog
from chiasm.export.peer import compared, work

ENTRIES = {name: e for name, e in catalog().items() if e.spec.peer is not None}


@pytest.mark.parametrize("entry", ENTRIES.values(), ids=ENTRIES)
def test_values_are_the_peers(entry: Entry) -> None:
    spec, peer = entry.spec, entry.spec.peer
    assert peer is not None
    for sizes in example_inputs.TESTS:
        fitted = example_inputs.fit(spec, sizes) | dict(peer.sizes)
        inputs = list(example_inputs.make(spec, fitted, spec.variants()[0]).values())
        actual = [o.numpy() for o in outputs(module(entry)(*inputs))]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            expected = work(spec, inputs).outputs(actual)
        for a, e, described in zip(actual, expected, spec.outputs, strict=True):
            apart = compared(spec, a, e, described.layout)
            assert apart.share <= peer.share, f"{apart.share:.2%} of {sizes} differ, by up to {apart.most}"
