"""Wrong arguments, damaged files and a full disk give one line on stderr and an exit status, never a
traceback or a partial file."""

import base64
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

import pytest
from click.testing import CliRunner

from chiasm.export import ExportError, cli
from chiasm.export import bundle as bundle_module
from chiasm.export.bundle import Writer, clean_up
from chiasm.export.cli import main
from chiasm.export.manifest import sha256
from tests.export.commands import COMMAND, ROOT, refused, run, spawn

Folder = Callable[[str], Path]


@pytest.fixture
def alarm() -> Iterator[None]:
    """Fails a test that would wait for ever."""
    before = signal.signal(signal.SIGALRM, lambda *_: pytest.fail("it waits for ever"))
    signal.alarm(30)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def test_pipes_and_devices_are_refused(sobel: Path, photo: Path, tmp_path: Path, alarm: None) -> None:
    out = tmp_path / "out.png"
    os.mkfifo(tmp_path / "pipe.png")
    refused(run("run", sobel, tmp_path / "pipe.png", out), "pipe.png", "not a regular file")
    refused(run("run", sobel, "/dev/null", out), "/dev/null", "not a regular file")
    for name in ("sbom.cdx.json", "forward.float32.onnx", "manifest.json"):
        (sobel / name).unlink()
        os.mkfifo(sobel / name)
        refused(run("verify", sobel), name, "not a regular file")
    for words in (("info", sobel), ("run", sobel, photo, out), ("pack", "edges", sobel, "-o", tmp_path)):
        refused(run(*words), "manifest.json", "not a regular file")


def test_links_out_of_a_bundle_are_refused(sobel: Path, photo: Path, tmp_path: Path) -> None:
    for name in ("provenance.json", "forward.float32.onnx", "manifest.json"):
        (sobel / name).rename(tmp_path / name)
        (sobel / name).symlink_to(tmp_path / name)
        refused(run("pack", "edges", sobel, "-o", tmp_path / "dist"), name, "link that leaves")
        refused(run("verify", sobel), name, "link that leaves")
    refused(run("info", sobel), "manifest.json", "link that leaves", "put the file itself there")
    (sobel / "manifest.json").unlink()
    (tmp_path / "manifest.json").rename(sobel / "real.json")
    (sobel / "manifest.json").symlink_to("real.json")
    assert run("info", sobel).returncode == 0
    assert not (tmp_path / "dist").exists()


def test_settings_that_are_no_values(light: Folder, photo: Path, tmp_path: Path) -> None:
    bundle, out = light("enhance.adjust_brightness"), tmp_path / "out.png"
    for text in ("factor", "=1", "factor=1 -s"):
        refused(run("run", bundle, photo, out, "-s", text), status=2 if text != "factor=1 -s" else 1)
    refused(run("run", bundle, photo, out, "-s", "factor=1", "-s", "factor=2"), "twice", status=2)
    for value in (
        "",
        "[1,",
        "[[1, 2], [3]]",
        "null",
        '"x"',
        '{"a": 1}',
        "1e999999",
        "1e39",
        "[" * 5000,
        "999999x999999",
        "[[1.5]]",
        "[[\x1b[31m",
    ):
        refused(run("run", bundle, photo, out, "-s", f"factor={value}"), "factor")
    assert not out.exists()


@contextmanager
def limited(size: int) -> Iterator[None]:
    """No file can grow beyond `size` bytes, as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_full_disk_leaves_nothing(light: Folder, photo: Path, tmp_path: Path) -> None:
    bundle = light("filters.sobel")
    assert run("run", bundle, photo, tmp_path / "out.bmp", "-b", "onnx").returncode == 0
    (tmp_path / "out.bmp").unlink()
    with limited(500):
        done = run("run", bundle, photo, tmp_path / "out.bmp", "-b", "onnx")
        packed = run("pack", "x", bundle, "-o", tmp_path / "dist")
    refused(done, "out.bmp", "cannot be written", "large")
    refused(packed, "chiasm_bundles_x", "too large", "ulimit -f")
    assert not list(tmp_path.rglob("*.*"))
    with open("/dev/full", "w") as full:
        refused(spawn("info", "--json", bundle, stdout=full), "No space left")
        for words in (["doctor"], ["list", "--installed"], ["--help"], ["info", "--help"]):
            refused(spawn(*words, module="chiasm", stdout=full), "No space left")


def test_a_bundle_that_cannot_be_written_leaves_what_was_there(light: Folder, tmp_path: Path) -> None:
    manifest = json.loads((light("filters.sobel") / "manifest.json").read_text())
    writer = Writer(manifest, {p.name: p.read_bytes() for p in light("filters.sobel").iterdir()})
    there = tmp_path / "filters.sobel.chiasm"
    there.mkdir()
    (there / "mine").write_text("mine")
    for folder in (tmp_path, tmp_path / "new"):
        with limited(1000), pytest.raises(ExportError, match="cannot be written: File too large"):
            writer.write(folder)
    assert [p.name for p in there.iterdir()] == ["mine"] and not list(tmp_path.glob("**/.writing*"))
    (tmp_path / "file").write_text("")
    with pytest.raises(ExportError, match="cannot be written: Not a directory"):
        writer.write(tmp_path / "file" / "below")
    assert sorted(p.name for p in writer.write(tmp_path).iterdir()) == sorted(writer.files)
    assert not list(tmp_path.glob(".writing*"))


def test_an_interrupt_or_another_export_between_two_steps_loses_no_bundle(
    light: Folder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bundle = light("filters.sobel")
    files = {p.name: p.read_bytes() for p in bundle.iterdir()}
    writer = Writer(json.loads(files["manifest.json"]), files)
    there, rename = writer.write(tmp_path), os.rename

    def interrupted(source: Path, target: Path) -> None:
        rename(source, target)
        if source == there:
            os.kill(os.getpid(), signal.SIGINT)

    def overtaken(source: Path, target: Path) -> None:
        rename(source, target)
        if source == there:
            monkeypatch.setattr(os, "rename", rename)
            writer.write(tmp_path)

    monkeypatch.setattr(bundle_module, "_exchanged", lambda *_: False)  # as some file systems
    for step, expected in ((interrupted, pytest.raises(KeyboardInterrupt)), (overtaken, nullcontext())):
        monkeypatch.setattr(os, "rename", step)
        with expected:
            writer.write(tmp_path)
        monkeypatch.setattr(os, "rename", rename)
        assert [p.name for p in tmp_path.iterdir()] == [there.name]
        assert sorted(p.name for p in there.iterdir()) == sorted(files)


def test_a_bundle_is_there_while_it_is_replaced(light: Folder, tmp_path: Path) -> None:
    files = {p.name: p.read_bytes() for p in light("filters.sobel").iterdir()}
    writer = Writer(json.loads(files["manifest.json"]), files)
    manifest = writer.write(tmp_path) / "manifest.json"
    missing, over = 0, threading.Event()

    def look() -> None:
        nonlocal missing
        while not over.is_set():
            missing += not manifest.exists()

    reader = threading.Thread(target=look)
    reader.start()
    try:
        for _ in range(100):
            writer.write(tmp_path)
    finally:
        over.set()
        reader.join()
    assert missing == 0 and [p.name for p in tmp_path.iterdir()] == [manifest.parent.name]


def test_what_an_ended_process_was_writing_is_removed_and_what_it_had_moved_away_put_back(
    sobel: Path,
) -> None:
    folder = sobel.parent
    (folder / ".writing-17-one" / "new").mkdir(parents=True)
    sobel.rename(folder / ".writing-17-one" / "old")
    (folder / ".writing-18-other").mkdir()
    clean_up(folder, 17)
    assert sorted(f.name for f in folder.iterdir()) == [".writing-18-other", sobel.name]
    assert run("info", sobel).returncode == 0


def test_bundles_that_are_none(sobel: Path, photo: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.png"
    for command in (["info"], ["verify"]):
        refused(run(*command, tmp_path), "manifest.json")
        refused(run(*command, photo), "not a bundle")
        refused(run(*command, tmp_path / "none"), "none", status=2)
    refused(run("run", photo, photo, out), "not a bundle")
    text = (sobel / "manifest.json").read_bytes()
    for damage, part in (
        (b"{", "not JSON"),
        (b"\xff\xfe", "not JSON"),
        (b"[" * 100_000, "not JSON"),
        (b'{"name": "a", "name": "b"}', "the key 'name' occurs twice"),
        (b"[]", "manifest.json"),
        (b'{"schema_version": 99}', "99"),
        (text[:-30], "not JSON"),
        (text.replace(b'"min": 8', b'"min": "' + b"x" * 5000 + b'"'), "min"),
        (text.replace(b'"dtype": "T"', b'"dtype": "float99"'), "float99"),
        (text.replace(b'"name": "filters.sobel"', rb'"name": "filters.sobel\n"'), "$.name"),
    ):
        (sobel / "manifest.json").write_bytes(damage)
        for command in (["info", sobel], ["verify", sobel], ["run", sobel, photo, out]):
            refused(run(*command), part)
    # A layout is information for people, so it may be any text
    for layout in ("HWC", "HW"):
        (sobel / "manifest.json").write_bytes(text.replace(b'"NCHW"', f'"{layout}"'.encode()))
        refused(run("run", sobel, photo, out), "does not map an image to an image")


def test_verify_names_what_a_bundle_lacks(sobel: Path) -> None:
    from safetensors.torch import load_file, save

    manifest = json.loads((sobel / "manifest.json").read_text())

    def replaced(file: str, data: bytes) -> None:
        (sobel / file).write_bytes(data)
        for entry in (manifest["golden"], *(a for m in manifest["methods"].values() for a in m["artifacts"])):
            if entry["file"] == file:
                entry |= {"size": len(data), "sha256": sha256(data)}
        (sobel / "manifest.json").write_text(json.dumps(manifest))

    golden = load_file(sobel / "golden.safetensors")
    whole = (sobel / "golden.safetensors").read_bytes()
    replaced(
        "golden.safetensors",
        save({k: v for k, v in golden.items() if not k.endswith("forward.float64/input")}),
    )
    refused(run("verify", sobel), "forward.float64/input")
    replaced("golden.safetensors", b"no tensors at all")
    refused(run("verify", sobel), "golden.safetensors")
    replaced("golden.safetensors", whole)
    replaced("forward.float32.onnx", b"no model")
    done = run("verify", sobel)
    assert done.returncode == 1 and "Traceback" not in done.stderr + done.stdout
    assert any("FAIL" in line and "onnx (python)" in line for line in done.stdout.splitlines())
    (sobel / "provenance.json").unlink()
    refused(run("verify", sobel), "provenance.json")


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can become a user who may not read")
def test_no_permission(sobel: Path, photo: Path, tmp_path: Path) -> None:
    for folder in (photo.parent, tmp_path, *tmp_path.parents):
        if Path(tempfile.gettempdir()) in folder.parents:  # pytest's folder, which other users cannot open
            folder.chmod(0o755)
    # All imported modules are too
    assert run("run", sobel, photo, tmp_path / "out.png", "-b", "onnx").returncode == 0
    (tmp_path / "out.png").unlink()
    (sobel / "forward.pt").chmod(0)
    (tmp_path / "open").mkdir()
    (tmp_path / "open").chmod(0o777)
    os.seteuid(65534)
    try:
        written = run("run", sobel, photo, tmp_path / "out.png", "-b", "onnx")
        verified = run("verify", sobel)
        served = run("triton", tmp_path / "open" / "models", f"edges={sobel}")
        os.seteuid(0)
        (sobel / "manifest.json").chmod(0)
        os.seteuid(65534)
        read = run("info", sobel)
    finally:
        os.seteuid(0)
    refused(written, "out.png", "Permission denied")
    refused(verified, "forward.pt", "Permission denied")
    refused(served, "forward.pt", "Permission denied")
    refused(read, "manifest.json", "Permission denied")


def test_odd_text_is_shown_as_it_is(sobel: Path) -> None:
    manifest = json.loads((sobel / "manifest.json").read_text())
    manifest["summary"] = '[red]not red[/] [/] :smile: "quoted" \x1b[2J\x07 two\nlines [link=x'
    manifest["config"] = {"[bold]": "[/]\x1b[31m"}
    manifest["methods"]["forward"]["inputs"][0]["description"] = "[blink]\x1b]0;title\x07 [/nonsense]"
    (sobel / "manifest.json").write_text(json.dumps(manifest))
    done = run("info", sobel)
    assert done.returncode == 0, done.stderr
    assert (
        '[red]not red[/] [/] :smile: "quoted" two lines [link=x' in done.stdout
        and "[blink]" in done.stdout
        and "[/nonsense]" in done.stdout
    )
    assert "\x1b" not in done.stdout and "\x07" not in done.stdout
    assert json.loads(run("info", "--json", sobel).stdout) == manifest


def test_an_interrupt_is_one_line_and_leaves_nothing(tmp_path: Path) -> None:
    environment = os.environ | {"PYTHONPATH": str(ROOT / "python")}
    command = [*COMMAND, "export", "filters.*", "-f", "onnx", "-o", str(tmp_path), "-j", "1"]
    process = subprocess.Popen(
        command,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        # A shell's background job ignores interrupts, and so would this test's child.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    deadline = time.monotonic() + 100
    while not list(tmp_path.glob("*.chiasm")) and time.monotonic() < deadline:  # the first of many exists
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGINT)  # like a terminal, to the workers too
    _, stderr = process.communicate(timeout=15)
    assert process.returncode == 130 and stderr.strip().splitlines() == ["Error: interrupted"], stderr
    assert not list(tmp_path.glob(".writing*"))


def test_an_interrupt_of_the_imports_is_one_line(tmp_path: Path) -> None:
    # The module that the command imports first waits for the interrupt
    (tmp_path / "click.py").write_text("import time\nprint('importing', flush=True)\ntime.sleep(100)\n")
    process = subprocess.Popen(
        [sys.executable, "-m", "chiasm", "list"],
        env=os.environ | {"PYTHONPATH": f"{tmp_path}:{ROOT / 'python'}"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert process.stdout is not None and process.stdout.readline() == "importing\n"
    process.send_signal(signal.SIGINT)
    _, stderr = process.communicate(timeout=15)
    assert process.returncode == 130 and stderr == "Error: interrupted\n"


def test_a_closed_stdout(light: Folder) -> None:
    bundle = light("filters.sobel")
    for words in (f"chiasm info {bundle}", "chiasm doctor", "chiasm --help"):
        done = subprocess.run(
            f"{sys.executable} -m {words} >&-",
            shell=True,
            env=os.environ | {"PYTHONPATH": str(ROOT / "python")},
            stderr=subprocess.PIPE,
            text=True,
            timeout=100,
        )
        assert done.returncode == 0 and not done.stderr, done.stderr


def test_a_reader_that_leaves(sobel: Path) -> None:
    manifest = json.loads((sobel / "manifest.json").read_text())
    # More than the capacity of a pipe
    (sobel / "manifest.json").write_text(json.dumps(manifest | {"summary": "long" * 100_000}))
    for words, reader in (
        (f"chiasm.export info --json {sobel}", "head -c 1"),
        (f"chiasm.export info {sobel}", "head -c 1"),
        ("chiasm --help", "true"),
        ("chiasm doctor", "true"),
    ):
        done = subprocess.run(
            ["bash", "-c", f"{sys.executable} -m {words} | {reader}; exit ${{PIPESTATUS[0]}}"],
            env=os.environ | {"PYTHONPATH": str(ROOT / "python"), "PYTHONUNBUFFERED": ""},
            capture_output=True,
            text=True,
            timeout=100,
        )
        assert done.returncode == 128 + signal.SIGPIPE and not done.stderr, done.stderr


def test_a_deleted_working_folder(sobel: Path, tmp_path: Path) -> None:
    done = subprocess.run(
        ["bash", "-c", f"cd {tmp_path} && mkdir gone && cd gone && rmdir ../gone && exec $0 $@"]
        + [*COMMAND, "verify", str(sobel)],
        env=os.environ | {"PYTHONPATH": str(ROOT / "python")},
        capture_output=True,
        text=True,
        timeout=100,
    )
    refused(done, "the working folder was deleted")


def test_a_bundle_whose_name_is_no_text(sobel: Path, tmp_path: Path) -> None:
    odd = sobel.rename(tmp_path / "odd\udcff\x1b[31m.chiasm")
    refused(run("verify", odd), "path", "UTF-8")
    (odd / "manifest.json.minisig").write_text("no signature")
    key = base64.b64encode(b"Ed" + bytes(40)).decode()
    refused(run("verify", "--key", key, odd), "manifest.json.minisig", "odd")
    refused(run("verify", "--key", "\xff" * 56, odd), "neither a minisign public key nor a file")
    (tmp_path / "bad.pub").write_text("no key")
    refused(run("verify", "--key", tmp_path / "bad.pub", odd), "bad.pub", "not a minisign public key")


def test_wrong_words() -> None:
    for words in (
        ["nonsense"],
        ["--nonsense"],
        ["export"],
        ["export", "no.such.op"],
        ["export", "filters.sobel", "-f", "tensorflow"],
        ["export", "filters.sobel", "-j", "0"],
        ["run"],
        ["list", "\x1b[31m"],
    ):
        done = run(*words)
        refused(done, status=2)
        assert "\x1b" not in done.stderr


def test_an_empty_output_is_no_folder(sobel: Path, photo: Path) -> None:
    for words in (
        ["export", "filters.sobel", "-o", ""],
        ["pack", "filters", sobel, "-o", ""],
        ["run", sobel, photo, ""],
        ["map", sobel, photo.parent, ""],
        ["triton", "", sobel],
    ):
        refused(run(*words), "expected a path, got an empty text", status=2)


def test_a_backend_that_is_no_text(light: Folder, photo: Path, tmp_path: Path) -> None:
    refused(
        run("run", light("filters.sobel"), photo, tmp_path / "out.png", "-b", "\udcff"), "backend", "UTF-8"
    )


def test_an_error_of_ours_says_how_to_see_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object, **__: object) -> dict:
        raise KeyError("surprise")

    monkeypatch.setattr(cli, "_select", broken)
    result = CliRunner().invoke(main, ["list"])
    assert (
        result.exit_code == 1
        and "internal error: KeyError: 'surprise'" in result.output
        and "CHIASM_TRACEBACK=1" in result.output
    )
    monkeypatch.setenv("CHIASM_TRACEBACK", "1")
    assert isinstance(CliRunner().invoke(main, ["list"]).exception, KeyError)
