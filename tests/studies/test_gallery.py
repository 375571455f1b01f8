"""The gallery draws the picture that each spec names, and no other."""

from __future__ import annotations

import pytest

from chiasm.export.catalog import catalog
from chiasm.export.spec import Spec
from gallery.panels.choice import PICTURES, picture_of


def test_each_spec_has_a_picture_and_each_picture_a_spec() -> None:
    assert {picture_of(entry.spec) for entry in catalog().values()} == set(PICTURES)


def test_a_picture_that_is_not_known() -> None:
    with pytest.raises(ValueError, match=r"^spec 'my.blur': the gallery has no picture 'blurs': add it to"):
        picture_of(Spec("my.blur", [], picture="blurs"))
