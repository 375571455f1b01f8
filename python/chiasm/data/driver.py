# pyarrow and Ray are optional, and not in .venv:
# pyright: reportMissingImports=false
"""Run all shards of an input, in processes of this machine or as tasks of a Ray cluster, and resume an
earlier run."""

from __future__ import annotations

import ctypes
import fcntl
import hashlib
import json
import multiprocessing
import os
import re
import signal
import socket
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from ..export.ending import ENDING, delayed
from ..export.text import one_line
from .errors import DataError
from .mapping import Map
from .shards import Shard, write

#: The job of an output folder, so that a restart with another job is rejected.
JOB = "_chiasm_map.json"
#: An option of prctl: the signal that a process gets when its parent dies.
_PR_SET_PDEATHSIG = 1

#: Called on progress: with the finished shard, if any, and its error, if it failed; and with the rows and the
#: bad rows since the last call.
Report = Callable[[Shard | None, str | None, int, int], None]


@contextmanager
def output_folder(folder: Path, job: dict[str, Any]) -> Iterator[None]:
    """Lock the output folder for this process. It must be empty, or belong to the same job.

    Removes files that a killed process left unfinished.
    """
    folder.mkdir(parents=True, exist_ok=True)
    job = json.loads(json.dumps(job))
    with open(folder / ".lock", "w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise DataError(f"{folder}: another `chiasm map` is writing to it") from None
        file = folder / JOB
        try:
            began = json.loads(file.read_bytes())
        except FileNotFoundError:
            if others := sorted(p.name for p in folder.iterdir() if not p.name.startswith(".")):
                raise DataError(
                    f"{folder}: expected an empty folder, or one that `chiasm map` began; it has"
                    f" {others[0]!r}"
                ) from None
            scratch = folder / f".{JOB}.tmp"
            scratch.write_text(json.dumps(job, indent=1))
            scratch.rename(file)
            began = job
        except ValueError as error:
            raise DataError(f"{file}: damaged ({one_line(error)}): choose another folder") from error
        if began != job:
            differs = [k for k in job if not isinstance(began, dict) or began.get(k) != job[k]]
            raise DataError(
                f"{folder}: it was begun with another {' and another '.join(differs) or 'job'}: choose"
                " another folder, or remove this one"
            )
        _clean(folder)
        try:
            yield
        finally:
            _clean(folder)


def _clean(folder: Path) -> None:
    for left in folder.glob(".part-*.tmp"):
        left.unlink(missing_ok=True)


def fingerprint(mapping: Map, files: str, rows: int) -> dict[str, Any]:
    """Everything that determines the bytes of the shards."""
    from importlib.metadata import version

    import numpy as np

    from chiasm import __version__

    # Not as text: the image of which only the size is used may have a thousand million pixels
    constants = {
        name: [str(array.dtype), array.shape, hashlib.sha256(np.ascontiguousarray(array).data).hexdigest()]
        for name, array in mapping.constants.items()
    }
    options = hashlib.sha256(json.dumps([mapping.columns, constants], sort_keys=True).encode()).hexdigest()
    return {
        "bundle": mapping.parcel.sha256,
        "INPUT": files,
        "--column or --set": options,
        "--rows": rows,
        "version of chiasm, pyarrow or Pillow": [__version__, version("pyarrow"), version("pillow")],
    }


def in_processes(shards: list[Shard], mapping: Map, folder: Path, jobs: int, report: Report) -> None:
    """Write shards in `jobs` processes. A killed worker ends the run with a DataError; an interrupt or a
    signal to end ends the workers first."""
    _expect_a_killed_tracker()
    # Spawned, not forked: the threads of this process do not survive a fork
    context = multiprocessing.get_context("spawn")
    jobs = min(jobs, len(shards))
    # Rows and bad rows of each worker. No lock: a killed worker would hold it for ever
    counts = context.RawArray("q", 2 * jobs)
    seen = [0, 0]
    given = mapping, folder, counts
    pool = ProcessPoolExecutor(jobs, mp_context=context, initializer=_worker, initargs=(os.getpid(), given))
    try:
        # Until all workers have been given what they need. They get no interrupt: this process handles it for
        # them.
        with delayed():
            try:
                pending = {pool.submit(_write, shard): shard for shard in shards}
            except BrokenProcessPool:
                raise _killed() from None
        while pending:
            done, _ = wait(pending, 0.25, FIRST_COMPLETED)
            for future in done:
                report(pending.pop(future), _failure(future.result), 0, 0)
            now = [sum(counts[::2]), sum(counts[1::2])]
            report(None, None, now[0] - seen[0], now[1] - seen[1])
            seen = now
    except BaseException:
        workers = multiprocessing.active_children()
        for worker in workers:
            worker.kill()
        for worker in workers:
            worker.join()
        pool.shutdown(cancel_futures=True)
        raise
    pool.shutdown()


@cache
def _expect_a_killed_tracker() -> None:
    """Python removes its semaphores, and signs them off from the process that would remove them after a
    crash. If that one was killed, it starts another, which knows none of them and prints a traceback for
    each: sign off only from a tracker that is there."""
    from multiprocessing import resource_tracker

    sign_off, tracker = resource_tracker.unregister, resource_tracker._resource_tracker  # pyright: ignore
    is_alive = getattr(tracker, "_check_alive", lambda: True)

    def unregister(name: str, kind: str) -> None:
        if getattr(tracker, "_fd", None) is None or is_alive():  # None: there has been none
            sign_off(name, kind)

    resource_tracker.unregister = unregister  # pyright: ignore


def _failure(result: Callable[[], Any]) -> str | None:
    """The error of a shard, or None. An error that concerns all shards is raised."""
    try:
        result()
    except BrokenProcessPool:
        raise _killed() from None
    except Exception as error:  # one shard's failure, of whatever kind, does not stop the others
        return one_line(error) or type(error).__name__
    return None


def _killed() -> DataError:
    return DataError(
        "a worker was killed, perhaps because memory was short: finished shards are kept; the same"
        " command goes on from there (with fewer at once: --jobs 1)"
    )


def _worker(parent: int, given: tuple[Map, Path, Any]) -> None:
    """Set up a worker, which ends with its parent."""
    global _work
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)  # the parent died before that
    signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING)
    _work = given


_work: tuple[Map, Path, Any]


def _write(shard: Shard) -> None:
    mapping, folder, counts = _work
    # multiprocessing numbers workers in the order in which they start
    slot = 2 * (int(multiprocessing.current_process().name.rpartition("-")[2]) % (len(counts) // 2))

    def count(rows: int, bad: int) -> None:
        counts[slot] += rows
        counts[slot + 1] += bad

    write(shard, mapping, folder, count)


def on_ray(shards: list[Shard], mapping: Map, folder: Path, address: str, jobs: int, report: Report) -> None:
    """Write shards as tasks of a Ray cluster, one CPU each; "local" starts a cluster with `jobs` CPUs here.
    Input and output must be the same folders on every node. Ray runs the task of a killed worker again."""
    try:
        import ray
    except ImportError:
        raise DataError("Ray is not installed: pip install 'chiasm[ray]'") from None

    if found := re.fullmatch(r"(?:ray://)?\[?([^\[\]/]+)\]?:(\d{1,5})", address):
        try:  # Ray itself tries for minutes
            socket.create_connection((found[1], int(found[2])), timeout=5).close()
        except (OSError, OverflowError) as error:
            raise DataError(f"--ray: no cluster at {address!r}: {one_line(error)}") from None
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")  # no statistics from a cluster that starts here
    local = {"num_cpus": jobs, "include_dashboard": False} if address == "local" else {}
    try:
        ray.init(address, logging_level="ERROR", log_to_driver=False, **local)
    except (ConnectionError, RuntimeError, ValueError) as error:
        raise DataError(f"--ray: no cluster at {address!r}: {one_line(error, 200)}") from error
    running: dict[Any, Shard] = {}
    try:
        task = ray.remote(num_cpus=1, max_retries=5)(_write_on_ray)
        shared = ray.put(mapping)
        waiting = iter(shards)
        # Enough to keep every node busy: the cluster holds what is submitted, not this process
        most = 2 * max(1, int(ray.cluster_resources().get("CPU", 1)))
        while True:
            while len(running) < most and (shard := next(waiting, None)) is not None:
                running[task.remote(shard, shared, str(folder))] = shard
            if not running:
                return
            done, _ = ray.wait(list(running), timeout=0.5)
            for reference in done:
                shard = running.pop(reference)
                rows = bad = 0
                failure = None
                try:
                    rows, bad = ray.get(reference)
                except ray.exceptions.RayTaskError as error:
                    failure = one_line(error.cause)
                except ray.exceptions.RayError as error:
                    failure = f"{shard}: {one_line(error)}"
                report(shard, failure, rows, bad)
    finally:
        for reference in running:
            ray.cancel(reference, force=True)
        ray.shutdown()


def _write_on_ray(shard: Shard, mapping: Map, folder: str) -> tuple[int, int]:
    return write(shard, mapping, Path(folder), lambda rows, bad: None)
