"""The examples in docs/onnx.md and in the docstrings of chiasm.onnx run as written; those that need the
plug-in are marked."""

import doctest
import importlib
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import onnx
import pytest

from chiasm.export import onnx_function, sizes

from .test_onnx_merging import classifier, detector

ROOT = Path(__file__).resolve().parents[2]
BLOCKS = [
    b
    for b in re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "onnx.md").read_text(), re.DOTALL)
    if "needs the plug-in" not in b
]
PRINTED = (
    "(1, 3, 480, 640)",
    "",
    "['frame'] ['scores', 'labels', 'found', 'boxes_out']",
    "['pipelines_preprocess', 'Conv', 'Relu']",
)


@pytest.fixture
def bundles(light: Callable[[str], Path]) -> Path:
    """The folder that holds the bundles of the examples."""
    for name in (
        "filters.sobel",
        "pipelines.letterbox",
        "ops.decode_yolov8",
        "geometry.bbox.transform_bbox.xyxy",
    ):
        light(name)
    return light("pipelines.preprocess").parent


@pytest.mark.parametrize("index", range(len(PRINTED)))
def test_the_documents_examples(bundles: Path, index: int, tmp_path: Path) -> None:
    assert len(BLOCKS) == len(PRINTED)
    (tmp_path / "bundles").symlink_to(bundles)
    onnx.save(classifier(13, 7), tmp_path / "classifier.onnx")
    onnx.save(detector(), tmp_path / "detector.onnx")
    (tmp_path / "example.py").write_text(BLOCKS[index])
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "example.py"], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.strip() == PRINTED[index]


@pytest.mark.parametrize("name", ["onnx", "onnx.merging", "onnx.network", "onnx.plugin", "onnx.sessions"])
def test_docstrings(bundles: Path, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "build").mkdir()
    (tmp_path / "build" / "bundles").symlink_to(bundles)
    monkeypatch.chdir(tmp_path)
    result = doctest.testmod(importlib.import_module(f"chiasm.{name}"))
    assert result.attempted > 1 and result.failed == 0


def test_docstrings_of_the_exporters_part() -> None:
    result = doctest.testmod(onnx_function)
    assert result.attempted == 2 and result.failed == 0


def test_docstrings_of_sizes() -> None:
    result = doctest.testmod(sizes)
    assert result.attempted == 1 and result.failed == 0
