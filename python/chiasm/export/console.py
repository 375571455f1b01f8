"""Where the command `chiasm` prints."""

from __future__ import annotations

from typing import NoReturn

from rich.console import Console


class _Console(Console):
    def on_broken_pipe(self) -> NoReturn:
        """Leave the exit status to `ending.ended`: rich's own would be 1, which for `verify` is a failure."""
        raise BrokenPipeError


console = _Console(emoji=False)
