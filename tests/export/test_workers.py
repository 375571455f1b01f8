"""Several ops are exported at once, and what happens to the others if a process is killed."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from chiasm.export import ExportError, workers
from chiasm.export.workers import Wanted, export_all

from .commands import COMMAND, ROOT


def pretend(op: Wanted, output: Path) -> float:
    """In place of `export_entry`, in a worker: leaves what an export leaves that is killed or not."""
    if op.name == "killed":
        (output / f".writing-{os.getpid()}-x" / "new").mkdir(parents=True)
        subprocess.Popen(["sleep", "1000"])  # a compiler
        os.kill(os.getpid(), signal.SIGKILL)
    if op.name == "exits":
        raise SystemExit("no more")
    time.sleep(0.2)
    (output / op.name).touch()
    return 0.2


def test_a_killed_worker_fails_its_op_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workers, "export_entry", pretend)
    names = ["one", "killed", "two", "exits", "three", "four"]
    with pytest.raises(ExportError) as failed:
        export_all([Wanted(name) for name in names], tmp_path, jobs=2)
    assert str(failed.value).startswith("2 of 6 ops failed: ")
    assert "killed: the process that exported it was killed" in str(failed.value)
    assert "exits: SystemExit: no more" in str(failed.value)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["four", "one", "three", "two"]
    assert "sleep 1000" not in subprocess.run(["ps", "-eo", "args"], capture_output=True, text=True).stdout


def test_a_worker_that_the_system_kills_is_replaced(tmp_path: Path) -> None:
    names = ["color.rgb_to_bgr", "color.bgr_to_rgb", "color.rgb_to_xyz", "color.xyz_to_rgb"]
    process = subprocess.Popen(
        [*COMMAND, "export", *names, "-f", "onnx", "-o", str(tmp_path), "-j", "2"],
        env=os.environ | {"PYTHONPATH": str(ROOT / "python")},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    deadline = time.monotonic() + 100
    while not list(tmp_path.iterdir()) and time.monotonic() < deadline:  # the first writes
        time.sleep(0.01)
    for child in Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split():
        if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes():
            os.kill(int(child), signal.SIGKILL)
            break
    _, stderr = process.communicate(timeout=200)
    assert process.returncode == 0, stderr
    assert sorted(f.name for f in tmp_path.iterdir()) == sorted(f"{name}.chiasm" for name in names)


def test_workers_end_with_their_parent(tmp_path: Path) -> None:
    """The processes that run artifacts too."""
    program = (
        "import os, sys; from chiasm.export.checks import trial; trial.prepare();"
        "print(trial._Process._kept._process.pid, flush=True); os.kill(os.getpid(), 9)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        env=os.environ | {"PYTHONPATH": str(ROOT / "python")},
        capture_output=True,
        text=True,
        timeout=100,
    )
    child = Path(f"/proc/{int(done.stdout)}")
    deadline = time.monotonic() + 20
    while child.exists() and "trial" in (child / "cmdline").read_text() and time.monotonic() < deadline:
        time.sleep(0.05)
    assert time.monotonic() < deadline
