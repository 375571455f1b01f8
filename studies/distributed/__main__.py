"""make study WHAT=distributed: see studies/distributed/__init__.py. Writes build/studies/distributed,
docs/use_cases/distributed.png and its section of docs/use_cases.md."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

import torch
from rich.progress import Progress

from chiasm.geometry.registration import Homography
from gallery.cases import ROOT
from studies.use_cases import folder, publish

from .report import check, picture, section
from .settings import Settings
from .work import batch, learn, pipeline


def main() -> None:
    settings, there = Settings(), folder("distributed")
    torch.set_num_threads(1)  # like each of the processes
    together, single = by_processes(settings, there), alone(settings)
    check(settings, together, single)
    picture(settings, together)
    lines = section(settings, together, single)
    publish("distributed", lines)
    print("\n".join(lines))


def by_processes(settings: Settings, there: Path) -> list[dict[str, Any]]:
    """The results of each process of torchrun, see ``worker.work``."""
    (there / "settings.json").write_text(json.dumps(asdict(settings)))
    command = [
        sys.executable,
        "-m",
        "torch.distributed.run",
        "--standalone",
        f"--nproc-per-node={settings.processes}",
        "-m",
        "studies.distributed.worker",
        there,
    ]
    subprocess.run(command, check=True, cwd=ROOT, env=os.environ | {"OMP_NUM_THREADS": "1"})
    return torch.load(there / "result.pt")


def alone(settings: Settings) -> dict[str, Any]:
    """The same work in this process, without torch.distributed."""
    photographs, op, model = batch(settings), pipeline(), Homography().double()
    started = time.monotonic()
    with torch.no_grad():
        edges = op(photographs)
    piped = time.monotonic()
    with Progress() as progress:
        task = progress.add_task("learning by one process", total=settings.levels * settings.steps)
        learn(model, photographs.double(), 1.0, settings, lambda: progress.advance(task))
    return {
        "edges": edges,
        "homography": model().detach(),
        "pipeline_seconds": piped - started,
        "learning_seconds": time.monotonic() - piped,
    }


if __name__ == "__main__":
    main()
