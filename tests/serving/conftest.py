"""A server for all tests of a file. The client is in a separate environment, which comes after .venv on the
path."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.append(str(next((Path(__file__).resolve().parents[2] / ".deps/triton").glob("lib/*/site-packages"))))

from .server import Server


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    with Server(tmp_path_factory.mktemp("triton"), "--model-control-mode=explicit") as running:
        yield running
