"""The most memory that a batch adds to a process, on one thread: a contender's results and its intermediate
data.

python -m studies.batch.memory WORK NAME -> megabytes per image
"""

from __future__ import annotations

import ctypes
import gc
import sys
import warnings
from pathlib import Path

from studies.use_cases import folder

from .settings import Settings
from .ways import Images, Setup, photographs
from .works import WORKS


def megabytes(field: str) -> float:
    """A field of /proc/self/status, in megabytes."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(f"{field}:"):
            return int(line.split()[1]) / 1024
    raise RuntimeError(f"no {field} in /proc/self/status")


def measure(work: str, name: str, setup: Setup) -> float:
    """The peak over one call, without the prepared input images. One image is run first, so that one-time
    loading does not count."""
    way, batch = WORKS[work].ways[name], setup.settings.memory_batch
    way.make(Images(photographs(1, setup.settings.size)), setup).call()
    images = Images(photographs(batch, setup.settings.size))
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    Path("/proc/self/clear_refs").write_text("5")  # resets the peak
    before = megabytes("VmRSS")
    way.make(images, setup).call()
    return (megabytes("VmHWM") - before - images.bytes() / 2**20) / batch


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    print(measure(sys.argv[1], sys.argv[2], Setup(Settings(), folder("batch") / "bundles", 1)))
