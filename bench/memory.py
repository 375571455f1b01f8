"""make bench WHAT=memory: what ops need beside inputs and outputs -> docs/benchmarks_memory.md.

The ops are all that have a peer, on an image of 1080p or as many objects. Each op's first run is in a process
of its own, in which the largest resident set is compared with that before the run.
"""

from __future__ import annotations

import ctypes
import json
import os
import sys
import traceback
from datetime import date

import numpy as np
import torch
from rich.progress import track

import chiasm.runtime
from chiasm.export.catalog import Entry
from tools.columns import wrapped

from .machine import ROOT, cores, export_bundles, notes
from .peers.measure import chosen, inputs, native_method, sizes
from .wheel import room

PAGE = ROOT / "docs" / "benchmarks_memory.md"
#: the aim, in times the outputs, for ops that add at least so many bytes
MOST, LEAST_BYTES = 2.0, 1 << 20
HEAD = """# Memory

Made by `make bench WHAT=memory` on {date}: {cores} cores. chiasm {version}'s native backend runs each op that
another library has too ([benchmarks_peers.md](benchmarks_peers.md)) for the first time, into buffers of the
caller, on one image of 1920 x 1080 with three channels where the op takes images. *Added* is by how much the
process's largest resident set then exceeds that before the run: buffers between loops, stacks of threads,
pages of code.

The aim is at most {most:g} times the outputs, for ops that add more than a megabyte: {over} of {count} ops
miss it.

| op | inputs MB | outputs MB | added MB | times the outputs |
|---|---|---|---|---|
"""


def main() -> int:
    entries = chosen(sys.argv[1:], untimed=True)
    export_bundles((e.spec.name for e in entries), formats=("native",))
    torch.set_num_threads(1)  # no threads that a forked process would lack
    rows = [(e.spec.name, *measured(e)) for e in track(entries, "memory")]
    rows.sort(key=lambda row: (is_over(row), row[3]), reverse=True)
    text = page(rows)
    if not sys.argv[1:]:
        PAGE.write_text(wrapped(text))
    print(text)
    return 0


def measured(entry: Entry) -> tuple[int, int, int]:
    """The bytes of inputs and outputs, and those that a run adds."""
    spec, variant = entry.spec, entry.spec.variants()[0]
    given = [t.numpy() for t in inputs(spec, sizes(spec)[-1], variant)]
    reader, writer = os.pipe()
    if (child := os.fork()) == 0:
        status = 1
        try:
            os.write(writer, json.dumps(first_run(spec.name, variant, given)).encode())
            status = 0
        except Exception:
            traceback.print_exc()
        finally:
            os._exit(status)
    os.close(writer)
    with os.fdopen(reader, "rb") as pipe:
        said = pipe.read()
    if os.waitpid(child, 0)[1]:
        sys.exit(f"{spec.name}: could not be measured")
    outputs, added = json.loads(said)
    return sum(x.nbytes for x in given), outputs, added


def first_run(bundle: str, variant: str | None, given: list[np.ndarray]) -> tuple[int, int]:
    """The bytes of the outputs, and of what the run adds to this process."""
    chiasm.runtime.set_num_threads(cores())
    method = native_method(bundle, variant)
    outputs = room(method, given)
    for output in outputs:
        output[...] = 0  # so that its pages are there
    ctypes.CDLL(None).malloc_trim(0)
    with open("/proc/self/clear_refs", "w") as file:
        file.write("5")  # the largest resident set is that of now
    before = resident("VmRSS")
    method.run_into(given, outputs)
    return sum(output.nbytes for output in outputs), max(0, resident("VmHWM") - before)


def resident(name: str) -> int:
    with open("/proc/self/status") as file:
        line = next(line for line in file if line.startswith(name))
    return int(line.split()[1]) * 1024


def is_over(row: tuple[str, int, int, int]) -> bool:
    _, _, outputs, added = row
    return added >= LEAST_BYTES and added > MOST * outputs


def page(rows: list[tuple[str, int, int, int]]) -> str:
    text = HEAD.format(
        date=date.today(),
        cores=cores(),
        version=chiasm.__version__,
        most=MOST,
        over=sum(map(is_over, rows)) or "none",
        count=len(rows),
    )
    for name, given, outputs, added in rows:
        times = f"{added / outputs:.2f}" if added >= LEAST_BYTES else ""
        if is_over((name, given, outputs, added)):
            times = f"**{times}**"
        text += f"| {name} | {given / 1e6:.1f} | {outputs / 1e6:.1f} | {added / 1e6:.2f} | {times} |\n"
    return text + notes(PAGE)


if __name__ == "__main__":
    raise SystemExit(main())
