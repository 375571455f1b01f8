"""The command `chiasm`, and `python -m chiasm`.

What this module does by itself needs nothing but the runtime. All else is `chiasm.export.cli`, which needs
the extra `cli`.
"""

from __future__ import annotations

import sys
from pathlib import Path

from .export.ending import ended

#: A wheel's folders for building C and C++ programs.
_FOLDERS = {"--cmakedir": "lib/cmake/chiasm", "--includedir": "include", "--libdir": "lib"}


def main() -> None:
    """Do what the arguments say."""
    with ended():
        _do(sys.argv[1:])


def _do(arguments: list[str]) -> None:
    if len(arguments) == 1 and arguments[0] in _FOLDERS:
        print(_folder(_FOLDERS[arguments[0]]))
    elif arguments == ["doctor"]:
        from .doctor import report

        print("\n".join(report()))
    elif arguments == ["list", "--installed"]:
        from .packs import listing

        print("\n".join(listing()))
    else:
        _command()


def _folder(name: str) -> Path:
    folder = Path(__file__).parent / name
    if not folder.is_dir():
        raise SystemExit(
            f"Error: {folder} is not there: this is a source tree; `cmake --install build/release` makes one"
            " elsewhere, and an installed wheel has it"
        )
    return folder


def _command() -> None:
    try:
        from .export.cli import main as command
    except ImportError as error:
        from .extras import advice

        sentence = advice(error)
        if sentence is None:
            raise
        raise SystemExit(
            f"Error: {sentence} (`chiasm doctor` and `chiasm list --installed` do without)"
        ) from None
    command(prog_name="chiasm")


if __name__ == "__main__":
    main()
