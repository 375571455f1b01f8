"""make bench WHAT=networks: whole networks, natively and in ONNX Runtime, in turns ->
docs/benchmarks_networks.md.

python -m bench.networks NAME THREADS one network and number of threads, as JSON: a process can set the latter
only once
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
from collections.abc import Callable
from datetime import date
from pathlib import Path

import numpy as np
import onnxruntime
import torch
import torchvision
from rich.progress import track
from torch import nn

import chiasm.runtime
from chiasm.export import Spec, TensorSpec, export
from tools.columns import wrapped

from .machine import ROOT, cores, cpu
from .wheel import interleaved, onnx_call, onnx_options

PAGE = ROOT / "docs" / "benchmarks_networks.md"
FOLDER = ROOT / "build" / "bench" / "networks"
SIDE = 224
#: CPU levels, each with its own bundle
LEVELS = {"AVX2": "x86-64-v3", "AVX-512": "x86-64-v4"}


def vision_transformer() -> nn.Module:
    """ViT-Ti of A. Steiner et al., How to train your ViT?, arXiv:2106.10270, 2021."""
    return torchvision.models.VisionTransformer(SIDE, 16, 12, 3, 192, 768)


NETWORKS: dict[str, Callable[[], nn.Module]] = {
    "MobileNetV2": torchvision.models.mobilenet_v2,
    "MobileNetV3-large": torchvision.models.mobilenet_v3_large,
    "EfficientNet-B0": torchvision.models.efficientnet_b0,
    "ResNet-18": torchvision.models.resnet18,
    "ViT-Ti/16": vision_transformer,
}


def main() -> int:
    rows = []
    for name in track(NETWORKS, description="networks"):
        write(name)
        rows += [measured(name, threads) for threads in sorted({1, cores()})]
    PAGE.write_text(wrapped(page(rows)))
    print(f"wrote {PAGE.relative_to(ROOT)}")
    return 0


def write(name: str) -> None:
    """Export a network with random weights as bundles, one for each level, and with PyTorch's own ONNX
    export."""
    torch.manual_seed(0)
    network = NETWORKS[name]().eval()
    tensors = [TensorSpec("image", ("B", 3, SIDE, SIDE))], [TensorSpec("scores")]
    spec = Spec(f"networks.{plain(name)}", *tensors, gradients=())
    for isa in LEVELS.values():
        export(network, spec, FOLDER / isa, formats=["native"], isas=(isa,))
    torch.onnx.export(network, (torch.rand(1, 3, SIDE, SIDE),), onnx_path(name), dynamo=True, verbose=False)


def plain(name: str) -> str:
    return name.lower().replace("-", "_").replace("/", "_")


def onnx_path(name: str) -> Path:
    return FOLDER / f"{plain(name)}.onnx"


def measured(name: str, threads: int) -> dict:
    command = [sys.executable, "-m", "bench.networks", name, str(threads)]
    return json.loads(subprocess.run(command, stdout=subprocess.PIPE, text=True, cwd=ROOT, check=True).stdout)


def measure(name: str, threads: int) -> dict:
    chiasm.runtime.set_num_threads(threads)
    image = np.random.default_rng(0).random((1, 3, SIDE, SIDE), dtype=np.float32)
    methods = {}
    for level, isa in LEVELS.items():
        bundle = chiasm.runtime.open(FOLDER / isa / f"networks.{plain(name)}.chiasm")
        try:
            methods[level] = bundle.method("forward", backend="native")
        except chiasm.runtime.ChiasmError:  # this machine does not have the level
            continue
    scores = {level: method(image) for level, method in methods.items()}
    contenders = {
        level: lambda method=method, out=scores[level]: method.run_into([image], [out])
        for level, method in methods.items()
    }
    options = onnx_options(threads)
    options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_ENABLE_ALL
    session = onnxruntime.InferenceSession(onnx_path(name), options)
    [peer] = session.run(None, {session.get_inputs()[0].name: image})
    for result in scores.values():
        np.testing.assert_allclose(result, peer, atol=1e-4 * float(np.abs(peer).max()))
    contenders["onnxruntime"] = onnx_call(session, [image])
    times = interleaved(list(contenders.values()), threads=threads)
    return {"network": name, "threads": threads} | dict(zip(contenders, times, strict=True))


def page(rows: list[dict]) -> str:
    lines = [
        "# Benchmark of networks",
        "",
        f"Made by `make bench WHAT=networks` on {date.today()}: {cpu()}, {cores()} cores, shared with",
        f"other work; one image of 3 x {SIDE} x {SIDE}, float32, random weights, in Python. chiasm's",
        f"native code, which needs no libtorch, and ONNX Runtime {onnxruntime.__version__} on the files of",
        "`torch.onnx.export` take turns in one process, on several threads each after a pause and calls that",
        "do not count; medians in milliseconds. *Times as fast* is ONNX Runtime's time over chiasm's. ONNX",
        "Runtime uses the widest vectors that the CPU has; chiasm's code uses those of the level for which",
        "it was exported (`--isa`), AVX2 by default.",
        "",
        "| network | threads | AVX2 | AVX-512 | ONNX Runtime | times as fast, AVX2 | AVX-512 |",
        "|---|---|---|---|---|---|---|",
    ]
    ratios: dict[str, list[float]] = {level: [] for level in LEVELS}
    for row in rows:
        times, shares = [], []
        for level, values in ratios.items():
            times.append(f"{row[level] / 1e3:.1f}" if level in row else "")
            if level in row:
                values.append(row["onnxruntime"] / row[level])
            shares.append(f"{values[-1]:.2f}" if level in row else "")
        columns = [row["network"], str(row["threads"]), *times, f"{row['onnxruntime'] / 1e3:.1f}", *shares]
        lines.append(f"| {' | '.join(columns)} |")
    means = [f"{statistics.geometric_mean(v):.2f} with {level}" for level, v in ratios.items() if v]
    lines += ["", f"Geometric means: {', '.join(means)}.", ""]
    return "\n".join(lines)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(json.dumps(measure(sys.argv[1], int(sys.argv[2]))))
    else:
        sys.exit(main())
