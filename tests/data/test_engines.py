"""The recipes of docs/scale.md, each on its real engine, give the same rows as a plain loop, bit for bit."""

import contextlib
import doctest
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as parquet
import pytest
import ray

from chiasm.data import DataError, Map, mapping, on_ray
from chiasm.data.on_ray import _fitting, map_batches

from .conftest import BAD, BUNDLES, COUNT, EDGES, PREPROCESS, ROOT, same_rows
from .test_command import chiasm_map, shards, start

RECIPES = dict(
    re.findall(r"```python\n# (\w+)\n(.*?)```", (ROOT / "docs" / "scale.md").read_text(), re.DOTALL)
)


@pytest.fixture
def place(tmp_path: Path, photos: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the files that the recipes name."""
    (tmp_path / "bundles").symlink_to(BUNDLES)
    (tmp_path / "photos").symlink_to(photos)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def cluster() -> Iterator[None]:
    ray.init(
        "local",
        num_cpus=3,
        include_dashboard=False,
        log_to_driver=False,
        logging_level="ERROR",
        object_store_memory=300 * 2**20,
    )
    ray.data.DataContext.get_current().enable_progress_bars = False
    yield
    ray.shutdown()


def follow(recipe: str) -> dict:
    names: dict = {"__name__": recipe}
    exec(compile(RECIPES[recipe], f"docs/scale.md: {recipe}", "exec"), names)
    return names


def test_plain(place: Path, expected: dict[str, np.ndarray | None]) -> None:
    follow("plain")
    same_rows(parquet.read_table("rows.parquet"), expected, "path")


def test_daft(place: Path, expected: dict[str, np.ndarray | None]) -> None:
    same_rows(follow("daft")["rows"].to_arrow(), expected, "path")


def test_spark(place: Path, expected: dict[str, np.ndarray | None]) -> None:
    os.environ["PYSPARK_PYTHON"] = sys.executable
    # A JVM without a web interface, and a job that lists the files itself
    settings = {
        "spark.ui.enabled": "false",
        "spark.driver.bindAddress": "127.0.0.1",
        "spark.driver.host": "127.0.0.1",
        "spark.sql.sources.parallelPartitionDiscovery.threshold": "1000",
        "spark.sql.files.openCostInBytes": "4096",
        "spark.sql.execution.arrow.maxRecordsPerBatch": "32",
    }
    options = [part for key, value in settings.items() for part in ("--conf", f"{key}={value}")]
    os.environ["PYSPARK_SUBMIT_ARGS"] = " ".join([*options, "pyspark-shell"])
    names = follow("spark")
    try:
        same_rows(parquet.read_table("rows"), expected, "path")
        # bytes become a numeric type of Spark, with shapes
        edges = Map(EDGES, columns={"frame": "content"}, errors="null")
        photos = names["photos"].limit(4)
        kind = "path string, output struct<data: array<smallint>, shape: array<int>>"
        rows = photos.mapInArrow(edges, kind).toArrow().to_pylist()
        for row in rows:
            got = row["output"]
            if Path(row["path"]).name in BAD:
                assert got is None
            else:
                want = edges({"content": [Path(row["path"].removeprefix("file:")).read_bytes()]})["output"][0]
                np.testing.assert_array_equal(np.array(got["data"]).reshape(got["shape"]), want)
    finally:
        names["spark"].stop()


def test_ray(place: Path, cluster: None, expected: dict[str, np.ndarray | None]) -> None:
    follow("ray")
    same_rows(parquet.read_table("rows"), expected, "path")


def test_examples(place: Path, cluster: None) -> None:
    """The examples in docstrings."""
    (place / "build").symlink_to(ROOT / "build")
    for module in (mapping, on_ray):
        result = doctest.testmod(module)
        assert result.attempted > 3 and result.failed == 0


@pytest.mark.parametrize("form", ["pyarrow", "numpy"])
def test_ray_in_tasks(photos: Path, cluster: None, expected: dict[str, np.ndarray | None], form: str) -> None:
    """Without a pool; also in NumPy batches, from which Ray makes its own tensors."""
    preprocess = Map(PREPROCESS, columns={"frame": "bytes"}, errors="column")
    files = ray.data.read_binary_files(str(photos), include_paths=True)
    rows = files.map_batches(preprocess, batch_format=form, batch_size=32).to_arrow_refs()
    parts = ray.get(rows)  # in a part without an error, the error column has no type
    same_rows(pa.concat_tables(parts, promote_options="default"), expected, "path")
    edges = Map(EDGES, columns={"frame": "bytes"}, errors="column")
    taken = files.map_batches(edges, batch_format=form, batch_size=32).take_all()
    bad = {Path(row["path"]).name for row in taken if row["error"] is not None}
    assert len(taken) == COUNT and bad == set(BAD)


class Slow(Map):
    """Slow enough to be killed in the middle."""

    def __call__(self, batch: pa.Table) -> pa.Table:
        time.sleep(0.1)
        return super().__call__(batch)


def workers(word: bytes) -> list[int]:
    """This test's processes whose title contains a word; they are recognised by their cache folder, which
    they inherit."""
    mark, found = f"CHIASM_CACHE={os.environ['CHIASM_CACHE']}".encode(), []
    for path in Path("/proc").glob("[0-9]*"):
        try:
            if word in (path / "cmdline").read_bytes() and mark in (path / "environ").read_bytes():
                found.append(int(path.name))
        except OSError:
            continue
    return found


def test_a_killed_actor_is_started_again(
    photos: Path, cluster: None, expected: dict[str, np.ndarray | None]
) -> None:
    ray.cloudpickle.register_pickle_by_value(sys.modules[__name__])
    preprocess = Slow(PREPROCESS, columns={"frame": "bytes"}, errors="column")
    files = ray.data.read_binary_files(str(photos), include_paths=True, override_num_blocks=8)
    parts, killed = [], 0
    for part in map_batches(files, preprocess, workers=2, batch_size=2).iter_batches(
        batch_size=None, batch_format="pyarrow"
    ):
        parts.append(part)
        if not killed:
            killed = next(iter(workers(b"ray::MapWorker")))
            os.kill(killed, signal.SIGKILL)
    assert killed and len(parts) > 1
    same_rows(pa.concat_tables(parts), expected, "path")


def test_a_pool_that_would_wait_for_ever_is_refused(photos: Path, cluster: None) -> None:
    files = ray.data.read_binary_files(str(photos))
    preprocess, before = Map(PREPROCESS, columns={"frame": "bytes"}, errors="column"), time.monotonic()
    with pytest.raises(DataError, match=r"do not leave a CPU for reading on a cluster of 3 CPUs.*at most 2"):
        map_batches(files, preprocess, workers=3)
    with pytest.raises(DataError, match="workers >= 1"):
        map_batches(files, preprocess, workers=0)
    assert time.monotonic() - before < 60  # Ray by itself would wait for ever
    assert map_batches(files, preprocess, workers=2).schema() is not None
    # nodes with 2, 2 and 1 CPUs: one node keeps a CPU for reading
    assert [_fitting(nodes, 1) for nodes in ([2, 2, 1], [4], [1], [], [0])] == [4, 3, 0, 0, 0]
    assert [_fitting([4, 4], cpus) for cpus in (0.5, 2, 3, 4)] == [14, 3, 2, 1]


def test_serve(place: Path, cluster: None, photos: Path, expected: dict[str, np.ndarray | None]) -> None:
    from ray import serve

    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    serve.start(http_options={"host": "127.0.0.1", "port": port})
    try:
        follow("serve")
        for name in ("0000.jpg", "0001.jpg"):
            data = (photos / name).read_bytes()
            with urllib.request.urlopen(f"http://127.0.0.1:{port}/", data, timeout=180) as answer:
                assert answer.read() == expected[name].tobytes()
        with pytest.raises(urllib.error.HTTPError) as refused:
            urllib.request.urlopen(f"http://127.0.0.1:{port}/", b"no image", timeout=180)
        assert refused.value.code == 400 and b"not an image" in refused.value.read()
    finally:
        serve.shutdown()


def test_the_command_on_ray(photos: Path, expected: dict[str, np.ndarray | None], tmp_path: Path) -> None:
    """A run that is killed with its cluster and then finished in processes gives the bytes of an undisturbed
    run."""
    ray.shutdown()
    out, whole = tmp_path / "out", tmp_path / "whole"
    driver = start(PREPROCESS, photos, out, "--rows", 2, "--ray", "local", "-j", 2)
    deadline = time.monotonic() + 300
    while not shards(out):
        assert driver.poll() is None and time.monotonic() < deadline
        time.sleep(0.005)
    driver.kill()
    driver.communicate()
    while left := workers(b"ray"):  # they would end by themselves in 90 seconds
        for process in left:
            with contextlib.suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL)
        assert time.monotonic() < deadline
        time.sleep(0.1)
    assert len(shards(out)) < COUNT // 2
    code, text = chiasm_map(PREPROCESS, photos, out, "--rows", 2, "-j", 1)
    assert code == 0 and "by an earlier run" in text, text
    same_rows(parquet.read_table(out), expected)
    code, text = chiasm_map(PREPROCESS, photos, whole, "--rows", 2, "-j", 1)
    assert code == 0 and shards(out) == shards(whole)


def test_two_nodes(photos: Path, expected: dict[str, np.ndarray | None], tmp_path: Path) -> None:
    """Two nodes, each with its own object store and cache: each gets a copy of the bundle."""
    ray.shutdown()
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{free.getsockname()[1]}"
    common = ["--node-ip-address=127.0.0.1", "--num-cpus=1", "--object-store-memory=100000000", "--block"]
    common += ["--disable-usage-stats"]
    short = tempfile.mkdtemp(prefix="chiasm-", dir="/tmp")  # names of sockets must be short
    places = [
        [
            "--head",
            f"--port={address.rpartition(':')[2]}",
            "--include-dashboard=false",
            f"--temp-dir={short}",
        ],
        [f"--address={address}"],
    ]
    nodes = []
    try:
        for k, place in enumerate(places):
            environment = {**os.environ, "CHIASM_CACHE": str(tmp_path / f"cache-{k}")}
            command = [Path(sys.executable).parent / "ray", "start", *place, *common]
            with open(tmp_path / f"node-{k}.log", "w") as log:
                nodes.append(subprocess.Popen(command, env=environment, stdout=log, stderr=log))
            deadline = time.monotonic() + 180
            while "Ray runtime started" not in (tmp_path / f"node-{k}.log").read_text():
                assert nodes[-1].poll() is None and time.monotonic() < deadline, (
                    tmp_path / f"node-{k}.log"
                ).read_text()
                time.sleep(0.1)
        code, text = chiasm_map(PREPROCESS, photos, tmp_path / "out", "--rows", 2, "--ray", address)
        assert code == 0, text
        same_rows(parquet.read_table(tmp_path / "out"), expected)
        for k in range(2):
            copies = list((tmp_path / f"cache-{k}" / "bundles").glob("*/*"))
            assert [c.name for c in copies] == ["pipelines.preprocess.chiasm"], k
    finally:
        for node in reversed(nodes):
            node.terminate()
        for node in nodes:
            node.wait(30)
        shutil.rmtree(short)
