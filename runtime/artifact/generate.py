"""Generates files from the declarations of the kernels (python/chiasm/primitives/kernels/declarations).

    generate.py build FOLDER    declared/SOURCE.h, kernels.h, kernel_calls.h and kernel_calls.cpp, for CMake
    generate.py tests FOLDER    guarded_calls.inc, refused_calls.inc and named_calls.inc, for tests/kernels
    generate.py docs FILE       the page of kernels

A file whose content would not change is not written, so that nothing is compiled again.
"""

import sys
import traceback
from pathlib import Path
from typing import Dict, List

HERE = Path(__file__).resolve().parent
DECLARATIONS = HERE.parents[1] / "python" / "chiasm" / "primitives" / "kernels" / "declarations"
# Not through the package chiasm, which needs torch
sys.path[:0] = [str(HERE), str(DECLARATIONS.parents[1])]

from kernels.schema import DeclarationError  # noqa: E402

try:
    from kernels.declarations import KERNELS
except DeclarationError as error:
    sys.exit(f"error: {error}")
except SyntaxError as error:
    sys.exit(f"error: {Path(error.filename or '').name}:{error.lineno}: {error.msg}")
except Exception as error:
    frames = traceback.extract_tb(error.__traceback__)
    frame = [frame for frame in frames if Path(frame.filename).parent == DECLARATIONS][-1]
    sys.exit(f"error: {Path(frame.filename).name}:{frame.lineno}: {error}")

from example_tests import allowed_calls, forbidden_calls, named_calls  # noqa: E402
from kernel_adapters import call, calls, headers, prototypes  # noqa: E402
from kernel_page import page  # noqa: E402


def check() -> None:
    """Every kernel is defined in the source that its declaration names, which includes its header; and its
    expressions have a form in C++."""
    for k in KERNELS.values():
        source = HERE / "kernels" / k.source
        if not source.is_file():
            raise DeclarationError(f"kernel {k.name}: there is no source runtime/artifact/kernels/{k.source}")
        text = source.read_text()
        for wanted in (
            f'#include "declared/{source.stem}.h"',
            f"CHIASM_INSTANTIATE({k.name})" if k.variable else f"void {k.name}(",
        ):
            if wanted not in text:
                raise DeclarationError(
                    f"kernel {k.name}: runtime/artifact/kernels/{k.source} does not have '{wanted}'"
                )
        call(k)


def write(files: Dict[Path, str]) -> None:
    for file, text in files.items():
        file.parent.mkdir(parents=True, exist_ok=True)
        if not file.is_file() or file.read_text() != text:
            file.write_text(text)


def main(arguments: List[str]) -> None:
    check()
    match arguments:
        case ["build", folder]:
            made = headers(sorted(source.name for source in (HERE / "kernels").glob("*.cpp")))
            made.update({"kernel_calls.h": prototypes(), "kernel_calls.cpp": calls()})
            write({Path(folder) / name: text for name, text in made.items()})
        case ["tests", folder]:
            write(
                {
                    Path(folder) / "guarded_calls.inc": allowed_calls(),
                    Path(folder) / "refused_calls.inc": forbidden_calls(),
                    Path(folder) / "named_calls.inc": named_calls(),
                }
            )
        case ["docs", file]:
            write({Path(file): page()})
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except DeclarationError as error:
        sys.exit(f"error: {error}")
