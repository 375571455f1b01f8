"""The examples in docs/triton.md run as written, on the ports of this server."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from .server import ROOT, Server, site_packages
from .test_repository import network

PAGE = (ROOT / "docs" / "triton.md").read_text()


def blocks(language: str) -> list[str]:
    found = re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)
    assert found, f"docs/triton.md shows no {language}"
    return found


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """A server of the repository that the page's commands make."""
    folder = tmp_path_factory.mktemp("page")
    (folder / "bundles").symlink_to(ROOT / "build" / "bundles")
    network(folder / "network.onnx")
    commands = [line for block in blocks("sh") for line in block.splitlines() if line.startswith("chiasm ")]
    assert len(commands) == 2
    for command in commands:
        words = [sys.executable, "-m", "chiasm.export", *command.split()[1:]]
        subprocess.run(words, cwd=folder, check=True, stdout=subprocess.DEVNULL)
    with Server(folder) as running:
        yield running


def test_everything_is_served(served: Server) -> None:
    states = {m["name"]: m["state"] for m in served.http.get_model_repository_index()}
    assert states == dict.fromkeys(("edges", "sobel", "prepare", "network", "classify"), "READY")


def test_clients(served: Server, tmp_path: Path) -> None:
    said = ["(480, 640)", "[8, 8]"]
    for code, expected in zip(blocks("python"), said, strict=True):
        code = code.replace("localhost:8001", f"127.0.0.1:{served.grpc_port}")
        code = code.replace("localhost:8000", f"127.0.0.1:{served.http_port}")
        script = tmp_path / "client.py"
        script.write_text(f"import sys\nsys.path.append({str(site_packages())!r})\n{code}")
        done = subprocess.run([sys.executable, script], capture_output=True, text=True)
        assert done.stdout.strip() == expected, done.stderr


def test_configurations(server: Server) -> None:
    count = 0
    for block in blocks("protobuf"):
        if block.startswith("# not run here"):
            continue
        named = re.match(r"# models/(\w+)/config.pbtxt of ([\w.]+)\n", block)
        assert named, block
        lines = [line for line in block.splitlines() if not line.startswith(("#", "backend"))]
        server.serve(named[1], named[2], config="\n".join(lines))
        count += 1
    assert count == 2


def test_metrics(served: Server) -> None:
    [line] = re.findall(r"^chiasm_model_info\{.*$", PAGE, re.MULTILINE)
    assert line in served.metrics().splitlines()
