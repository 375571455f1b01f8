"""The C++ compiler beside the exporter: it works while Python goes on, and reads headers that were
precompiled with the package."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

import torch

#: What Inductor's code includes first, for each of the two files that it writes.
HEADERS = {"wrapper": "torch/csrc/inductor/aoti_include/cpu.h", "kernel": "torch/csrc/inductor/cpp_prefix.h"}
#: Bytes of C++ above which -O3 takes four times as long as -O2: thousands of lines of arithmetic, with no
#: loop in them to unroll.
_LARGE = 150_000


class Build:
    """A library that Inductor builds by commands, which `run` takes. Compilers are started and not waited
    for; `library` waits, and links.

    Args:
        include: headers that go before the compiler's own.
        precompiled: a folder with what `precompile` made, or made for something else.
        objects: are linked too.
        after: its compilers end before others start, so that the number of them does not grow with the number
            of methods.
        dropped: words that are left out of the linker's command.
        at_once: Inductor gets its library when it links it; else it gets an empty file, and goes on.
    """

    def __init__(
        self,
        include: Path | None = None,
        precompiled: Path | None = None,
        objects: Sequence[Path] = (),
        after: Build | None = None,
        dropped: Sequence[str] = (),
        at_once: bool = False,
    ) -> None:
        self.include, self.precompiled, self.objects = include, precompiled, list(map(str, objects))
        self.after, self.dropped, self.at_once = after, dropped, at_once
        self._scratch = tempfile.TemporaryDirectory()
        self.folder = Path(self._scratch.name)
        self._running: list[tuple[list[str], subprocess.Popen]] = []
        self._made: dict[str, str] = {}  # Inductor's object files, and ours
        self._link: list[str] = []

    def run(self, command: str, cwd: str) -> None:
        """In place of Inductor's `run_compile_cmd`."""
        words = shlex.split(command)
        target = Path(words[words.index("-o") + 1])
        sources = [word for word in words if word.endswith(".cpp")]
        if "-shared" in words:
            kept = [word for word in words if word not in self.dropped]
            self._link = [*(self._made.get(word) or self._kept(word) for word in kept), *self.objects]
            self._link[self._link.index(str(target))] = "library.so"
            target.write_bytes(self.library() if self.at_once else b"")
        elif sources:
            self._start(words, sources[0], target)
        else:
            _check(words, subprocess.run(words, cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.STDOUT))

    def _start(self, words: list[str], source: str, target: Path) -> None:
        """Compile in a folder of ours, where files have the same names in every export: they stand in the
        texts of errors."""
        if self.after is not None:
            self.after.wait()
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
        with open(self.folder / f"{kind}.log", "wb") as log:
            process = subprocess.Popen(
                command,
                cwd=self.folder,
                env=os.environ | _environment(self.include),
                stdout=log,
                stderr=subprocess.STDOUT,
            )
        self._running.append((command, process))
        self._made[str(target)] = f"{kind}.o"
        target.touch()  # Inductor removes it

    def _kept(self, word: str) -> str:
        """A word of the linker's command; of an object file, which Inductor will remove, a copy."""
        return str(shutil.copy(word, self.folder)) if word.endswith(".o") else word

    def wait(self) -> None:
        """Until no compiler is at work."""
        for _, process in self._running:
            process.wait()

    def library(self) -> bytes:
        """The linked library, once."""
        for command, process in self._running:
            output = subprocess.CompletedProcess(
                command, process.wait(), (self.folder / f"{Path(command[-1]).stem}.log").read_bytes()
            )
            _check(command, output)
        _check(
            self._link,
            subprocess.run(self._link, cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT),
        )
        return (self.folder / "library.so").read_bytes()

    def close(self) -> None:
        """End what is at work, and remove its files."""
        for _, process in self._running:
            process.kill()
            process.wait()
        self._scratch.cleanup()


def _check(command: Sequence[str], done: subprocess.CompletedProcess) -> None:
    from torch._inductor.exc import CppCompileError

    if done.returncode:
        raise CppCompileError(list(command), done.stdout.decode(errors="replace"))


def _flags(words: Sequence[str], source: str) -> list[str]:
    """The compiler and what it is told, without the files. Texts of errors name headers without their folder,
    which would make the same export on another machine another file; of warnings there are thousands, about
    PyTorch's headers."""
    skipped = {source, "-c", "-o", words[words.index("-o") + 1]}
    # Integers from data wrap around, as in PyTorch: else the compiler takes a sum of two for positive, and an
    # index's check with it out.
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
    """Make `folder`/KIND.h.gch: what `HEADERS` names, for commands like `command`. It is 140 MB, so it stays
    where it was built."""
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
    """The precompiled header, where it was made by the same command from headers that are still the same.
    Whether it was by the same compiler, the compiler itself looks; else it reads the headers."""
    header = folder / f"{kind}.h"
    try:
        if header.read_text() != _text(kind, flags):
            return None
        made = os.stat(f"{header}.gch").st_mtime_ns
        # The first is what was made of them
        files = Path(f"{header}.gch.d").read_text().replace("\\\n", " ").split()[1:]
        return header if all(os.stat(file).st_mtime_ns <= made for file in files) else None
    except OSError:
        return None


def _text(kind: str, flags: list[str]) -> str:
    return f"// {shlex.join(flags)}\n#include <{HEADERS[kind]}>\n"
