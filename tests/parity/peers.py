"""Compares the ops whose results are whole numbers (bytes, 16 bits) with their peers, on photographs.

    python tests/parity/peers.py [PATTERN...]    -> build/peers.json: by how many levels the values of an op
                                                    differ at most, and the share of those that differ

The ops run in eager Python; the parity matrix compares every other way to run them with it.
"""

from __future__ import annotations

import json
import sys
import warnings
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import numpy as np
import torch
from rich.progress import track

from chiasm.export.catalog import Entry, catalog
from chiasm.export.job import run_eager
from chiasm.export.peer import compared, work
from chiasm.export.tracing.module import bind_spec

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from bench.peers.measure import inputs, sizes, variants  # noqa: E402

FOUND = ROOT / "build" / "peers.json"


def apart(entry: Entry) -> dict[str, Any] | None:
    """The largest difference, in levels, and the share of differing values, over all images, types and whole
    outputs; None if no output has whole numbers."""
    spec, most, differing, values = entry.spec, 0.0, 0.0, 0
    for variant in variants(spec):
        for size in sizes(spec):
            tensors = inputs(spec, size, variant)
            module = bind_spec(entry.function(), spec)
            ours = [
                o.numpy()
                for o in run_eager(module, dict(zip([t.name for t in spec.inputs], tensors, strict=True)))
            ]
            if not any(is_levels(o) for o in ours):
                return None
            theirs = work(spec, tensors).outputs(ours)
            for a, e, described in zip(ours, theirs, spec.outputs, strict=True):
                if is_levels(a):
                    found = compared(spec, a, e, described.layout)
                    most, values = max(most, found.most), values + a.size
                    differing += found.differing * a.size
    return {"most": most, "differing": differing / max(values, 1)}


def is_levels(output: np.ndarray) -> bool:
    return output.dtype.name in ("uint8", "int16", "uint16")


def main(patterns: list[str]) -> None:
    torch.set_grad_enabled(False)
    warnings.simplefilter("ignore")
    wanted = [
        entry
        for name, entry in catalog().items()
        if entry.spec.peer is not None and any(fnmatch(name, p) for p in patterns or ["*"])
    ]
    found = {entry.spec.name: apart(entry) for entry in track(wanted, "peers")}
    FOUND.write_text(json.dumps({name: row for name, row in found.items() if row is not None}, indent=1))
    print(f"wrote {FOUND.relative_to(ROOT)}")


if __name__ == "__main__":
    main(sys.argv[1:])
