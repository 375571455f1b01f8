"""Bundles that are installed as Python packages (`chiasm pack` makes them), found by their ops' names.

Such a distribution has an entry point in the group `chiasm.bundles`: the name of a package, whose folder
holds the bundles.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path

from .export.text import one_line

#: The group of entry points.
GROUP = "chiasm.bundles"
#: The suffix of bundles' folders.
SUFFIX = ".chiasm"


@dataclass(frozen=True)
class Pack:
    """An installed folder of bundles."""

    distribution: str
    version: str
    folder: Path

    def bundles(self) -> list[Path]:
        """The bundles, by name."""
        return sorted(path for path in self.folder.glob(f"*{SUFFIX}") if path.is_dir())


def packs() -> list[Pack]:
    """The installed bundles by name; packages that are missing at their entry point's location are
    skipped.

    Raises
    ------
    OSError
        If the entry points of some distribution, of whatever kind, cannot be read.
    """
    try:
        entries = entry_points(group=GROUP)
    except Exception as error:  # of a parser
        raise OSError(
            "an entry_points.txt of the installed distributions cannot be read"
            f" ({type(error).__name__}: {one_line(error)}): `pip check` and a new installation help"
        ) from error
    found = []
    for entry in entries:
        folder = _folder(entry.value)
        if folder is not None and entry.dist is not None:
            found.append(Pack(one_line(entry.dist.name), one_line(entry.dist.version), folder))
    return sorted(found, key=lambda pack: pack.distribution)


def _folder(package: str) -> Path | None:
    """The folder of an installed package. This runs none of its code; `find_spec` would, to find a package
    inside another."""
    if not all(part.isidentifier() for part in package.split(".")):
        return None
    first, *rest = package.split(".")
    try:
        spec = find_spec(first)
    except ValueError:  # of a module like __main__, which is imported and has none
        return None
    # A module that is no package has no such locations, and its file is among everyone's
    for location in (spec and spec.submodule_search_locations) or ():
        folder = Path(location, *rest)
        if folder.is_dir():
            return folder
    return None


def is_name(path: str) -> bool:
    """Whether this can be an op's name, and is no path."""
    return "." in path and all(part.isidentifier() for part in path.split("."))


def find(name: str) -> Path | None:
    """The installed bundle of an op, from the first pack that has it."""
    for pack in packs():
        folder = pack.folder / f"{name}{SUFFIX}"
        if folder.is_dir():
            return folder
    return None


def located(path: str) -> str:
    """The path; or, if there is nothing and it is the name of an installed bundle, the path of that."""
    if os.path.lexists(path) or not is_name(path):
        return path
    return str(find(path) or path)


def listing() -> list[str]:
    """A line for each installed bundle, for `chiasm list --installed`."""
    lines = [
        f"{one_line(bundle.name.removesuffix(SUFFIX))}  {pack.distribution} {pack.version}"
        for pack in packs()
        for bundle in pack.bundles()
    ]
    return lines or ["no bundles are installed: pip install a wheel that `chiasm pack` made"]
