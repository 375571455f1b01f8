"""Writes whole files. Needs only the standard library."""

from __future__ import annotations

import errno
import os
from contextlib import suppress
from pathlib import Path


def write_whole(path: Path, data: bytes | memoryview, *, durable: bool = False) -> None:
    """Write a file atomically, replacing an existing one; a link itself is replaced, not its target.

    Args:
        path: the file.
        data: its content.
        durable: returns when the file is on the disk under its name; after a power cut it is there and whole.

    Raises:
        OSError: an error of the system, which may name a file beside `path`, or none.
    """
    # Not a file of tempfile, which has no mode but 0600: another takes the umask, which can be read only by
    # setting it, for all threads
    scratch = path.parent / f".writing-{os.urandom(8).hex()}"
    try:
        with open(scratch, "xb") as file:
            file.write(data)
            if durable:
                file.flush()
                os.fsync(file.fileno())
        os.replace(scratch, path)
        if durable:
            sync_folder(path.parent)
    finally:
        with suppress(OSError):  # it was moved, or could not be made
            scratch.unlink()


def sync_folder(folder: Path) -> None:
    """Wait until the names of a folder's files are on the disk."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP):  # of file systems that do not offer it
            raise
    finally:
        os.close(descriptor)
