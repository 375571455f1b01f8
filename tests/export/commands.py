"""The command `chiasm`, for tests of it."""

import os
import subprocess
import sys
from pathlib import Path

from click.testing import CliRunner

from chiasm.export.cli import main

ROOT = Path(__file__).resolve().parents[2]
COMMAND = [sys.executable, "-m", "chiasm.export"]


def run(*arguments: object) -> subprocess.CompletedProcess[str]:
    """The command in this process."""
    result = CliRunner().invoke(main, [str(a) for a in arguments])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return subprocess.CompletedProcess(arguments, result.exit_code, result.stdout, result.stderr)


def spawn(
    *arguments: object, module: str = "chiasm.export", **options: object
) -> subprocess.CompletedProcess[str]:
    """The command in a separate process."""
    environment = os.environ | {"PYTHONPATH": str(ROOT / "python"), "COLUMNS": "200"}
    return subprocess.run(
        [sys.executable, "-m", module, *map(str, arguments)],
        env=environment,
        stdin=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        timeout=100,
        **{"stdout": subprocess.PIPE} | options,
    )


def refused(done: subprocess.CompletedProcess[str], *parts: str, status: int = 1) -> None:
    """Assert that stderr has one line, which contains these parts."""
    assert done.returncode == status, done.stderr
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 1 and lines[0].startswith("Error: "), done.stderr
    assert "Traceback" not in done.stderr + (done.stdout or "") and "internal error" not in done.stderr
    for part in parts:
        assert part in lines[0], lines[0]
