"""Compiled artifacts under AddressSanitizer and UBSan, with guards around every tensor.

    python tests/robustness/sanitized_artifacts.py            forty ops of all families
    python tests/robustness/sanitized_artifacts.py --few      the first three
    python tests/robustness/sanitized_artifacts.py OP...      these ops; OP+vjp is an op's gradient

`make sanitize-artifacts` runs the first, `make test` the second. Each op is exported with a compiler that
adds the sanitizers, linked with the libraries of build/asan-ubsan, and run by a separate program
(sanitized_artifacts.cpp): on the golden vectors, the smallest sizes, odd sizes, and with NaN, infinities and
other special values in all and in one of each input's elements; on one thread and on three, with tensors that
end, and that begin, at the edge of memory. No sanitizer may report anything, nothing may be written outside a
tensor, and results for ordinary values must equal eager Python's. An op may reject special values with a
message. Compiled code is kept in build/sanitized.
"""

from __future__ import annotations

import os
import re
import struct
import subprocess
import sys
import threading
import warnings
import zipfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "build" / "sanitized"
RUNNER = FOLDER / "runner"
#: Reports the version of another compiler, so that the exporter caches its output separately. Optimises at
#: most with -O1, so that compile times are bearable and reports readable.
COMPILER = """#!/bin/bash
if [ "$1" = --version ]; then echo "g++ with sanitizers, 1: $(g++ --version | head -1)"; exit; fi
unset LD_PRELOAD
for argument; do
  case $argument in
    -O2|-O3) arguments+=(-O1) ;;
    -s) ;;
    *) arguments+=("$argument") ;;
  esac
done
exec /usr/bin/g++ "${arguments[@]}" -fsanitize=address,undefined,float-cast-overflow -fno-omit-frame-pointer
"""
ENVIRONMENT = {"CXX": str(FOLDER / "g++"), "CHIASM_CACHE": str(FOLDER / "cache")}
os.environ |= ENVIRONMENT  # before torch reads them

import torch  # noqa: E402

from chiasm.export import example_inputs, export, isas  # noqa: E402
from chiasm.export.catalog import catalog  # noqa: E402
from chiasm.export.comparison import compare  # noqa: E402
from chiasm.export.errors import ExportError  # noqa: E402
from chiasm.export.job import run_eager, with_cotangents  # noqa: E402
from chiasm.export.manifest import read_manifest  # noqa: E402
from chiasm.export.spec import TensorSpec  # noqa: E402
from chiasm.export.tracing.gradient import vjp_module  # noqa: E402
from chiasm.export.tracing.module import bind_spec  # noqa: E402

isas.LIBRARIES = ROOT / "build" / "asan-ubsan" / "artifact"

#: The first three: a table that is read at indices from data, pixels that are written at such indices, and
#: one of chiasm's kernels.
OPS = [
    "color.apply_colormap",
    "image.draw_line",
    "enhance.integral_image",
    "color.raw_to_rgb",
    "color.rgb_to_hsv",
    "contrib.connected_components",
    "contrib.extract_tensor_patches.padded",
    "contrib.interp",
    "enhance.adjust_hue",
    "enhance.equalize_clahe",
    "enhance.histogram2d",
    "feature.extract_patches_from_pyramid",
    "feature.fast_response",
    "feature.match_snn",
    "feature.sift_describe.plain",
    "filters.bilateral_blur",
    "filters.canny",
    "filters.gaussian_blur2d",
    "filters.median_blur",
    "filters.otsu_threshold",
    "filters.percentile_filter",
    "filters.sobel",
    "filters.spatial_gradient3d",
    "geometry.bbox.nms_fixed",
    "geometry.conversions.euler_from_quaternion",
    "geometry.lie.se3_log",
    "geometry.linalg.transform_points.plane",
    "geometry.quaternion.quaternion_slerp",
    "geometry.solvers.solve_quadratic",
    "geometry.subpix.nms2d.values",
    "geometry.transform.crop_by_indices.resize",
    "geometry.transform.remap.bicubic_reflection",
    "geometry.transform.remap.bilinear_zeros+vjp",
    "geometry.transform.resize.bicubic_antialias",
    "geometry.transform.warp_perspective.bilinear_border",
    "geometry.transform.warp_polar.linear",
    "losses.focal_loss",
    "losses.one_hot",
    "losses.ssim_loss",
    "metrics.confusion_matrix.counts",
    "metrics.mean_iou",
    "morphology.gradient",
    "pipelines.edges",
    "pipelines.preprocess",
]
FEW = 3
ODD = {"B": 3, "C": 3, "H": 37, "W": 29, "N": 13, "OH": 9, "OW": 11}
FLOATS = (float("nan"), float("inf"), -float("inf"), 0.0, -1.0, 1e-40, 1e10, -3e9, 3e9, 1e38, -1e38)
# In the order of chiasm_dtype
DTYPES = (
    "bool",
    "uint8",
    "int8",
    "int16",
    "int32",
    "int64",
    "float16",
    "bfloat16",
    "float32",
    "float64",
)
SECONDS = 120  # for one run

Tensors = dict[str, torch.Tensor]


def main(arguments: list[str]) -> int:
    ops = OPS[:FEW] if arguments == ["--few"] else arguments or OPS
    FOLDER.mkdir(parents=True, exist_ok=True)
    compiler = Path(ENVIRONMENT["CXX"])
    if not compiler.exists() or compiler.read_text() != COMPILER:
        compiler.write_text(COMPILER)
        compiler.chmod(0o755)
    source = Path(__file__).with_suffix(".cpp")
    folders = (f"-I{ROOT}", f"-I{ROOT}/include")
    command = [compiler, "-std=c++17", "-O1", "-Wall", *folders, source, "-o", RUNNER, "-pthread"]
    subprocess.run(command, check=True)
    failed = 0
    with ProcessPoolExecutor(
        int(os.environ.get("JOBS", len(os.sched_getaffinity(0)))), mp_context=get_context("spawn")
    ) as pool:
        for op, (done, problems) in zip(ops, pool.map(checked, ops), strict=True):
            print(f"{'FAIL' if problems else 'ok':4} {op}: {done}", *problems, sep="\n     ", flush=True)
            failed += bool(problems)
    print(f"sanitized artifacts: {len(ops)} ops, {failed} failed")
    return 1 if failed else 0


def checked(op: str) -> tuple[str, list[str]]:
    """A summary of an op's runs, and its problems."""
    warnings.simplefilter("ignore")
    torch.set_num_threads(1)
    # The exporter tries the artifact in a separate process, which needs the sanitizer from its start, and the
    # C++ library that the sanitizer watches.
    libraries = [
        subprocess.run(["g++", f"-print-file-name={name}"], capture_output=True, text=True, check=True).stdout
        for name in ("libasan.so", "libstdc++.so")
    ]
    os.environ |= {"LD_PRELOAD": " ".join(libraries).replace("\n", ""), "ASAN_OPTIONS": "detect_leaks=0"}
    try:
        return watched(op)
    except ExportError as error:
        return "not exported", [str(error)]


def watched(op: str) -> tuple[str, list[str]]:
    name, _, method = op.partition("+")
    method = method or "forward"
    entry = catalog()[name]
    spec = replace(entry.spec, dtypes=entry.spec.dtypes[:1])
    bundle = export(
        entry.function(), spec, FOLDER / "bundles" / method, ["native"], methods=("forward", method)
    )
    signature = read_manifest(bundle)["methods"][method]
    (artifact,) = (a for a in signature["artifacts"] if a["backend"] == "native")
    library = FOLDER / "bundles" / method / f"{name}.so"
    with zipfile.ZipFile(bundle / artifact["file"]) as archive:
        library.write_bytes(archive.read("chiasm/op.so"))

    function = bind_spec(entry.function(), spec)
    if method == "vjp":
        outputs = [
            TensorSpec(t["name"], tuple(t["shape"]), t["dtype"])
            for t in read_manifest(bundle)["methods"]["forward"]["outputs"]
        ]
        eager = vjp_module(function, spec, outputs)
    else:
        eager = function
    tensors = [TensorSpec(t["name"], tuple(t["shape"]), t["dtype"]) for t in signature["inputs"]]
    runner, problems, refused, runs = Runner(library), [], "", 0
    for what, sizes in all_sizes(spec):
        try:
            inputs = with_cotangents(function, spec, sizes, spec.variants()[0], tensors)
            expected = run_eager(eager, inputs)
        except (ValueError, RuntimeError) as error:
            if what == "golden":
                raise ExportError(f"{op}: eager Python refuses its own golden inputs: {error}") from error
            refused += (  # not all sizes within the limits are valid together
                f", {what} sizes refused by eager Python"
            )
            continue
        for threads, placement in ((1, 0), (3, 1), (3, 0), (1, 1)):
            runs += 1
            results, message = runner.run(inputs, expected, threads, placement)
            message = message if results is None else compare(signature, results, expected)[1]
            problems += [f"{what} {sizes}, {threads} threads: {message}"] if message else []
        if what != "golden":
            continue
        for changed, special in special_inputs(inputs):
            for threads, placement in ((1, 0), (3, 1)):
                runs += 1
                results, message = runner.run(special, expected, threads, placement)
                problems += (
                    [f"{changed}, {threads} threads: {message}"]
                    if results is None and runner.is_broken
                    else []
                )
    problems += runner.close()
    return f"{runs} runs{refused}", list(dict.fromkeys(problems))


def all_sizes(spec) -> Iterator[tuple[str, dict[str, int]]]:
    yield "golden", example_inputs.fit(spec, example_inputs.GOLDEN)
    yield "smallest", {symbol: low for symbol, (low, _) in spec.used_symbols().items()}
    yield "odd", example_inputs.fit(spec, ODD)


def special_inputs(inputs: Tensors) -> Iterator[tuple[str, Tensors]]:
    for name, tensor in inputs.items():
        if tensor.dtype == torch.bool or tensor.numel() == 0:
            continue
        limits = torch.iinfo(tensor.dtype) if not tensor.is_floating_point() else None
        for value in FLOATS if limits is None else (limits.min, limits.max, max(-1, limits.min), 1):
            one = tensor.clone()
            one.view(-1)[tensor.numel() // 2] = value
            yield f"{name} with {value} in one place", inputs | {name: one}
            yield f"{name} full of {value}", inputs | {name: torch.full_like(tensor, value)}


class Runner:
    """A process that runs an artifact, restarted if it has died."""

    def __init__(self, library: Path) -> None:
        self.library = library
        self.said = ""
        self.start()

    def start(self) -> None:
        self.is_broken = False
        options = {
            "ASAN_OPTIONS": "detect_leaks=1:detect_stack_use_after_return=1",
            "UBSAN_OPTIONS": "print_stacktrace=0",
        }
        self.process = subprocess.Popen(
            [RUNNER, self.library],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=os.environ | options,
        )
        self.lines: list[str] = []
        self.listener = threading.Thread(
            target=lambda: self.lines.extend(
                line.decode(errors="replace").rstrip() for line in self.process.stderr
            )
        )
        self.listener.start()

    def run(
        self, inputs: Tensors, outputs: tuple[torch.Tensor, ...], threads: int, placement: int
    ) -> tuple[list[torch.Tensor] | None, str]:
        """The outputs, with the shapes of `outputs`; or None, and the reason."""
        if self.is_broken:
            self.start()
        request = [struct.pack("<4i", threads, placement, len(inputs), len(outputs))]
        for tensor in inputs.values():
            request += [header(tensor), as_bytes(tensor)]
        request += [header(tensor) for tensor in outputs]
        clock = threading.Timer(SECONDS, self.process.kill)
        clock.start()
        try:
            self.process.stdin.write(b"".join(request))
            self.process.stdin.flush()
            status = struct.unpack("<i", self.read(4))[0]
            if status == 2:
                return self.broken("something was written beside a tensor, or scratch was lost")
            if status == 1:
                return None, self.read(struct.unpack("<i", self.read(4))[0]).decode()
            return [
                (
                    torch.frombuffer(bytearray(self.read(t.nbytes)), dtype=t.dtype).reshape(t.shape)
                    if t.numel()
                    else t.clone()
                )
                for t in outputs
            ], ""
        except (BrokenPipeError, EOFError):
            return self.broken("")
        finally:
            clock.cancel()

    def broken(self, why: str) -> tuple[None, str]:
        said = self.close()
        self.is_broken = True
        return None, why or f"the process ended with {self.process.returncode}: " + " | ".join(
            said or self.lines[-3:] or ["it took too long"]
        )

    def read(self, size: int) -> bytes:
        data = self.process.stdout.read(size)
        if len(data) < size:
            raise EOFError
        return data

    def close(self) -> list[str]:
        """The sanitizers' reports, each once."""
        with suppress(BrokenPipeError):
            self.process.stdin.close()
        self.process.stdout.read()
        self.process.wait()
        self.listener.join()
        said: dict[str, str] = {}
        for line in self.lines:
            if "runtime error:" in line:
                place, _, what = line.partition("runtime error: ")
                said.setdefault(place, Path(place.strip()).name + " " + what)
            # Also the location of a memory error
            elif "ERROR: " in line or (said and re.match(r"\s*#[0-4] ", line)):
                said.setdefault(line.strip(), re.sub(r"0x[0-9a-f]+ ?|==\d+==", "", line).strip())
        return list(said.values())


def header(tensor: torch.Tensor) -> bytes:
    return struct.pack(
        f"<2i{tensor.dim()}q",
        DTYPES.index(str(tensor.dtype).removeprefix("torch.")),
        tensor.dim(),
        *tensor.shape,
    )


def as_bytes(tensor: torch.Tensor) -> bytes:
    return tensor.contiguous().view(-1).view(torch.uint8).numpy().tobytes() if tensor.numel() else b""


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
