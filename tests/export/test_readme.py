"""README.md: its examples run as written, and its numbers are those of docs/benchmarks.md."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def blocks(language: str) -> list[str]:
    found = re.findall(rf"```{language}\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    assert found, f"the README shows no {language}"
    return found


#: What the README calls the ops whose speed it gives.
MEASURED = {
    "Sobel": "filters.sobel",
    "Gaussian": "filters.gaussian_blur2d",
    "bilinear resize": "geometry.transform.resize.bilinear",
    "perspective warp": "geometry.transform.warp_perspective.bilinear_zeros",
    "dilation": "morphology.dilation",
    "median": "filters.median_blur",
    "grey": "color.rgb_to_grayscale",
    "HSV": "color.rgb_to_hsv",
}


def test_speeds() -> None:
    text = " ".join((ROOT / "README.md").read_text().split())
    page = (ROOT / "docs" / "benchmarks.md").read_text()
    stated = re.findall(
        r"([A-Za-z ]+) ([\d.]+)(?: times as fast as OpenCV)?[,.] ", text.split("slower): ")[1]
    )
    measured = {}
    for name, bundle in MEASURED.items():
        row = re.search(rf"^\| {bundle} \| 1x1080x1920 \| 1 \|(.*)$", page, re.MULTILINE)
        assert row is not None, bundle
        measured[name] = f"{float(row[1].split('|')[3].strip(' *')):.1f}"
    assert {name.strip(): number for name, number in stated[: len(MEASURED)]} == measured


@pytest.mark.parametrize("index", range(2))
def test_python(index: int, tmp_path: Path) -> None:
    script = tmp_path / "example.py"
    script.write_text(blocks("python")[index])
    done = subprocess.run(
        [sys.executable, "-W", "ignore", script], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr[-2000:]
    if index == 0:
        assert "torch.Size([1, 3, 480, 640]) native" in done.stdout
    assert list((tmp_path / "bundles").glob("my.*.chiasm/manifest.json"))


def test_native_code_inside_onnx_runtime(tmp_path: Path) -> None:
    script = tmp_path / "example.py"
    script.write_text(blocks("python")[0] + "\n" + blocks("python")[2])
    done = subprocess.run(
        [sys.executable, "-W", "ignore", script], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.endswith("(1, 3, 480, 640)\n") and "standard operators" not in done.stderr


def test_cpp(tmp_path: Path) -> None:
    (tmp_path / "bundles").symlink_to(ROOT / "build" / "bundles")
    (tmp_path / "main.cpp").write_text(blocks("cpp")[0])
    library = ROOT / "build" / "release" / "lib"
    command = [
        "g++",
        "-std=c++17",
        "-Wall",
        "-Werror",
        f"-I{ROOT / 'include'}",
        "main.cpp",
        f"-L{library}",
        "-lchiasm",
        f"-Wl,-rpath,{library}",
        "-o",
        "main",
    ]
    subprocess.run(command, cwd=tmp_path, check=True)
    subprocess.run(["./main"], cwd=tmp_path, check=True)
