"""The replaced parts of PyTorch are unchanged since the replacements were written."""

from __future__ import annotations

from importlib.metadata import version

import pytest

from chiasm.export.patches import PATCHES, VERSIONS, replaced, source_digest


@pytest.mark.parametrize("name", PATCHES)
def test_what_is_replaced_is_what_it_was(name: str) -> None:
    """If this fails, PyTorch's source has changed: read it, adapt the replacement in chiasm/export/patches,
    and record the new digest there."""
    assert source_digest(name) == PATCHES[name].source


@pytest.mark.parametrize("package", VERSIONS)
def test_the_versions_are_those_of_the_replacements(package: str) -> None:
    assert version(package).startswith(f"{VERSIONS[package]}.")


def test_what_is_replaced_comes_back_and_is_declared() -> None:
    from torch._inductor import cpp_builder

    before = cpp_builder.run_compile_cmd
    with pytest.raises(ZeroDivisionError), replaced({"torch._inductor.cpp_builder:run_compile_cmd": None}):
        assert cpp_builder.run_compile_cmd is None
        raise ZeroDivisionError
    assert cpp_builder.run_compile_cmd is before
    with (
        pytest.raises(AssertionError, match="is declared in chiasm/export/patches"),
        replaced({"torch._inductor.cpp_builder:get_cpp_compiler": None}),
    ):
        pass
