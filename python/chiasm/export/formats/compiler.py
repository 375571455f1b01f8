"""Runs the C++ compiler in parallel with Python, with headers that were precompiled with the package."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from concurrent.futures import Executor, Future, wait
from pathlib import Path
from threading import Lock

import torch

#: The first header that Inductor's code includes, for each of the two files that it writes.
HEADERS = {"wrapper": "torch/csrc/inductor/aoti_include/cpu.h", "kernel": "torch/csrc/inductor/cpp_prefix.h"}
#: How many compilers an export runs at once: Inductor writes two files for each method.
AT_ONCE = 2
#: Bytes of C++ above which -O3 takes four times as long as -O2: thousands of lines of arithmetic, with no
#: loop in them to unroll.
_LARGE = 150_000


class Build:
    """Builds the library of an Inductor package from the commands that Inductor passes to `run`. `run` gives
    them to `compilers` without waiting; `library` waits.

    Args:
        compilers: runs compilers and linkers, in the order of its submissions; shared by the builds of an
            export, so that their number does not grow with the number of methods.
        include: headers that go before the compiler's own.
        precompiled: a folder of headers from `precompile`, perhaps for other settings.
        objects: object files that are linked too.
        dropped: words that are removed from the linker's command.
        at_once: when Inductor links, it gets the library; otherwise it gets an empty file, and goes on.
    """

    def __init__(
        self,
        compilers: Executor,
        include: Path | None = None,
        precompiled: Path | None = None,
        objects: Sequence[Path] = (),
        dropped: Sequence[str] = (),
        at_once: bool = False,
    ) -> None:
        self.compilers, self.include, self.precompiled = compilers, include, precompiled
        self.objects, self.dropped, self.at_once = list(map(str, objects)), dropped, at_once
        self._scratch = tempfile.TemporaryDirectory()
        self.folder = Path(self._scratch.name)
        self._compilations: list[Future[None]] = []
        # Read here, because a thread would read it while Python changes it
        self._environment = os.environ | _environment(include)
        self._lock = Lock()  # of the two below
        self._running: list[subprocess.Popen[bytes]] = []
        self._closed = False
        self._made: dict[str, str] = {}  # Inductor's object files, and ours
        self._linking: Future[None] | None = None

    def run(self, command: str, cwd: str) -> None:
        """In place of Inductor's `run_compile_cmd`."""
        words = shlex.split(command)
        target = Path(words[words.index("-o") + 1])
        sources = [word for word in words if word.endswith(".cpp")]
        if "-shared" in words:
            kept = [word for word in words if word not in self.dropped]
            # glibc 2.41 does not load a library that requires an executable stack, which is the default of
            # assembly, such as that of Inductor's constants.
            given = [self._made.get(word) or self._kept(word) for word in kept]
            link = [*given, *self.objects, "-Wl,-z,noexecstack"]
            link[link.index(str(target))] = "library.so"
            self._linking = self.compilers.submit(self._link, link)
            target.write_bytes(self.library() if self.at_once else b"")
        elif sources:
            self._start(words, sources[0], target)
        else:
            done = subprocess.run(words, cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            _check(words, done.returncode, done.stdout)

    def _start(self, words: list[str], source: str, target: Path) -> None:
        """Compile in a folder of ours, where files have the same names in every export: error messages in the
        code contain them."""
        kind = source.split(".")[-2]
        shutil.copy(source, self.folder / f"{kind}.cpp")
        flags = _flags(words, source)
        if kind == "kernel" and os.path.getsize(source) > _LARGE:
            flags = ["-O2" if flag == "-O3" else flag for flag in flags]
        header = self.precompiled and _fitting(self.precompiled, kind, flags)
        command = [
            *flags,
            *(["-include", str(header)] if header else []),
            "-c",
            f"{kind}.cpp",
            "-o",
            f"{kind}.o",
        ]
        self._compilations.append(self.compilers.submit(self._execute, command, kind))
        self._made[str(target)] = f"{kind}.o"
        target.touch()  # Inductor removes it

    def _link(self, command: list[str]) -> None:
        for compilation in self._compilations:  # which were submitted before, so this ends
            compilation.result()
        self._execute(command, "library")

    def _execute(self, command: list[str], name: str) -> None:
        """Run a compiler or a linker, in a thread of `compilers`."""
        log_file = self.folder / f"{name}.log"
        with self._lock, open(log_file, "wb") as log:
            if self._closed:
                return
            process = subprocess.Popen(
                command,
                cwd=self.folder,
                env=self._environment,
                stdout=log,
                stderr=subprocess.STDOUT,
            )
            self._running.append(process)
        process.wait()
        _check(command, process.returncode, log_file.read_bytes())

    def _kept(self, word: str) -> str:
        """A word of the linker's command. For an object file, a copy, because Inductor will remove the
        file."""
        return str(shutil.copy(word, self.folder)) if word.endswith(".o") else word

    def library(self) -> bytes:
        """The linked library."""
        assert self._linking is not None
        self._linking.result()
        return (self.folder / "library.so").read_bytes()

    def close(self) -> None:
        """Stop running compilers, and remove their files."""
        with self._lock:
            self._closed = True
            for process in self._running:
                process.kill()
        wait([*self._compilations, *filter(None, [self._linking])])
        self._scratch.cleanup()


def _check(command: Sequence[str], status: int, output: bytes) -> None:
    from torch._inductor.exc import CppCompileError

    if status:
        raise CppCompileError(list(command), output.decode(errors="replace"))


def _flags(words: Sequence[str], source: str) -> list[str]:
    """The compiler and its flags, without the files. Error messages in the code name headers without their
    folder, so that exports on other machines give the same file. Warnings are off, because there are
    thousands about PyTorch's headers."""
    skipped = {source, "-c", "-o", words[words.index("-o") + 1]}
    # Integers from data wrap around, as in PyTorch: otherwise the compiler assumes that a sum of positive
    # integers is positive, and removes the check of an index.
    return [
        *(word for word in words if word not in skipped),
        "-w",
        "-fwrapv",
        f"-ffile-prefix-map={Path(torch.__file__).parent / 'include'}=",
    ]


def _environment(include: Path | None) -> dict[str, str]:
    return (
        {"CPATH": os.pathsep.join(filter(None, [str(include), os.environ.get("CPATH")]))} if include else {}
    )


# --- headers ------------------------------------------------------------------------------------------------


def precompile(folder: Path, kind: str, command: str, include: Path) -> None:
    """Write `folder`/KIND.h.gch, a header of `HEADERS` precompiled for commands like `command`. It has 140
    MB, so it stays where it was built."""
    flags = _flags(words := shlex.split(command), next(word for word in words if word.endswith(".cpp")))
    header, made, new = folder / f"{kind}.h", folder / f"{kind}.h.gch", folder / f"{kind}.h.new"
    header.write_text(_text(kind, flags))
    listing = ["-MD", "-MF", f"{made}.d", "-MT", str(made)]
    subprocess.run(
        [*flags, *listing, "-x", "c++-header", str(header), "-o", str(new)],
        env=os.environ | _environment(include),
        check=True,
    )
    os.replace(new, made)


def _fitting(folder: Path, kind: str, flags: list[str]) -> Path | None:
    """The precompiled header, if it was compiled by the same command and its headers have not changed. The
    compiler itself checks that it was compiled by the same compiler; otherwise it reads the plain headers."""
    header = folder / f"{kind}.h"
    try:
        if header.read_text() != _text(kind, flags):
            return None
        made = os.stat(f"{header}.gch").st_mtime_ns
        # The first one is the target
        files = Path(f"{header}.gch.d").read_text().replace("\\\n", " ").split()[1:]
        return header if all(os.stat(file).st_mtime_ns <= made for file in files) else None
    except OSError:
        return None


def _text(kind: str, flags: list[str]) -> str:
    return f"// {shlex.join(flags)}\n#include <{HEADERS[kind]}>\n"
