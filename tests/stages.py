"""Chooses the targets that `make test` runs: some always, the others if their sources have changed.

    python tests/stages.py     the targets, in the order in which they are run

Skipped targets are listed, with their sources, on standard error. `make test-all` skips none, and each can be
run by its name. tests/changes.py finds changed sources; where it cannot, none is skipped.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from tests import changes  # noqa: E402
from tests.changes import changed_files, is_drawn, known_changes  # noqa: E402

if TYPE_CHECKING:
    import pytest

#: Every target depends on these.
ALWAYS = (
    "Makefile",
    "requirements.txt",
    "tests/changes.py",
    "tests/stages.py",
    "tools/environment.sh",
    "tools/setup.sh",
)
RUNTIME = (
    "CMakeLists.txt",
    "CMakePresets.json",
    "cmake/",
    "include/",
    "runtime/artifact/abi.h",
    *(f"runtime/{name}" for name in ("CMake", "base/", "core/", "backends/", "ort/", "python/", "triton/")),
)
FAMILIES = (
    *("augmentation", "color", "contrib", "enhance", "feature", "filters", "geometry", "image", "io"),
    *("losses", "metrics", "morphology", "ops", "pipelines"),
)
#: The sources of native code; readers, servers and wheels do not depend on its content.
ARTIFACTS = ("runtime/artifact/", "python/chiasm/primitives/kernels/", "python/chiasm/export/formats/")
#: What commands that read bundles import.
READERS = (
    *(f"python/chiasm/export/{name}.py" for name in ("command", "ending", "errors", "files", "manifest")),
    "python/chiasm/export/text.py",
    "python/chiasm/extras.py",
    "python/chiasm/packs.py",
    "python/chiasm/writing.py",
)
#: What is exported, and the exporter.
OPS = (
    *(f"python/chiasm/{family}/" for family in FAMILIES),
    "python/chiasm/primitives/",
    "python/chiasm/export/",
)
#: The folders and files that a target tests; empty for targets that always run.
SOURCES: dict[str, tuple[str, ...]] = {
    "lint": (),
    "test-bundles": (),
    "test-ops": (),
    "test-export": (),
    "test-runtime": (),
    "test-kernels": ("runtime/artifact/", "python/chiasm/primitives/kernels/", "tests/kernels/"),
    "test-robustness": (*RUNTIME, "tests/runtime/", "tests/robustness/"),
    "test-aarch64": (
        *RUNTIME,
        *ARTIFACTS,
        "tests/kernels/",
        "tests/parity/aarch64.py",
        "tests/runtime/",
        "tests/consumer/aarch64",
        "tools/aarch64",
        "tools/wheels.sh",
    ),
    "test-parity": (),
    "test-special-values": (*OPS, *RUNTIME, *ARTIFACTS, "tests/parity/special_"),
    "other-runtimes": (*OPS, "python/chiasm/onnx/", "tests/parity/other_runtimes.py", "tools/other_runtimes"),
    "test-browser": (
        "python/chiasm/export/formats/onnx",
        "python/chiasm/export/onnx_function.py",
        "tests/browser/",
        "tools/browser",
        "tools/site/live",
    ),
    "test-serving": (
        *RUNTIME,
        *READERS,
        "python/chiasm/export/signing.py",
        "python/chiasm/triton/",
        "tests/serving/",
        "tools/triton",
    ),
    "test-data": (
        *RUNTIME,
        "python/chiasm/data/",
        *READERS,
        "python/chiasm/export/console.py",
        "python/chiasm/export/constants.py",
        "python/chiasm/export/images.py",
        "python/chiasm/export/sizes.py",
        "python/chiasm/runtime/",
        "tests/data/",
        "tools/data",
        "docs/scale.md",
    ),
    "test-studies": (
        *OPS,
        *RUNTIME,
        "python/chiasm/runtime/",
        "examples/",
        "studies/",
        "tests/examples/",
        "tests/studies/",
    ),
    "test-install": (
        *RUNTIME,
        "packaging/",
        "pyproject.toml",
        *(f"python/chiasm/{name}.py" for name in ("__init__", "__main__", "doctor", "extras", "packs")),
        "python/chiasm/export/pack.py",
        "tests/consumer/",
        "tools/wheels",
    ),
    "test-sanitizers": (
        *RUNTIME,
        *ARTIFACTS,
        "tests/kernels/",
        "tests/runtime/",
        "tests/robustness/",
    ),
    "test-fuzz": (*RUNTIME, "tests/fuzz/", "tests/runtime/fake_backend.cpp"),
}


#: One of so many unchanged files of tests runs.
DRAWN = 6


def has_changed(sources: tuple[str, ...]) -> bool:
    return any(file.startswith(sources) for file in changed_files())


def runs(test: pytest.Item) -> bool:
    """Whether a test of the exporter or of the runtime in Python runs: its file, or what that tests, has
    changed, or the file is drawn."""
    file = test.path
    return (
        has_changed(("requirements.txt", *RUNTIME, *ARTIFACTS))
        or changes.has_changed(file)
        or is_drawn(file.name, file, DRAWN)
    )


def main() -> None:
    if known_changes() is None:
        print("git does not know the base: every file counts as changed", file=sys.stderr)
    for target, sources in SOURCES.items():
        if not sources or os.environ.get("CHIASM_ALL_TESTS") or has_changed((*ALWAYS, *sources)):
            print(target)
        else:
            print(f"left out: {target}, since none of {', '.join(sources)} has changed", file=sys.stderr)


if __name__ == "__main__":
    main()
