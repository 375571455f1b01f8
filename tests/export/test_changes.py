"""What a test run takes as changed, and what it draws of the rest (tests/changes.py)."""

import os
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests import changes

Git = Callable[..., None]


@pytest.fixture(autouse=True)
def fresh(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Nothing is known of another tree, before and after each test."""
    cached = [f for f in vars(changes).values() if hasattr(f, "cache_clear")]
    for name in [name for name in os.environ if name.startswith(("CHIASM_BASE", "GIT_"))]:
        monkeypatch.delenv(name)
    for function in cached:
        function.cache_clear()
    yield
    for function in cached:
        function.cache_clear()


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Sources, not yet in a repository."""
    files = {
        "python/chiasm/onnx/merging.py": "",
        "python/chiasm/filters/blur.py": "",
        "tests/export/conftest.py": "",
        "tests/export/scenes.py": "",
        "tests/export/test_merging.py": (
            "import os, chiasm.onnx\nfrom scenes import house\nfrom tests.parity.images import load\n"
        ),
    }
    for name, text in files.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    monkeypatch.setattr(changes, "ROOT", tmp_path.resolve())
    return tmp_path.resolve()


def git_in(folder: Path) -> Git:
    who = ("-c", "user.name=a", "-c", "user.email=a@example.com", "-c", "commit.gpgsign=false")

    def git(*arguments: str) -> None:
        subprocess.run(["git", *who, *arguments], cwd=folder, check=True, capture_output=True)

    return git


@pytest.fixture
def git(tree: Path) -> Git:
    """The sources in a repository of two commits, the second of which changes nothing."""
    git = git_in(tree)
    git("init")
    git("add", ".")
    git("commit", "-m", "first")
    git("commit", "--allow-empty", "-m", "second")
    return git


def test_the_changes_since_the_last_commit(tree: Path, git: Git) -> None:
    assert changes.changed_files() == frozenset()
    changes.known_changes.cache_clear()
    changes.changed_files.cache_clear()
    (tree / "python/chiasm/filters/blur.py").rename(tree / "python/chiasm/filters/a kernel.py")
    (tree / "naïve.md").touch()
    git("add", ".")
    git("commit", "-m", "third")
    (tree / "not yet added.py").touch()
    assert changes.changed_files() == {
        "python/chiasm/filters/blur.py",
        "python/chiasm/filters/a kernel.py",
        "naïve.md",
        "not yet added.py",
    }


def test_a_base_that_is_given(tree: Path, git: Git, monkeypatch: pytest.MonkeyPatch) -> None:
    (tree / "new.py").touch()
    git("add", ".")
    git("commit", "-m", "third")
    git("commit", "--allow-empty", "-m", "fourth")
    monkeypatch.setenv("CHIASM_BASE", "HEAD~2")
    assert changes.changed_files() == {"new.py"}


def test_everything_has_changed_without_a_repository(tree: Path) -> None:
    assert changes.known_changes() is None
    assert "python/chiasm/filters/blur.py" in changes.changed_files()
    assert len(changes.changed_files()) == 5


def test_everything_has_changed_if_the_repository_is_another(tree: Path, tmp_path: Path, git: Git) -> None:
    changes.ROOT = tree / "python"  # the fixture restores it
    assert changes.known_changes() is None
    assert changes.changed_files() == {"chiasm/filters/blur.py", "chiasm/onnx/merging.py"}


@pytest.mark.parametrize("base", ["no-such-commit", "0" * 40])
def test_everything_has_changed_since_a_base_that_is_not_there(
    git: Git, base: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CHIASM_BASE", base)
    assert changes.known_changes() is None
    assert len(changes.changed_files()) == 5


def test_everything_has_changed_in_a_clone_of_one_commit(
    tree: Path, git: Git, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    clone = (tmp_path_factory.mktemp("clone") / "clone").resolve()
    git("clone", "--depth", "1", tree.as_uri(), str(clone))
    monkeypatch.setattr(changes, "ROOT", clone)
    assert changes.known_changes() is None
    assert len(changes.changed_files()) == 5


@pytest.mark.parametrize(
    ("file", "changed"),
    [
        ("python/chiasm/onnx/merging.py", True),
        ("python/chiasm/filters/blur.py", False),
        ("tests/export/conftest.py", True),
        ("tests/export/scenes.py", True),
        ("tests/parity/images.py", True),
        ("tests/parity/sounds.py", False),
    ],
)
def test_a_test_has_changed_with_what_it_imports(tree: Path, git: Git, file: str, changed: bool) -> None:
    (tree / file).parent.mkdir(exist_ok=True)
    (tree / file).write_text("changed = True\n")
    assert changes.has_changed(tree / "tests/export/test_merging.py") == changed


def test_as_many_commits_in_a_row_draw_every_test(tree: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tree / "tests/export/test_merging.py"
    names = [f"test_{i}" for i in range(60)]
    drawn = []
    for turn in range(6):
        monkeypatch.setattr(changes, "turn", lambda turn=turn: turn)
        drawn += [name for name in names if changes.is_drawn(name, file, 6)]
    assert sorted(drawn) == sorted(names)


def test_each_commit_is_a_turn(git: Git) -> None:
    assert changes.turn() == 2
