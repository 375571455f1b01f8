# jsonschema has no types.
# pyright: reportUnknownVariableType=false, reportUnknownMemberType=false
"""Reading a bundle: its manifest and its files, checked. Imports no engine, so that programs that only run
bundles can use it."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import re
from collections.abc import Iterator
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any, cast

import jsonschema
from jsonschema.exceptions import best_match
from jsonschema.validators import extend

from ..packs import SUFFIX as SUFFIX
from .files import read_regular

SCHEMA_VERSION = 3
#: GPUs that native code is compiled for, by their compute capability.
GPUS = ("sm_80", "sm_86", "sm_89", "sm_90", "sm_100", "sm_120")
FORMATS = ("torchscript", "onnx", "native")
METHODS = ("forward", "vjp")
#: The most bytes of a manifest, as for the runtime (runtime/core/manifest.h).
_MOST_OF_MANIFEST = 16 << 20


class BundleError(RuntimeError):
    """A bundle is damaged, is not one, or lacks what is asked of it; or the command cannot use what it is
    given beside one: an image file, a key, a value, a target."""


@cache
def schema() -> dict[str, Any]:
    """The JSON Schema of manifests."""
    return json.loads(resources.files("chiasm.export").joinpath("manifest.schema.json").read_text())


def sha256(data: bytes) -> str:
    """The hash, in hexadecimal."""
    return hashlib.sha256(data).hexdigest()


def read_manifest(bundle: Path) -> dict[str, Any]:
    """The manifest of a bundle, checked against the schema."""
    return parse_manifest(bundle, manifest_text(bundle))


def manifest_text(bundle: Path) -> bytes:
    """The manifest's bytes, unchecked."""
    try:
        return read_inside(bundle, "manifest.json", _MOST_OF_MANIFEST)
    except (FileNotFoundError, NotADirectoryError, IsADirectoryError) as error:
        raise BundleError(
            f"{bundle}: not a bundle: it has no manifest.json (`chiasm export --help` makes one)"
        ) from error
    except OSError as error:
        raise BundleError(f"{bundle / 'manifest.json'}: {error.strerror}") from error


def parse_manifest(bundle: Path, text: bytes) -> dict[str, Any]:
    """The manifest in these bytes of a bundle, checked against the schema."""
    file = bundle / "manifest.json"
    try:
        manifest: dict[str, Any] = json.loads(text, object_pairs_hook=_object)
    except (ValueError, RecursionError) as error:
        raise BundleError(f"{file}: not JSON: {error}") from error
    version = _version_of(manifest)
    if isinstance(version, int) and version > SCHEMA_VERSION:
        raise BundleError(
            f"{file}: written with schema version {version}, this chiasm reads up to {SCHEMA_VERSION}:"
            " upgrade chiasm"
        )
    try:
        found: Any = best_match(_validator().iter_errors(manifest))
    except RecursionError as error:
        raise BundleError(f"{file}: nested too deeply") from error
    if found is not None:
        raise BundleError(f"{file}: at {found.json_path}: {found.message[:300]}")
    return manifest


@cache
def _validator() -> Any:
    kind: Any = extend(jsonschema.Draft202012Validator, {"pattern": _match})
    return kind(schema())


def _match(_: Any, pattern: str, text: Any, __: Any) -> Iterator[jsonschema.ValidationError]:
    """JSON Schema's patterns are ECMAScript's: unlike Python's, `$` does not match before a line feed at the
    end, and digits are 0 to 9."""
    if isinstance(text, str) and not re.search(pattern.replace("$", r"\Z"), text, re.ASCII):
        yield jsonschema.ValidationError(f"{text!r} does not match {pattern!r}")


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object whose keys differ, as the runtime wants it: readers that take another of the two would see
    another manifest."""
    made = dict(pairs)
    if len(made) < len(pairs):
        seen: set[str] = set()
        for key, _ in pairs:
            if key in seen:
                raise ValueError(f"the key {key!r} occurs twice")
            seen.add(key)
    return made


def _version_of(manifest: Any) -> Any:
    return cast("dict[str, Any]", manifest).get("schema_version") if isinstance(manifest, dict) else None


def read_file(bundle: Path, entry: dict[str, Any]) -> bytes:
    """A file of the bundle whose size and hash are those of its manifest entry."""
    path = bundle / entry["file"]
    try:
        data = read_inside(bundle, entry["file"], entry["size"])
    except OSError as error:
        raise BundleError(f"{path}: {error.strerror}") from error
    if len(data) != entry["size"]:
        raise BundleError(
            f"{path}: {len(data)} bytes, the manifest says {entry['size']}: truncated or replaced"
        )
    if sha256(data) != entry["sha256"]:
        raise BundleError(f"{path}: sha256 differs from the manifest's: damaged or tampered with")
    return data


def read_inside(bundle: Path, name: str, most: int) -> bytes:
    """The content of a file in the bundle's folder, of at most `most` bytes.

    Raises:
        OSError: as for `read_regular`; or it is a link out of the folder, which the runtime rejects.
    """
    path = bundle / name
    target = Path(os.path.realpath(path))
    if path.is_symlink() and not target.is_relative_to(os.path.realpath(bundle)):
        what = f"is a link that leaves the bundle's folder, to {target}: put the file itself there"
        raise OSError(errno.ELOOP, what, str(path))
    return read_regular(path, most)
