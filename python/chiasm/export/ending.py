"""How the command `chiasm` ends if the system or an interrupt ends it. This module imports quickly, and needs
only the standard library."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn


@contextmanager
def ended() -> Iterator[None]:
    """An interrupt of the block, or a failed write, becomes one line on stderr and an exit status: 130 for an
    interrupt, else 1. There is no message if nobody reads the output any more."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed by the caller
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115
    try:
        yield
        sys.stdout.flush()  # so that a failed write is detected here, not when the interpreter ends
    except KeyboardInterrupt:
        fail("interrupted", 130)
    except BrokenPipeError:
        _discard()
        raise SystemExit(128 + signal.SIGPIPE) from None
    except MemoryError:
        fail("out of memory", 1)
    except OSError as error:
        fail(": ".join(str(part) for part in (error.filename, error.strerror or error) if part), 1)


def fail(message: str, status: int) -> NoReturn:
    """End with a message."""
    try:
        print(f"Error: {message}", file=sys.stderr)
        sys.stdout.flush()
    except OSError:
        _discard()
    raise SystemExit(status) from None


def _discard() -> None:
    """Discard the buffered output."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
