"""How the command `chiasm` ends if the system, a signal or an interrupt ends it. This module imports quickly,
and needs only the standard library."""

from __future__ import annotations

import errno
import os
import signal
import sys
import threading
from collections.abc import Generator
from contextlib import contextmanager
from typing import NoReturn

_REMEDIES = {
    errno.EMFILE: " (see `ulimit -n`)",
    errno.EFBIG: " (see `ulimit -f`)",
    errno.ENOSPC: ": make room on the disk",
}
#: The signals that ask a process to end.
ENDING = (signal.SIGTERM, signal.SIGHUP)


class Terminated(KeyboardInterrupt):
    """A signal that asks the process to end, its only argument: what an interrupt stops, it stops, too."""


@contextmanager
def _termination_is_an_exception() -> Generator[None]:
    """A signal to end raises Terminated in the block, so that it stops its workers and removes unfinished
    files. A second signal ends the process at once; but that of a limit of CPU time comes every second."""
    signals: list[int] = []
    if threading.current_thread() is threading.main_thread():
        # Not if the caller ignores it, as nohup does
        signals = [n for n in (*ENDING, signal.SIGXCPU) if signal.getsignal(n) is signal.SIG_DFL]

    def end(number: int, _frame: object) -> NoReturn:
        for other in signals:
            signal.signal(other, signal.SIG_IGN if other == number == signal.SIGXCPU else signal.SIG_DFL)
        raise Terminated(number)

    for number in signals:
        signal.signal(number, end)
    try:
        yield
    finally:
        for number in signals:
            signal.signal(number, signal.SIG_DFL)


@contextmanager
def delayed() -> Generator[None]:
    """An interrupt or a signal to end in the block waits until the block has ended. Processes that start in
    the block have these signals blocked."""
    numbers = {signal.SIGINT, *ENDING}
    received: list[int] = []
    handlers = {}

    def receive(number: int, _frame: object) -> None:
        received.append(number)

    # A block of this thread's signals is not enough: the system delivers them to another thread, one of a
    # library's, and Python then calls their handlers in this thread all the same
    if threading.current_thread() is threading.main_thread():
        ignored = signal.SIG_IGN, None
        handlers = {n: signal.signal(n, receive) for n in numbers if signal.getsignal(n) not in ignored}
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, numbers)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for number in received:
            signal.raise_signal(number)


def end_with(parent: int) -> None:
    """End this process, a child of `parent`, as soon as that ends."""
    import ctypes

    set_signal_at_parents_end = 1  # PR_SET_PDEATHSIG
    ctypes.CDLL(None).prctl(set_signal_at_parents_end, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)  # the parent ended before that


@contextmanager
def ended() -> Generator[None]:
    """An interrupt of the block, a signal to end, or a failed write becomes one line on stderr and an exit
    status: 128 and the signal's number, else 1. There is no message if nobody reads the output any more."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed by the caller
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115
    try:
        with _termination_is_an_exception():
            yield
        sys.stdout.flush()  # so that a failed write is detected here, not when the interpreter ends
    except Terminated as error:
        number = error.args[0]
        limit = number == signal.SIGXCPU
        fail("the limit of CPU time is used up (see `ulimit -t`)" if limit else "terminated", 128 + number)
    except KeyboardInterrupt:
        fail("interrupted", 130)
    except BrokenPipeError:
        _discard()
        raise SystemExit(128 + signal.SIGPIPE) from None
    except MemoryError:
        fail("out of memory", 1)
    except OSError as error:
        what = ": ".join(str(part) for part in (error.filename, error.strerror or error) if part)
        fail(what + _REMEDIES.get(error.errno or 0, ""), 1)


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
