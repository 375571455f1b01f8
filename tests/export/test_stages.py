"""The tests that `make test` runs (tests/stages.py)."""

import re

import pytest

from tests import stages


def test_its_targets_and_their_sources_are_there() -> None:
    made = (stages.ROOT / "Makefile").read_text()
    targets = set(re.findall(r"^([a-z0-9-]+):", made, re.MULTILINE))
    assert targets.issuperset(stages.SOURCES)
    # all tests except those of the whole catalog, those of a part, and those that take hours
    assert {t for t in targets if t.startswith("test-")} - {"test-all", "test-quick"} == {
        t for t in stages.SOURCES if t.startswith("test-")
    }
    for sources in stages.SOURCES.values():
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
    monkeypatch.delenv("CHIASM_ALL_TESTS", raising=False)
    stages.main()
    printed = capsys.readouterr()
    assert (target in printed.out.split()) == runs
    assert (f"left out: {target}, since none of" in printed.err) != runs
    monkeypatch.setenv("CHIASM_ALL_TESTS", "1")
    stages.main()
    assert capsys.readouterr().out.split() == list(stages.SOURCES)
