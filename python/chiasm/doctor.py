"""What this machine can run, and for what is not there, why and what to do: `chiasm doctor`.

Needs nothing but the runtime, and says so where even that is missing.
"""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, packages_distributions, version
from importlib.util import find_spec
from pathlib import Path

from . import __version__, packs
from .export.text import one_line
from .extras import EXTRAS, has_ops

#: The backends of chiasm, and what brings each where its plug-in is not found.
_BACKENDS = {
    "native": "it belongs to chiasm itself: install chiasm again",
    "torch": 'pip install "chiasm[torch]"',
    "onnx": "it belongs to chiasm itself, where ONNX Runtime's headers were at hand when it was built",
}
#: The Python packages that hold the engines of backends.
_ENGINES = {"torch": "torch", "onnx": "onnxruntime"}
#: The instruction sets that artifacts are compiled for, by the machine's family, the fastest first, and what
#: a CPU without one lacks.
_INSTRUCTION_SETS = {
    "x86_64": {
        "x86-64-v4": "AVX-512",
        "x86-64-v3": "AVX2, FMA and BMI2",
        "x86-64-v2": "SSE4.2 and POPCNT",
    },
    "aarch64": {"armv8.2-a": "atomics and rounding products (FEAT_LSE, FEAT_RDM)"},
}


def report() -> list[str]:
    """The report, a list of lines."""
    return [
        f"chiasm     {__version__} in {Path(__file__).parent}",
        f"Python     {platform.python_version()} ({sys.executable})",
        f"system     {platform.system()} {platform.machine()}, {' '.join(platform.libc_ver())}",
        *_runtime(),
        *_extras(),
        *_ops(),
        *_exporting(),
        *_bundles(),
    ]


def _runtime() -> Iterator[str]:
    try:
        import chiasm.runtime
    except ImportError as error:
        yield f"runtime    cannot be imported: {error}: in a source tree, make build"
        return
    yield from _cpu()
    cores, limit = len(os.sched_getaffinity(0)), chiasm.runtime.get_num_threads()
    yield f"threads    {cores} cores for this process; a run uses up to {limit}"
    try:
        policy = chiasm.runtime.get_trust()
        keys = [key for key in os.environ.get("CHIASM_TRUSTED_KEYS", "").split(":") if key]
        yield f"trust      policy {policy}" + (f", {len(keys)} trusted keys" if policy == "signed" else "")
    except chiasm.runtime.ChiasmError as error:
        yield f"trust      {error}"
    yield from _plugins()


def _cpu() -> Iterator[str]:
    from chiasm import _runtime

    found = _runtime.instruction_sets()
    if found:
        yield f"CPU        runs artifacts for {', '.join(found)}"
    for name, features in _INSTRUCTION_SETS.get(platform.machine(), {}).items():
        if name in found:
            return
        rest = (
            f": native artifacts for {found[0]} alone run here" if found else ": no native artifacts run here"
        )
        rest = "" if name == "x86-64-v4" else f"{rest}; the onnx backend does"
        yield f"CPU        not {name}: it has not all of {features}{rest}"


def _plugins() -> Iterator[str]:
    import chiasm.runtime

    found = {backend.name: backend for backend in chiasm.runtime.backends()}
    for name in dict.fromkeys([*_BACKENDS, *found]):
        backend = found.get(name)
        if backend is None:
            yield f"backend    {name}: there is no plug-in libchiasm_{name}.so: {_BACKENDS[name]}"
        elif not backend.available and (engine := _ENGINES.get(name)) and find_spec(engine) is None:
            yield f'backend    {name}: {engine} is not installed: pip install "chiasm[{name}]"'
        elif backend.available:
            yield f"backend    {name}: {backend.engine_version}" + (", with CUDA" if backend.has_cuda else "")
        else:
            yield f"backend    {name}: {' '.join(backend.problem.split())}"
    for folder in os.environ.get("CHIASM_BACKEND_PATH", "").split(":"):
        if folder:
            names = sorted(file.name for file in Path(folder).glob("libchiasm_*.so"))
            yield f"plug-ins   {folder} (CHIASM_BACKEND_PATH): {', '.join(names) or 'none'}"


def _extras() -> Iterator[str]:
    distributions = packages_distributions()
    for extra, modules in EXTRAS.items():
        present = [name for name in modules if find_spec(name)]
        missing = [name for name in modules if name not in present]
        known = [f"{name} {_version(distributions.get(name, [name])[0])}" for name in present]
        parts = [", ".join(known)] if known else []
        if missing:
            parts.append(f'not {", ".join(missing)}: pip install "chiasm[{extra}]"')
        yield f"extra      {extra}: {'; '.join(parts)}"


def _version(distribution: str) -> str:
    try:
        return version(distribution)
    except PackageNotFoundError:
        return "of unknown version"


def _ops() -> Iterator[str]:
    if not has_ops():
        yield 'ops        none: chiasm-ops is not installed: pip install "chiasm[ops]"'


def _exporting() -> Iterator[str]:
    """The tools that build native artifacts."""
    folder = Path(__file__).parent / "artifact"
    made = sorted(file.parent.name for file in folder.glob("*/libchiasm_aoti.a"))
    if made:
        yield f"export     links native artifacts for {', '.join(made)}"
    else:
        yield f'export     no native artifacts: no libraries in {folder}: pip install "chiasm[export]"'
    compiler = os.environ.get("CXX", "g++")
    if shutil.which(compiler) is None:
        yield f"export     no native artifacts: no compiler {compiler!r}: apt-get install g++, or set CXX"
        return
    try:
        done = subprocess.run(
            [compiler, "--version"], capture_output=True, text=True, errors="replace", check=True, timeout=10
        )
        yield f"export     compiles with {one_line((done.stdout.splitlines() or [compiler])[0])}"
    except (OSError, subprocess.SubprocessError) as error:
        yield (
            f"export     no native artifacts: the compiler {compiler!r} does not run ({one_line(error)}):"
            " set CXX to another"
        )


def _bundles() -> Iterator[str]:
    try:
        found = packs.packs()
    except OSError as error:  # of another package that is damaged
        yield f"bundles    {error}"
        return
    for pack in found:
        yield f"bundles    {pack.distribution} {pack.version}: {len(pack.bundles())} in {pack.folder}"
    if not found:
        yield "bundles    none is installed as a package (`chiasm pack` makes such packages)"
