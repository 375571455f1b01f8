"""The tests that `make test` runs (tests/stages.py)."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests import changes, stages


def test_its_targets_and_their_sources_are_there() -> None:
    made = (stages.ROOT / "Makefile").read_text()
    targets = set(re.findall(r"^([a-z0-9-]+):", made, re.MULTILINE))
    assert targets.issuperset(stages.SOURCES)
    # all tests except those of the whole catalog, those of a part, and those that take hours
    assert {t for t in targets if t.startswith("test-")} - {"test-all", "test-quick"} == {
        t for t in stages.SOURCES if t.startswith("test-")
    }
    for sources in (stages.ALWAYS, *stages.SOURCES.values()):
        assert [s for s in sources if not list(stages.ROOT.glob(f"{s.rstrip('/')}*"))] == []


@pytest.mark.parametrize(
    ("file", "target", "runs"),
    [
        ("runtime/core/json.cpp", "test-fuzz", True),
        ("tests/kernels/calls.h", "test-aarch64", True),
        ("runtime/artifact/kernels/products.h", "test-sanitizers", True),
        ("runtime/artifact/kernels/products.h", "test-serving", False),
        ("python/chiasm/filters/blur.py", "test-fuzz", False),
        ("python/chiasm/filters/blur.py", "test-parity", True),
        ("python/chiasm/filters/blur.py", "other-runtimes", True),
        ("python/chiasm/data/images.py", "test-special-values", False),
        ("docs/design.md", "test-ops", True),
        ("docs/design.md", "test-data", False),
        ("Makefile", "test-fuzz", True),
        ("requirements.txt", "test-browser", True),
        ("python/chiasm/writing.py", "test-data", True),
        ("python/chiasm/writing.py", "test-install", False),
        ("python/chiasm/export/signing.py", "test-serving", True),
        ("python/chiasm/export/signing.py", "test-data", False),
        ("python/chiasm/doctor.py", "test-install", True),
    ],
)
def test_a_target_runs_where_its_sources_have_changed(
    file: str,
    target: str,
    runs: bool,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(stages, "changed_files", lambda: frozenset([file]))
    monkeypatch.setattr(stages, "known_changes", lambda: frozenset([file]))
    monkeypatch.delenv("CHIASM_ALL_TESTS", raising=False)
    stages.main()
    printed = capsys.readouterr()
    assert (target in printed.out.split()) == runs
    assert (f"left out: {target}, since none of" in printed.err) != runs
    monkeypatch.setenv("CHIASM_ALL_TESTS", "1")
    stages.main()
    assert capsys.readouterr().out.split() == list(stages.SOURCES)


def test_every_target_runs_where_git_does_not_know_the_base(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(stages, "changed_files", changes.all_files)
    monkeypatch.setattr(stages, "known_changes", lambda: None)
    monkeypatch.delenv("CHIASM_ALL_TESTS", raising=False)
    stages.main()
    printed = capsys.readouterr()
    assert printed.out.split() == list(stages.SOURCES)
    assert printed.err == "git does not know the base: every file counts as changed\n"


def imports(file: Path) -> Iterator[Path]:
    """The files of chiasm that a file imports when it is imported itself."""
    python = stages.ROOT / "python"
    for node in ast.parse(file.read_text()).body:
        if isinstance(node, ast.ImportFrom):
            folder = file.parents[node.level - 1] if node.level else python
            module = folder / (node.module or "").replace(".", "/")
            for path in (module, *(module / alias.name for alias in node.names)):
                if path.with_suffix(".py").is_file():
                    yield path.with_suffix(".py")


@pytest.mark.parametrize(("package", "target"), [("data", "test-data"), ("triton", "test-serving")])
def test_a_target_runs_where_what_its_package_imports_has_changed(package: str, target: str) -> None:
    found: set[Path] = set()
    following = list((stages.ROOT / "python/chiasm" / package).rglob("*.py"))
    while following:
        file = following.pop()
        if file not in found:
            found.add(file)
            following += imports(file)
    paths = {str(file.relative_to(stages.ROOT)) for file in found}
    assert [p for p in sorted(paths) if not p.startswith(stages.SOURCES[target])] == []
