"""tools/columns.py: pages of Markdown are wrapped, and only where it changes nothing but the lines."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from tools.columns import WIDTH, too_long, wrapped

ROOT = Path(__file__).resolve().parents[2]
LONG = "word " * 30 + "end"


def test_paragraphs_and_items_are_wrapped() -> None:
    page = f"# {LONG}\n\nshort\n{LONG}\n\n* {LONG}\n* short\n  too\n"
    made = wrapped(page).split("\n")
    assert made[0] == f"# {LONG}"  # a heading is one line
    assert all(len(line) <= WIDTH for line in made[1:])
    assert made[2].startswith("short word") and made[5].startswith("* word") and made[6].startswith("  word")
    assert made[-3:] == ["* short", "  too", ""]
    assert " ".join(wrapped(page).split()) == " ".join(page.split())
    assert too_long(page) == [4, 6] and too_long(wrapped(page)) == []
    assert wrapped(wrapped(page)) == wrapped(page)


def test_what_cannot_be_broken_stays() -> None:
    link = f"[{LONG}](https://example.com)"
    kept = f"| {LONG} |\n\n```text\n{LONG}\n```\n\n<td>{LONG}</td>\n\n{link}\n\n{'x' * 120}\n"
    assert wrapped(kept) == kept and too_long(kept) == []


def test_a_line_does_not_begin_with_a_mark_of_markdown() -> None:
    words = "word " * 22  # a line holds them, and not one more
    for mark in ("+", "-", "12.", "|x|", "<x>", "#"):
        lines = wrapped(f"{words}{mark} {LONG}\n").split("\n")
        assert lines[0].endswith("word") and lines[1].startswith(f"word {mark} word"), lines


def test_the_command_names_the_lines(tmp_path: Path) -> None:
    source = tmp_path / "source.h"
    source.write_text(f"// short\n// {LONG}\n")
    done = subprocess.run(
        [sys.executable, ROOT / "tools/columns.py", source], capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert done.stderr == f"{source}:2: longer than {WIDTH} columns\n"


def test_make_lists_its_targets_in_100_columns() -> None:
    listed = subprocess.run(["make", "help"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert "lint" in listed
    assert [line for line in listed.splitlines() if len(line) > 100] == []
