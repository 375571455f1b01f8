"""make study WHAT=batch: Sobel edges and three pipelines on batches of 1 to 256 photographs, compared with
other libraries -> docs/use_cases.md."""

from __future__ import annotations

import json
import subprocess
import sys
import time
import warnings
from collections.abc import Iterator
from importlib.metadata import distributions, version

from rich.console import Console
from rich.markdown import Markdown
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

import chiasm
from bench.machine import ROOT, cores
from studies.use_cases import PICTURES, folder, publish

from . import in_cpp
from .measure import environment
from .page import Measured, section, threads_text
from .pictures import sheet
from .plot import beside, log_log
from .settings import Settings
from .ways import Setup
from .works import WORKS, batches, export_bundle

#: works whose memory is measured: those on batches
WITH_MEMORY = ("sobel", "prepare")
#: the number of languages, each of which gives rows of a race
LANGUAGES = 2


def main() -> int:
    warnings.simplefilter("ignore")
    start, settings = time.monotonic(), Settings()
    setup = Setup(settings, folder("batch") / "bundles", 1)
    threads, measured = sorted({1, cores()}), Measured()
    columns = TextColumn("{task.description:44}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    with Progress(*columns, console=Console(stderr=True)) as progress:
        for work in progress.track(WORKS, description="exporting bundles"):
            export_bundle(work, settings, setup.bundles)
        settings_file = in_cpp.write_settings(setup, folder("batch"))
        for work in progress.track(WORKS, description="comparing results from C++"):
            found, opencv = in_cpp.check(work, setup, settings_file)
            measured.add({"work": work, "agreement": found})
        for count in threads:
            for work in WORKS:
                total = LANGUAGES * len(batches(work, settings))
                task = progress.add_task(f"{work} on {threads_text(count)}", total=total)
                for row in (*in_python(work, count), *in_cpp.race(work, count, settings_file)):
                    measured.add(row)
                    progress.advance(task, advance="times" in row)
        for work in WITH_MEMORY:
            measured.memory[work] = in_cpp.memory(work, settings_file)
            for name in progress.track(WORKS[work].ways, description=f"memory of {work}"):
                measured.memory[work][name] = memory(work, name)
    (folder("batch") / "measured.json").write_text(
        json.dumps([{"work": w, "threads": n, "times": t} for (w, n), t in measured.times.items()], indent=1)
    )
    PICTURES.mkdir(parents=True, exist_ok=True)
    sheet(setup).save(PICTURES / "batch.png", optimize=True)
    for work in WORKS:
        beside([chart(measured, work, count) for count in threads]).save(
            PICTURES / f"batch_{work}.png", optimize=True
        )
    lines = section(measured, settings, threads, versions(opencv), (time.monotonic() - start) / 60)
    publish("batch", lines)
    Console(width=None if sys.stdout.isatty() else 170).print(Markdown("\n".join(lines)))
    return 0


def in_python(work: str, threads: int) -> Iterator[dict]:
    """The rows of a race, measured in a separate process."""
    command = [sys.executable, "-m", "studies.batch.measure", work, str(threads)]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, text=True, cwd=ROOT, env=environment(threads)
    ) as process:
        for line in process.stdout:
            yield json.loads(line)
    if process.returncode:
        raise RuntimeError(f"{' '.join(command[1:])} failed")


def memory(work: str, name: str) -> float:
    command = [sys.executable, "-m", "studies.batch.memory", work, name]
    return float(
        subprocess.run(
            command, capture_output=True, text=True, check=True, cwd=ROOT, env=environment(1)
        ).stdout
    )


def chart(measured: Measured, work: str, threads: int):
    """Write a chart of milliseconds per image by batch size."""
    lines = {
        name: [(size, ms / size) for size, (ms, _) in sorted(times.items())]
        for name, times in measured.times[work, threads].items()
    }
    native = [name for name in lines if name.startswith("chiasm native")]
    return log_log(
        lines,
        native,
        f"{WORKS[work].title}, {threads_text(threads)}",
        ("images in a batch", "ms an image"),
        (600, 420),
    )


def versions(opencv: str) -> dict[str, str]:
    """The versions of the contenders; `opencv` is that of C++."""
    kornia = {
        d.name.replace("_", "-"): d.version for d in distributions(path=[str(ROOT / ".deps" / "kornia")])
    }
    names = {
        "OpenCV": "opencv-python-headless",
        "Pillow": "pillow",
        "scikit-image": "scikit-image",
        "SciPy": "scipy",
        "PyTorch": "torch",
        "ONNX Runtime": "onnxruntime",
    }
    found = {"chiasm": chiasm.__version__} | {name: version(package) for name, package in names.items()}
    return found | {"OpenCV in C++": opencv, "Kornia": kornia["kornia"], "kornia-rs": kornia["kornia-rs"]}


if __name__ == "__main__":
    raise SystemExit(main())
