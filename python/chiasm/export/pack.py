"""Wheels of bundles: `chiasm-bundles-NAME`, which `chiasm.runtime.open` finds by the names of the ops.

A wheel is written here and not by a build tool, so that the same bundles give the same bytes: files are
sorted by name, and all have the same time.
"""

from __future__ import annotations

import base64
import hashlib
import io
import os
import re
import time
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from chiasm import __version__

from ..packs import GROUP, SUFFIX
from .dates import given_time
from .errors import ExportError
from .files import MOST_OF_FILE, naming, read_regular
from .isas import ISAS
from .manifest import BundleError, read_inside, read_manifest
from .signing import check_files

#: The first and the last time that a zip archive can store, in seconds since 1970. The first is the default.
_EPOCH, _LAST = 315532800, 4354819198
_NAME = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*")


def pack(name: str, bundles: Sequence[Path], output: Path, version: str = __version__) -> tuple[Path, bool]:
    """Write the wheel `chiasm-bundles-NAME` of bundles.

    Returns:
        The wheel's file, and whether it was written: False if it was already there with the same content.

    Raises:
        ExportError: the name or the version is not one of a wheel, or two bundles are of one op.
        BundleError: a bundle is damaged.
    """
    if not _NAME.fullmatch(name):
        raise ExportError(f"pack: expected a name of small letters, digits and hyphens, got {name!r}")
    if not re.fullmatch(r"[0-9]+(\.[0-9]+)*((a|b|rc)[0-9]+)?(\.post[0-9]+)?", version):
        raise ExportError(f"pack: expected a version like 0.1.0, got {version!r}")
    distribution = f"chiasm_bundles_{name.replace('-', '_')}"
    files: dict[str, bytes] = {
        f"{distribution}/__init__.py": f'"""Bundles of chiasm: {len(bundles)} ops."""\n'.encode()
    }
    glibc: dict[str, tuple[int, int]] = {}
    for bundle in bundles:
        manifest = read_manifest(bundle)
        folder = f"{distribution}/{manifest['name']}{SUFFIX}"
        if f"{folder}/manifest.json" in files:
            raise ExportError(f"pack: {bundle}: there is another bundle of {manifest['name']}")
        files.update(_contents(bundle, manifest, folder))
        for machine, version_of_one in _glibcs(manifest):
            glibc[machine] = max(glibc.get(machine, (0, 0)), version_of_one)
    platforms = [f"manylinux_{major}_{minor}_{machine}" for machine, (major, minor) in sorted(glibc.items())]
    tags = platforms or ["any"]
    info = f"{distribution}-{version}.dist-info"
    files |= {
        f"{info}/METADATA": (
            f"Metadata-Version: 2.1\nName: {distribution.replace('_', '-')}\nVersion: {version}\n"
            f"Summary: Ops of chiasm, exported: {name}\nRequires-Python: >=3.10\nRequires-Dist: chiasm\n"
        ).encode(),
        f"{info}/WHEEL": (
            f"Wheel-Version: 1.0\nGenerator: chiasm {__version__}\n"
            f"Root-Is-Purelib: {str(not glibc).lower()}\n" + "".join(f"Tag: py3-none-{tag}\n" for tag in tags)
        ).encode(),
        f"{info}/entry_points.txt": f"[{GROUP}]\n{name} = {distribution}\n".encode(),
    }
    record = _record(files, f"{info}/RECORD")
    target = output / f"{distribution}-{version}-py3-none-{'.'.join(tags)}.whl"
    if _holds(target, f"{info}/RECORD", record):
        return target, False
    output.mkdir(parents=True, exist_ok=True)
    _write(target, files | {f"{info}/RECORD": record})
    return target, True


def _contents(bundle: Path, manifest: dict[str, Any], folder: str) -> dict[str, bytes]:
    """Every file of the bundle. They are those of the manifest, or no runtime would open the bundle."""
    check_files(bundle, manifest)
    names = sorted(file.relative_to(bundle).as_posix() for file in bundle.rglob("*") if file.is_file())
    try:
        return {f"{folder}/{name}": read_inside(bundle, name, MOST_OF_FILE) for name in names}
    except OSError as error:
        raise BundleError(f"{error.filename}: {error.strerror}") from error


def _glibcs(manifest: dict[str, Any]) -> Iterator[tuple[str, tuple[int, int]]]:
    """The machines that native code is for, and the versions of glibc that it needs."""
    for method in manifest["methods"].values():
        for artifact in method["artifacts"]:
            if "glibc" in artifact:
                major, minor = artifact["glibc"].split(".")
                machine = "x86_64" if "sm" in artifact else ISAS[artifact["isa"]].machine
                yield machine, (int(major), int(minor))


def _record(files: dict[str, bytes], own: str) -> bytes:
    lines: list[str] = []
    for path, data in sorted(files.items()):
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        lines.append(f"{path},sha256={digest},{len(data)}\n")
    return "".join([*lines, f"{own},,\n"]).encode()


def _holds(wheel: Path, path: str, record: bytes) -> bool:
    """Whether a complete wheel with this list of hashes exists."""
    try:
        # Opening a pipe would wait for its writer
        with zipfile.ZipFile(io.BytesIO(read_regular(wheel, MOST_OF_FILE))) as archive:
            return archive.read(path) == record
    except (OSError, EOFError, KeyError, NotImplementedError, RuntimeError, zipfile.BadZipFile, zlib.error):
        return False  # the last ones: damaged


def _write(target: Path, files: dict[str, bytes]) -> None:
    """Write under a temporary name first, so that an interrupted run leaves no partial wheel."""
    seconds = min(max(given_time() or _EPOCH, _EPOCH), _LAST)
    part = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        with naming(target), zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as archive:
            for path, data in sorted(files.items()):
                entry = zipfile.ZipInfo(path, time.gmtime(seconds)[:6])
                entry.compress_type = zipfile.ZIP_DEFLATED
                entry.external_attr = 0o100644 << 16
                archive.writestr(entry, data)
        os.replace(part, target)
    finally:
        part.unlink(missing_ok=True)
