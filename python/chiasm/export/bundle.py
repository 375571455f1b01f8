"""Bundles on disk: writing one atomically, and reading its golden vectors."""

from __future__ import annotations

import ctypes
import errno
import json
import os
import shutil
import tempfile
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import jsonschema
import torch
from safetensors.torch import load, save

from .dates import given_time
from .ending import delayed
from .errors import ExportError
from .manifest import SUFFIX, BundleError, read_file, schema, sha256


@dataclass
class Golden:
    """Inputs and eager outputs of one method, for one value of T. `name` tells several of them apart."""

    method: str
    variant: str | None
    tensors: dict[str, torch.Tensor]
    name: str = ""


@dataclass
class Writer:
    """Collects a bundle's files and writes the folder at once."""

    manifest: dict[str, Any]
    files: dict[str, bytes] = field(default_factory=dict)

    def artifact(self, method: str, file: str, data: bytes, **entry: Any) -> None:
        """Add a file that a backend loads; a file that serves two methods is stored once."""
        self.files[file] = data
        self.manifest["methods"][method]["artifacts"].append(
            {"file": file, "size": len(data), "sha256": sha256(data), **entry}
        )

    def golden(self, cases: list[Golden]) -> None:
        """Add the golden vectors."""
        tensors: dict[str, torch.Tensor] = {}
        listed: list[dict[str, Any]] = []
        for case in cases:
            prefix = ".".join(filter(None, (case.method, case.variant, case.name)))
            # cloned: a gradient may be a view of a cotangent, and what shares memory is not saved
            tensors |= {
                f"{prefix}/{name}": t.clone(memory_format=torch.contiguous_format)
                for name, t in case.tensors.items()
            }
            listed.append({"prefix": prefix, "method": case.method, "dtype": case.variant})
        data = save(tensors)
        self.files["golden.safetensors"] = data
        self.manifest["golden"] = {
            "file": "golden.safetensors",
            "size": len(data),
            "sha256": sha256(data),
            "cases": listed,
        }

    def document(self, kind: str, file: str, data: bytes) -> None:
        """Add a file to the bundle that no engine reads."""
        self.files[file] = data
        self.manifest.setdefault("documents", {})[kind] = {
            "file": file,
            "size": len(data),
            "sha256": sha256(data),
        }

    def write(self, folder: Path) -> Path:
        """Write `folder`/NAME.chiasm atomically, replacing an existing one; returns its path."""
        self.manifest["created"] = _now()
        jsonschema.validate(self.manifest, schema())
        target = folder / f"{self.manifest['name']}{SUFFIX}"
        made = None
        try:
            folder.mkdir(parents=True, exist_ok=True)
            made = Path(tempfile.mkdtemp(dir=folder, prefix=_writing(os.getpid())))
            new = made / "new"
            new.mkdir()
            for name, data in (
                *self.files.items(),
                ("manifest.json", (json.dumps(self.manifest, indent=1) + "\n").encode()),
            ):
                (new / name).write_bytes(data)
            if target.is_symlink() or (target.exists() and not target.is_dir()):
                raise ExportError(
                    f"{target}: in the way: not a folder; move it away, or export to another folder"
                )
            with delayed():  # an interrupt between the two steps would lose the old bundle
                _replace(target, new, made / "old")
        except OSError as error:
            raise ExportError(
                f"{target}: cannot be written: {error.strerror} ({error.filename or folder}); nothing was"
                " changed"
            ) from error
        finally:
            if made is not None and (target.exists() or not (made / "old").exists()):
                shutil.rmtree(made, ignore_errors=True)
        return target


def _replace(target: Path, new: Path, old: Path) -> None:
    """Put the folder `new` at `target`. What was there is at `new` afterwards; where the file system cannot
    exchange two folders in one step, it moves to `old`, and comes back if that fails."""
    for attempt in range(10):  # another export may move its own bundle there between two steps
        if _exchanged(new, target):
            return
        moved = old.with_name(f"{old.name}{attempt or ''}")
        with suppress(FileNotFoundError):
            os.rename(target, moved)
        try:
            os.rename(new, target)
            return
        except OSError as error:
            if error.errno not in (errno.ENOTEMPTY, errno.EEXIST) or attempt == 9:
                if moved.exists() and not target.exists():
                    os.rename(moved, target)
                raise


def _exchanged(a: Path, b: Path) -> bool:
    """Exchange two folders in one step. False if one does not exist, or the file system cannot do it."""
    at_working_folder, exchange = -100, 2  # AT_FDCWD, RENAME_EXCHANGE
    libc = ctypes.CDLL(None)
    return libc.renameat2(at_working_folder, os.fsencode(a), at_working_folder, os.fsencode(b), exchange) == 0


def _writing(process: int) -> str:
    """The prefix of the folders in which a process writes bundles."""
    return f".writing-{process}-"


def clean_up(folder: Path, process: int) -> None:
    """Remove what a killed process was writing, and put back a bundle that it had moved away."""
    for left in folder.glob(f"{_writing(process)}*"):
        if (left / "old").exists():
            name = json.loads((left / "old" / "manifest.json").read_text())["name"]
            if not (folder / f"{name}{SUFFIX}").exists():
                os.rename(left / "old", folder / f"{name}{SUFFIX}")
        shutil.rmtree(left, ignore_errors=True)


def _now() -> str:
    """The time in the manifest: now, or $SOURCE_DATE_EPOCH if it is set, for reproducible builds."""
    seconds = given_time()
    moment = datetime.now(timezone.utc) if seconds is None else datetime.fromtimestamp(seconds, timezone.utc)
    return moment.strftime("%Y-%m-%dT%H:%M:%SZ")


def read_golden(bundle: Path, manifest: dict[str, Any]) -> dict[str, torch.Tensor]:
    """All golden vectors of the manifest's cases, by name."""
    data = read_file(bundle, manifest["golden"])
    file = bundle / manifest["golden"]["file"]
    try:
        tensors = load(data)
    except Exception as error:  # safetensors' own exceptions, and those that wrong sizes of tensors cause
        raise BundleError(f"{file}: not golden vectors: {error}") from error
    for case in manifest["golden"]["cases"]:
        if case["method"] not in manifest["methods"]:
            raise BundleError(
                f"{file}: has a case of the method {case['method']!r}, which the bundle has not"
            )
        method = manifest["methods"][case["method"]]
        for tensor in (*method["inputs"], *method["outputs"]):
            if f"{case['prefix']}/{tensor['name']}" not in tensors:
                raise BundleError(
                    f"{file}: lacks the tensor {case['prefix']}/{tensor['name']}: damaged, or of another"
                    " bundle"
                )
    return tensors
