"""The example `batch` at a small size: all contenders do the same work, times and memory are right, the C++
program, the page."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import chiasm.runtime
from bench.images.ops import Agreement
from bench.machine import ROOT
from studies import use_cases
from studies.batch import in_cpp, memory
from studies.batch.measure import Disagreement, agreement, check, measure
from studies.batch.ours import FLAT, NATIVE
from studies.batch.page import Measured, aim, section, standing, table
from studies.batch.plot import log_log
from studies.batch.race import race
from studies.batch.settings import SMALL
from studies.batch.ways import Images, Ready, Setup, Way, photographs
from studies.batch.works import WORKS, export_bundle

KORNIA = (ROOT / ".deps" / "kornia" / "kornia").exists()


@pytest.fixture(scope="module")
def setup(tmp_path_factory: pytest.TempPathFactory) -> Setup:
    folder = tmp_path_factory.mktemp("batch")
    for work in WORKS:
        export_bundle(work, SMALL, folder)
    return Setup(SMALL, folder, chiasm.runtime.get_num_threads() or 1)


def names(work: str) -> list[str]:
    """The contenders that can run here, except those that compile for minutes."""
    return [
        n
        for n in WORKS[work].ways
        if n != "Kornia, torch.compile" and (KORNIA or not n.lower().startswith("kornia"))
    ]


@pytest.mark.parametrize("work", WORKS)
def test_contenders_do_the_same_work(setup: Setup, work: str) -> None:
    found = check(work, setup, names(work))
    assert {"OpenCV", FLAT, NATIVE} <= set(found)
    assert found["OpenCV"]["most"] > 0  # it does not equal chiasm's own result


def test_other_work_is_found() -> None:
    expected = np.random.default_rng(1).random((2, 3, 8, 9))
    assert agreement(Agreement(0.11), expected + 0.1, expected)["most"] == pytest.approx(0.1)
    with pytest.raises(Disagreement, match=r"0\.00% of the values"):
        agreement(Agreement(0.09), expected + 0.1, expected)
    with pytest.raises(Disagreement, match="shape"):
        agreement(Agreement(1), expected[:1], expected)
    framed = expected.copy()
    framed[..., 0] = 7
    assert agreement(Agreement(0, edge=1), framed, expected)["most"] == 0


def test_photographs_in_all_forms() -> None:
    images = Images(photographs(7, SMALL.size))
    assert images.pixels.shape == (7, 3, *SMALL.size)
    assert (images.pixels[0] == images.pixels[6]).all()
    assert images.pixels[1].std() > 20
    assert (images.frames[2][..., 2] == images.pixels[2, 0]).all()
    assert (images.stacked_frames[2] == images.frames[2]).all()
    np.testing.assert_allclose(images.matrices[3][..., 1] * 255, images.pixels[3, 1], atol=1e-4)
    assert images.bytes() == images.pixels.size * (1 + 1 + 4 + 4)


def test_race_is_in_turns_and_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    order: list[str] = []
    now = 0.0  # a clock of the test's own, because sleep takes longer on a busy machine
    monkeypatch.setattr("studies.batch.race.time", SimpleNamespace(perf_counter=lambda: now))

    def contender(name: str, seconds: float):
        def call() -> None:
            nonlocal now
            order.append(name)
            now += seconds

        return call

    times = race(
        {"slow": contender("slow", 0.03), "fast": contender("fast", 0.001)},
        repeats=12,
        seconds=0.05,
        turns=4,
        pause=False,
    )
    assert (times["slow"].repeats, times["fast"].repeats) == (3, 12)
    assert (times["slow"].ms, times["fast"].ms) == (pytest.approx(30), pytest.approx(1))
    slow = [i for i, name in enumerate(order) if name == "slow"]
    assert order[slow[-1] - 1] == "fast" and order[slow[-2] - 1] == "fast"


def test_rows_of_a_race(setup: Setup) -> None:
    rows = list(measure("sobel", setup, [FLAT, NATIVE, "OpenCV"]))
    assert set(rows[0]["agreement"]) == {FLAT, NATIVE, "OpenCV"}
    assert [row["batch"] for row in rows[1:]] == list(SMALL.batches)
    assert all(
        t["ms"] > 0 and 3 <= t["repeats"] <= SMALL.repeats for row in rows[1:] for t in row["times"].values()
    )


def test_memory_is_the_peak_of_a_call(setup: Setup, monkeypatch: pytest.MonkeyPatch) -> None:
    def make(images: Images, setup: Setup) -> Ready:
        def call() -> np.ndarray:  # 8 MB of results per image, and temporarily 16 more
            between = [np.ones(2 << 20) for _ in range(len(images))]
            return np.stack([b[: 1 << 20] for b in between])

        assert len(images.floats) == len(images)
        return Ready(call, lambda made: made)

    monkeypatch.setitem(WORKS, "made up", replace(WORKS["sobel"], ways={"hungry": Way(make, Agreement())}))
    assert memory.measure("made up", "hungry", setup) == pytest.approx(24, rel=0.15)


@pytest.mark.skipif(not in_cpp.PROGRAM.exists(), reason="no release build")
class TestTwin:
    @pytest.fixture(scope="class")
    def settings(self, setup: Setup, tmp_path_factory: pytest.TempPathFactory) -> Path:
        return in_cpp.write_settings(setup, tmp_path_factory.mktemp("in_cpp"))

    @pytest.mark.parametrize("work", WORKS)
    def test_makes_what_python_makes(self, setup: Setup, settings: Path, work: str) -> None:
        found, version = in_cpp.check(work, setup, settings)
        assert found[in_cpp.CHIASM]["most"] <= WORKS[work].ways[NATIVE].agrees.tolerance
        assert found[in_cpp.OPENCV]["most"] > 0 and version.count(".") == 2

    def test_races(self, settings: Path) -> None:
        rows = list(in_cpp.race("sobel", 1, settings))
        assert [row["batch"] for row in rows] == list(SMALL.batches)
        assert all(set(row["times"]) == {in_cpp.CHIASM, in_cpp.OPENCV} for row in rows)

    def test_measures_memory(self, settings: Path) -> None:
        height, width = SMALL.size
        results = 3 * height * width * 4 / 2**20
        assert all(results / 2 < mb < 20 * results for mb in in_cpp.memory("sobel", settings).values())

    def test_says_what_is_wrong(self, settings: Path) -> None:
        with pytest.raises(RuntimeError, match="there is no work blur"):
            list(in_cpp.race("blur", 1, settings))
        with pytest.raises(RuntimeError, match="cannot read"):
            list(in_cpp.program("results", settings.with_name("none.json"), "sobel"))


def made_up(opencv: float) -> Measured:
    """Native code takes 1 ms per image, OpenCV in Python `opencv` ms, in C++ 5 ms."""
    measured = Measured()
    for work in WORKS:
        measured.add(
            {
                "work": work,
                "threads": 1,
                "agreement": {"OpenCV": {"mean": 1e-5, "most": 1e-3, "note": "rounds"}},
            }
        )
        for batch in (1, 4):
            ms = {NATIVE: 1.0, "OpenCV": opencv, "Kornia": 7.0, in_cpp.CHIASM: 1.0, in_cpp.OPENCV: 5.0}
            row = {
                "work": work,
                "threads": 1,
                "batch": batch,
                "times": {n: {"ms": t * batch, "repeats": 500} for n, t in ms.items()},
            }
            measured.add(row)
    return measured


def test_page_says_who_is_ahead() -> None:
    assert "is 2.00 to 2.00 times as fast as the fastest peer: ahead at every batch size" in standing(
        made_up(2.0), "sobel", 1
    )
    assert "**behind** at 1 (OpenCV, 0.50), 4 (OpenCV, 0.50)" in standing(made_up(0.5), "sobel", 1)
    assert "3.50 times OpenCV (reached); 5.00 times OpenCV, C++ (reached)" in aim(made_up(3.5), "prepare", 1)
    assert "1.50 times OpenCV (**not reached**, 2.0 times short of it)" in aim(made_up(1.5), "prepare", 1)
    lines = table(made_up(0.5), "sobel", 1, 500)
    assert lines[2] == "| Kornia | 7 | 7 |  |" and "| OpenCV | **0.5** | **0.5** |  |" in lines


def test_section_is_published(tmp_path: Path) -> None:
    page = tmp_path / "use_cases.md"
    use_cases.publish("batch", section(made_up(2.0), SMALL, [1], {"chiasm": "1"}, 5.0), page)
    text = page.read_text()
    assert all(f"### {work.title}" in text for work in WORKS.values())
    assert text.count("The aim is 3 times OpenCV") == 1


def test_plot_is_logarithmic_in_both() -> None:
    chart = np.asarray(
        log_log({"line": [(1, 1), (10, 10), (100, 100)]}, ["line"], "title", ("x", "y"), (500, 300))
    ).astype(int)
    area = chart[40:265, 50:305]  # inside the axes, without the names
    ys, xs = np.nonzero(np.ptp(area, axis=2) > 60)
    slope, offset = np.polyfit(xs, ys, 1)
    assert slope < 0 and np.abs(slope * xs + offset - ys).max() < 5
