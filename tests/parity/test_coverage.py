"""docs/coverage.md and the catalog say the same, and no public function is left out in silence."""

from coverage import PAGE, declared, public_functions

from chiasm.export.catalog import NO_GRADIENT, NOT_DEPLOYED, catalog


def rows() -> dict[str, list[str]]:
    lines = [line for line in PAGE.read_text().splitlines() if line.startswith("| `")]
    cells = [[c.strip() for c in line.strip("|").split(" | ")] for line in lines]
    return {c[0]: c for c in cells}


def test_page_has_every_op_and_no_other() -> None:
    assert set(rows()) == {f"`{name}`" for name in catalog()}, "run `make parity coverage`"


def test_page_says_what_the_catalog_says() -> None:
    found = rows()
    for name, entry in catalog().items():
        assert found[f"`{name}`"][:5] == declared(entry), f"{name}: run `make parity coverage`"


def test_nothing_failed_when_the_page_was_written() -> None:
    assert "**failed**" not in PAGE.read_text()
    assert " 0 failed" in PAGE.read_text()


def test_every_public_function_is_deployed_or_excused() -> None:
    public = public_functions()
    assert len(public) > 350
    assert {name for name, deployed in public.items() if not deployed} == set(NOT_DEPLOYED)


def test_ops_without_a_gradient_are_in_the_catalog_and_have_none() -> None:
    entries = catalog()
    assert not [name for name in NO_GRADIENT if entries[name].spec.differentiated()]
    assert all(f"`{name}`: {reason}" in PAGE.read_text() for name, reason in NO_GRADIENT.items()), "run `make parity coverage`"
