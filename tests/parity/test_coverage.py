"""No public function is left out of the catalog in silence, and docs/coverage.md can be written for all that
is in it.

The page itself is what the last full matrix found (`make parity coverage`, hours): no test asks that it be of
today.
"""

from coverage import declared, public_functions

from chiasm.export.catalog import NO_GRADIENT, NOT_DEPLOYED, catalog


def test_every_public_function_is_deployed_or_excused() -> None:
    public = public_functions()
    assert public["filters.sobel"]
    assert {name for name, deployed in public.items() if not deployed} == set(NOT_DEPLOYED)


def test_excuses_say_why() -> None:
    assert [name for name, reason in (NOT_DEPLOYED | NO_GRADIENT).items() if len(reason.split()) < 3] == []


def test_ops_without_a_gradient_are_in_the_catalog_and_have_none() -> None:
    entries = catalog()
    assert not [name for name in NO_GRADIENT if entries[name].spec.differentiated()]


def test_a_row_of_the_page_says_what_the_catalog_says() -> None:
    for name, entry in catalog().items():
        row = declared(entry)
        assert row[0] == f"`{name}`" and all(isinstance(cell, str) and cell for cell in row), row
