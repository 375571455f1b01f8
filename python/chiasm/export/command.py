"""How the command `chiasm` ends: whatever goes wrong is one message on stderr and an exit status, never a
traceback."""

from __future__ import annotations

import atexit
import gc
import os
import signal
import sys
from collections.abc import Callable
from typing import Any

import click

from ..extras import advice
from .errors import ExportError
from .manifest import BundleError
from .text import one_line, plain

#: Set, it lets an unexpected exception through.
TRACEBACK = "CHIASM_TRACEBACK"


def jobs_option(text: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """The option `--jobs`: how much is done at once, which is what `text` says."""
    cores = len(os.sched_getaffinity(0))
    return click.option(
        "-j", "--jobs", type=click.IntRange(1), default=cores, show_default="one a core", help=text
    )


def pairs(option: str, texts: tuple[str, ...]) -> dict[str, str]:
    """The values of an option NAME=VALUE that may be given again, by name."""
    found: dict[str, str] = {}
    for text in texts:
        name, separator, value = text.partition("=")
        if not separator or not name:
            raise click.UsageError(f"{option}: expected NAME=VALUE, got {text!r}")
        if name in found:
            raise click.UsageError(f"{option}: {name} is given twice")
        found[name] = value
    return found


class Group(click.Group):
    """Commands whose exceptions become one line on stderr: exit status 2 where the command was typed wrong,
    130 where it was interrupted, else 1."""

    def invoke(self, ctx: click.Context) -> Any:
        # Else Python looks through all of torch's objects for garbage before it ends, which takes 1.2 s
        atexit.register(gc.freeze)
        try:
            result = super().invoke(ctx)
            sys.stdout.flush()  # what cannot be written is known here, not when the interpreter ends
            return result
        except click.UsageError as error:
            command = error.ctx.command_path if error.ctx else "chiasm"
            _fail(f"{one_line(error.format_message())} (`{command} --help` shows an example)", 2)
        except ExportError as error:
            _fail(plain(str(error)), 1)
        except BundleError as error:
            _fail(one_line(error), 1)
        except (KeyboardInterrupt, click.Abort):
            _fail("interrupted", 130)
        except BrokenPipeError:
            # Nobody reads any more; what is buffered goes nowhere
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
            raise SystemExit(128 + signal.SIGPIPE) from None
        except MemoryError:
            _fail("out of memory", 1)
        except OSError as error:
            _fail(f"{': '.join(str(part) for part in (error.filename, error.strerror or error) if part)}", 1)
        except (click.ClickException, click.exceptions.Exit):
            raise
        except Exception as error:
            if isinstance(error, ImportError) and (what := advice(error)):
                _fail(what, 1)
            # The runtime's, which cannot be imported where the runtime is not, and chiasm.data's
            if type(error).__name__ in ("ChiasmError", "DataError"):
                _fail(one_line(error), 1)
            if os.environ.get(TRACEBACK):
                raise
            _fail(
                f"internal error: {type(error).__name__}: {one_line(error)}: please report it; {TRACEBACK}=1"
                " shows where it comes from",
                1,
            )


def _fail(message: str, status: int) -> None:
    try:
        click.echo(f"Error: {message}", err=True)
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    raise SystemExit(status) from None
