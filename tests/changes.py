"""Finds what has changed since the base, so that a test run can skip a part of the rest.

    ... | python tests/changes.py 3    of the files named there: what has changed, and every third other one

The base is $CHIASM_BASE, else the commit at which the branch left origin's, else the previous commit.
"""

from __future__ import annotations

import ast
import hashlib
import inspect
import os
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pytest

ROOT = Path(__file__).resolve().parents[1]


def git(*arguments: str) -> str:
    """The output of git; empty if this is not a repository or the revision does not exist."""
    done = subprocess.run(["git", "-C", str(ROOT), *arguments], capture_output=True, text=True)
    return done.stdout.strip() if done.returncode == 0 else ""


@cache
def changed_files() -> frozenset[str]:
    """Paths that differ from the base, including uncommitted changes."""
    base = os.environ.get("CHIASM_BASE") or git("merge-base", "HEAD", "origin/HEAD")
    if not base or base == git("rev-parse", "HEAD"):
        base = "HEAD~1"
    return frozenset(
        git("diff", "--name-only", base).split() + git("ls-files", "--others", "--exclude-standard").split()
    )


@cache
def has_changed(test: Path) -> bool:
    """Whether a file of tests, a file of chiasm that it imports, or a file that its docstring names (or whose
    folder it names) has changed."""
    changed = changed_files()
    if str(test.relative_to(ROOT)) in changed:
        return True
    tree = ast.parse(test.read_text())
    named = ast.get_docstring(tree) or ""
    for file in map(Path, changed):
        if str(file) in named or (len(file.parts) > 2 and str(file.parent) in named):
            return True
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("chiasm"):
            module = "python/" + str(node.module).replace(".", "/")
            if any(file.startswith((f"{module}.py", f"{module}/")) for file in changed):
                return True
    return False


def source_of(function: Callable) -> str:
    """The path of the file that defines a function of chiasm."""
    return str(Path(inspect.getsourcefile(function) or "").resolve().relative_to(ROOT))


@cache
def _text_of(file: Path) -> bytes:
    return file.read_bytes()


def is_drawn(name: str, file: Path, of: int) -> bool:
    """Whether `name` is chosen, as one of ``of`` names. The choice is the same as long as the content of
    `file` is."""
    digest = hashlib.sha256(name.encode() + _text_of(file)).digest()
    return digest[0] % of == 0


def leave_out(
    config: pytest.Config, items: list[pytest.Item], folder: Path, runs: Callable[[pytest.Item], bool]
) -> None:
    """Deselect a folder's tests that do not run, unless all are wanted, or some are asked for by name."""
    asked_for = any("::" in argument for argument in config.args) or config.option.keyword
    if os.environ.get("CHIASM_ALL_TESTS") or asked_for:
        return
    left_out = {item for item in items if folder in item.path.parents and not runs(item)}
    if left_out:
        items[:] = [item for item in items if item not in left_out]
        config.hook.pytest_deselected(items=list(left_out))


if __name__ == "__main__":
    # Prints the files named on standard input that have changed, and one of so many of the others.
    for line in sys.stdin.read().split():
        if (
            os.environ.get("CHIASM_ALL_TESTS")
            or line in changed_files()
            or is_drawn(line, ROOT / line, int(sys.argv[1]))
        ):
            print(line)
