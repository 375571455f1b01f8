# pyarrow and Ray are optional, and not in .venv:
# pyright: reportMissingImports=false
"""The inputs of `chiasm map`, split into shards: the part that a worker maps at a time and writes as one
file."""

from __future__ import annotations

import errno
import hashlib
import os
import stat
import tarfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from tarfile import (
    EOFHeaderError,  # pyright: ignore[reportAttributeAccessIssue]
    HeaderError,
    ReadError,
)
from typing import Any

from ..export.files import MOST_OF_IMAGE, read_regular
from ..export.text import one_line
from ..writing import sync_folder
from .errors import DataError
from .mapping import ERROR, Map

#: The names of image files, of formats that both Pillow and OpenCV have.
IMAGES = (
    *(".avif", ".bmp", ".dib", ".gif", ".jfif", ".jp2", ".jpe", ".jpeg", ".jpg"),
    *(".pbm", ".pgm", ".png", ".pnm", ".ppm", ".tif", ".tiff", ".webp"),
)
#: The names of compressed tars, as far as an error tells them apart.
_COMPRESSED = (".tar.bz2", ".tar.gz", ".tar.xz", ".tar.zst", ".tgz")
#: The number of rows that are in memory at once and form a row group of the file.
BATCH = 32
ID = "id"


@dataclass(frozen=True)
class Shard:
    """A part of the input: image files below a folder, a tar, or a row group of a parquet file."""

    number: int
    kind: str  # "images", "tar" or "parquet"
    root: str
    names: tuple[str, ...]
    row_group: int = 0
    #: The bytes of a tar or a parquet file.
    size: int = 0

    @property
    def file(self) -> str:
        """The name of the file for its rows."""
        return f"part-{self.number:06}.parquet"

    def __str__(self) -> str:
        group = f", row group {self.row_group}" if self.kind == "parquet" else ""
        first, *others = self.names
        more = f" and {len(others)} more" if others else ""
        return f"{Path(self.root) / first}{more}{group}"


def plan(source: Path, rows: int) -> tuple[list[Shard], str]:
    """The shards of an input, always the same for the same files, and a hash of the files' names, sizes and
    times of change.

    `source` is a folder of images, of tars or of parquet files, including subfolders, or one such file. A
    shard of images has `rows` of them.
    """
    if source.is_dir():
        root, found = source, sorted(_files(source))
    else:
        root, found = source.parent, [(source.name, source.stat())]
    by_kind = {
        "images": [name for name, _ in found if name.lower().endswith(IMAGES)],
        "tar": [name for name, _ in found if name.lower().endswith(".tar")],
        "parquet": [name for name, _ in found if name.lower().endswith(".parquet")],
    }
    kinds = [kind for kind, names in by_kind.items() if names]
    if len(kinds) != 1:
        what = " and ".join(f"{len(by_kind[k])} {k}" for k in kinds) or "none of them"
        if any(name.lower().endswith(_COMPRESSED) for name, _ in found):
            what += ": compressed tars must be decompressed first (gunzip)"
        raise DataError(
            f"{source}: expected images ({' '.join(IMAGES)}), tars (.tar) or parquet files (.parquet), of one"
            f" kind; got {what}"
        )
    [kind] = kinds
    names, top = by_kind[kind], str(root.resolve())
    # Opening a pipe would wait for who writes it. (Images are opened with care: each is a row.)
    if kind != "images" and (wrong := [name for name in names if not (root / name).is_file()]):
        raise DataError(
            f"{root / wrong[0]}: not a regular file but a pipe or a device: write its content to a file first"
        )
    sizes = {name: status.st_size for name, status in found}
    if kind == "images":
        parts = [(tuple(names[i : i + rows]), 0, 0) for i in range(0, len(names), rows)]
    elif kind == "tar":
        parts = [((name,), 0, sizes[name]) for name in names]
    else:
        parts = [((name,), group, sizes[name]) for name in names for group in range(_row_groups(root / name))]
    chosen = set(names)
    text = "".join(f"{s.st_size} {s.st_mtime_ns} {name}\0" for name, s in found if name in chosen)
    shards = [Shard(i, kind, top, *part) for i, part in enumerate(parts)]
    if not shards:
        raise DataError(f"{source}: it has no rows")
    return shards, hashlib.sha256(text.encode(errors="surrogateescape")).hexdigest()


def _files(folder: Path) -> Iterator[tuple[str, os.stat_result]]:
    """The files below a folder, by their paths in it, with their states. Links to folders are followed."""

    def fail(error: OSError) -> None:
        raise error

    above = {str(folder): {os.path.realpath(folder)}}  # of each folder, the real folders on the way to it
    for path, folders, names in os.walk(folder, onerror=fail, followlinks=True):
        way = above.pop(path)
        real = {name: os.path.realpath(os.path.join(path, name)) for name in folders}
        # Without those that a link leads back to
        folders[:] = [name for name in folders if not name.startswith(".") and real[name] not in way]
        above |= {os.path.join(path, name): way | {real[name]} for name in folders}
        for name in names:
            if not name.startswith("."):
                full = Path(path) / name
                try:
                    status = full.stat()
                except OSError as error:
                    if error.errno in (errno.ENOENT, errno.ELOOP):  # a link to nothing, or to itself
                        continue
                    raise
                yield str(full.relative_to(folder)), status


def map_no_rows(shard: Shard, mapping: Map) -> None:
    """Raise a DataError if the method cannot run here, or does not fit the shard's columns or the
    constants."""
    if shard.kind == "parquet":
        import pyarrow as pa
        import pyarrow.parquet as parquet

        mapping(pa.Table.from_batches([], _read(parquet.read_schema, Path(shard.root) / shard.names[0])))
    else:
        _map_files(mapping, [])


def _row_groups(file: Path) -> int:
    import pyarrow.parquet as parquet

    return _read(parquet.read_metadata, file).num_row_groups


def _read(read: Callable[[Path], Any], file: Path) -> Any:
    """Read the end of a parquet file."""
    import pyarrow as pa

    try:
        return read(file)
    except (pa.ArrowException, OSError) as error:  # the second also for damage
        raise DataError(f"{file}: not a parquet file that can be read: {one_line(error)}") from error


def write(shard: Shard, mapping: Map, folder: Path, count: Callable[[int, int], None]) -> tuple[int, int]:
    """Map a shard and write its file; returns its rows, and how many of them are bad.

    The file appears under its name when it is completely on the disk. After each batch, `count` is called
    with the numbers of its rows and of its bad rows.
    """
    import pyarrow.parquet as parquet

    target = folder / shard.file
    scratch = folder / f".{shard.file}.{os.uname().nodename}-{os.getpid()}.tmp"
    rows = bad = 0
    writer = None
    try:
        began = _state(shard)
        scratch.unlink(missing_ok=True)
        with open(scratch, "xb") as file:  # not into what a link of this name leads to
            for batch in _mapped(shard, mapping):
                if writer is None:
                    schema = batch.schema.with_metadata(
                        {
                            **(batch.schema.metadata or {}),
                            "chiasm.bundle": mapping.parcel.name,
                            "chiasm.manifest_sha256": mapping.parcel.sha256,
                            "chiasm.artifact": mapping.open().method.artifact,
                        }
                    )
                    # Pixels repeat few values: a dictionary would only take time
                    writer = parquet.ParquetWriter(file, schema, use_dictionary=False)
                writer.write_batch(batch.replace_schema_metadata(writer.schema.metadata))
                wrong = batch.num_rows - batch.column(ERROR).null_count
                rows, bad = rows + batch.num_rows, bad + wrong
                count(batch.num_rows, wrong)
            if writer is not None:
                writer.close()
            file.flush()
            os.fsync(file.fileno())
        if _state(shard) != began:
            raise DataError("it was changed while it was read: run the same command again")
        scratch.rename(target)
        sync_folder(folder)
    except OSError as error:
        # A full disk names no file
        raise DataError(f"{shard}, written to {target}: {one_line(error.strerror or error)}") from error
    except Exception as error:  # of whatever kind: a damaged tar raises nearly any
        raise DataError(f"{shard}: {one_line(error) or type(error).__name__}") from error
    finally:
        if writer is not None:
            writer.is_open = False  # else its finalizer closes it once more, and prints that it cannot
        scratch.unlink(missing_ok=True)
    return rows, bad


def _state(shard: Shard) -> tuple[int, ...]:
    """What differs if a tar or a parquet file is changed while it is read. (Each image is read whole.)"""
    if shard.kind == "images":
        return ()
    try:
        status = (Path(shard.root) / shard.names[0]).stat()
    except OSError as error:
        raise DataError(f"it cannot be read any more: {error.strerror}") from error
    if not stat.S_ISREG(status.st_mode) or status.st_size != shard.size:
        raise DataError(
            f"it was changed after this run had begun: it had {shard.size} bytes, now it has {status.st_size}"
        )
    return status.st_dev, status.st_ino, status.st_mtime_ns


def _mapped(shard: Shard, mapping: Map) -> Iterator[Any]:
    """The result as record batches of at most BATCH rows; for an empty shard one batch without rows."""
    if shard.kind == "parquet":
        import pyarrow as pa
        import pyarrow.parquet as parquet

        from .columns import empty_batch

        with parquet.ParquetFile(Path(shard.root) / shard.names[0]) as file:
            empty = True
            batches = file.iter_batches(BATCH, row_groups=[shard.row_group])
            while True:
                try:
                    batch = next(batches, None)
                except pa.ArrowInvalid as error:
                    if "lists to be of size" not in str(error):
                        raise
                    raise DataError(
                        "a list of fixed size, or a part of a tensor, is null, which pyarrow cannot read from"
                        " parquet: write tensors as structs of `data` and `shape`"
                    ) from error
                if batch is None:
                    break
                empty = False
                yield mapping(batch)
            if empty:
                yield mapping(empty_batch(file.schema_arrow))
        return
    if shard.kind == "images":
        root = Path(shard.root)
        members = ((name, lambda name=name: read_regular(root / name, MOST_OF_IMAGE)) for name in shard.names)
    else:
        members = _members(Path(shard.root) / shard.names[0])
    some, batch = False, []
    for member in members:
        batch.append(member)
        if len(batch) == BATCH:
            yield _map_files(mapping, batch)
            some, batch = True, []
    if batch or not some:
        yield _map_files(mapping, batch)


class _Member(tarfile.TarInfo):
    """A tar's member. tarfile itself treats an unreadable header as the end of the archive, so later members
    would be missing silently."""

    @classmethod
    def fromtarfile(cls, tarfile: Any) -> Any:
        try:
            return super().fromtarfile(tarfile)
        except EOFHeaderError:  # the block of zeros at the end
            raise
        except HeaderError as error:
            raise ReadError(
                f"{error} at byte {tarfile.offset}: the archive is damaged, cut short or has no end"
            ) from error

    def _proc_member(self, tarfile: Any) -> Any:
        """tarfile calls this for each header. It keeps the content of a long name or of PAX records in
        memory, and the search for records in a run of digits takes quadratic time (in CPython 3.11.9 and
        earlier)."""
        if self.size < 0:
            raise ReadError(f"a member of {self.size} bytes at byte {self.offset}: the archive is damaged")
        if self.type in _DESCRIPTIONS and self.size > _MOST_OF_DESCRIPTION:
            raise ReadError(
                f"a name or records of {self.size} bytes at byte {self.offset}, expected at most"
                f" {_MOST_OF_DESCRIPTION}: the archive is damaged"
            )
        return super()._proc_member(tarfile)  # pyright: ignore[reportAttributeAccessIssue]


#: Members that describe the one after them, or all: a long name or target, PAX records.
_DESCRIPTIONS = (
    tarfile.GNUTYPE_LONGNAME,
    tarfile.GNUTYPE_LONGLINK,
    tarfile.XHDTYPE,
    tarfile.XGLTYPE,
    tarfile.SOLARIS_XHDTYPE,
)
#: The most bytes of one. Two paths have at most 8 KiB.
_MOST_OF_DESCRIPTION = 1 << 14


def _members(path: Path) -> Iterator[tuple[str, Callable[[], bytes]]]:
    try:
        yield from _read_members(path)
    except (DataError, tarfile.TarError, OSError, MemoryError):
        raise
    except Exception as error:  # nearly any, in tarfile's own words: of a number, of nested headers
        raise DataError(f"the archive is damaged: {one_line(error, 200)}") from error


def _read_members(path: Path) -> Iterator[tuple[str, Callable[[], bytes]]]:
    length = path.stat().st_size
    with tarfile.open(path, "r|", tarinfo=_Member) as archive:
        for member in archive:
            if member.size < 0:  # by a record
                raise DataError(f"{member.name!r} has {member.size} bytes: the archive is damaged")
            if archive.offset > length:  # tarfile would read up to there, behind the end of the file
                raise DataError(f"{member.name!r} ends behind the archive: it is damaged or cut short")
            if not member.isdir() and member.name.lower().endswith(IMAGES):
                yield member.name, _content(archive, member)
        stream = archive.fileobj
        while stream and (rest := stream.read(1 << 20)):
            if rest.strip(b"\0"):  # tars joined by cat, or with a hole
                raise DataError("there is more behind the end of the archive")


def _content(archive: tarfile.TarFile, member: tarfile.TarInfo) -> Callable[[], bytes]:
    """A function that returns a member's bytes or raises its error. The bytes are read now, because a stream
    has them only once."""
    problem = ""
    if not member.isfile():
        problem = "a link or a device, not a file: make the tar with --dereference --hard-dereference"
    elif member.issparse():  # a few bytes of a header can stand for any size
        problem = "stored as a sparse file: make the tar without --sparse"
    elif member.size > MOST_OF_IMAGE:
        problem = f"has {member.size} bytes, expected at most {MOST_OF_IMAGE}"
    data = None if problem else archive.extractfile(member)
    read = data.read() if data else b""

    def content() -> bytes:
        if problem:
            raise DataError(problem)
        return read

    return content


def _map_files(mapping: Map, files: list[tuple[str, Callable[[], bytes]]]) -> Any:
    import pyarrow as pa

    from .columns import Column

    [source] = mapping.columns.values()
    rows, errors = mapping.run({source: Column(len(files), lambda i: files[i][1](), encoded=True)})
    # Bytes of a file's name that are not UTF-8 become \xNN
    names = [name.encode(errors="surrogateescape").decode(errors="backslashreplace") for name, _ in files]
    return pa.record_batch({ID: pa.array(names, pa.string()), **mapping.to_arrow(rows, errors)})
