"""make study WHAT=registration: registration of photographs by gradient descent, with each step as one
exported function -> docs/use_cases.md."""

from __future__ import annotations

import time
import warnings

import cv2
import torch
from rich.console import Console
from rich.progress import track

from chiasm import runtime
from studies.use_cases import PICTURES, folder, publish

from .bundles import export_all
from .descent import Engine
from .figure import figure
from .pairs import pairs
from .report import difference, page
from .settings import Settings
from .trials import runs, trial

NAME = "registration"
ENGINES = 6


def main() -> None:
    settings, start = Settings(), time.perf_counter()
    warnings.simplefilter("ignore")
    torch.set_num_threads(settings.threads)
    cv2.setNumThreads(settings.threads)
    runtime.set_num_threads(settings.threads)
    console = Console(stderr=True)
    with console.status("exporting the bundles") as status:
        bundles = export_all(
            settings,
            folder(NAME) / "bundles",
            ("onnx", "native"),
            lambda step: status.update(f"exporting {step}"),
        )
    engine = Engine.bundles(bundles, "native")
    trials = [
        trial(pair, engine, settings) for pair in track(pairs(settings), "registering pairs", console=console)
    ]
    shown = trials[settings.shown]
    figure(shown.pair, shown.levels, settings, PICTURES / f"{NAME}.png")
    found = list(
        track(runs(shown.pair, settings, bundles), "one pair by every engine", ENGINES, console=console)
    )
    lines = page(settings, trials, found, time.perf_counter() - start, cv2.__version__)
    print("\n".join(lines))
    publish(NAME, lines)
    apart = max(difference(run, found) for run in found)
    if apart > settings.tolerance:
        raise SystemExit(f"{NAME}: homographies differ by {apart:.1e}, more than {settings.tolerance:g}")


if __name__ == "__main__":
    main()
