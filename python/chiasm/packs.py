"""Bundles that are installed as Python packages (`chiasm pack` makes them), found by their ops' names.

Such a distribution has an entry point in the group `chiasm.bundles`: the name of a package, whose folder
holds the bundles.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path

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
        return sorted(self.folder.glob(f"*{SUFFIX}"))


def packs() -> list[Pack]:
    """The installed bundles by name; packages that are missing at their entry point's location are
    skipped."""
    found = []
    for entry in entry_points(group=GROUP):
        spec = find_spec(entry.value)
        if spec is not None and spec.origin is not None and entry.dist is not None:
            found.append(Pack(entry.dist.name, entry.dist.version, Path(spec.origin).parent))
    return sorted(found, key=lambda pack: pack.distribution)


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


def listing() -> list[str]:
    """A line for each installed bundle, for `chiasm list --installed`."""
    lines = [
        f"{bundle.name.removesuffix(SUFFIX)}  {pack.distribution} {pack.version}"
        for pack in packs()
        for bundle in pack.bundles()
    ]
    return lines or ["no bundles are installed: pip install a wheel that `chiasm pack` made"]
