"""The C++ compiler in an export: it compiles only the op, with or without the package's precompiled
headers."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from itertools import accumulate
from pathlib import Path

import pytest
import torch
from torch import Tensor

from chiasm.export import Spec, TensorSpec, example_inputs, export, isas
from chiasm.export.formats import compiler
from chiasm.export.formats.compiler import AT_ONCE, Build
from chiasm.export.formats.native import to_native
from chiasm.export.isas import LIBRARIES
from chiasm.export.manifest import read_manifest
from chiasm.export.tracing.graph import trace
from chiasm.export.tracing.module import bind_spec
from tests.export.conftest import SPEC, scaled_difference

ROOT = Path(__file__).parents[2]


def test_the_first_export_compiles_nothing_but_the_op(tmp_path: Path) -> None:
    log, tools = tmp_path / "log", tmp_path / "bin"
    tools.mkdir()
    real = subprocess.run(["which", "g++"], capture_output=True, text=True, check=True).stdout.strip()
    (tools / "g++").write_text(f'#!/bin/sh\nprintf "%s\\n" "$*" >> {log}\nexec {real} "$@"\n')
    (tools / "g++").chmod(0o755)
    cold = {
        name: str(tmp_path / name) for name in ("HOME", "TMPDIR", "CHIASM_CACHE", "TORCHINDUCTOR_CACHE_DIR")
    }
    for folder in cold.values():
        Path(folder).mkdir()
    environment = (
        os.environ
        | cold
        | {
            "PATH": f"{tools}:{os.environ['PATH']}",
            "PYTHONPATH": f"{ROOT / 'python'}:{ROOT}",
        }
    )
    program = """
import sys
from tests.export.conftest import SPEC, export, scaled_difference
export(scaled_difference, SPEC, sys.argv[1], methods=("forward",))
"""
    subprocess.run(
        [sys.executable, "-W", "ignore", "-c", program, tmp_path / "out"],
        cwd=ROOT,
        env=environment,
        check=True,
        capture_output=True,
    )

    commands = [shlex.split(line) for line in log.read_text().splitlines()]
    files = [
        word.rpartition("/")[2] for words in commands for word in words if word.endswith((".cpp", ".S", ".h"))
    ]
    assert not any("c++-header" in words or "-E" in words for words in commands)
    assert sum("-shared" in words for words in commands) == 1
    assert sorted(
        name for name in files if name not in ("wrapper.h", "kernel.h") and not name.endswith(".weights.S")
    ) == ["kernel.cpp", "signature.cpp", "wrapper.cpp"]
    # with the headers that were built with the package
    assert {words[words.index("-include") + 1] for words in commands if "-include" in words} == {
        str(LIBRARIES / "x86-64-v3" / f"{kind}.h") for kind in ("wrapper", "kernel")
    }
    assert not list((tmp_path / "TMPDIR").rglob("*.gch")), "PyTorch makes none of its own"


def bucket(x: Tensor) -> Tensor:
    """An operator that AOTInductor leaves to libtorch."""
    return torch.bucketize(x[:, 0].contiguous(), x[:, 1].contiguous())


@pytest.mark.parametrize(
    ("fn", "linked"), [(scaled_difference, "native"), (bucket, "torch")], ids=["native", "torch"]
)
def test_no_library_asks_for_an_executable_stack(fn: Callable, linked: str, tmp_path: Path) -> None:
    """glibc 2.41 and later refuse to load one."""
    spec = SPEC if fn is scaled_difference else Spec("test.bucket", [TensorSpec("x", ("N", 3))], gradients=())
    bundle = export(fn, spec, tmp_path, formats=["native"], methods=("forward",))
    listed = read_manifest(bundle)["methods"]["forward"]["artifacts"]
    compiled = [a for a in listed if a["file"].endswith(".pt2")]
    assert {a["backend"] for a in compiled} == {linked}
    for artifact in compiled:
        with zipfile.ZipFile(bundle / artifact["file"]) as archive:
            libraries = [name for name in archive.namelist() if name.endswith(".so")]
            assert libraries
            for name in libraries:
                headers = subprocess.run(
                    ["readelf", "--program-headers", "--wide", archive.extract(name, tmp_path)],
                    capture_output=True,
                    text=True,
                    check=True,
                ).stdout
                [flags] = re.findall(r"GNU_STACK .* (\S+) +0x\w+$", headers, re.MULTILINE)
                assert flags == "RW"


def test_precompiled_headers_change_no_byte(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    taken: list[bool] = []
    fitting = compiler._fitting

    def code(name: str, headers: bool) -> bytes:
        monkeypatch.setenv("CHIASM_CACHE", str(tmp_path / name))
        monkeypatch.setattr(
            compiler,
            "_fitting",
            lambda *of: taken.append(bool(found := fitting(*of) if headers else None)) or found,
        )
        op = bind_spec(scaled_difference, SPEC)
        program = trace(
            op,
            SPEC,
            list(SPEC.inputs),
            example_inputs.make(SPEC, example_inputs.fit(SPEC, example_inputs.EXAMPLE), "float32"),
            "native",
        )
        with (
            ThreadPoolExecutor(AT_ONCE) as compilers,
            closing(to_native(lambda target: program, SPEC, "x86-64-v3", "chiasm 1\n", compilers)) as made,
        ):
            return made.artifact().data

    assert code("with", True) == code("without", False)
    assert taken == [True, True, False, False]


def test_a_precompiled_header_that_does_not_fit_is_left_alone(tmp_path: Path) -> None:
    header, made, listing = tmp_path / "kernel.h", tmp_path / "kernel.h.gch", tmp_path / "kernel.h.gch.d"
    part = tmp_path / "part.h"
    flags = ["g++", "-O3", "-Isome folder"]

    def fits(of: list[str]) -> bool:
        return compiler._fitting(tmp_path, "kernel", of) == header

    assert not fits(flags), "there is none"
    header.write_text(compiler._text("kernel", flags))
    part.write_text("")
    listing.write_text(f"{made}: {header} \\\n {part}\n")
    assert not fits(flags), "only its text is there"
    made.write_bytes(b"")
    os.utime(made, ns=(part.stat().st_mtime_ns + 10**9,) * 2)
    assert fits(flags)
    assert not fits(["g++", "-O2", "-Isome folder"]), "made by another command"
    os.utime(part, ns=(made.stat().st_mtime_ns + 1,) * 2)
    assert not fits(flags), "one of its headers is newer"
    part.unlink()
    assert not fits(flags), "one of its headers is gone"


def test_an_export_that_ends_early_leaves_no_compiler_at_work(tmp_path: Path) -> None:
    source = tmp_path / "op.kernel.cpp"
    source.write_text("")
    slow = tmp_path / "slow"
    slow.write_text("#!/bin/sh\nexec sleep 1000\n")
    slow.chmod(0o755)
    with ThreadPoolExecutor(1) as compilers:
        build = Build(compilers)
        for name in ("op", "next"):
            build.run(f"{slow} {source} -c -o {tmp_path / name}.o", str(tmp_path))
        while not build._running:
            time.sleep(0.01)
        (process,) = build._running
        assert process.poll() is None and (tmp_path / "next.o").exists()
        build.close()
        assert process.poll() is not None and not build.folder.exists()
        assert build._running == [process], "the next one was not started"


def test_an_export_runs_two_compilers_at_once(tmp_path: Path) -> None:
    log, source, tool = tmp_path / "log", tmp_path / "op.kernel.cpp", tmp_path / "tool"
    source.write_text("")
    tool.write_text(
        f"""#!/bin/sh
echo 1 >> {log}
for word; do last=$word; done
sleep 0.1
[ "$1" = -shared ] && ls op.o other.o > library.so
touch "$last"
echo -1 >> {log}
"""
    )
    tool.chmod(0o755)
    with ThreadPoolExecutor(AT_ONCE) as compilers:
        builds = [Build(compilers) for _ in range(4)]
        for build in builds:
            for name in ("op", "other"):
                source.rename(source := tmp_path / f"x.{name}.cpp")
                build.run(f"{tool} {source} -c -o {tmp_path / name}.o", str(tmp_path))
            objects = f"{tmp_path / 'op'}.o {tmp_path / 'other'}.o"
            build.run(f"{tool} -shared {objects} -o {tmp_path / 'op'}.so", str(tmp_path))
        for build in builds:
            assert build.library() == b"op.o\nother.o\n", "it is linked when its objects are there"
            build.close()
    running = list(accumulate(map(int, log.read_text().split())))
    assert len(running) == 24 and max(running) == 2


def test_the_compiler_leaves_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Inductor's own files grew with each export of the same op, until it was compiled as a large one is."""
    monkeypatch.setenv("TORCHINDUCTOR_CACHE_DIR", str(tmp_path / "inductor"))
    monkeypatch.setenv("CHIASM_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    (tmp_path / "temporary").mkdir()
    export(scaled_difference, SPEC, tmp_path, formats=("native",), methods=("forward",))
    assert not (tmp_path / "inductor").exists()
    assert not list((tmp_path / "temporary").iterdir())


def test_a_variable_of_pytorch_switches_no_checks_on(tmp_path: Path) -> None:
    """They rejected what the spec allows: the batch of 1."""
    bundle = export(scaled_difference, SPEC, tmp_path, formats=("native",), methods=("forward",))
    program = """
import sys, numpy, chiasm.runtime
run = chiasm.runtime.open(sys.argv[1]).method("forward", backend="native")
print(run(numpy.ones((1, 1, 4, 4), "float32"), numpy.ones(1, "float32")).shape)
"""
    done = subprocess.run(
        [sys.executable, "-c", program, bundle],
        env=os.environ | {"AOTI_RUNTIME_CHECK_INPUTS": "1", "PYTHONPATH": str(ROOT / "python")},
        capture_output=True,
        text=True,
    )
    assert (done.stdout, done.stderr) == ("(1, 1, 3, 4)\n", "")


def test_a_package_in_a_folder_with_a_space(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "site packages"
    folder.symlink_to(LIBRARIES)
    monkeypatch.setattr(isas, "LIBRARIES", folder)
    monkeypatch.setenv("CHIASM_CACHE", str(tmp_path / "cache"))
    bundle = export(scaled_difference, SPEC, tmp_path, formats=("native",), methods=("forward",))
    [artifact] = read_manifest(bundle)["methods"]["forward"]["artifacts"]
    assert artifact["backend"] == "native"
