"""Prose and comments have at most 110 columns: `make lint` checks it, and the writers of pages wrap theirs.

    python tools/columns.py FILE ...    print the lines that are too long: of C and C++ sources all lines, of
                                        Markdown those that `wrapped` would break

clang-format breaks code, but no comments and no string literals.
"""

from __future__ import annotations

import re
import sys
import textwrap
from itertools import groupby
from pathlib import Path

WIDTH = 110
#: What a line of Markdown is broken between: links, images and code stay whole.
_WORD = re.compile(r"(?:!?\[[^\]]*\]\([^)\s]*\)|`[^`]*`|\S)+")
#: A word that begins a list, a heading, a table or HTML if it is the first of its line.
_MARK = re.compile(r"(?:[-+*=>#]+|\d+[.)]|[|<].*)$")
#: The marker of an item of a list.
_ITEM = re.compile(r"\s*(?:[-+*]|\d+\.)\s+")


def wrapped(page: str) -> str:
    """A page of Markdown, its paragraphs and items of lists that have too long a line wrapped anew. Tables,
    headings, HTML and blocks of code stay as they are."""
    parts = [_wrapped(lines) if is_prose else lines for is_prose, lines in _parts(page.split("\n"))]
    return "\n".join(line for part in parts for line in part)


def too_long(page: str) -> list[int]:
    """The numbers of the lines of Markdown that `wrapped` would break."""
    found, number = [], 0
    for is_prose, lines in _parts(page.split("\n")):
        if is_prose and _wrapped(lines) != lines:
            found += [number + i for i, line in enumerate(lines, 1) if len(line) > WIDTH]
        number += len(lines)
    return found


def _parts(lines: list[str]) -> list[tuple[bool, list[str]]]:
    """A page's lines, divided into paragraphs and items of lists (True) and anything else (False)."""
    fence, at, keys = "", 0, []
    for line in lines:
        text = line.lstrip()
        closes = bool(fence) and text.startswith(fence)
        if not fence and (opened := re.match(r"```+|~~~+|:::+", text)):
            fence = opened[0]
        is_prose = not fence and bool(text) and text[0] not in "|<#>"
        if not is_prose or _ITEM.match(line) or not keys or not keys[-1][0]:
            at += 1
        keys.append((is_prose, at))
        if closes:
            fence = ""
    runs = groupby(zip(keys, lines), key=lambda pair: pair[0])
    return [(key[0], [line for _, line in pairs]) for key, pairs in runs]


def _wrapped(lines: list[str]) -> list[str]:
    if all(len(line) <= WIDTH for line in lines):
        return lines
    text = "\n".join(lines)
    marker = _ITEM.match(text)
    first = marker[0] if marker else text[: len(text) - len(text.lstrip(" "))]
    words: list[str] = []
    for word in _WORD.findall(text[len(first) :]):
        if words and _MARK.match(word):
            words[-1] += f" {word}"
        else:
            words.append(word)
    wrapper = textwrap.TextWrapper(
        WIDTH,
        initial_indent=first,
        subsequent_indent=" " * len(first),
        break_long_words=False,
        break_on_hyphens=False,
    )
    # A space inside of a word is no place to break at.
    made = wrapper.wrap(" ".join(re.sub(r"\s+", "\0", word) for word in words))
    return [line.replace("\0", " ") for line in made]


def main(files: list[str]) -> int:
    status = 0
    for file in files:
        text = Path(file).read_text()
        if file.endswith(".md"):
            numbers = too_long(text)
        else:
            numbers = [i for i, line in enumerate(text.split("\n"), 1) if len(line) > WIDTH]
        for number in numbers:
            print(f"{file}:{number}: longer than {WIDTH} columns", file=sys.stderr)
            status = 1
    return status


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
