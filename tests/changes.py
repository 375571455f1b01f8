"""Finds what has changed since the base, so that a test run can skip a part of the rest.

    ... | python tests/changes.py 3    of the files named there: what has changed, and every third other one

The base is $CHIASM_BASE, else the commit at which the branch left origin's, else the previous commit. Where
git does not know it (a clone of one commit, a wrong name, no repository), every file counts as changed.
"""

from __future__ import annotations

import ast
import hashlib
import inspect
import os
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pytest

ROOT = Path(__file__).resolve().parents[1]
#: Folders that have no sources.
APART = frozenset((".git", ".deps", ".venv", "build", "dist", "__pycache__"))


class GitError(Exception):
    """git is not there, or its command failed."""


def git(*arguments: str) -> str:
    """The output of git."""
    try:
        done = subprocess.run(
            ["git", "-C", str(ROOT), *arguments], capture_output=True, text=True, errors="surrogateescape"
        )
    except OSError as error:
        raise GitError(str(error)) from error
    if done.returncode:
        raise GitError(done.stderr.strip())
    return done.stdout


def base() -> str:
    """The revision to compare with; git may not know it."""
    head = git("rev-parse", "HEAD").strip()
    named = os.environ.get("CHIASM_BASE")
    if named:
        named = git("rev-parse", "--verify", f"{named}^{{commit}}").strip()
    else:
        with suppress(GitError):
            named = git("merge-base", "HEAD", "origin/HEAD").strip()
    return named if named and named != head else "HEAD~1"


@cache
def known_changes() -> frozenset[str] | None:
    """Paths that differ from the base, including uncommitted changes; None if git cannot tell."""
    try:
        if Path(git("rev-parse", "--show-toplevel").rstrip("\n")).resolve() != ROOT:
            return None  # copied into another repository
        changed = git("diff", "--name-only", "--no-renames", "-z", base(), "--")
        added = git("ls-files", "--others", "--exclude-standard", "-z")
    except GitError:
        return None
    return frozenset(f"{changed}{added}".split("\0")) - {""}


@cache
def all_files() -> frozenset[str]:
    found = []
    for folder, folders, files in os.walk(ROOT):
        folders[:] = [name for name in folders if name not in APART]
        found += [str((Path(folder) / name).relative_to(ROOT)) for name in files]
    return frozenset(found)


@cache
def changed_files() -> frozenset[str]:
    """Paths that differ from the base, including uncommitted changes; all if git cannot tell."""
    known = known_changes()
    return all_files() if known is None else known


def imported(tree: ast.AST) -> set[str]:
    """The modules that a file names in its imports, and what it takes from them: a module too, perhaps."""
    modules = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            modules |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            modules |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return modules - {"tests"}


@cache
def has_changed(test: Path) -> bool:
    """Whether a file of tests, a file of chiasm or of the tests that it imports, its folder's conftest.py, or
    a file that its docstring names (or whose folder it names) has changed. An import of a package is one of
    all files in it."""
    changed = changed_files()
    if str(test.relative_to(ROOT)) in changed:
        return True
    tree = ast.parse(test.read_text())
    named = ast.get_docstring(tree) or ""
    for file in map(Path, changed):
        if str(file) in named or (len(file.parts) > 2 and str(file.parent) in named):
            return True
    roots = {"chiasm": ROOT / "python", "tests": ROOT}
    for module in {*imported(tree), "conftest"}:
        folder = roots.get(module.partition(".")[0], test.parent)
        path = str((folder / module.replace(".", "/")).relative_to(ROOT))
        if any(file.startswith((f"{path}.py", f"{path}/")) for file in changed):
            return True
    return False


def source_of(function: Callable) -> str:
    """The path of the file that defines a function of chiasm."""
    return str(Path(inspect.getsourcefile(function) or "").resolve().relative_to(ROOT))


@cache
def _text_of(file: Path) -> bytes:
    return file.read_bytes()


@cache
def turn() -> int:
    """The number of commits so far: each commit draws other tests, and ``of`` of them in a row draw all."""
    try:
        return int(git("rev-list", "--count", "HEAD"))
    except GitError:
        return 0


def is_drawn(name: str, file: Path, of: int) -> bool:
    """Whether `name` is chosen, as one of ``of`` names. The content of `file` and the number of commits
    decide."""
    digest = hashlib.sha256(name.encode() + _text_of(file)).digest()
    return (int.from_bytes(digest[:8], "big") + turn()) % of == 0


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
    for line in sys.stdin.read().splitlines():
        if (
            os.environ.get("CHIASM_ALL_TESTS")
            or line in changed_files()
            or is_drawn(line, ROOT / line, int(sys.argv[1]))
        ):
            print(line)
