"""How the command `chiasm` ends where the system, or the user at the keyboard, ends it. What imports it needs
nothing but the standard library, and no time."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn


@contextmanager
def ended() -> Iterator[None]:
    """What interrupts the block, or cannot be written, becomes one line on stderr and an exit status: 130
    for an interrupt, else 1; nothing is said where nobody reads any more."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed by the caller
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115
    try:
        yield
        sys.stdout.flush()  # what cannot be written is known here, not when the interpreter ends
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
    """What is buffered for stdout goes nowhere."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
