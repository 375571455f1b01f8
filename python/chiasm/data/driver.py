# pyarrow and Ray are optional, and not in .venv:
# pyright: reportMissingImports=false
"""Run all shards of an input, in processes of this machine or as tasks of a Ray cluster, and resume an
earlier run."""

from __future__ import annotations

import fcntl
import hashlib
import json
import multiprocessing
import os
import re
import signal
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import islice
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

from ..export.ending import ENDING, delayed, end_with
from ..export.files import naming, read_regular
from ..export.text import one_line
from ..writing import write_whole
from .errors import DataError
from .mapping import Map
from .shards import Shard, write

#: The job of an output folder, so that a restart with another job is rejected.
JOB = "_chiasm_map.json"
#: The most bytes of its file.
_MOST_OF_JOB = 1 << 20

#: Called on progress: with the finished shard, if any, and its error, if it failed; and with the rows and the
#: bad rows since the last call, less those of a shard that failed after all.
Report = Callable[[Shard | None, str | None, int, int], None]


@contextmanager
def output_folder(folder: Path, job: dict[str, Any]) -> Iterator[None]:
    """Lock the output folder for this process. It must be empty, or belong to the same job.

    Removes files that a killed process left unfinished.
    """
    folder.mkdir(parents=True, exist_ok=True)
    _expect_ours(folder)  # before anything is written: a folder that is not ours does not even get a lock
    job = json.loads(json.dumps(job))
    # Whatever else has this name, it is neither waited for, as a pipe, nor emptied, as what a link leads to
    with open(folder / ".lock", "a", opener=_no_other) as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise DataError(f"{folder}: another `chiasm map` is writing to it") from None
        file = folder / JOB
        try:
            began = json.loads(read_regular(file, _MOST_OF_JOB))
        except FileNotFoundError:
            _expect_ours(folder)
            with naming(folder):
                write_whole(file, json.dumps(job, indent=1).encode(), durable=True)
            began = job
        except (ValueError, RecursionError) as error:
            raise DataError(f"{file}: damaged ({one_line(error)}): choose another folder") from error
        if began != job:
            had = began if isinstance(began, dict) else {}
            differs = [
                f"{key} ({one_line(had.get(key), 200)}, now {value})" if isinstance(value, list) else key
                for key, value in job.items()
                if had.get(key) != value
            ]
            raise DataError(
                f"{folder}: it was begun with another {' and another '.join(differs) or 'job'}: choose"
                " another folder, or remove this one"
            )
        _clean(folder)
        try:
            yield
        finally:
            _clean(folder)


def _expect_ours(folder: Path) -> None:
    """Reject a folder that has files, of which none is a job's."""
    others = sorted(p.name for p in folder.iterdir() if not p.name.startswith("."))
    if others and JOB not in others:
        raise DataError(
            f"{folder}: expected an empty folder, or one that `chiasm map` began; it has {others[0]!r}"
        )


def _no_other(path: str, flags: int) -> int:
    return os.open(path, flags | os.O_NOFOLLOW | os.O_NONBLOCK, 0o666)


def _clean(folder: Path) -> None:
    for left in folder.glob(".part-*.tmp"):
        left.unlink(missing_ok=True)


def fingerprint(mapping: Map, files: str, rows: int) -> dict[str, Any]:
    """Everything that determines the bytes of the shards."""
    from importlib.metadata import version

    import numpy as np

    from chiasm import __version__

    from .decoding import decodes_by_turbo

    # Not as text: the image of which only the size is used may have a thousand million pixels
    constants = {
        name: [str(array.dtype), array.shape, hashlib.sha256(np.ascontiguousarray(array).data).hexdigest()]
        for name, array in mapping.constants.items()
    }
    options = hashlib.sha256(json.dumps([mapping.columns, constants], sort_keys=True).encode()).hexdigest()
    turbo = version("simplejpeg") if decodes_by_turbo() else None
    versions = [__version__, version("pyarrow"), version("pillow"), turbo]
    return {
        "bundle": mapping.parcel.sha256,
        "INPUT (by names, sizes and times of change)": files,
        "--column or --set": options,
        "--rows": rows,
        "artifact of the bundle (by CPU, backends and trust policy)": _chosen(mapping),
        "version of chiasm, pyarrow, Pillow or simplejpeg": versions,
    }


def _chosen(mapping: Map) -> list[str]:
    """The artifact that runs in this process, and the version of its engine."""
    import chiasm.runtime

    method = mapping.open().method
    engine = ""
    if method.backend != "native":  # to ask loads every engine
        engine = next(b.engine_version for b in chiasm.runtime.backends() if b.name == method.backend)
    return [method.backend, method.artifact, engine]


def in_processes(shards: list[Shard], mapping: Map, folder: Path, jobs: int, report: Report) -> None:
    """Write shards in `jobs` processes. A killed worker ends the run with a DataError; an interrupt or a
    signal to end ends the workers first."""
    # Spawned, not forked: the threads of this process do not survive a fork
    context = multiprocessing.get_context("spawn")
    waiting = iter(shards)
    workers: list[BaseProcess] = []
    running: dict[Any, Shard] = {}
    try:
        # Until all workers have been given what they need. They get no interrupt: this process handles it for
        # them.
        with delayed():
            for shard in islice(waiting, jobs):
                # A pipe for each worker, not a queue for all: a killed worker would hold the queue's lock for
                # ever, and Python prints a traceback for each lock if its resource tracker was killed
                connection, other_end = context.Pipe()
                with other_end:
                    worker = context.Process(target=_serve, args=(other_end, os.getpid(), folder))
                    _expect_alive(worker.start)
                workers.append(worker)
                running[connection] = shard
            # Not among the arguments above: a worker that got only a part of the bundle, because this process
            # was killed, would print a traceback
            for connection, shard in running.items():
                _expect_alive(connection.send, mapping)
                _expect_alive(connection.send, shard)
        while running:
            ready = wait(list(running))
            for connection in [c for c in running if c in ready]:
                finished, failure, rows, bad = _expect_alive(connection.recv)
                report(running[connection] if finished else None, failure, rows, bad)
                if not finished:
                    continue
                if (shard := next(waiting, None)) is None:
                    del running[connection]
                    connection.close()  # ends the worker
                else:
                    _expect_alive(connection.send, shard)
                    running[connection] = shard
    except BaseException:
        for worker in workers:
            worker.kill()
        raise
    finally:
        for worker in workers:
            worker.join()


def _expect_alive(call: Callable[..., Any], *arguments: Any) -> Any:
    """Communicate with a worker."""
    try:
        return call(*arguments)
    except (EOFError, ConnectionError):
        raise DataError(
            "a worker was killed, perhaps because memory was short (or CPU time, see `ulimit -t`): finished"
            " shards are kept; the same command goes on from there (with fewer at once: --jobs 1)"
        ) from None


def _serve(connection: Connection, parent: int, folder: Path) -> None:
    """Write the shards that come through a connection after their Map, until it is closed. A worker, which
    ends with its parent."""
    end_with(parent)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING)

    def count(rows: int, bad: int) -> None:
        nonlocal counted
        counted = (counted[0] + rows, counted[1] + bad)
        connection.send((False, None, rows, bad))

    mapping: Any = None
    while True:
        try:
            mapping = mapping or connection.recv()
            shard = connection.recv()
        except (EOFError, OSError):  # the second in the middle of a message
            return
        failure, counted = None, (0, 0)
        try:
            write(shard, mapping, folder, count)
        except Exception as error:  # one shard's failure, of whatever kind, does not stop the others
            failure = one_line(error) or type(error).__name__
        rows, bad = counted if failure else (0, 0)
        connection.send((True, failure, -rows, -bad))


def on_ray(shards: list[Shard], mapping: Map, folder: Path, address: str, jobs: int, report: Report) -> None:
    """Write shards as tasks of a Ray cluster, one CPU each; "local" starts a cluster with `jobs` CPUs here.
    Input and output must be the same folders on every node. Ray runs the task of a killed worker again."""
    try:
        import ray
    except ImportError:
        raise DataError("Ray is not installed: pip install 'chiasm[ray]'") from None

    # Ray itself tries for minutes, with any text that has a colon
    if address not in ("auto", "local"):
        found = re.fullmatch(r"(?:ray://)?\[?([^\[\]/]+)\]?:(\d{1,5})", address)
        if not found:
            raise DataError(f"--ray: expected auto, local or HOST:PORT, got {address!r}")
        try:
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
