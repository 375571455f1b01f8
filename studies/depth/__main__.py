"""make study WHAT=depth: depth from calibrated views by gradient descent -> docs/use_cases.md and its
pictures."""

from __future__ import annotations

import time
import warnings

import torch
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from chiasm import runtime

from ..use_cases import PICTURES, folder, publish
from .bundles import export_all
from .descent import Level, eager, loaded
from .pictures import figure
from .report import section
from .runs import Judged, in_cpp, in_python, judge
from .scenes import Scene, motorcycle, room, save
from .settings import Settings

NAME = "depth"


def main() -> None:
    warnings.simplefilter("ignore")
    torch.set_num_threads(1)
    runtime.set_num_threads(1)
    settings, start = Settings(), time.perf_counter()
    columns = TextColumn("{task.description:44}"), BarColumn(), TimeElapsedColumn(), TimeRemainingColumn()
    with Progress(*columns) as progress:
        exporting = progress.add_task("exporting", total=None)
        export_all(
            settings,
            folder(NAME) / "bundles",
            ("onnx", "native"),
            lambda what: progress.update(exporting, description=f"exporting {what}"),
        )
        progress.update(exporting, total=1, completed=1, description="exported the bundles")
        begun = time.perf_counter()
        results = [run(scene, settings, progress) for scene in (room(settings), motorcycle(settings))]
    PICTURES.mkdir(parents=True, exist_ok=True)
    for scene, levels, _ in results:
        # 256 colours are enough, and a third of the bytes.
        figure(scene, levels).quantize(256).save(PICTURES / f"{NAME}_{scene.name}.png", optimize=True)
    lines = section(settings, results, begun - start, time.perf_counter() - begun)
    publish(NAME, lines)
    Console().print("\n".join(lines), markup=False, highlight=False, soft_wrap=True)


def run(scene: Scene, settings: Settings, progress: Progress) -> tuple[Scene, list[Level], list[Judged]]:
    """Run a scene with every engine, eager Python first; also returns native Python's results at every
    scale."""
    bundles, work = folder(NAME) / "bundles", folder(NAME) / scene.name
    save(scene, settings, work)
    height, width = scene.depth.shape
    pixels = settings.iterations * sum((height >> i) * (width >> i) for i in range(settings.scales))
    runs = []
    for engine, functions in (
        ("Python, eager", eager(settings)),
        ("Python, native code", loaded(bundles, "native")),
    ):
        task = progress.add_task(f"{scene.name}: {engine}", total=pixels)
        made, levels = in_python(
            engine, scene, settings, functions, lambda n, task=task: progress.advance(task, n)
        )
        runs.append(made)
    for backend in ("native", "onnx"):
        task = progress.add_task(f"{scene.name}: C++, {backend}", total=None)
        runs.append(in_cpp(backend, scene, bundles, work))
        progress.update(task, total=1, completed=1)
    return scene, levels, judge(runs, scene)


if __name__ == "__main__":
    main()
