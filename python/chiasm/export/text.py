"""Texts for a terminal. What imports it needs nothing but the standard library, and no time."""

from __future__ import annotations

import re

#: Terminals' colours and cursor movements, and other characters that would not stand in a line.
_CONTROL = re.compile(
    r"\x1b\[[0-9;?]*[ -/]*[@-~]|\x1b\][^\x07\x1b]*(?:\x07|\x1b\\)|\x1b.|[\x00-\x08\x0b-\x1f\x7f-\x9f]"
)


def plain(text: str) -> str:
    """Text without what would move a terminal's cursor or change its colours."""
    return _CONTROL.sub("", text)


def one_line(text: object, most: int = 600) -> str:
    """The same in one line, without characters that are not seen, cut where it is very long."""
    line = " ".join("".join(c if c.isprintable() else " " for c in plain(str(text))).split())
    return line if len(line) <= most else f"{line[:most]} ..."
