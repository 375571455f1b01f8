"""The C++ that AOTInductor generates, for tests of how ops are compiled."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path

import pytest
from torch.export import ExportedProgram

from chiasm.export import Spec
from chiasm.export.formats.compiler import AT_ONCE, Build
from chiasm.export.formats.native import _inductor
from chiasm.export.isas import LIBRARIES


class _Written(Exception):
    """Ends a compilation once its C++ is generated."""


def written(
    program: ExportedProgram, spec: Spec, monkeypatch: pytest.MonkeyPatch, gradient: bool = False
) -> str:
    """The C++ of a program's loops."""
    sources: list[str] = []

    def start(build: Build, words: list[str], source: str, target: Path) -> None:
        if source.endswith(".kernel.cpp"):
            sources.append(Path(source).read_text())
            raise _Written
        target.touch()

    monkeypatch.setattr(Build, "_start", start)
    with (
        pytest.raises(Exception, match=rf"_Written|{spec.name}"),
        ThreadPoolExecutor(AT_ONCE) as compilers,
        closing(Build(compilers, LIBRARIES / "include")) as build,
    ):
        _inductor(program, spec, "x86-64-v3", {"aot_inductor.link_libtorch": False}, build, gradient)
    assert sources
    return sources[0]
