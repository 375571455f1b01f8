"""The measurements for one number of threads, which a process can set only once.

    python -m bench.peers.measure THREADS SECONDS [OP...]    -> a line of JSON, in microseconds, for each op
    and size

Results are compared before they are timed: a line whose results differ has a problem, and no times. Then
chiasm's native backend, the peer and a copy of as many bytes take turns.
"""

from __future__ import annotations

import json
import sys
import warnings
from typing import Any

import cv2
import numpy as np
import torch

import chiasm.runtime
from chiasm.export import example_inputs
from chiasm.export.catalog import Entry, catalog
from chiasm.export.peer import Work, compared, work
from chiasm.export.spec import Spec, TensorSpec

from ..images.data import photograph
from ..machine import LIBC, bundle_path, keep_memory
from ..wheel import copy_of, interleaved, room

#: (batch, height, width), of three channels
IMAGES = ((8, 256, 256), (1, 1080, 1920))
#: the symbols of these sizes, which a peer does not change, and those of resized images and of chroma
EXTENT = ("H", "W", "OH", "OW", "UH", "UW")
#: boxes or masks of an image
OBJECTS = 100
#: for ops without images: the number of samples of one item, or of samples and of items in each, and the
#: dimensions of a descriptor
BATCH, SAMPLES, POINTS, DIMENSIONS = 1000, 8, 1000, 128
WORDS = "uint16"


class Mismatch(Exception):
    """Results that differ by more than the tolerance."""


def main(threads: int, seconds: float, names: list[str]) -> None:
    chiasm.runtime.set_num_threads(threads)
    cv2.setNumThreads(threads)
    torch.set_num_threads(threads)
    keep_memory()
    warnings.simplefilter("ignore")
    for entry in chosen(names):
        for variant in variants(entry.spec):
            for size in sizes(entry.spec):
                row: dict[str, Any] = {"bundle": entry.spec.name, "threads": threads, "dtype": variant}
                try:
                    row |= measured(entry, size, variant, threads, seconds)
                except Mismatch as error:
                    row["problem"] = str(error)
                print(json.dumps(row), flush=True)
                LIBC.malloc_trim(0)  # what an op has kept would add up to the machine's memory


def chosen(names: list[str], untimed: bool = False) -> list[Entry]:
    """The ops with a peer whose name contains one of `names`; all of them if `names` is empty. Peers with
    timed=False are left out, unless `untimed`."""
    return [
        e
        for name, e in catalog().items()
        if (peer := e.spec.peer) is not None
        and (peer.timed or untimed)
        and (not names or any(n in name for n in names))
    ]


def variants(spec: Spec) -> list[str | None]:
    """The types at which to measure: the first, and 16 bits."""
    return [v for i, v in enumerate(spec.variants()) if i == 0 or v == WORDS]


def sizes(spec: Spec) -> list[dict[str, int]]:
    """The values of the symbols at which to measure."""
    used = spec.used_symbols()
    if "H" in used and "W" in used:
        made = [
            {
                **{"B": b, "C": 3, "H": h, "W": w, "D": 8, "N": OBJECTS},
                **{"OH": h * 3 // 4, "OW": w * 3 // 4},  # resized
                **{"UH": h // 2, "UW": w // 2},  # chroma
            }
            for b, h, w in IMAGES
        ]
    else:
        made = [{"B": SAMPLES if "N" in used else BATCH, "C": 3, "N": POINTS, "D": DIMENSIONS}]
    own = {s: n for s, n in spec.peer.sizes.items() if s not in EXTENT} if spec.peer else {}
    return [example_inputs.fit(spec, sizes | own) for sizes in made]


def measured(entry: Entry, size: dict[str, int], variant: str | None, threads: int, seconds: float) -> dict:
    spec = entry.spec
    method = native_method(spec.name, variant)
    tensors = inputs(spec, size, variant)
    given = [t.numpy() for t in tensors]
    outputs = room(method, given)
    theirs = work(spec, tensors)
    method.run_into(given, outputs)
    difference = checked(spec, outputs, theirs)
    contenders = {
        "native": lambda: method.run_into(given, outputs),
        "peer": theirs.run,
        "copy": copy_of([*given, *outputs]),
    }
    times = interleaved(list(contenders.values()), seconds, threads=threads)
    shape = "x".join(str(size[s]) for s in ("B", "H", "W", "N") if s in size)
    return {
        "size": shape,
        "library": theirs.peer.library.partition(".")[0],
        "difference": difference,
        "race": dict(zip(contenders, times, strict=True)),
    }


def native_method(bundle: str, variant: str | None) -> chiasm.runtime.Method:
    opened = chiasm.runtime.open(bundle_path(bundle))
    return opened.method("forward", backend="native", **({"dtype": variant} if variant else {}))


def inputs(spec: Spec, size: dict[str, int], variant: str | None) -> list[torch.Tensor]:
    """Photographs, unless the spec makes its own images."""
    made = example_inputs.make(spec, size, variant)
    if spec.make_inputs is None:
        made |= {t.name: pictures(t, made[t.name]) for t in spec.inputs if t.layout in ("NCHW", "NHWC")}
    return list(made.values())


def pictures(tensor: TensorSpec, like: torch.Tensor) -> torch.Tensor:
    """Photographs in the shape, type and range of a tensor."""
    batch, *rest = like.shape
    height, width = rest[1:] if tensor.layout == "NCHW" else rest[:2]
    channels = rest[0] if tensor.layout == "NCHW" else rest[2]
    pixels = torch.from_numpy(photograph(batch, height, width))
    pixels = pixels[:, torch.arange(channels) % 3]
    low, high = tensor.range or (0.0, 1.0)
    values = (pixels.to(torch.float64) / 255 * (high - low) + low).to(like.dtype)
    return values if tensor.layout == "NCHW" else values.permute(0, 2, 3, 1).contiguous()


def checked(spec: Spec, ours: list[np.ndarray], theirs: Work) -> float:
    """The largest difference of the results; Mismatch if it exceeds the tolerance. Peers round 16 bits in
    their own way: they may be a level apart."""
    most = 0.0
    for a, e, described in zip(ours, theirs.outputs(ours), spec.outputs, strict=True):
        apart = compared(spec, a, e, described.layout)
        if apart.share > theirs.peer.share and not (a.dtype == WORDS and apart.most <= 1):
            shape = "x".join(map(str, a.shape))
            raise Mismatch(f"{spec.name}, {shape}: {apart.share:.1%} of the values are not the peer's")
        most = max(most, apart.most)
    return most


if __name__ == "__main__":
    main(int(sys.argv[1]), float(sys.argv[2]), sys.argv[3:])
