"""README.md: its examples run as written."""

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
