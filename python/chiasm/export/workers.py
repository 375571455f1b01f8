"""Exports several ops of the catalog at once, in processes of their own."""

from __future__ import annotations

import multiprocessing
import os
import signal
import tempfile
import time
import warnings
from collections import deque
from collections.abc import Generator, Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

import click
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from ..packs import SUFFIX
from .command import collect_seldom
from .console import console
from .ending import end_with
from .errors import ExportError
from .manifest import FORMATS, METHODS
from .text import one_line, plain

#: An op's name, and the seconds of its export or its error.
_Outcome = tuple[str, float | BaseException]


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
    # A single op is exported in this process: a worker would import torch again.
    outcomes = _by_workers(ops, output, jobs) if len(ops) > 1 else _here(ops, output)
    with Progress(*columns, console=console) as progress, closing(outcomes):
        task = progress.add_task("exporting", total=len(ops))
        for name, outcome in outcomes:
            if isinstance(outcome, BaseException):
                failures[name] = _failure(name, outcome)
                if len(ops) > 1:
                    console.print(f"[red]failed[/] {escape(failures[name])}", highlight=False)
            else:
                console.print(f"[green]exported[/] {name}{SUFFIX} [dim]{outcome:.1f} s[/]", highlight=False)
            progress.update(task, advance=1, description=name)
    if failures:
        # once more: hundreds of lines may have been printed since
        many = [f"{len(failures)} of {len(ops)} ops failed: {', '.join(failures)}"] if len(ops) > 1 else []
        raise ExportError("\n".join([*many, *failures.values()]))
    folder = one_line(output)
    click.echo(
        f"{len(ops)} bundles in {folder}/ in {time.monotonic() - started:.0f} s. Next: chiasm verify"
        f" {folder}/*{SUFFIX}"
    )


def _expect_writable(folder: Path) -> None:
    """Make the folder, and reject one in which no file can be made: now, not after minutes of compiling."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise ExportError(f"{folder}: cannot be written: {error.strerror}; choose another folder") from error


def _here(ops: Sequence[Wanted], output: Path) -> Generator[_Outcome]:
    for op in ops:
        try:
            yield op.name, export_entry(op, output)
        except Exception as error:
            yield op.name, error


def _by_workers(ops: Sequence[Wanted], output: Path, jobs: int) -> Generator[_Outcome]:
    """Export ops in processes. One op's failure, of whatever kind, does not stop the others: if a worker is
    killed, those that were in work are exported again, one at a time, and only the one that is killed alone
    fails."""
    waiting, suspects = deque(ops), deque[Wanted]()
    while waiting or suspects:
        queue = suspects or waiting
        in_work: dict[Future[float], Wanted] = {}
        with _Workers(1 if suspects else min(jobs, len(waiting)), output) as workers:
            while (queue or in_work) and not workers.broken:
                while queue and len(in_work) < workers.count:
                    op = queue.popleft()
                    in_work[workers.submit(op)] = op
                for ended in wait(in_work, return_when=FIRST_COMPLETED).done:
                    error = ended.exception()
                    if isinstance(error, BrokenProcessPool):
                        workers.broken = True
                    else:
                        yield in_work.pop(ended).name, error or ended.result()
        if workers.count > 1:
            suspects.extend(in_work.values())
        else:
            for op in in_work.values():
                yield op.name, BrokenProcessPool()


class _Workers:
    """Processes that export ops. When the block is left early, they are killed (an op's code might catch an
    exception), and what they were writing is removed."""

    def __init__(self, count: int, output: Path) -> None:
        self.count, self._output = count, output
        #: Whether a worker was killed, after which none takes an op.
        self.broken = False
        self._ids: set[int] = set()
        self._scratch = tempfile.TemporaryDirectory(prefix="chiasm-export-", ignore_cleanup_errors=True)
        # Workers are spawned, not forked: torch's threads do not survive a fork.
        self._pool = ProcessPoolExecutor(
            count,
            mp_context=multiprocessing.get_context("spawn"),
            initializer=_begin,
            initargs=(self._scratch.name, os.getpid()),
        )

    def submit(self, op: Wanted) -> Future[float]:
        try:
            task = self._pool.submit(export_entry, op, self._output)
        except BrokenProcessPool as error:
            task = Future[float]()
            task.set_exception(error)
        self._ids |= {worker.pid for worker in multiprocessing.active_children() if worker.pid is not None}
        return task

    def __enter__(self) -> _Workers:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is not None or self.broken:
            self._kill()
        self._pool.shutdown(cancel_futures=True)
        self._scratch.cleanup()

    def _kill(self) -> None:
        from .bundle import clean_up

        alive = {worker.pid for worker in multiprocessing.active_children()}
        for process in self._ids:
            try:
                os.killpg(process, signal.SIGKILL)  # its compilers too, which outlive a worker
            except ProcessLookupError:
                if process in alive:  # the worker has no session yet
                    os.kill(process, signal.SIGKILL)
        for process in self._ids:
            clean_up(self._output, process)


def _begin(scratch: str, parent: int) -> None:
    """Start a session for the worker and its compilers, which ends with the parent: that handles interrupts,
    and ends them all."""
    os.setsid()
    end_with(parent)
    os.environ["TMPDIR"] = tempfile.tempdir = scratch
    collect_seldom()


def _failure(name: str, error: BaseException) -> str:
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
