"""The gallery draws the picture that each spec names, and no other."""

from __future__ import annotations

import os

import numpy as np
import pytest
import torch

from chiasm.export.catalog import Entry, catalog
from chiasm.export.example_inputs import dtype_of
from chiasm.export.job import run_eager
from chiasm.export.spec import Spec
from chiasm.export.tracing.module import bind_spec
from gallery.inputs import inputs, telling
from gallery.pages.views import scene
from gallery.panels import Shown, panels
from gallery.panels.choice import PICTURES, picture_of
from tests.changes import ROOT, changed_files, is_drawn, source_of


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


def is_drawn_now(name: str, entry: Entry) -> bool:
    """Whether the op's picture is drawn in this run: all are if asked for, or if the gallery has changed,
    else those of changed ops and one of twelve others."""
    if os.environ.get("CHIASM_ALL_TESTS") or any(file.startswith("gallery/") for file in changed_files()):
        return True
    source = source_of(entry.function())
    return source in changed_files() or is_drawn(name, ROOT / source, 12)


DRAWN = {name: entry for name, entry in catalog().items() if is_drawn_now(name, entry)}


@pytest.mark.parametrize("entry", DRAWN.values(), ids=DRAWN)
def test_a_picture_of_results(entry: Entry) -> None:
    spec, photographs = entry.spec, scene(entry.spec.name).images()
    op = bind_spec(entry.function(), spec)
    given = telling(op, inputs(spec, photographs, scene(spec.name).target, points=24))
    results = dict(zip([t.name for t in spec.outputs], run_eager(op, given), strict=True))
    described = [{"name": t.name, "layout": t.layout, "color": t.color} for t in spec.outputs]
    made = panels(Shown(spec, photographs[0], given, described, results))
    assert made
    assert {(p.image.dtype, p.image.shape[2:]) for p in made} == {(np.dtype(np.uint8), (3,))}


def test_seeds_change_every_sample() -> None:
    entry = catalog()["augmentation.random_horizontal_flip"]
    op = bind_spec(entry.function(), entry.spec)
    photographs = np.random.default_rng(0).integers(0, 256, (3, 32, 40, 3), np.uint8)
    given = telling(op, inputs(entry.spec, photographs))
    torch.testing.assert_close(op(*given.values()), given["input"].flip(-1))
