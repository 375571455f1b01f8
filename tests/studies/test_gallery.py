"""The gallery draws the picture that each spec names, and no other."""

from __future__ import annotations

import numpy as np
import pytest

from chiasm.export.catalog import Entry, catalog
from chiasm.export.example_inputs import dtype_of
from chiasm.export.spec import Spec
from chiasm.export.tracing.module import bind_spec
from gallery.inputs import inputs
from gallery.panels.choice import PICTURES, picture_of


def test_each_spec_has_a_picture_and_each_picture_a_spec() -> None:
    assert {picture_of(entry.spec) for entry in catalog().values()} == set(PICTURES)


def test_a_picture_that_is_not_known() -> None:
    with pytest.raises(ValueError, match=r"^spec 'my.blur': the gallery has no picture 'blurs': add it to"):
        picture_of(Spec("my.blur", [], picture="blurs"))


FRAMES = {
    name: entry for name, entry in catalog().items() if any(t.layout == "NHWC" for t in entry.spec.inputs)
}


@pytest.mark.parametrize("entry", FRAMES.values(), ids=FRAMES)
def test_ops_on_frames_take_their_pictures(entry: Entry) -> None:
    photographs = np.random.default_rng(0).integers(0, 256, (1, 96, 120, 3), np.uint8)
    given = inputs(entry.spec, photographs)
    for t in entry.spec.inputs:
        if t.layout == "NHWC":
            assert given[t.name].dtype == dtype_of(t.dtype, entry.spec.variants()[0])
    bind_spec(entry.function(), entry.spec)(*given.values())
