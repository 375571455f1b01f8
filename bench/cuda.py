# Kornia is installed only where this is measured.
# pyright: reportMissingImports=false, reportAttributeAccessIssue=false
"""make bench WHAT=cuda: native code for GPUs, Kornia (eager and compiled) and torchvision, in turns on one
GPU -> docs/benchmarks_cuda.md.

python -m bench.cuda BUNDLES RESULT.json     measure bundles that were exported elsewhere
python -m bench.cuda RESULT.json             write the page
"""

from __future__ import annotations

import json
import statistics
import sys
import time
from collections.abc import Callable
from datetime import date
from functools import partial
from pathlib import Path

import torch

import chiasm.runtime
from tools.columns import wrapped

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "benchmarks_cuda.md"
BATCH, HEIGHT, WIDTH = 8, 1080, 1920
#: Ops whose loops read from the GPU whether to end, which a CUDA graph cannot capture.
WAITING = ("filters.canny",)
Call = Callable[[], object]


def image() -> torch.Tensor:
    return torch.rand(BATCH, 3, HEIGHT, WIDTH, device="cuda")


def frames() -> torch.Tensor:
    return torch.randint(0, 256, (BATCH, HEIGHT, WIDTH, 3), dtype=torch.uint8, device="cuda")


def sigma() -> torch.Tensor:
    return torch.full((BATCH, 2), 1.5, device="cuda")


def homography() -> torch.Tensor:
    m = torch.tensor([[0.98, 0.05, 12.0], [-0.04, 1.01, -7.0], [1e-5, -2e-5, 1.0]], device="cuda")
    return m.expand(BATCH, 3, 3).contiguous()


def like(height: int, width: int) -> torch.Tensor:
    return torch.empty(height, width, dtype=torch.uint8, device="cuda")


def letterboxed(frame: torch.Tensor) -> torch.Tensor:
    """The same letterbox as chiasm's bundle, written with torchvision."""
    import torchvision.transforms.v2.functional as tv

    x = tv.resize(frame.permute(0, 3, 1, 2), [360, 640], antialias=False)
    x = tv.pad(x, [0, 140], fill=114)
    return x.flip(1).to(torch.float32) / 255


def cases() -> dict[str, tuple[Callable[[], tuple], dict[str, Callable]]]:
    """The cases by bundle: inputs, and the peers that are timed on them."""
    import kornia as K
    import torchvision.transforms.v2.functional as tv

    return {
        "filters.sobel": (lambda: (image(),), {"kornia": K.filters.sobel}),
        "filters.spatial_gradient": (lambda: (image(),), {"kornia": K.filters.spatial_gradient}),
        "filters.laplacian": (lambda: (image(),), {"kornia": lambda x: K.filters.laplacian(x, 3)}),
        "filters.box_blur": (lambda: (image(),), {"kornia": lambda x: K.filters.box_blur(x, (5, 5))}),
        "filters.gaussian_blur2d": (
            lambda: (image(), sigma()),
            {
                "kornia": lambda x, s: K.filters.gaussian_blur2d(x, (5, 5), s),
                "torchvision": lambda x, s: tv.gaussian_blur(x, [5, 5], [1.5, 1.5]),
            },
        ),
        "filters.unsharp_mask": (
            lambda: (image(),),
            {"kornia": lambda x: K.filters.unsharp_mask(x, (5, 5), (1.5, 1.5))},
        ),
        "filters.median_blur": (lambda: (image(),), {"kornia": lambda x: K.filters.median_blur(x, (3, 3))}),
        "filters.bilateral_blur": (
            lambda: (image(),),
            {"kornia": lambda x: K.filters.bilateral_blur(x, (5, 5), 0.1, (1.5, 1.5))},
        ),
        "filters.canny": (lambda: (image(),), {"kornia": lambda x: K.filters.canny(x, 0.5, 0.9)}),
        "morphology.dilation": (
            lambda: (image(), torch.ones(3, 3, device="cuda")),
            {"kornia": K.morphology.dilation},
        ),
        "color.rgb_to_grayscale": (
            lambda: (image(),),
            {"kornia": K.color.rgb_to_grayscale, "torchvision": tv.rgb_to_grayscale},
        ),
        "color.rgb_to_hsv": (lambda: (image(),), {"kornia": K.color.rgb_to_hsv}),
        "color.rgb_to_lab": (lambda: (image(),), {"kornia": K.color.rgb_to_lab}),
        "color.rgb_to_ycbcr": (lambda: (image(),), {"kornia": K.color.rgb_to_ycbcr}),
        "enhance.normalize": (
            lambda: (image(), torch.full((3,), 0.4, device="cuda"), torch.full((3,), 0.2, device="cuda")),
            {
                "kornia": K.enhance.normalize,
                "torchvision": lambda x, m, s: tv.normalize(x, [0.4] * 3, [0.2] * 3),
            },
        ),
        "geometry.transform.hflip": (
            lambda: (image(),),
            {"kornia": K.geometry.transform.hflip, "torchvision": tv.hflip},
        ),
        "geometry.transform.resize.bilinear": (
            lambda: (image(), like(HEIGHT // 2, WIDTH // 2)),
            {
                "kornia": lambda x, _: K.geometry.transform.resize(x, (HEIGHT // 2, WIDTH // 2)),
                "torchvision": lambda x, _: tv.resize(x, [HEIGHT // 2, WIDTH // 2], antialias=False),
            },
        ),
        "geometry.transform.warp_perspective.bilinear_zeros": (
            lambda: (image(), homography(), like(HEIGHT, WIDTH)),
            {"kornia": lambda x, m, _: K.geometry.transform.warp_perspective(x, m, (HEIGHT, WIDTH))},
        ),
        "pipelines.letterbox": (lambda: (frames(),), {"torchvision": letterboxed}),
        "filters.gaussian_blur2d.frames": (
            lambda: (frames(), sigma()),
            {"torchvision": lambda x, _: tv.gaussian_blur(x.permute(0, 3, 1, 2), [5, 5], [1.5, 1.5])},
        ),
    }


def measure(folder: Path) -> dict:
    if not torch.cuda.is_available():
        sys.exit("bench.cuda: there is no CUDA device")
    import kornia
    import torchvision

    torch.backends.cuda.matmul.allow_tf32 = torch.backends.cudnn.allow_tf32 = False
    torch.set_grad_enabled(False)
    bandwidth = copied_bytes_per_second()
    rows = []
    for name, (inputs, peers) in cases().items():
        if (folder / f"{name}.chiasm").exists():
            rows.append(measured(folder / f"{name}.chiasm", inputs(), peers))
            print(json.dumps(rows[-1]), flush=True)
            torch.cuda.empty_cache()
    packages = {"torch": torch, "kornia": kornia, "torchvision": torchvision}
    return {
        "device": torch.cuda.get_device_name(),
        "cuda": torch.version.cuda,
        "versions": {package: module.__version__ for package, module in packages.items()},
        "bandwidth": bandwidth,
        "date": str(date.today()),
        "rows": rows,
    }


def copied_bytes_per_second() -> float:
    source = torch.empty(1 << 28, device="cuda")
    target = torch.empty_like(source)
    return 2 * source.nbytes / interleaved({"copy": lambda: target.copy_(source)})["copy"] * 1e6


def measured(bundle: Path, given: tuple[torch.Tensor, ...], peers: dict[str, Callable]) -> dict:
    started = time.perf_counter()
    method = chiasm.runtime.open(bundle).method(backend="native", device="cuda")
    loaded = time.perf_counter()
    found = method.run(list(given))
    torch.cuda.synchronize()
    ran = time.perf_counter()
    outputs = found if isinstance(found, tuple) else (found,)
    calls: dict[str, Call] = {"chiasm": lambda: method.run_into(list(given), outputs)}
    failed = {}
    if bundle.stem not in WAITING:
        graph = torch.cuda.CUDAGraph()
        with torch.cuda.graph(graph):
            method.run_into(list(given), outputs)
        calls["graph"] = graph.replay
    functions = dict(peers)
    if "kornia" in peers:
        functions["compiled"] = torch.compile(peers["kornia"])
    for peer, function in functions.items():
        try:
            function(*given)
            calls[peer] = partial(function, *given)
        except Exception as error:
            failed[peer] = f"{type(error).__name__}: {error}"[:200]
    return {
        "bundle": bundle.stem,
        "bytes": sum(t.nbytes for t in (*given, *outputs)),
        "load_ms": (loaded - started) * 1e3,
        "first_ms": (ran - loaded) * 1e3,
        "us": interleaved(calls),
        "failed": failed,
    }


def interleaved(calls: dict[str, Call], rounds: int = 9, seconds: float = 0.004) -> dict[str, float]:
    """Microseconds of each call: the median over rounds in which all take turns."""
    counts = {}
    for name, call in calls.items():
        call()
        counts[name] = max(1, min(200, int(seconds * 1e6 / max(timed(call, 2), 1.0))))
    found: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(rounds):
        for name, call in calls.items():
            found[name].append(timed(call, counts[name]))
    return {name: statistics.median(all_of) for name, all_of in found.items()}


def timed(call: Call, count: int) -> float:
    begin, end = torch.cuda.Event(enable_timing=True), torch.cuda.Event(enable_timing=True)
    torch.cuda.synchronize()
    begin.record()
    for _ in range(count):
        call()
    end.record()
    end.synchronize()
    return begin.elapsed_time(end) / count * 1e3


def page(result: dict) -> str:
    peers = ("kornia", "compiled", "torchvision")
    lines = [
        "# Native code on a GPU, against Kornia and torchvision",
        "",
        f"Made by `python -m bench.cuda` on {result['date']}: {result['device']}, CUDA"
        f" {result['cuda']}, "
        + ", ".join(f"{name} {version}" for name, version in result["versions"].items())
        + f". A copy on the device moves {result['bandwidth'] / 1e12:.2f} TB/s, read and written.",
        "",
        f"Median microseconds for a batch of {BATCH} images of {HEIGHT} x {WIDTH} x 3, all contenders in",
        "turns: float32, or bytes for frames and the letterbox. *Of copy* is the op's bandwidth (inputs read",
        "once, outputs written once) as a share of the copy's. *Graph* is the same call replayed from a CUDA",
        "graph, without the host's work. The second number of each peer is its time over chiasm's; under 1",
        "the peer is faster.",
        "",
        "| op | load ms | first run ms | chiasm | of copy | graph | Kornia | compiled | torchvision |",
        "|---" * 9 + "|",
    ]
    ratios: dict[str, list[float]] = {peer: [] for peer in peers}
    for row in result["rows"]:
        us = row["us"]
        cells = [
            row["bundle"],
            f"{row['load_ms']:.1f}",
            f"{row['first_ms']:.1f}",
            f"{us['chiasm']:.0f}",
            f"{row['bytes'] / us['chiasm'] * 1e6 / result['bandwidth']:.0%}",
            f"{us['graph']:.0f}" if "graph" in us else "",
        ]
        for peer in peers:
            if peer in us:
                ratio = us[peer] / us["chiasm"]
                ratios[peer].append(ratio)
                cells.append(f"{us[peer]:.0f} ({'**' * (ratio < 1)}{ratio:.2f}{'**' * (ratio < 1)})")
            else:
                cells.append("fails" if peer in row["failed"] else "")
        lines.append(f"| {' | '.join(cells)} |")
    means = [f"{peer} {statistics.geometric_mean(r):.2f}" for peer, r in ratios.items() if r]
    return "\n".join([*lines, "", f"Geometric means: {', '.join(means)}.", ""])


def main(arguments: list[str]) -> int:
    if len(arguments) == 2:
        Path(arguments[1]).write_text(json.dumps(measure(Path(arguments[0]))))
        return 0
    if arguments:
        result = json.loads(Path(arguments[0]).read_text())
    else:
        from .machine import BUNDLES

        export_for_this_gpu()
        result = measure(BUNDLES)
    PAGE.write_text(wrapped(page(result)))
    print(f"wrote {PAGE.relative_to(ROOT)}")
    return 0


def export_for_this_gpu() -> None:
    from chiasm.export.workers import export_names

    from .machine import BUNDLES, cores

    if not torch.cuda.is_available():
        sys.exit("bench.cuda: there is no CUDA device")
    gpu = "sm_" + "".join(map(str, torch.cuda.get_device_capability()))
    export_names(list(cases()), BUNDLES, ("native",), (gpu,), methods=("forward",), jobs=cores())


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
