"""One race in Python with one number of threads, which a process can set only once.

python -m studies.batch.measure WORK THREADS -> lines of JSON: the agreement of the results, then the times at
each batch size
"""

from __future__ import annotations

import json
import os
import sys
import warnings
from collections.abc import Collection, Iterator

import numpy as np

from bench.images.ops import Agreement
from studies.use_cases import folder

from .race import race
from .settings import Settings
from .ways import Images, Setup, photographs
from .works import WORKS, batches

#: the number of images in the batch whose results are compared
COMPARED = 3


class Disagreement(RuntimeError):
    """Raised if a contender's results differ from the expected ones by more than its limits."""


def agreement(limits: Agreement, made: np.ndarray, expected: np.ndarray) -> dict:
    """The mean and the greatest difference; raises Disagreement if they exceed the limits."""
    if made.shape != expected.shape:
        raise Disagreement(f"shape {made.shape}, expected {expected.shape}")
    inside = (..., *(slice(limits.edge, -limits.edge or None),) * 2)
    difference = np.abs(made[inside].astype(np.float64) - expected[inside])
    share = float(np.mean(difference <= limits.tolerance))
    if share < limits.share:
        raise Disagreement(
            f"{share:.2%} of the values within {limits.tolerance:g}, expected {limits.share:.2%}; at most"
            f" {difference.max():.3g}"
        )
    return {"mean": float(difference.mean()), "most": float(difference.max()), "note": limits.note}


def reference(work: str, setup: Setup) -> np.ndarray:
    """The result of chiasm's eager function for the compared images."""
    eager = next(iter(WORKS[work].ways.values())).make(
        Images(photographs(COMPARED, setup.settings.size)), setup
    )
    return eager.planes(eager.call())


def check(work: str, setup: Setup, names: Collection[str]) -> dict[str, dict]:
    """Compare every contender's results with chiasm's eager ones; Disagreement names the first that exceeds
    its limits."""
    images, expected = Images(photographs(COMPARED, setup.settings.size)), reference(work, setup)
    ways, found = WORKS[work].ways, {}
    for name in names:
        ready = ways[name].make(images, setup)
        try:
            found[name] = agreement(ways[name].agrees, ready.planes(ready.call()), expected)
        except Disagreement as error:
            raise Disagreement(f"{work}, {name}: {error}") from error
    return found


def measure(work: str, setup: Setup, names: Collection[str]) -> Iterator[dict]:
    """A row on the agreement of results, then a row of times for each batch size."""
    settings = setup.settings
    yield {"work": work, "threads": setup.threads, "agreement": check(work, setup, names)}
    for batch in batches(work, settings):
        images = Images(photographs(batch, settings.size))
        calls = {name: WORKS[work].ways[name].make(images, setup).call for name in names}
        times = race(calls, settings.repeats, settings.seconds, settings.turns, pause=setup.threads > 1)
        yield {
            "work": work,
            "threads": setup.threads,
            "batch": batch,
            "times": {name: t._asdict() for name, t in times.items()},
        }


def environment(threads: int) -> dict[str, str]:
    """The environment variables of a measuring process: the number of threads, and the cache folder of
    torch.compile."""
    count = str(threads)
    return os.environ | {
        "OMP_NUM_THREADS": count,
        "RAYON_NUM_THREADS": count,
        "TORCHINDUCTOR_CACHE_DIR": str(folder("batch") / "torch.compile"),
    }


def main(work: str, threads: int) -> None:
    warnings.simplefilter("ignore")
    setup = Setup(Settings(), folder("batch") / "bundles", threads)
    for row in measure(work, setup, list(WORKS[work].ways)):
        print(json.dumps(row), flush=True)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
