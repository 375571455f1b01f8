"""make bench WHAT=letterbox: from camera frames to a network's input, by chiasm and OpenCV's wheel in turns
-> docs/benchmarks_letterbox.md.

python -m bench.letterbox THREADS results for one number of threads, as JSON: a process can set it only once
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
from collections.abc import Callable
from datetime import date
from functools import partial
from typing import Any

import cv2
import numpy as np
from PIL import Image

import chiasm.runtime
from tools.columns import wrapped

from .machine import ROOT, bundle_path, cores, cpu, export_bundles, keep_memory
from .wheel import interleaved

PAGE = ROOT / "docs" / "benchmarks_letterbox.md"
BUNDLES = ("pipelines.letterbox", "pipelines.letterbox_nv12")


class Into:
    """Calls functions with the matrix that each of them returned at its last call, as its `dst`."""

    def __init__(self) -> None:
        self.kept: dict[Callable[..., np.ndarray], np.ndarray] = {}

    def __call__(self, function: Callable[..., np.ndarray], *arguments: Any, **options: Any) -> np.ndarray:
        self.kept[function] = function(*arguments, dst=self.kept.get(function), **options)
        return self.kept[function]


Resize = Callable[[Into, np.ndarray, tuple[int, int]], np.ndarray]
#: With other settings: what they give, and the same by OpenCV.
SETTINGS: dict[str, tuple[str, Callable[[Into, np.ndarray], np.ndarray]]] = {
    "pipelines.letterbox.stretch": ("BGR, stretched", lambda into, x: planes(linear(into, x, (SIDE, SIDE)))),
    "pipelines.letterbox.uint8_nhwc": (
        "BGR, to uint8 RGB",
        lambda into, x: into(cv2.cvtColor, bordered(into, x, linear), cv2.COLOR_BGR2RGB),
    ),
    "pipelines.letterbox.float16": ("BGR, to float16", lambda into, x: into(cast, blob(into, x), np.float16)),
    "pipelines.letterbox.antialias": (
        "BGR, antialiased (resized by Pillow)",
        lambda into, x: planes(bordered(into, x, antialiased)),
    ),
    "pipelines.letterbox.uint16": (
        "BGR of 16 bits",
        lambda into, x: planes(into(cast, bordered(into, x, linear), np.float32), 1 / 65535),
    ),
    "pipelines.pad_to_multiple": ("BGR, padded to 1088 x 1920", lambda into, x: planes(padded(into, x))),
    "pipelines.center_crop.antialias": (
        "BGR, ImageNet's recipe (resized by Pillow)",
        lambda into, x: normalized(planes(cropped(into, x))),
    ),
}
#: ImageNet's, red, green, blue
MEAN = np.array([0.485, 0.456, 0.406], np.float32)[:, None, None]
BY = (1 / np.array([0.229, 0.224, 0.225], np.float32))[:, None, None]
SIDE = 640
HD = (1080, 1920)
#: heights and widths of the frames in a batch of different sizes
MIXED = (
    (1080, 1920),
    (720, 1280),
    (480, 640),
    (1920, 1080),
    (600, 800),
    (768, 1024),
    (540, 960),
    (1200, 1600),
) * 2


def main() -> int:
    export_bundles((*BUNDLES, *SETTINGS), ("native",))
    rows = [row for threads in sorted({1, cores()}) for row in measured(threads)]
    PAGE.write_text(wrapped(page(rows)))
    print(f"wrote {PAGE.relative_to(ROOT)}")
    return 0


def measured(threads: int) -> list[dict]:
    command = [sys.executable, "-m", "bench.letterbox", str(threads)]
    return json.loads(subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=True).stdout)


def measure(threads: int) -> list[dict]:
    chiasm.runtime.set_num_threads(threads)
    cv2.setNumThreads(threads)
    keep_memory()
    random = np.random.default_rng(0)
    frame = random.integers(0, 256, (*HD, 3), dtype=np.uint8)
    luma, chroma = frame[..., :1].copy(), random.integers(0, 256, (HD[0] // 2, HD[1] // 2, 2), dtype=np.uint8)
    frames = [random.integers(0, 256, (*size, 3), dtype=np.uint8) for size in MIXED]
    bgr, nv12 = (chiasm.runtime.open(bundle_path(b)) for b in BUNDLES)

    def one(bundle: chiasm.runtime.Bundle, *inputs: np.ndarray) -> Callable[[], None]:
        method = bundle.method("forward")
        batches = [x[None] for x in inputs]
        outputs = tuple(np.empty_like(x) for x in method(*batches))
        return lambda: method.run_into(batches, outputs)

    def mixed() -> Callable[[], None]:
        method = bgr.method("forward", num_threads=1)
        image = np.empty((len(frames), 3, SIDE, SIDE), np.float32)
        back = np.empty((len(frames), 3, 3), np.float32)
        inputs = [x[None] for x in frames]
        outputs = [(image[i : i + 1], back[i : i + 1]) for i in range(len(frames))]
        return lambda: method.run_each(inputs, outputs)

    into = Into()

    def converted() -> np.ndarray:
        return blob(into, into(cv2.cvtColorTwoPlane, luma, chroma, cv2.COLOR_YUV2BGR_NV12))

    intos = [Into() for _ in frames]

    def blobs() -> np.ndarray:
        images = [bordered(kept, x, linear) for kept, x in zip(intos, frames, strict=True)]
        return cv2.dnn.blobFromImages(images, 1 / 255, swapRB=True)

    contenders = {
        "1080p, BGR": (
            one(bgr, frame),
            {"steps": lambda: blob(into, frame), "blob": lambda: padded_blob(frame)},
        ),
        "1080p, NV12": (one(nv12, luma, chroma), {"steps": converted}),
        "16 frames of 8 sizes, BGR": (mixed(), {"steps": blobs}),
    }
    for bundle, (what, steps) in SETTINGS.items():
        given = frame if "uint16" not in bundle else frame.astype(np.uint16) * 257
        ours = one(chiasm.runtime.open(bundle_path(bundle)), given)
        contenders[f"1080p, {what}"] = ours, {"steps": partial(steps, Into(), given)}
    rows = []
    for name, (ours, theirs) in contenders.items():
        times = interleaved([ours, *theirs.values()], threads=threads)
        rows.append(
            {"what": name, "threads": threads, "chiasm": times[0]} | dict(zip(theirs, times[1:], strict=True))
        )
    return rows


def linear(into: Into, image: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    return into(cv2.resize, image, size, interpolation=cv2.INTER_LINEAR)


def antialiased(_: Into, image: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    return np.asarray(Image.fromarray(image).resize(size, Image.Resampling.BILINEAR))


def cast(image: np.ndarray, dtype: type, dst: np.ndarray | None = None) -> np.ndarray:
    result = np.empty(image.shape, dtype) if dst is None else dst
    np.copyto(result, image, casting="same_kind")
    return result


def normalized(image: np.ndarray) -> np.ndarray:
    image -= MEAN
    image *= BY
    return image


def bordered(into: Into, frame: np.ndarray, resize: Resize) -> np.ndarray:
    """The method of YOLO's authors: resize, copyMakeBorder."""
    height, width = frame.shape[:2]
    ratio = min(SIDE / height, SIDE / width)
    size = round(width * ratio), round(height * ratio)
    left, top = (SIDE - size[0]) // 2, (SIDE - size[1]) // 2
    edges = top, SIDE - size[1] - top, left, SIDE - size[0] - left
    grey = (114 if frame.dtype == np.uint8 else 114 * 257,) * 3
    return into(cv2.copyMakeBorder, resize(into, frame, size), *edges, cv2.BORDER_CONSTANT, value=grey)


def padded(into: Into, frame: np.ndarray) -> np.ndarray:
    below, beside = -frame.shape[0] % 32, -frame.shape[1] % 32
    edges = below // 2, below - below // 2, beside // 2, beside - beside // 2
    return into(cv2.copyMakeBorder, frame, *edges, cv2.BORDER_CONSTANT, value=(114,) * 3)


def cropped(into: Into, frame: np.ndarray) -> np.ndarray:
    """torchvision's Resize and CenterCrop, of 256 and 224 pixels, of frames wider than high."""
    width = 256 * frame.shape[1] // frame.shape[0]
    left = round((width - 224) / 2)
    return antialiased(into, frame, (width, 256))[16:240, left : left + 224]


def planes(image: np.ndarray, by: float = 1 / 255) -> np.ndarray:
    """OpenCV's own conversion to planes of floats."""
    return cv2.dnn.blobFromImage(image, by, swapRB=True)


def blob(into: Into, frame: np.ndarray) -> np.ndarray:
    return planes(bordered(into, frame, linear))


def padded_blob(frame: np.ndarray) -> np.ndarray:
    given = cv2.dnn.Image2BlobParams()
    given.scalefactor = (1 / 255,) * 4
    given.size = (SIDE, SIDE)
    given.swapRB = True
    given.paddingmode = cv2.dnn.DNN_PMODE_LETTERBOX
    given.borderValue = (114, 114, 114, 114)
    return cv2.dnn.blobFromImageWithParams(frame, given)


def page(rows: list[dict]) -> str:
    lines = [
        "# Benchmark of letterboxes",
        "",
        f"Made by `make bench WHAT=letterbox` on {date.today()}: {cpu()}, {cores()} cores, shared with",
        f"other work. Frames of bytes become planes of {SIDE} x {SIDE} float32, or what the row says, in",
        f"Python; chiasm and the wheel of OpenCV {cv2.__version__} (with IPP) take turns in one process, on",
        "several threads each after a pause and calls that do not count; medians in milliseconds. chiasm",
        "writes into the caller's buffers. OpenCV's and NumPy's functions get their last result as the place",
        "of the next; `blobFromImage` and Pillow take none, and malloc reuses the memory of theirs.",
        "*Steps* are `cvtColor` if needed, `resize`, `copyMakeBorder`, `blobFromImage`; *blob* is",
        "`blobFromImageWithParams`. *Times as fast* is the time of the faster of these over chiasm's.",
        "Frames of different sizes are one call of `run_each` with chiasm; with OpenCV they are a loop of",
        "`resize` and `copyMakeBorder`, and one `blobFromImages`.",
        "",
        "| frames | threads | chiasm | OpenCV, steps | OpenCV, blob | times as fast |",
        "|---|---|---|---|---|---|",
    ]
    ratios = []
    for row in rows:
        theirs = [row[way] for way in ("steps", "blob") if way in row]
        ratios.append(min(theirs) / row["chiasm"])
        blob_time = f"{row['blob'] / 1e3:.2f}" if "blob" in row else ""
        lines.append(
            f"| {row['what']} | {row['threads']} | {row['chiasm'] / 1e3:.2f} | {row['steps'] / 1e3:.2f}"
            f" | {blob_time} | {ratios[-1]:.2f} |"
        )
    lines += ["", f"Geometric mean: {statistics.geometric_mean(ratios):.2f}.", ""]
    return "\n".join(lines)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(json.dumps(measure(int(sys.argv[1]))))
    else:
        sys.exit(main())
