"""Exports several ops of the catalog at once, in processes of their own."""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import tempfile
import time
import warnings
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import click
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from ..packs import SUFFIX
from .command import collect_seldom
from .console import console
from .errors import ExportError
from .manifest import FORMATS, METHODS
from .text import one_line, plain

#: An option of prctl: the signal that a process gets when its parent dies.
_PR_SET_PDEATHSIG = 1
_Result = TypeVar("_Result")


class Wanted(NamedTuple):
    """An op to export, and how."""

    name: str
    formats: tuple[str, ...] = FORMATS
    isas: tuple[str, ...] = ("x86-64-v3",)
    methods: tuple[str, ...] = METHODS


def export_names(
    names: Iterable[str],
    output: Path,
    formats: tuple[str, ...] = FORMATS,
    isas: tuple[str, ...] = ("x86-64-v3",),
    methods: tuple[str, ...] = METHODS,
    jobs: int = 1,
) -> None:
    """`export_all` of ops that are exported in the same way."""
    export_all([Wanted(name, formats, isas, methods) for name in names], output, jobs)


def export_all(ops: Sequence[Wanted], output: Path, jobs: int = 1) -> None:
    """Export ops of the catalog, several at once, with a progress bar. Raises ExportError at the end if some
    failed."""
    _expect_writable(output)
    started = time.monotonic()
    failures: dict[str, str] = {}
    columns = TextColumn("{task.description:48}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    # Workers are spawned, not forked: torch's threads do not survive a fork. A single op is exported in this
    # process: a worker would import torch again.
    context = multiprocessing.get_context("spawn")
    scratch = tempfile.TemporaryDirectory(prefix="chiasm-export-", ignore_cleanup_errors=True)
    workers = (
        ProcessPoolExecutor(
            min(jobs, len(ops)), mp_context=context, initializer=_worker, initargs=(scratch.name,)
        )
        if len(ops) > 1
        else _Here()
    )
    with scratch, Progress(*columns, console=console) as progress, workers as pool:
        task = progress.add_task("exporting", total=len(ops))
        pending = {pool.submit(export_entry, op, output): op.name for op in ops}
        try:
            for done in as_completed(pending):
                name = pending[done]
                try:
                    seconds = done.result()
                    console.print(
                        f"[green]exported[/] {name}{SUFFIX} [dim]{seconds:.1f} s[/]", highlight=False
                    )
                except Exception as error:  # one op's failure, of whatever kind, does not stop the others
                    failures[name] = _failure(name, error)
                    if len(ops) > 1:
                        console.print(f"[red]failed[/] {escape(failures[name])}", highlight=False)
                progress.update(task, advance=1, description=name)
        except KeyboardInterrupt:
            _stop(pool, output)
            raise
    if failures:
        # once more: hundreds of lines may have been printed since
        many = [f"{len(failures)} of {len(ops)} ops failed: {', '.join(failures)}"] if len(ops) > 1 else []
        raise ExportError("\n".join([*many, *failures.values()]))
    click.echo(
        f"{len(ops)} bundles in {output}/ in {time.monotonic() - started:.0f} s. Next: chiasm verify"
        f" {output}/*{SUFFIX}"
    )


def _expect_writable(folder: Path) -> None:
    """Make the folder, and reject one in which no file can be made: now, not after minutes of compiling."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise ExportError(f"{folder}: cannot be written: {error.strerror}; choose another folder") from error


class _Here(Executor):
    """Runs tasks in this process, immediately."""

    def submit(self, fn: Callable[..., _Result], /, *args: Any, **kwargs: Any) -> Future[_Result]:
        done = Future[_Result]()
        try:
            done.set_result(fn(*args, **kwargs))
        except Exception as error:
            done.set_exception(error)
        return done


def _worker(scratch: str) -> None:
    """Start a session for the worker and its compilers: the parent handles interrupts, and ends them all."""
    os.setsid()
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    os.environ["TMPDIR"] = tempfile.tempdir = scratch
    collect_seldom()


def _stop(pool: Executor, output: Path) -> None:
    """Kill the workers (an op's code might catch an exception), and remove what they were writing."""
    from .bundle import clean_up

    ids = [worker.pid for worker in multiprocessing.active_children() if worker.pid is not None]
    for process in ids:
        try:
            os.killpg(process, signal.SIGKILL)
        except ProcessLookupError:  # the worker has no session yet
            os.kill(process, signal.SIGKILL)
    pool.shutdown(cancel_futures=True)
    for process in ids:
        clean_up(output, process)


def _failure(name: str, error: Exception) -> str:
    if isinstance(error, ExportError):
        return plain(str(error))
    if isinstance(error, BrokenProcessPool):
        return (
            f"{name}: the process that exported it was killed; where memory is short, export fewer at once:"
            " --jobs 1"
        )
    return f"{name}: {type(error).__name__}: {one_line(error)}"


def export_entry(op: Wanted, output: Path) -> float:
    """Export one op of the catalog; returns the seconds it took."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from .catalog import catalog
        from .pipeline import export as export_op

        started = time.monotonic()
        entry = catalog()[op.name]
        export_op(entry.function(), entry.spec, output, op.formats, op.isas, op.methods)
        return time.monotonic() - started
