"""make bench WHAT=augmentation: six steps from bytes to a network's input, compared with Kornia, torchvision,
Albumentations and DALI -> docs/benchmarks_augmentation.md."""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
from collections.abc import Sequence
from importlib.metadata import distributions, version
from typing import Any

import numpy as np
from rich.progress import track

import chiasm
from tools.columns import wrapped

from ..images.data import photograph
from ..machine import ROOT, cores
from .ours import FOLDER, write
from .page import PAGE, page
from .race import (
    ALBUMENTATIONS,
    APART,
    BYTES,
    COMPILED,
    DALI,
    EAGER,
    FLOAT,
    KORNIA,
    NATIVE,
    WHOLE,
    Process,
    looks,
    medians,
    started,
)
from .settings import SETTINGS, STEPS
from .worker import LOOK

CONTENDERS = (NATIVE, EAGER, COMPILED, KORNIA, BYTES, FLOAT, WHOLE, ALBUMENTATIONS, DALI)
#: contenders whose single steps are timed too
STEPPED = (NATIVE, ALBUMENTATIONS, DALI)
#: the number of batches that are compared; the most standard errors by which the means of their 147 parts may
#: differ; the largest ratio of their deviations
BATCHES, ERRORS, RATIO = 16, 6.0, 1.1
IMAGES = FOLDER / "images.npy"
RECORD = FOLDER / "found.json"


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m bench augmentation", description=__doc__)
    parser.add_argument("--seconds", type=float, default=60, help="that contenders take turns for")
    options = parser.parse_args()
    FOLDER.mkdir(parents=True, exist_ok=True)
    np.save(IMAGES, photograph(SETTINGS.batch, SETTINGS.side, SETTINGS.side))
    write([STEPS, *([step] for step in STEPS)])
    found: dict[str, Any] = {
        "names": [c.name for c in CONTENDERS],
        "load": os.getloadavg()[0],
        "versions": versions(),
        "batches": BATCHES,
        "side": LOOK,
        "errors": {},
        "times": {},
        "steps": {},
    }
    for threads in sorted({1, cores()}):
        with started(CONTENDERS, IMAGES, threads, STEPS) as processes:
            on = f"on {threads} thread{'s' * (threads != 1)}"
            found["errors"] |= {f"{p.contender.name} {on}": p.error for p in processes if p.error}
            check(processes)
            found["times"][str(threads)] = medians(processes, options.seconds)
            RECORD.write_text(json.dumps(found, indent=1))
    for step in track(STEPS, description="single steps"):
        with started(STEPPED, IMAGES, 1, [step]) as processes:
            found["steps"][step] = medians(processes, options.seconds / len(STEPS))
    RECORD.write_text(json.dumps(found, indent=1))
    text = page(found)
    PAGE.write_text(wrapped(text))
    print(text)
    return 0


def check(processes: Sequence[Process]) -> None:
    """Exit the process if the distribution of a contender's results differs from chiasm's."""
    found = looks([p for p in processes if p.contender is not WHOLE], BATCHES)
    ours = found[NATIVE.name]
    for name, theirs in found.items():
        picture = float(np.abs(np.subtract(theirs["picture"], ours["picture"])).max())
        errors = picture / math.sqrt(theirs["variance"] + ours["variance"])
        ratio = theirs["deviation"] / ours["deviation"]
        print(f"{name}: {errors:.1f} standard errors apart, {ratio:.2f} of the deviation", file=sys.stderr)
        if name != NATIVE.name and (errors > ERRORS or not 1 / RATIO < ratio < RATIO):
            sys.exit(f"{name}: its results are not distributed as chiasm's")


def versions() -> dict[str, str]:
    code = "from importlib.metadata import version as v; print(v('albumentations'), v('nvidia-dali-cuda120'))"
    theirs = subprocess.run([APART, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    albumentations, dali = theirs.split()
    [kornia] = distributions(name="kornia", path=[str(ROOT / ".deps" / "kornia")])
    return {
        "chiasm": chiasm.__version__,
        "PyTorch": version("torch").partition("+")[0],
        "Kornia": kornia.version,
        "torchvision": version("torchvision").partition("+")[0],
        "Albumentations": albumentations,
        "DALI": dali,
    }


if __name__ == "__main__":
    sys.exit(main())
