"""How the command `chiasm` ends: every error is one message on stderr and an exit status, never a
traceback."""

from __future__ import annotations

import atexit
import gc
import os
import re
import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from ..extras import advice
from ..packs import is_name, located
from .ending import ended, fail
from .errors import ExportError
from .manifest import SUFFIX, BundleError
from .text import one_line, plain

#: The most bytes of a password, as in minisign.
_MOST_OF_PASSWORD = 1024
#: What the dynamic linker says if memory is short.
_SHORT_OF_MEMORY = r"failed to map segment|[Cc]annot allocate memory"
#: If this variable is set, an unexpected exception is not caught.
TRACEBACK = "CHIASM_TRACEBACK"


def jobs_option(text: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """The option `--jobs`: how many of the things that `text` names are done at once."""
    cores = len(os.sched_getaffinity(0))
    return click.option(
        "-j", "--jobs", type=click.IntRange(1), default=cores, show_default="one a core", help=text
    )


class BundlePath(click.Path):
    """A bundle: its folder, or its name if a package has installed it, as for `chiasm.runtime.open`."""

    def __init__(self) -> None:
        super().__init__(path_type=Path, exists=True)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        found = located(os.fsdecode(value))
        if is_name(found) and not os.path.lexists(found):
            self.fail(
                f"{found} is neither a folder here nor the name of an installed bundle (`chiasm list"
                " --installed`)",
                param,
                ctx,
            )
        return super().convert(found, param, ctx)


class OutputPath(click.Path):
    """A path that need not exist. Rejects an empty path (an unset shell variable), which pathlib reads as
    '.'; and one inside a bundle, because no runtime opens a bundle with a file that its manifest does not
    name."""

    def __init__(self, *, file_okay: bool = False) -> None:
        super().__init__(path_type=Path, file_okay=file_okay, dir_okay=not file_okay)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if value == "":
            self.fail("expected a path, got an empty text", param, ctx)
        path = super().convert(value, param, ctx)
        # Not by resolve(), which raises an error of its own for a loop
        real = Path(os.path.realpath(os.fsdecode(path)))
        for folder in (real, *real.parents):
            if folder.suffix == SUFFIX and (folder / "manifest.json").is_file():
                self.fail(
                    f"{path} is inside the bundle {folder}, which a new file would make invalid: choose a"
                    " place beside it",
                    param,
                    ctx,
                )
        return path


def pairs(option: str, texts: tuple[str, ...]) -> dict[str, str]:
    """The values, by name, of an option NAME=VALUE that may be repeated."""
    found: dict[str, str] = {}
    for text in texts:
        name, separator, value = text.partition("=")
        if not separator or not name:
            raise click.UsageError(f"{option}: expected NAME=VALUE, got {text!r}")
        if name in found:
            raise click.UsageError(f"{option}: {name} is given twice")
        found[name] = value
    return found


def password(key: Path, file: Path | None) -> str:
    """The password of a key: the first line of the file, else what the terminal or a pipe says."""
    if file is None:
        try:
            with open("/dev/tty"):
                return click.prompt(f"Password of {key}", hide_input=True)
        except OSError:  # no terminal: getpass would print warnings, and an end of the input be an interrupt
            source, line = "the standard input", sys.stdin.buffer.readline(_MOST_OF_PASSWORD)
            if not line:
                raise ExportError(
                    f"{key}: it needs a password, and there is no terminal to ask: --password-file FILE"
                ) from None
    else:
        source = f"--password-file {file}"
        with open(file, "rb") as opened:  # which may be a pipe: <(pass show minisign)
            line = opened.readline(_MOST_OF_PASSWORD)
    try:
        return line.decode().rstrip("\r\n")
    except UnicodeDecodeError as error:
        raise ExportError(f"{source}: its first line is not text in UTF-8: write it so") from error


@contextmanager
def _explained() -> Generator[None]:
    """An exception of the block becomes one line on stderr and an exit status: 2 for wrong usage, 130 after
    an interrupt, else 1."""
    with ended():
        try:
            yield
        except click.exceptions.NoArgsIsHelpError:  # `chiasm` alone: not an error's line, but the help
            raise
        except click.UsageError as error:
            command = error.ctx.command_path if error.ctx else "chiasm"
            fail(f"{one_line(error.format_message())} (`{command} --help` shows an example)", 2)
        except ExportError as error:
            fail(plain(str(error)), 1)
        except BundleError as error:
            fail(one_line(error), 1)
        except click.Abort:
            fail("interrupted", 130)
        except (click.ClickException, click.exceptions.Exit, MemoryError, OSError):
            raise
        except Exception as error:
            if isinstance(error, ImportError) and (what := advice(error)):
                fail(what, 1)
            if isinstance(error, ImportError) and re.search(_SHORT_OF_MEMORY, str(error)):
                fail(f"out of memory: {one_line(error)}", 1)
            # Exceptions of the runtime, which may not be installed, and of chiasm.data
            if type(error).__name__ in ("ChiasmError", "DataError"):
                fail(one_line(error), 1)
            if os.environ.get(TRACEBACK):
                raise
            fail(
                f"internal error: {type(error).__name__}: {one_line(error)}: please report it;"
                f" {TRACEBACK}=1 shows where it comes from",
                1,
            )


def collect_seldom() -> None:
    """Collect garbage rarely. torch's modules and an op's graphs are many small objects that stay alive: a
    collection after every 700 new objects took a tenth of the time."""
    gc.set_threshold(100_000)


class Group(click.Group):
    """Commands whose exceptions become one line on stderr: exit status 2 for wrong usage, 130 after an
    interrupt, else 1."""

    def main(self, *args: Any, **kwargs: Any) -> Any:
        try:
            os.getcwd()
        except FileNotFoundError:  # in which MKL, a part of torch, would end the process
            fail("the working folder was deleted: change to another one (`cd`)", 1)
        return super().main(*args, **kwargs)

    def make_context(self, *args: Any, **kwargs: Any) -> click.Context:
        with _explained():  # wrong usage of the group; and `--help`, which click writes here
            return super().make_context(*args, **kwargs)

    def invoke(self, ctx: click.Context) -> Any:
        collect_seldom()
        # Otherwise Python collects garbage among all of torch's objects before it ends, which takes 1.2 s
        atexit.register(gc.freeze)
        with _explained():
            return super().invoke(ctx)
