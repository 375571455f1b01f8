"""Texts for a terminal, and names. Imports only the standard library, and quickly."""

from __future__ import annotations

import re

#: Terminals' colours and cursor movements, and other characters that do not belong in a line.
_CONTROL = re.compile(
    r"\x1b\[[0-9;?]*[ -/]*[@-~]|\x1b\][^\x07\x1b]*(?:\x07|\x1b\\)|\x1b.|[\x00-\x08\x0b-\x1f\x7f-\x9f]"
)


def plain(text: str) -> str:
    """Text without sequences that move a terminal's cursor or change its colours."""
    return _CONTROL.sub("", text)


def one_line(text: object, most: int = 600) -> str:
    """The same in one line, without invisible characters, and shortened if it is very long."""
    line = " ".join("".join(c if c.isprintable() else " " for c in plain(words(text))).split())
    return line if len(line) <= most else f"{line[:most]} ..."


def first_sentence(docstring: str | None) -> str:
    """The first sentence of a docstring, or its first paragraph if that has no full stop, in one line."""
    paragraph = " ".join(re.split(r"\n\s*\n", (docstring or "").strip())[0].split())
    # A full stop before a small letter, as in "e.g. a", ends no sentence
    ended = re.match(r".*?\.(?=\s+[A-Z`:(]|$)", paragraph)
    return ended[0] if ended else paragraph


def words(value: object) -> str:
    """`str(value)`; the name of its type if it has none, as an exception of a user's may."""
    try:
        return str(value)
    except Exception:
        return type(value).__name__


def free_name(name: str, taken: set[str]) -> str:
    """`name`, with a number after it if it is taken; `taken` gets the result."""
    free, number = name, 2
    while free in taken:
        free, number = f"{name}_{number}", number + 1
    taken.add(free)
    return free
