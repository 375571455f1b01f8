"""make study WHAT=attack: see studies/attack/__init__.py. Writes build/studies/attack,
docs/use_cases/attack*.png and its section of docs/use_cases.md."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
from PIL import Image
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from studies.use_cases import folder, publish

from .matching import bundle, by_program, by_python
from .optimise import State, attack, wanted
from .pictures import write
from .report import Look, section
from .settings import Settings


def main() -> None:
    settings, console, there = Settings(), Console(), folder("attack")
    started = time.monotonic()
    with console.status("exporting the matching: takes minutes unless it is cached"):
        made = bundle(settings, there, ("native", "onnx"))
    exported = time.monotonic()
    looks = run(settings, console)
    attacked = time.monotonic()
    files = {
        name: save(look.state.images, there, name)
        for name, look in (("original", looks[0]), ("attacked", looks[-1]))
    }
    said = {
        backend: {name: by_program(*pair, made, backend, settings) for name, pair in files.items()}
        for backend in ("native", "onnx")
    }
    seconds = {"exporting the bundle": exported - started, "the attack": attacked - exported}
    write(looks[0], looks[-1])
    lines = section(settings, looks, said, seconds)
    publish("attack", lines)
    print("\n".join(lines))


def run(settings: Settings, console: Console) -> list[Look]:
    """Run the attack; returns the matching's results before it, at intervals, and after it."""
    looks: list[Look] = []
    columns = TextColumn("{task.description:72}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    with Progress(*columns, console=console) as progress:
        task = progress.add_task("the attack", total=settings.steps)
        for state in attack(settings):
            if state.step % settings.look_every == 0 or state.step == settings.steps:
                looks.append(look(state, settings))
                progress.update(task, description=f"the attack: {looks[-1]}")
            progress.update(task, completed=state.step)
    return looks


def look(state: State, settings: Settings) -> Look:
    match = by_python(*state.images, settings)
    return Look(state, match, match.error(wanted(settings), state.images[0].shape))


def save(images: np.ndarray, there: Path, name: str) -> tuple[Path, Path]:
    """Save both images as PNG files, which are lossless."""
    paths = there / f"{name}1.png", there / f"{name}2.png"
    for path, image in zip(paths, images, strict=True):
        Image.fromarray(image).save(path)
    return paths


if __name__ == "__main__":
    main()
