"""Reads whole files. Needs only the standard library."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

#: The most bytes of a bundle's file, as for the runtime (runtime/core/manifest.cpp).
MOST_OF_FILE = 1 << 40
#: The most bytes of an image file: 180 million pixels, the most that Pillow accepts, with 64 bits each.
MOST_OF_IMAGE = 1 << 31
#: The most bytes of a key or a signature, as for the runtime (runtime/core/minisign.h).
MOST_OF_KEY = 1 << 14


def read_regular(path: str | os.PathLike[str], most: int) -> bytes:
    """The content of a file of at most `most` bytes.

    Raises:
        OSError: an error of the system; or it is a pipe or a device, which may have no end, or a longer file.
    """
    # O_NONBLOCK: opening a pipe must not wait for its writer
    with open(path, "rb", opener=lambda name, flags: os.open(name, flags | os.O_NONBLOCK)) as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode):
            what = "not a regular file but a pipe or a device: write its content to a file first"
            raise OSError(errno.EINVAL, what, str(path))
        if status.st_size > most:
            raise OSError(errno.EFBIG, f"has {status.st_size} bytes, expected at most {most}", str(path))
        return file.read(status.st_size)


@contextmanager
def naming(path: Path) -> Generator[None]:
    """An error of the system in the block that names no file, such as that of a full disk, names this one."""
    try:
        yield
    except OSError as error:
        if error.filename is None:
            error.filename = str(path)
        raise
