"""The measurements of `make bench WHAT=ray`. Runs in .deps/data, which has no torch, and prints JSON.

usage: python -m bench.ray_contenders BUNDLE PHOTOS FOLDER
"""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import ray

from chiasm.data import Files, Map
from chiasm.data.on_ray import map_batches

WORKERS, BATCH, REPEATS = 2, 32, 3
#: The rows of a block of Ray's: by default it reads so few files that the overhead of its tasks dominates.
BLOCK = 100
#: The part of a run, from its start, that does not count in the rate.
FROM = 0.25
#: A variable in the environment of the workers that this program starts.
MARK = "CHIASM_BENCH"


def main() -> int:
    bundle, photos, folder = map(Path, sys.argv[1:])
    os.environ[MARK] = str(os.getpid())
    mapping = Map(bundle, columns={"frame": Files("path")})
    of_bytes = Map(bundle, columns={"frame": "bytes"})
    contenders: dict[str, Callable[[], dict]] = {
        "chiasm on Ray": lambda: on_ray(photos, paths, lambda ds: map_batches(ds, mapping, workers=WORKERS)),
        "OpenCV on Ray": lambda: on_ray(photos, paths, with_opencv),
        "chiasm on Ray, which reads the files": lambda: on_ray(
            photos, contents, lambda ds: map_batches(ds, of_bytes, workers=WORKERS)
        ),
        "chiasm, plain loop": lambda: plain_loops(photos, mapping),
    }
    runs: dict[str, list[dict]] = {name: [] for name in contenders}
    for _ in range(REPEATS):
        for name, run in contenders.items():
            runs[name].append(run())
            print(f"{name}: {runs[name][-1]['rate']:.0f} images a second", file=sys.stderr)
    found = {"runs": runs, "map": by_command(bundle, photos, folder), "versions": versions()}
    print(json.dumps(found))
    return 0


def versions() -> dict[str, str]:
    from importlib.metadata import version

    packages = {"Ray": "ray", "OpenCV": "opencv-python-headless", "simplejpeg": "simplejpeg"}
    return {name: version(package) for name, package in packages.items()}


def paths(photos: Path, blocks: int) -> Any:
    """The files' names: the workers read them."""
    return ray.data.from_items(
        [{"path": str(path)} for path in sorted(photos.iterdir())], override_num_blocks=blocks
    )


def contents(photos: Path, blocks: int) -> Any:
    """The files' bytes, which Ray reads in tasks of its own."""
    return ray.data.read_binary_files(str(photos), include_paths=True, override_num_blocks=blocks)


def on_ray(photos: Path, rows: Callable[[Path, int], Any], add: Callable[[Any], Any]) -> dict:
    """In a fresh cluster of three CPUs, so that two workers leave one for reading."""
    ray.init(
        "local",
        num_cpus=WORKERS + 1,
        include_dashboard=False,
        log_to_driver=False,
        logging_level="ERROR",
        object_store_memory=2**30,
    )
    try:
        ray.data.DataContext.get_current().enable_progress_bars = False
        count, began, sizes = len(os.listdir(photos)), None, []
        files = rows(photos, max(4, count // BLOCK))
        done = first = 0
        for batch in add(files).iter_batches(batch_size=None, batch_format="pyarrow"):
            done += batch.num_rows
            if began is None and done >= FROM * count:
                began, first = time.monotonic(), done
            if began is not None and len(sizes) < 1 + 20 * (done / count - FROM) / (1 - FROM):
                sizes.append(memory())  # about twenty times per run
        assert began is not None and done == count
        return {
            "rate": (done - first) / (time.monotonic() - began),
            "peak": max(sizes),
            "growth": sizes[-1] - sizes[0],
        }
    finally:
        ray.shutdown()


def memory() -> int:
    """The proportional set size of this process and of Ray's workers."""
    total, mine = 0, f"{MARK}={os.getpid()}".encode()
    for path in Path("/proc").glob("[0-9]*"):
        try:
            ours = path.name == str(os.getpid()) or (
                b"ray::" in (path / "cmdline").read_bytes() and mine in (path / "environ").read_bytes()
            )
            if ours:
                total += int((path / "smaps_rollup").read_text().split("Pss:")[1].split()[0]) * 1024
        except (OSError, IndexError):
            continue
    return total


class OpenCV:
    """The pipeline as a user would write it."""

    def __init__(self) -> None:
        import cv2

        cv2.setNumThreads(1)
        self.cv2 = cv2
        self.mean = np.array([0.485, 0.456, 0.406], np.float32)
        self.deviation = np.array([0.229, 0.224, 0.225], np.float32)

    def one(self, path: str) -> np.ndarray:
        frame = self.cv2.imread(path, self.cv2.IMREAD_COLOR)
        values = self.cv2.cvtColor(self.cv2.resize(frame, (224, 224)), self.cv2.COLOR_BGR2RGB)
        values = values.astype(np.float32)
        values *= 1 / 255
        values -= self.mean
        values /= self.deviation
        return values.transpose(2, 0, 1)

    def __call__(self, batch: pa.Table) -> pa.Table:
        images = np.stack([self.one(path) for path in batch["path"].to_pylist()])
        return pa.table(
            {"path": batch["path"], "output": pa.FixedShapeTensorArray.from_numpy_ndarray(images)}
        )


def with_opencv(files: Any) -> Any:
    ray.cloudpickle.register_pickle_by_value(sys.modules[OpenCV.__module__])
    return files.map_batches(
        OpenCV,
        compute=ray.data.ActorPoolStrategy(size=WORKERS),
        num_cpus=1,
        batch_size=BATCH,
        batch_format="pyarrow",
        zero_copy_batch=True,
    )


def plain_loops(photos: Path, mapping: Map) -> dict:
    """As many processes as Ray has workers, each with its part of the files, without Ray."""
    context = multiprocessing.get_context("spawn")
    start, results = context.Barrier(WORKERS), context.Queue()
    paths = sorted(photos.iterdir())
    loops = [
        context.Process(target=plain_loop, args=(mapping, paths[k::WORKERS], start, results))
        for k in range(WORKERS)
    ]
    for loop in loops:
        loop.start()
    counts, seconds = zip(*[results.get() for _ in loops])
    for loop in loops:
        loop.join()
    return {"rate": sum(counts) / max(seconds)}


def plain_loop(mapping: Map, paths: list[Path], start: Any, results: Any) -> None:
    first, began = max(BATCH, int(FROM * len(paths)) // BATCH * BATCH), 0.0
    start.wait()
    for i in range(0, len(paths), BATCH):
        if i == first:
            began = time.monotonic()
        some = paths[i : i + BATCH]
        mapping(pa.record_batch({"path": [str(p) for p in some]}))
    results.put((len(paths) - first, time.monotonic() - began))


def by_command(bundle: Path, photos: Path, folder: Path) -> list[dict]:
    """An undisturbed run, and a run in which a worker and then the driver are killed, and which is then
    resumed."""
    out, found = folder / "out", []
    command = [sys.executable, "-m", "chiasm.export", "map", bundle, photos, out, "-j", str(WORKERS)]
    command += ["--rows", str(max(10, len(os.listdir(photos)) // 100))]
    whole: dict[str, str] = {}
    for name, kills in (
        ("undisturbed", []),
        ("a worker and the driver killed, resumed", ["worker", "driver"]),
    ):
        shutil.rmtree(out, ignore_errors=True)
        began, had = time.monotonic(), 0
        for kill in [*kills, None]:
            process = subprocess.Popen([str(part) for part in command], stdout=sys.stderr, stderr=sys.stderr)
            if kill is not None:
                had = wait_for_shards(out, had + 5, process)
                os.kill(worker_of(process.pid) if kill == "worker" else process.pid, signal.SIGKILL)
            code = process.wait()
            assert (code == 0) == (kill is None), (name, kill, code)
        seconds, hashes = time.monotonic() - began, hashed(out)
        whole = whole or hashes
        found.append({"name": name, "seconds": seconds, "shards": len(hashes), "same": hashes == whole})
        shutil.rmtree(out)
    return found


def wait_for_shards(out: Path, count: int, process: subprocess.Popen) -> int:
    while (have := len(list(out.glob("part-*")))) < count:
        assert process.poll() is None, "the run ended before it could be killed"
        time.sleep(0.01)
    return have


def worker_of(pid: int) -> int:
    for path in Path(f"/proc/{pid}/task/{pid}/children").read_text().split():
        if b"spawn_main" in Path(f"/proc/{path}/cmdline").read_bytes():
            return int(path)
    raise RuntimeError(f"process {pid} has no worker")


def hashed(folder: Path) -> dict[str, str]:
    result = {}
    for path in sorted(folder.glob("part-*")):
        with open(path, "rb") as file:
            result[path.name] = hashlib.file_digest(file, "sha256").hexdigest()
    return result


if __name__ == "__main__":
    sys.exit(main())
