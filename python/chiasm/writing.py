"""Writes whole files. Needs only the standard library."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path


def write_whole(path: Path, data: bytes | memoryview) -> None:
    """Write a file atomically, replacing an existing one; a link itself is replaced, not its target.

    Raises:
        OSError: an error of the system, which may name a file beside `path`, or none.
    """
    # Not a file of tempfile, which has no mode but 0600: another takes the umask, which can be read only by
    # setting it, for all threads
    scratch = path.parent / f".writing-{os.urandom(8).hex()}"
    try:
        with open(scratch, "xb") as file:
            file.write(data)
        os.replace(scratch, path)
    finally:
        with suppress(OSError):  # it was moved, or could not be made
            scratch.unlink()
