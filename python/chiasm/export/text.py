"""Texts for a terminal. Imports only the standard library, and quickly."""

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
    line = " ".join("".join(c if c.isprintable() else " " for c in plain(str(text))).split())
    return line if len(line) <= most else f"{line[:most]} ..."
