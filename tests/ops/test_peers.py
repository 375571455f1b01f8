"""The values of every op that another library has, too: the spec's peer."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from test_catalog import module, outputs

from chiasm.export import samples
from chiasm.export.catalog import Entry, catalog
from chiasm.export.peer import Peer, work
from chiasm.export.spec import Tolerance

ENTRIES = {name: e for name, e in catalog().items() if e.spec.peer is not None}


@pytest.mark.parametrize("entry", ENTRIES.values(), ids=ENTRIES)
def test_values_are_the_peers(entry: Entry) -> None:
    spec, peer = entry.spec, entry.spec.peer
    assert peer is not None
    for sizes in samples.TESTS:
        fitted = samples.fit(spec, sizes) | dict(peer.sizes)
        inputs = list(samples.make(spec, fitted, spec.variants()[0]).values())
        actual = [o.numpy() for o in outputs(module(entry)(*inputs))]
        batched = [t.shape[:1] == ("B",) for t in spec.inputs]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            expected = work(peer, inputs, batched, spec.interleaved).outputs(actual)
        for a, e, described in zip(actual, expected, spec.outputs, strict=True):
            assert_close(a, e, peer, tolerance(entry, peer, a), described.layout)


def tolerance(entry: Entry, peer: Peer, actual: np.ndarray) -> Tolerance:
    if peer.atol is not None:
        return Tolerance(peer.atol, peer.rtol)
    return entry.spec.tolerance("forward", str(actual.dtype)) or Tolerance(0, 0)


def assert_close(
    actual: np.ndarray, expected: np.ndarray, peer: Peer, allowed: Tolerance, layout: str
) -> None:
    if peer.edge:
        inside = slice(peer.edge, -peer.edge)
        where = (slice(None), inside, inside) if layout == "NHWC" else (..., inside, inside)
        actual, expected = actual[where], expected[where]
    actual, expected = actual.astype(np.float64), expected.astype(np.float64)
    error = np.abs(actual - expected) - allowed.atol - allowed.rtol * np.abs(expected)
    wrong = ~(error <= 0) & (actual != expected) & ~(np.isnan(actual) & np.isnan(expected))
    assert wrong.mean() <= peer.share, (
        f"{wrong.sum()} of {wrong.size} differ, by up to {np.abs(actual - expected).max()}"
    )
