"""The programs in examples/: Python and C++ give the same results, which equal OpenCV's or eager
PyTorch's."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
import torch

from chiasm.export import export
from chiasm.export.catalog import catalog

ROOT = Path(__file__).resolve().parents[2]
NAMES = ("edges", "gradient", "own_op", "server", "track", "video")


def python(name: str, *arguments: object) -> str:
    return run(sys.executable, ROOT / "examples" / f"{name}.py", *arguments)


def cpp(name: str, *arguments: object) -> str:
    return run(ROOT / "build" / "release" / "bin" / f"example_{name}", *arguments)


def run(*command: object) -> str:
    environment = os.environ | {"PYTHONPATH": str(ROOT / "python")}
    done = subprocess.run(
        list(map(str, command)), env=environment, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def bundles(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("bundles")

    def made(name: str, methods: tuple[str, ...]) -> Path:
        entry = catalog()[name]
        return export(entry.function(), entry.spec, folder, formats=["onnx"], methods=methods)

    return {
        "pipelines.edges": made("pipelines.edges", ("forward",)),
        "ops.sort_track": made("ops.sort_track", ("forward",)),
        "filters.box_blur": made("filters.box_blur", ("forward", "vjp")),
    }


@pytest.mark.parametrize("name", NAMES)
def test_a_program_is_short_enough_to_copy(name: str) -> None:
    for suffix in (".py", ".cpp"):
        assert len((ROOT / "examples" / f"{name}{suffix}").read_text().splitlines()) < 60
    assert {f"{n}{s}" for n in NAMES for s in (".py", ".cpp")} == {
        f.name for f in (ROOT / "examples").iterdir() if f.suffix in (".py", ".cpp")
    }


def test_edges(bundles: dict[str, Path], tmp_path: Path) -> None:
    y, x = np.mgrid[0:120, 0:160]
    photo = np.stack([(x * 3) % 256, (y * 2) % 256, (x + y) % 256], -1).astype(np.uint8)
    cv2.imwrite(str(tmp_path / "photo.png"), photo)
    for program, out in ((python, "python.png"), (cpp, "cpp.png")):
        program("edges", bundles["pipelines.edges"], tmp_path / "photo.png", tmp_path / out)
    one, other = (cv2.imread(str(tmp_path / f), cv2.IMREAD_UNCHANGED) for f in ("python.png", "cpp.png"))
    np.testing.assert_array_equal(one, other)
    grey = photo.astype(np.float64) @ [0.114, 0.587, 0.299]
    blurred = cv2.GaussianBlur(grey, (5, 5), 1.0)
    wanted = np.hypot(cv2.Sobel(blurred, -1, 1, 0), cv2.Sobel(blurred, -1, 0, 1)).clip(0, 255)
    assert np.abs(one[3:-3, 3:-3] - wanted[3:-3, 3:-3]).max() < 1.0


def test_an_op_of_ones_own(tmp_path: Path) -> None:
    python("own_op", tmp_path, tmp_path / "python.raw")
    cpp("own_op", tmp_path / "my.soft_threshold.chiasm", tmp_path / "cpp.raw")
    one, other = (np.fromfile(tmp_path / f, np.float32) for f in ("python.raw", "cpp.raw"))
    ramp = torch.linspace(-1, 1, 120).reshape(2, 60)
    wanted = 2 * torch.stack([torch.nn.functional.softshrink(r, t) for r, t in zip(ramp, (0.25, 0.5))])
    for found in (one, other):
        np.testing.assert_allclose(found, wanted.flatten(), atol=1e-6)


def test_a_video(bundles: dict[str, Path]) -> None:
    assert (
        int(python("video", bundles["pipelines.edges"], 5))
        == int(cpp("video", bundles["pipelines.edges"], 5))
        > 0
    )


def test_objects_are_followed(bundles: dict[str, Path], tmp_path: Path) -> None:
    """Both squares keep their numbers, and their positions are right within the detector's 8 pixels."""
    out = [tmp_path / "python.png", tmp_path / "cpp.png"]
    one = python("track", bundles["ops.sort_track"], tmp_path, 40, out[0])
    assert one == cpp("track", bundles["ops.sort_track"], tmp_path / "my.squares.chiasm", 40, out[1])
    np.testing.assert_array_equal(*(cv2.imread(str(file)) for file in out))
    tracks = [[int(v) for v in re.findall(r"\d+", line)] for line in one.splitlines()]
    frames = range(2, 40)  # tracks are shown from the third frame on
    assert [track[0] for track in tracks] == [1, 2] * len(frames)
    wanted = [(x, y, x + 64, y + 64) for k in frames for x, y in ((4 * k, 40), (240 - 4 * k, 180))]
    np.testing.assert_allclose([track[1:] for track in tracks], wanted, atol=8)


def test_a_gradient(bundles: dict[str, Path], tmp_path: Path) -> None:
    out = [tmp_path / "python.raw", tmp_path / "cpp.raw"]
    for program, file in zip((python, cpp), out):
        program("gradient", bundles["filters.box_blur"], 200, file)
    one, other = (np.fromfile(file, np.float32).reshape(32, 32) for file in out)
    np.testing.assert_allclose(one, other, atol=1e-4)
    np.testing.assert_allclose(one, _descended(200), atol=1e-3)


def _descended(steps: int) -> np.ndarray:
    """The same descent by PyTorch's own pooling and autograd, in float64."""

    def blur(x: torch.Tensor) -> torch.Tensor:
        return torch.nn.functional.avg_pool2d(torch.nn.functional.pad(x, (2, 2, 2, 2), "reflect"), 5, 1)

    truth = torch.zeros(1, 1, 32, 32, dtype=torch.float64)
    truth[..., 8:24, 12:20] = 1
    blurred = blur(truth)
    guess = blurred.clone().requires_grad_()
    for _ in range(steps):
        (gradient,) = torch.autograd.grad((blur(guess) - blurred).square().sum() / 2, guess)
        guess.data -= 0.5 * gradient
    return guess.detach().numpy()[0, 0]


def test_a_server(bundles: dict[str, Path]) -> None:
    one, other = (p("server", bundles["pipelines.edges"], 24).split() for p in (python, cpp))
    assert one == other and len(set(one)) == 24


@pytest.mark.parametrize("name", NAMES)
def test_a_wrong_call_is_a_usage_line(name: str) -> None:
    program = ROOT / "build" / "release" / "bin" / f"example_{name}"
    done = subprocess.run([program], capture_output=True, text=True, timeout=60)
    assert done.returncode == 2 and done.stderr.startswith(f"usage: {name} ")
    script = ROOT / "examples" / f"{name}.py"
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1 and f"usage: {name}.py " in done.stderr and "Traceback" not in done.stderr
