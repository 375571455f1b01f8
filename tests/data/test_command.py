"""`chiasm map`, as users call it: in processes, killed, interrupted, and restarted."""

import errno
import gc
import hashlib
import io
import os
import signal
import subprocess
import sys
import tarfile
import time
import tracemalloc
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pyarrow as pa
import pyarrow.parquet as parquet
import pytest
from PIL import Image

import chiasm.runtime
from chiasm.data import DataError, Map, decoding
from chiasm.data.driver import JOB, fingerprint, in_processes, output_folder
from chiasm.data.shards import IMAGES as SUFFIXES
from chiasm.data.shards import Shard, plan, write

from .conftest import BLUR, COUNT, EDGES, PREPROCESS, SOBEL, encoded, same_rows


def start(*arguments: object) -> subprocess.Popen:
    command = [sys.executable, "-m", "chiasm.export", "map", *map(str, arguments)]
    return subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        # A shell lets its background jobs ignore interrupts
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )


def chiasm_map(*arguments: object) -> tuple[int, str]:
    process = start(*arguments)
    text, _ = process.communicate(timeout=300)
    assert "Traceback" not in text
    return process.returncode, text


def shards(folder: Path) -> dict[str, str]:
    return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in sorted(folder.glob("part-*.parquet"))}


def left_over(folder: Path) -> list[str]:
    return [p.name for p in folder.iterdir() if p.suffix == ".tmp"]


@pytest.fixture(scope="module")
def undisturbed(photos: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("undisturbed")
    code, text = chiasm_map(PREPROCESS, photos, folder, "--rows", 4, "-j", 2)
    assert code == 0 and f"{COUNT} rows" in text and "2 of them bad" in text, text
    return folder


def test_a_folder_of_images(undisturbed: Path, expected: dict[str, np.ndarray | None]) -> None:
    table = parquet.read_table(undisturbed)
    same_rows(table, expected)
    assert table.schema.field("output").type == pa.fixed_shape_tensor(pa.float32(), [3, 224, 224])
    assert table.schema.metadata[b"chiasm.bundle"] == b"pipelines.preprocess.chiasm"
    manifest = hashlib.sha256((PREPROCESS / "manifest.json").read_bytes()).hexdigest()
    assert table.schema.metadata[b"chiasm.manifest_sha256"].decode() == manifest
    assert table.schema.metadata[b"chiasm.artifact"].decode() == Map(PREPROCESS).open().method.artifact


def children(pid: int, main: bytes = b"spawn_main") -> list[int]:
    """The workers of a process: its children that run multiprocessing's main."""
    found = []
    for path in Path("/proc").glob("[0-9]*"):
        try:
            status, command = (path / "stat").read_text(), (path / "cmdline").read_bytes()
        except OSError:
            continue
        if int(status.rpartition(")")[2].split()[1]) == pid and main in command:
            found.append(int(path.name))
    return found


def begun(photos: Path, folder: Path) -> subprocess.Popen:
    """A run that has written a shard, but not all of them."""
    process = start(PREPROCESS, photos, folder, "--rows", 4, "-j", 2)
    deadline = time.monotonic() + 180
    while not shards(folder):
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.005)
    return process


SIGNALS = {"interrupt": signal.SIGINT, "termination": signal.SIGTERM}


@pytest.mark.parametrize("signal_name", SIGNALS)
def test_a_signal_while_workers_start_ends_the_run(photos: Path, tmp_path: Path, signal_name: str) -> None:
    process = start(PREPROCESS, photos, tmp_path / "out", "--rows", 1, "-j", 3)
    deadline = time.monotonic() + 180
    while not children(process.pid):
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.005)
    process.send_signal(SIGNALS[signal_name])
    text, _ = process.communicate(timeout=180)
    assert process.returncode == 128 + SIGNALS[signal_name] and text.count("Error") == 1, text
    assert "Traceback" not in text and "leaked" not in text and left_over(tmp_path / "out") == []


def test_workers_whose_parent_is_killed_while_they_start_print_nothing(photos: Path, tmp_path: Path) -> None:
    process = start(PREPROCESS, photos, tmp_path / "out", "--rows", 1, "-j", 3)
    deadline = time.monotonic() + 180
    while not children(process.pid):
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.005)
    time.sleep(
        0.02
    )  # the parent writes what it has for the worker, which takes longer to read the first of it
    process.kill()
    text, _ = process.communicate(timeout=180)  # until the workers have ended too
    assert process.returncode == -signal.SIGKILL and "Traceback" not in text, text


@pytest.mark.parametrize("end", ["driver", "worker", "interrupt", "termination"])
def test_what_is_ended_goes_on(photos: Path, undisturbed: Path, tmp_path: Path, end: str) -> None:
    out = tmp_path / "out"
    process = begun(photos, out)
    workers = children(process.pid)
    # stopped, so that it cannot finish before it is killed
    for pid in (process.pid, *workers):
        os.kill(pid, signal.SIGSTOP)
    assert workers and len(shards(out)) < COUNT // 4
    if end == "driver":
        process.kill()
    elif end == "worker":
        os.kill(workers[0], signal.SIGKILL)
    else:
        process.send_signal(SIGNALS[end])
    for pid in (process.pid, *workers):
        with suppress(ProcessLookupError):  # whose parent has seen already that it was killed
            os.kill(pid, signal.SIGCONT)
    text, _ = process.communicate(timeout=180)
    assert "Traceback" not in text
    if end == "worker":
        assert process.returncode == 1 and "a worker was killed" in text
    if end in SIGNALS:
        assert process.returncode == 128 + SIGNALS[end] and "Error: " in text
    deadline = time.monotonic() + 60
    while any(Path(f"/proc/{pid}").exists() for pid in workers):  # no worker outlives its driver
        assert time.monotonic() < deadline
        time.sleep(0.02)
    if end != "driver":
        assert left_over(out) == []
    finished = shards(out)
    assert finished.items() <= shards(undisturbed).items() and len(finished) < COUNT // 4
    kept = {name: (out / name).stat().st_mtime_ns for name in finished}
    code, text = chiasm_map(PREPROCESS, photos, out, "--rows", 4, "-j", 1)
    assert code == 0 and "by an earlier run" in text, text
    assert shards(out) == shards(undisturbed) and left_over(out) == []
    assert kept == {name: (out / name).stat().st_mtime_ns for name in finished}


@pytest.mark.parametrize("also_a_worker", [False, True])
def test_a_killed_tracker_of_semaphores_prints_nothing(
    photos: Path, tmp_path: Path, also_a_worker: bool
) -> None:
    process = begun(photos, tmp_path / "out")
    workers, [tracker] = children(process.pid), children(process.pid, b"resource_tracker")
    for pid in (tracker, *workers[:also_a_worker]):
        os.kill(pid, signal.SIGKILL)
    text, _ = process.communicate(timeout=180)
    assert process.returncode == also_a_worker, text
    assert "Traceback" not in text and "Warning" not in text and text.count("Error") == also_a_worker, text


def test_tars(photos: Path, expected: dict[str, np.ndarray | None], tmp_path: Path) -> None:
    paths = sorted(photos.iterdir())
    (tmp_path / "in").mkdir()
    for k, part in enumerate((paths[:40], paths[40:])):
        with tarfile.open(tmp_path / "in" / f"train-{k}.tar", "w") as archive:
            for path in part:
                archive.add(path, path.name)
                label = tarfile.TarInfo(path.with_suffix(".cls").name)
                label.size = 1
                archive.addfile(label, io.BytesIO(b"7"))
    code, text = chiasm_map(PREPROCESS, tmp_path / "in", tmp_path / "out", "-j", 1)
    assert code == 0, text
    same_rows(parquet.read_table(tmp_path / "out"), expected)
    # a truncated archive fails as a whole, the others do not
    whole = (tmp_path / "in" / "train-1.tar").read_bytes()
    (tmp_path / "in" / "train-1.tar").write_bytes(whole[: len(whole) // 2])
    code, text = chiasm_map(PREPROCESS, tmp_path / "in", tmp_path / "cut", "-j", 1)
    assert code == 1 and "1 of 2 shards failed" in text and "train-1.tar" in text, text
    assert list(shards(tmp_path / "cut")) == ["part-000000.parquet"] and left_over(tmp_path / "cut") == []


def written(source: Path, folder: Path) -> pa.Table:
    """The output of `chiasm map` for a source of one shard."""
    mapping = Map(SOBEL, errors="column")
    [shard], _ = plan(source, 500)
    folder.mkdir(exist_ok=True)
    write(shard, mapping, folder, lambda rows, bad: None)
    return parquet.read_table(folder / shard.file)


def a_tar(*members: tarfile.TarInfo | str, records: dict[str, str] | None = None) -> bytearray:
    """A tar of the given members; a name becomes an image."""
    picture, file = encoded(np.random.default_rng(0), 32, 32), io.BytesIO()
    with tarfile.open(fileobj=file, mode="w", format=tarfile.PAX_FORMAT) as archive:
        for member in members:
            content = None
            if isinstance(member, str):
                member, content = tarfile.TarInfo(member), io.BytesIO(picture)
                member.size, member.pax_headers = len(picture), records or {}
            archive.addfile(member, content)
    return bytearray(file.getbuffer())


@pytest.mark.parametrize(
    "damage",
    [
        "header",
        "hole",
        "cut in a header",
        "cut between members",
        "no end",
        "two",
        "sparse",
        "deep",
        "size",
        "far",
        "negative",
        "digits",
        "a hole of 8 GB",
        "sparse map",
    ],
)
def test_no_member_of_a_damaged_tar_is_missing_without_a_word(damage: str, tmp_path: Path) -> None:
    source = tmp_path / "a.tar"
    records = {"sparse": {"GNU.sparse.map": "x,y"}, "size": {"size": "-512"}, "far": {"size": "9" * 20}}.get(
        damage
    )
    data = a_tar("a.jpg", "b.jpg", "c.jpg", records=records)
    second = data.index(b"b.jpg") if records is None else 0
    if damage == "header":
        data[second : second + 4] = b"oops"
    elif damage == "hole":
        data[second : second + 512] = bytes(512)
    elif damage == "cut in a header":
        del data[second + 100 :]
    elif damage == "cut between members":
        del data[second:]
    elif damage == "no end":
        del data[(len(data.rstrip(b"\0")) + 511) // 512 * 512 :]
    elif damage == "two":
        data *= 2
    elif damage == "deep":
        extended = tarfile.TarInfo("p")
        extended.type = tarfile.XHDTYPE
        data = extended.tobuf() * 3000 + data
    elif damage == "negative":
        data[second + 124 : second + 136] = b"\xff" * 12  # its size, -1
        data[second + 148 : second + 156] = b"%07o\0" % tarfile.calc_chksums(data[second : second + 512])[0]
    elif damage in ("digits", "a hole of 8 GB"):  # quadratic time, and memory
        extended = tarfile.TarInfo("p")
        extended.type, extended.size = tarfile.XHDTYPE, 1 << 18 if damage == "digits" else 8 << 30
        data = extended.tobuf() + (b"1" * extended.size + data if damage == "digits" else b"")
    elif damage == "sparse map":
        data = a_tar("a.jpg", records={"GNU.sparse.major": "1", "GNU.sparse.minor": "0"})
    source.write_bytes(data)
    if damage == "a hole of 8 GB":
        os.truncate(source, 8 << 30)
    with pytest.raises(DataError, match=r"a\.tar: .*(archive|seeking)"):
        written(source, tmp_path / "out")
    assert list((tmp_path / "out").iterdir()) == []


def test_members_that_are_no_file_or_too_large_are_bad_rows(tmp_path: Path) -> None:
    hard, soft, sparse, folder = (tarfile.TarInfo(f"{name}.jpg") for name in ("hard", "soft", "sparse", "d"))
    hard.type, hard.linkname = tarfile.LNKTYPE, "a.jpg"
    soft.type, soft.linkname = tarfile.SYMTYPE, "/etc/passwd"
    folder.type = tarfile.DIRTYPE
    sparse.pax_headers = {"GNU.sparse.map": "0,0", "GNU.sparse.size": str(1 << 43)}
    source = tmp_path / "a.tar"
    source.write_bytes(a_tar("a.jpg", hard, soft, sparse, folder, "b.jpg"))
    rows = written(source, tmp_path / "out")
    assert rows["id"].to_pylist() == ["a.jpg", "hard.jpg", "soft.jpg", "sparse.jpg", "b.jpg"]
    for error, part in zip(rows["error"].to_pylist(), (None, "a link", "a link", "sparse file", None)):
        assert (error is None) if part is None else part in error, error
    # 3 GB in a sparse file
    large = tarfile.TarInfo("a.jpg")
    large.size = 3 << 30
    with open(source, "wb") as file:
        file.write(large.tobuf())
        file.truncate(512 + large.size + 1024)
    [error] = written(source, tmp_path / "out")["error"].to_pylist()
    assert "expected at most" in error


def test_a_pipe_as_input_and_a_full_disk(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.tar")
    os.mkfifo(tmp_path / "pipe.parquet")
    for name in ("pipe.tar", "pipe.parquet"):
        with pytest.raises(DataError, match=f"{name}: not a regular file"):
            plan(tmp_path / name, 500)
    (tmp_path / "a.tar").write_bytes(a_tar("a.jpg"))

    def full(rows: int, bad: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    [shard], _ = plan(tmp_path / "a.tar", 500)
    with pytest.raises(DataError, match=r"a\.tar, written to .*part-000000\.parquet: No space left"):
        write(shard, Map(SOBEL, errors="column"), tmp_path, full)


@pytest.mark.parametrize("name", [".lock", JOB])
def test_an_output_folder_with_a_pipe_or_a_link_for_a_file(name: str, tmp_path: Path) -> None:
    def refused() -> str:
        with pytest.raises((OSError, DataError)) as error, output_folder(tmp_path / "out", {"rows": 1}):
            pass
        return str(error.value)

    precious, file = tmp_path / "precious", tmp_path / "out" / name
    precious.write_text("[" * 100_000)
    file.parent.mkdir()
    os.mkfifo(file)
    assert name in refused()
    file.unlink()
    file.symlink_to(precious)
    assert name in refused()
    assert precious.stat().st_size == 100_000


def test_links_in_the_place_of_unfinished_files_are_replaced(tmp_path: Path) -> None:
    (tmp_path / "a.tar").write_bytes(a_tar("a.jpg"))
    precious, folder = tmp_path / "precious", tmp_path / "out"
    precious.write_text("mine")
    folder.mkdir()
    [shard], _ = plan(tmp_path / "a.tar", 500)
    for name in (f".{JOB}.tmp", f".{shard.file}.{os.uname().nodename}-{os.getpid()}.tmp"):
        (folder / name).symlink_to(precious)
    write(shard, Map(SOBEL, errors="column"), folder, lambda rows, bad: None)
    (folder / shard.file).rename(tmp_path / shard.file)
    with output_folder(folder, {"rows": 1}):
        assert precious.read_text() == "mine" and not (folder / JOB).is_symlink()


def test_a_cache_whose_name_is_not_text_is_one_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CHIASM_CACHE", os.fsdecode(bytes(tmp_path / "cache") + b"\xff"))
    with pytest.raises(DataError, match="in UTF-8, got"):
        Map(SOBEL, num_threads=2).open()


def test_a_large_constant_takes_no_more_memory() -> None:
    def job(values: np.ndarray) -> dict[str, object]:
        mapping = SimpleNamespace(
            columns={},
            constants={"like": values},
            parcel=SimpleNamespace(sha256=""),
            open=lambda: SimpleNamespace(method=SimpleNamespace(backend="native", artifact="")),
        )
        return fingerprint(mapping, "", 1)  # pyright: ignore[reportArgumentType]

    values = np.zeros((2000, 2000), np.uint8)
    job(values[:1])  # the modules that it imports
    tracemalloc.start()
    first = job(values)
    assert tracemalloc.get_traced_memory()[1] < 4 * values.nbytes
    tracemalloc.stop()
    assert job(values) == first
    values[9, 9] = 1
    assert job(values) != first and job(values[:1999]) != first


def test_parquet(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    images = rng.random((70, 3, 16, 24), np.float32)
    column = pa.FixedShapeTensorArray.from_numpy_ndarray(images)
    table = pa.table({"key": pa.array(range(70)), "image": column})
    parquet.write_table(table, tmp_path / "table.parquet", row_group_size=40)
    code, text = chiasm_map(
        BLUR,
        tmp_path / "table.parquet",
        tmp_path / "out",
        "-c",
        "input=image",
        "-s",
        "sigma=[[1.5, 1.5]]",
        "-j",
        1,
    )
    assert code == 0 and len(shards(tmp_path / "out")) == 2, text
    result = parquet.read_table(tmp_path / "out")
    assert result.column_names == ["key", "output", "error"] and result["key"].to_pylist() == list(range(70))
    blur = chiasm.runtime.open(BLUR).method("forward", num_threads=1)
    want = blur(images, np.full((70, 2), 1.5, np.float32))
    np.testing.assert_array_equal(result["output"].combine_chunks().to_numpy_ndarray(), want)


def mapped(file: Path, out: Path, between: Callable[[], object] = lambda: None) -> list[str]:
    """Map the row groups of a parquet file by sobel, and return their errors; `between` runs after each
    batch."""
    failures = []
    for shard in plan(file, 500)[0]:
        try:
            write(shard, Map(SOBEL, errors="column"), out, lambda *_: between())
        except DataError as error:
            failures.append(str(error))
    return failures


IMAGES = np.random.default_rng(4).random((70, 3, 8, 8), np.float32)


def test_parquet_that_cannot_be_read_is_one_error(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Also after the first batch has been written."""
    null_inside = IMAGES.tolist()
    null_inside[50][1] = None
    kind = pa.list_(pa.list_(pa.list_(pa.float32(), 8), 8), 3)
    file = tmp_path / "null.parquet"
    parquet.write_table(pa.table({"input": pa.array(null_inside, kind)}), file)
    [message] = mapped(file, tmp_path)
    assert message.startswith(f"{file}, row group 0: a list of fixed size, or a part of a tensor, is null")
    gc.collect()
    assert capfd.readouterr().err == "" and left_over(tmp_path) == []
    data = bytearray(file.read_bytes())
    data[-20:-8] = b"\xff" * 12
    file.write_bytes(data)
    with pytest.raises(DataError, match=rf"^{file}: not a parquet file that can be read: "):
        plan(file, 500)


def test_parquet_that_changes_is_one_error(tmp_path: Path) -> None:
    def table(images: np.ndarray) -> pa.Table:
        return pa.table({"input": pa.FixedShapeTensorArray.from_numpy_ndarray(images)})

    file = tmp_path / "table.parquet"
    parquet.write_table(table(IMAGES), file, row_group_size=40)
    assert mapped(file, tmp_path) == []
    first, second = mapped(file, tmp_path, lambda: os.utime(file))
    assert first == f"{file}, row group 0: it was changed while it was read: run the same command again"
    assert second.startswith(f"{file}, row group 1: it was changed while")
    shards, _ = plan(file, 500)
    parquet.write_table(table(IMAGES[:50]), file)
    with pytest.raises(DataError, match="row group 0: it was changed after this run had begun: it had "):
        write(shards[0], Map(SOBEL, errors="column"), tmp_path, lambda *_: None)
    file.unlink()
    os.mkfifo(file)
    with pytest.raises(DataError, match="row group 1: it was changed after this run had begun: it had "):
        write(shards[1], Map(SOBEL, errors="column"), tmp_path, lambda *_: None)


def test_refusals(photos: Path, undisturbed: Path, tmp_path: Path) -> None:
    empty, mixed, broken = tmp_path / "empty", tmp_path / "mixed", tmp_path / "broken.parquet"
    for folder in (empty, mixed, tmp_path / "full"):
        folder.mkdir()
    (mixed / "a.jpg").write_bytes(encoded(np.random.default_rng(0), 32, 32))
    (mixed / "a.tar").write_text("")
    broken.write_text("no parquet")
    parquet.write_table(pa.table({"text": pa.array([], pa.string())}), tmp_path / "none.parquet")
    (tmp_path / "full" / "mine.txt").write_text("")
    (tmp_path / "some.TGZ").write_text("")
    (tmp_path / "loop").symlink_to("loop")
    out = tmp_path / "out"
    for code, message, *arguments in (
        (1, "expected images", PREPROCESS, empty, out),
        (1, "got none of them: compressed tars must be decompressed", PREPROCESS, tmp_path / "some.TGZ", out),
        (1, "1 images and 1 tar", PREPROCESS, mixed, out),
        (1, "broken.parquet: not a parquet", PREPROCESS, broken, out),
        (1, "no column 'frame'", PREPROCESS, tmp_path / "none.parquet", out),
        (1, "expected numbers, tensors", PREPROCESS, tmp_path / "none.parquet", out, "-c", "frame=text"),
        (1, "'mine.txt'", PREPROCESS, photos, tmp_path / "full"),
        (1, "loop: File exists", PREPROCESS, photos, tmp_path / "loop"),
        (1, "inside INPUT", PREPROCESS, photos, photos / "out"),
        (1, "another bundle", EDGES, photos, undisturbed, "--rows", 4),
        (1, "another --rows", PREPROCESS, photos, undisturbed, "--rows", 5),
        (1, "no input 'x'", PREPROCESS, photos, out, "-s", "x=1"),
        (1, "have no columns", PREPROCESS, photos, out, "-c", "frame=image"),
        (1, "--set sigma=", BLUR, photos, out),
        (1, "neither JSON", BLUR, photos, out, "-s", "sigma=wide"),
        (1, "expected a constant of shape (B, 2), got one of shape ()", BLUR, photos, out, "-s", "sigma=1.5"),
        (2, "NAME=VALUE", BLUR, photos, out, "-s", "sigma"),
        (2, "does not exist", SOBEL, tmp_path / "nothing", out),
        (1, "no manifest.json", photos, photos, out),
        (1, "no cluster at '127.0.0.1:1'", PREPROCESS, photos, out, "--ray", "127.0.0.1:1"),
        (1, "expected auto, local or HOST:PORT", PREPROCESS, photos, out, "--ray", "ray://"),
        (1, "expected auto, local or HOST:PORT", PREPROCESS, photos, out, "--ray", "\x1b[31m:9"),
    ):
        got, text = chiasm_map(*arguments)
        errors = [line for line in text.splitlines() if line.startswith("Error: ")]
        assert got == code and len(errors) == 1 and message in errors[0], (arguments, text)
        assert not list(out.glob("part-*"))
        assert BLUR not in arguments or not out.exists()
    assert os.listdir(tmp_path / "full") == ["mine.txt"]  # a folder that is not ours gets no lock either
    code, text = chiasm_map("--help")
    assert code == 0 and "Examples:" in text


def test_images_of_every_name_are_rows(tmp_path: Path) -> None:
    source = tmp_path / "in"
    source.mkdir()
    small = np.random.default_rng(7).integers(0, 2, (8, 8), np.uint8) * 255
    picture = Image.fromarray(small).resize((64, 48), Image.Resampling.NEAREST)
    for extension in SUFFIXES:
        file = source / f"a{extension}"
        form = {".pbm": "1", ".pgm": "L", ".pnm": "L"}.get(extension, "RGB")
        picture.convert(form).save(file, Image.registered_extensions().get(extension, "PPM"))
    [shard], _ = plan(source, 500)
    write(shard, Map(EDGES, errors="column"), tmp_path, lambda *_: None)
    rows = parquet.read_table(tmp_path / shard.file).to_pylist()
    assert [row["id"] for row in rows] == sorted(f"a{extension}" for extension in SUFFIXES)
    frame = np.repeat(np.asarray(picture)[..., None], 3, 2)
    expected = chiasm.runtime.open(EDGES).method("forward", num_threads=1)(frame)
    for row in rows:
        assert row["error"] is None, row["id"]
        if not row["id"].startswith(("a.avif", "a.j", "a.webp")):  # lossless
            np.testing.assert_array_equal(np.reshape(row["output"]["data"], expected.shape), expected)


def test_what_determines_the_bytes_is_in_the_job(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(mapping: Map, files: str = "") -> str:
        with pytest.raises(DataError) as error, output_folder(tmp_path, fingerprint(mapping, files, 1)):
            pass
        return str(error.value)

    sobel = Map(SOBEL)
    with output_folder(tmp_path, fingerprint(sobel, "", 1)):
        pass
    artifact, other = (Map(SOBEL, backend=name).open().method.artifact for name in ("native", "onnx"))
    assert artifact != other
    said = refused(Map(SOBEL, backend="onnx"))
    assert f"{tmp_path}: it was begun with another artifact of the bundle (by CPU, backends and" in said
    assert f"(['native', '{artifact}', ''], now ['onnx', '{other}', '" in said, said
    assert "choose another folder, or remove this one" in said
    assert "another INPUT (by names, sizes and times of change):" in refused(sobel, "changed")
    monkeypatch.setattr(decoding, "_turbo", lambda: None)
    assert "another version of chiasm, pyarrow, Pillow or simplejpeg" in refused(sobel)


def test_a_file_of_the_same_size_that_has_changed_is_another_input(tmp_path: Path) -> None:
    for name in ("a.jpg", "b.jpg"):
        (tmp_path / name).write_bytes(b"one")
    _, before = plan(tmp_path, 500)
    assert plan(tmp_path, 500)[1] == before
    (tmp_path / "b.jpg").write_bytes(b"two")
    os.utime(tmp_path / "b.jpg", ns=(0, 1))
    _, after = plan(tmp_path, 500)
    assert after != before
    (tmp_path / "c.tar").write_bytes(a_tar("a.jpg"))
    _, before = plan(tmp_path / "c.tar", 500)
    os.utime(tmp_path / "c.tar", ns=(0, 1))
    assert plan(tmp_path / "c.tar", 500)[1] != before


def test_the_job_and_shards_are_on_the_disk_before_they_count(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also the names: a folder is synced after its file was renamed."""
    synced: list[tuple[str, bool]] = []
    sync = os.fsync

    def record(descriptor: int) -> None:
        path = Path(os.readlink(f"/proc/self/fd/{descriptor}"))
        synced.append((path.name, any(not p.name.startswith(".") for p in path.parent.glob("out/*"))))
        sync(descriptor)

    monkeypatch.setattr(os, "fsync", record)
    (tmp_path / "a.tar").write_bytes(a_tar("a.jpg"))
    out = tmp_path / "out"
    [shard], _ = plan(tmp_path / "a.tar", 500)
    with output_folder(out, {"rows": 1}):
        assert synced[0][0].startswith(".writing-") and synced[1:] == [("out", True)]
        (out / JOB).rename(tmp_path / JOB)
        del synced[:]
        write(shard, Map(SOBEL, errors="column"), out, lambda rows, bad: None)
        assert synced[0][0].startswith(f".{shard.file}.") and synced[1:] == [("out", True)]


def test_rows_of_a_shard_that_fails_are_not_counted(tmp_path: Path) -> None:
    null_inside = IMAGES.tolist()
    null_inside[50][1] = None
    kind = pa.list_(pa.list_(pa.list_(pa.float32(), 8), 8), 3)
    table = pa.table({"input": pa.array([*null_inside, *IMAGES.tolist()], kind)})
    file, out = tmp_path / "null.parquet", tmp_path / "out"
    parquet.write_table(table, file, row_group_size=len(IMAGES))
    out.mkdir()
    reports: list[tuple[bool, int]] = []

    def report(shard: Shard | None, failure: str | None, rows: int, bad: int) -> None:
        reports.append((failure is not None, rows))

    in_processes(plan(file, 500)[0], Map(SOBEL, errors="column"), out, 1, report)
    assert reports[:2] == [(False, 32), (True, -32)]
    assert sum(rows for _, rows in reports) == len(IMAGES) and list(shards(out)) == ["part-000001.parquet"]


def test_links_to_nothing_and_to_themselves_are_left_out(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(b"")
    (tmp_path / "nothing.png").symlink_to("nowhere.png")
    (tmp_path / "self.png").symlink_to("self.png")
    [shard], _ = plan(tmp_path, 500)
    assert shard.names == ("a.png",)


def test_links_to_folders_are_followed_but_not_back(tmp_path: Path) -> None:
    for folder in ("data/cats", "data/.hidden", "other"):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "a.png").write_bytes(b"")
    for link, target in (
        ("data/dogs", "../other"),
        ("data/more", "../other"),
        ("data/.links", "../other"),
        ("data/cats/up", ".."),
        ("data/self", "."),
        ("other/back", "../data"),
        ("link", "data"),
    ):
        (tmp_path / link).symlink_to(target)
    for source in (tmp_path / "data", tmp_path / "link"):
        [shard], _ = plan(source, 500)
        assert shard.names == ("cats/a.png", "dogs/a.png", "more/a.png")


def test_an_output_folder_whose_name_is_no_text_is_shown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONIOENCODING", "utf-8:strict")  # as in a terminal
    source, out = tmp_path / "in", tmp_path / "out\udcff"
    source.mkdir()
    (source / "a.png").write_bytes(encoded(np.random.default_rng(0), 48, 64, "PNG"))
    code, text = chiasm_map(EDGES, source, out, "-j", 1)
    assert code == 0 and "1 rows in" in text, text
    assert len(shards(out)) == 1


def test_the_only_image_as_a_constant_names_the_option(photos: Path, tmp_path: Path) -> None:
    code, text = chiasm_map(PREPROCESS, photos, tmp_path / "out", "-s", "frame=1")
    assert code == 1 and "leave out --set frame" in text


def test_two_runs_do_not_share_a_folder(photos: Path, tmp_path: Path) -> None:
    first = begun(photos, tmp_path)
    os.kill(first.pid, signal.SIGSTOP)
    code, text = chiasm_map(PREPROCESS, photos, tmp_path, "--rows", 4)
    os.kill(first.pid, signal.SIGCONT)
    assert code == 1 and "another `chiasm map` is writing" in text
    assert first.wait(60) == 0
