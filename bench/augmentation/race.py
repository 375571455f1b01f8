"""The contenders, each in its own process, take turns: one runs while the others wait for a line of input."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..machine import ROOT

#: the Python of the project's environment, and of the environment of tools/augmentation.in
OURS, APART = ".venv/bin/python", ".deps/augmentation/bin/python"


#: calls of at least so many seconds have one call per turn
LONG = 0.3


@dataclass(frozen=True)
class Contender:
    name: str
    #: the module in this package that has the function that makes the contender's call
    module: str
    function: str
    python: str = OURS


NATIVE = Contender("chiasm, native", "ours", "native")
EAGER = Contender("chiasm, eager", "ours", "eager")
COMPILED = Contender("Kornia, compiled", "peers_torch", "kornia_compiled")
KORNIA = Contender("Kornia, eager", "peers_torch", "kornia_eager")
BYTES = Contender("torchvision v2, uint8", "peers_torch", "torchvision_bytes")
FLOAT = Contender("torchvision v2, float", "peers_torch", "torchvision_float")
WHOLE = Contender("torchvision v2, uint8, one draw a batch", "peers_torch", "torchvision_batch")
ALBUMENTATIONS = Contender("Albumentations", "peers_other", "albumentations", APART)
DALI = Contender("DALI, CPU", "peers_other", "dali", APART)


class Process:
    """A contender that waits for its turns."""

    def __init__(self, contender: Contender, images: Path, threads: int, steps: Sequence[str]) -> None:
        self.contender = contender
        command = [contender.python, "-m", "bench.augmentation.worker", contender.module, contender.function]
        environment = os.environ | {
            "PYTHONPATH": str(ROOT / "python") if contender.python == OURS else "",
            "OMP_NUM_THREADS": str(threads),
            "NO_ALBUMENTATIONS_UPDATE": "1",  # otherwise it asks a server for its newest version
        }
        self.process = subprocess.Popen(
            [*command, str(images), str(threads), *steps],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=ROOT,
            env=environment,
        )
        self.error: str | None = None

    def wait(self) -> None:
        """Wait until it is ready or has failed."""
        self.error = self._answer().get("error")

    def ask(self, line: str) -> Any:
        assert self.process.stdin is not None
        print(line, file=self.process.stdin, flush=True)
        return self._answer()

    def _answer(self) -> Any:
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        if not line:
            raise RuntimeError(f"{self.contender.name}: its process ended")
        return json.loads(line)

    def end(self) -> None:
        assert self.process.stdin is not None
        self.process.stdin.close()
        self.process.wait()


@contextmanager
def started(
    contenders: Sequence[Contender], images: Path, threads: int, steps: Sequence[str]
) -> Iterator[list[Process]]:
    with ExitStack() as stack:
        processes = []
        for contender in contenders:
            processes.append(Process(contender, images, threads, steps))
            stack.callback(processes[-1].end)
        for process in processes:
            process.wait()
        yield processes


def medians(processes: Sequence[Process], seconds: float, least: int = 5) -> dict[str, list[float]]:
    """By name, milliseconds per call, and milliseconds of CPU time: medians. Each turn has one call that does
    not count, then two calls, or one if calls are long."""
    taken: dict[str, list[list[float]]] = {p.contender.name: [] for p in processes if not p.error}
    start, rounds = time.monotonic(), 0
    while time.monotonic() - start < seconds or rounds < least:
        for process in processes:
            if not process.error:
                times = taken[process.contender.name]
                times += process.ask("1" if times and times[-1][0] > LONG else "2")
        rounds += 1
    return {
        name: [1e3 * statistics.median(values) for values in zip(*times, strict=True)]
        for name, times in taken.items()
    }


def looks(processes: Sequence[Process], count: int) -> dict[str, dict[str, Any]]:
    """The statistics of ``count`` batches of each contender."""
    return {p.contender.name: p.ask(f"look {count}") for p in processes if not p.error}
