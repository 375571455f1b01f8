"""docs/howto/backend.md and docs/howto/dtype.md say what the code says."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = ("backend.md", "dtype.md")


def test_the_code_of_the_page_is_the_example_s():
    page = (ROOT / "docs" / "howto" / "backend.md").read_text()
    example = (ROOT / "runtime" / "backends" / "example" / "example.cpp").read_text()
    blocks = re.findall(r"```cpp\n(.*?)```", page, re.DOTALL)
    assert len(blocks) >= 5
    assert [block for block in blocks if block not in example] == []


@pytest.mark.parametrize("page", PAGES)
def test_the_files_that_a_page_names_are_there(page):
    text = (ROOT / "docs" / "howto" / page).read_text()
    named = {name for name in re.findall(r"`((?:runtime|include|tests|python)/[^`<*]+)`", text)}
    assert named
    assert [name for name in named if not (ROOT / name).exists()] == []
