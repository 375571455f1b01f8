"""Signing bundles and checking signatures, in minisign's format.

The manifest names every file of a bundle with its hash, so its signature, `manifest.json.minisig`, covers all
of them.
"""

from __future__ import annotations

import base64
import hashlib
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..writing import write_whole
from .errors import ExportError
from .files import MOST_OF_KEY, read_regular
from .manifest import BundleError, manifest_text, parse_manifest, read_file, read_inside
from .text import one_line

SIGNATURE = "manifest.json.minisig"
_UNTRUSTED, _TRUSTED = "untrusted comment: ", "trusted comment: "


@dataclass(frozen=True)
class SecretKey:
    """An Ed25519 key pair as minisign stores it: a seed and the public key, and a number that identifies the
    pair."""

    id: bytes
    key: bytes


def read_secret_key(file: Path, ask_password: Callable[[], str]) -> SecretKey:
    """Read a key file that `minisign -G` has written; `ask_password` is called if it is encrypted.

    Raises:
        ExportError: the file is no such key, or the password is wrong.
    """
    try:
        lines = read_regular(file, MOST_OF_KEY).decode().splitlines()
        data = base64.b64decode(lines[1], validate=True)
    except OSError as error:
        raise ExportError(f"{file}: {error.strerror}") from error
    except (ValueError, IndexError) as error:
        raise ExportError(f"{file}: not a minisign secret key (`minisign -G` makes one)") from error
    if len(data) != 158 or data[:2] != b"Ed" or data[2:4] not in (b"Sc", b"\0\0") or data[4:6] != b"B2":
        raise ExportError(f"{file}: not a minisign secret key (`minisign -G` makes one)")
    body, check = data[54:126], data[126:]
    protected = data[2:4] == b"Sc"
    if protected:
        stream = _scrypt(
            file,
            ask_password(),
            data[6:38],
            int.from_bytes(data[38:46], "little"),
            int.from_bytes(data[46:54], "little"),
        )
        plain = bytes(a ^ b for a, b in zip(data[54:], stream, strict=True))
        body, check = plain[:72], plain[72:]
    if (protected or any(check)) and check != hashlib.blake2b(data[:2] + body, digest_size=32).digest():
        raise ExportError(
            f"{file}: the password is wrong" if protected else f"{file}: damaged: its checksum is another"
        )
    key = SecretKey(body[:8], body[8:])
    try:
        _signature(b"", key)  # a key without a password has no checksum
    except BundleError as error:
        raise ExportError(
            f"{file}: damaged: its public half does not prove what its secret half signs: use a copy of it,"
            " or make another (`minisign -G`)"
        ) from error
    return key


def _scrypt(file: Path, password: str, salt: bytes, opslimit: int, memlimit: int) -> bytes:
    """The key's mask. minisign stores the cost as libsodium's two limits, from which libsodium derives
    scrypt's N and p (r is 8)."""
    opslimit = max(opslimit, 32768)
    bound_by_work = opslimit < memlimit // 32
    most = opslimit // 32 if bound_by_work else memlimit // 1024
    n = 2
    while n <= most // 2:
        n *= 2
    p = 1 if bound_by_work else min(opslimit // 4 // n, 0x3FFFFFFF) // 8
    memory = 128 * 8 * (n + p + 2)
    if memory >= 2**31:
        raise ExportError(
            f"{file}: its password protection needs {memory} bytes of memory, which is more than this program"
            " takes"
        )
    try:
        return hashlib.scrypt(password.encode(), salt=salt, n=n, r=8, p=p, maxmem=memory, dklen=104)
    except (ValueError, MemoryError) as error:
        raise ExportError(f"{file}: its password protection cannot be computed: {error}") from error


def sign(bundle: str | Path, key: SecretKey) -> Path:
    """Write the bundle's signature, replacing an existing one; returns its path.

    Raises:
        BundleError: a file differs from the manifest: a damaged bundle is not signed.
    """
    folder, target = Path(bundle), Path(bundle) / SIGNATURE
    message = manifest_text(folder)
    _prove(folder, message)
    try:
        write_whole(target, _signature(message, key))
    except OSError as error:
        raise BundleError(f"{target}: {error.strerror}") from error
    return target


def _signature(message: bytes, key: SecretKey) -> bytes:
    """The text of a signature file, which the key's public half proves (else BundleError)."""
    from chiasm import _runtime

    signature = _runtime.sign(hashlib.blake2b(message).digest(), key.key)
    comment = f"timestamp:{int(time.time())}\tfile:manifest.json\thashed"
    lines = [
        f"{_UNTRUSTED}signature of a chiasm bundle",
        base64.b64encode(b"ED" + key.id + signature).decode(),
        f"{_TRUSTED}{comment}",
        base64.b64encode(_runtime.sign(signature + comment.encode(), key.key)).decode(),
    ]
    text = ("\n".join(lines) + "\n").encode()
    public = base64.b64encode(b"Ed" + key.id + key.key[32:]).decode()
    try:
        _runtime.verify_signature(message, text, public, "the signature just made", "the key")
    except _runtime.ChiasmError as error:
        raise BundleError(str(error)) from error
    return text


def check_signature(bundle: str | Path, key: str) -> str:
    """Check that this public key (its text or the path of a file) has signed the bundle, and that no file has
    changed since.

    Returns the signature's trusted comment.

    Raises:
        BundleError: the signature or a file is wrong.
    """
    from chiasm import _runtime

    folder, file = Path(bundle), Path(bundle) / SIGNATURE
    message = manifest_text(folder)
    if not file.exists():
        raise BundleError(f"{folder}: is not signed: there is no {SIGNATURE} in it (`chiasm sign` makes one)")
    try:
        signature = read_inside(folder, SIGNATURE, MOST_OF_KEY)
        public = read_public_key(key)
        comment = _runtime.verify_signature(
            message, signature, public, one_line(file), f"--key {one_line(key)}"
        )
    except OSError as error:
        raise BundleError(f"{file}: {error.strerror}") from error
    except _runtime.ChiasmError as error:
        raise BundleError(str(error)) from error
    _prove(folder, message)
    return comment.decode(errors="replace")


def trust_only(key: str) -> None:
    """From now on this process runs only bundles that this public key has signed."""
    from chiasm import _runtime

    try:
        _runtime.set_trust("signed", [read_public_key(key).splitlines()[-1]])
    except _runtime.ChiasmError as error:
        raise BundleError(str(error)) from error


def read_public_key(key: str) -> str:
    """The key's text; `key` is the text itself or the path of a file that holds it."""
    try:
        if len(key) == 56 and len(base64.b64decode(key, validate=True)) == 42:
            return key
    except ValueError:  # no base64
        pass
    try:
        return read_regular(key, MOST_OF_KEY).decode()
    except (OSError, ValueError) as error:
        raise BundleError(
            f"{key or 'an empty text'}: neither a minisign public key nor a file that holds one:"
            f" {getattr(error, 'strerror', None) or error}"
        ) from error


def _prove(folder: Path, message: bytes) -> None:
    """Reject a bundle unless its files are exactly those in its manifest `message`."""
    check_files(folder, parse_manifest(folder, message))


def check_files(folder: Path, manifest: dict[str, Any]) -> None:
    """Reject a bundle (BundleError) unless its files are exactly those in its manifest."""
    entries = [a for method in manifest["methods"].values() for a in method["artifacts"]]
    entries += [manifest["golden"], *manifest.get("documents", {}).values()]
    for entry in entries:
        read_file(folder, entry)
    others = {p.name for p in folder.iterdir()} - {e["file"] for e in entries} - {"manifest.json", SIGNATURE}
    if others:
        raise BundleError(
            f"{folder} has {min(others)!r}, which its manifest does not name: remove it, or export the bundle"
            " again"
        )
