"""make study WHAT=training: see studies/training/__init__.py. Writes its section of docs/use_cases.md."""

from __future__ import annotations

import sys
import time
import warnings

import torch
from rich.console import Console
from rich.progress import Progress

from studies.use_cases import publish

from .report import Found, apart, section
from .settings import Settings
from .train import train
from .ways import WAYS


def main() -> int:
    warnings.simplefilter("ignore")
    settings, start = Settings(), time.monotonic()
    torch.set_num_threads(settings.threads)
    found: Found = {name: [] for name in WAYS}
    with Progress(console=Console(stderr=True)) as progress:
        task = progress.add_task("training", total=len(WAYS) * len(settings.seeds))
        for seed in settings.seeds:
            for name, way in WAYS.items():
                found[name].append(train(way(settings), settings, seed))
                progress.console.print(f"seed {seed}, {name}: {found[name][-1]:.2%}")
                progress.advance(task)
    lines = section(settings, found, time.monotonic() - start)
    print("\n".join(lines))
    publish("training", lines)
    if different := apart(found, settings):
        print(
            f"training: further apart than {settings.limit:g} standard errors: {different}", file=sys.stderr
        )
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
