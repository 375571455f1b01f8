"""How a bundle travels to workers: its files in the pickle, and its hash, by which a node keeps one copy."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..export.files import MOST_OF_FILE, read_regular
from .errors import DataError

_MANIFEST, _SIGNATURE = "manifest.json", "manifest.json.minisig"


@dataclass(frozen=True)
class Parcel:
    """A bundle's files in memory.

    The manifest has the hash of every file, so its own hash identifies the bundle.
    """

    name: str
    sha256: str
    files: dict[str, bytes] = field(repr=False)

    @classmethod
    def of(cls, path: Path) -> Parcel:
        """Read the files of a bundle that the runtime has opened, and compare their hashes."""
        try:
            files = {file.name: read_regular(file, MOST_OF_FILE) for file in sorted(path.iterdir())}
        except OSError as error:
            raise DataError(f"{error.filename}: {error.strerror}") from error
        for entry in _entries(json.loads(files[_MANIFEST])):
            if hashlib.sha256(files.get(entry["file"], b"")).hexdigest() != entry["sha256"]:
                raise DataError(
                    f"{path / entry['file']}: missing, or its sha256 is not the manifest's: export it again"
                )
        return cls(path.resolve().name, hashlib.sha256(files[_MANIFEST]).hexdigest(), files)

    def folder(self) -> Path:
        """This node's copy of the bundle, compared byte by byte; written first if there is none.

        Many processes may call this at once: a rename makes a complete copy appear under its name.
        """
        # A manifest may be signed again. For a process that trusts one key, two signatures make two bundles.
        signature = self.files.get(_SIGNATURE)
        key = self.sha256 + (f"-{hashlib.sha256(signature).hexdigest()[:16]}" if signature else "")
        problem: OSError | None = None
        for cache in _caches():
            target = cache / "bundles" / key / self.name
            try:
                for _ in range(10):  # another process may put its copy there between two steps
                    if self._is_at(target):
                        return target
                    self._write(target)
            except OSError as error:
                problem = error
        raise DataError(
            f"no folder to keep the bundle {self.name} in: {problem}: set CHIASM_CACHE to one that can be"
            " written"
        )

    def _is_at(self, folder: Path) -> bool:
        try:
            found = {
                file.name: file.is_file() and read_regular(file, MOST_OF_FILE) for file in folder.iterdir()
            }
        except (FileNotFoundError, NotADirectoryError, IsADirectoryError):
            return False
        return found == self.files

    def _write(self, target: Path) -> None:
        target.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(
            dir=target.parent, prefix=".writing-", ignore_cleanup_errors=True
        ) as scratch:
            new = Path(scratch) / "new"
            new.mkdir()
            for name, data in self.files.items():
                (new / name).write_bytes(data)
            try:
                new.rename(target)
            except OSError:
                if self._is_at(target):  # another process was faster
                    return
                if target.is_symlink() or not target.is_dir():
                    target.unlink()
                else:  # it is damaged: move it away; it is deleted with the scratch folder
                    shutil.move(target, Path(scratch) / "damaged")
                new.rename(target)


def _entries(value: Any) -> Iterator[dict[str, Any]]:
    """The entries of files in a manifest, at any depth."""
    if isinstance(value, dict):
        if isinstance(value.get("file"), str) and isinstance(value.get("sha256"), str):
            yield value
        value = list(value.values())
    if isinstance(value, list):
        for item in value:
            yield from _entries(item)


def _caches() -> Iterator[Path]:
    """The folders for copies: only $CHIASM_CACHE if it is set; else ~/.cache/chiasm, then the folder for
    temporary files, because workers of a cluster often have no home."""
    if given := os.environ.get("CHIASM_CACHE"):
        yield Path(given)
        return
    with suppress(RuntimeError):  # no home is known
        yield Path.home() / ".cache" / "chiasm"
    yield Path(tempfile.gettempdir()) / f"chiasm-{os.getuid()}"
