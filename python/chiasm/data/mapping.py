# pyarrow and Ray are optional, and not in .venv:
# pyright: reportMissingImports=false
"""`Map`: a bundle as a function of batches."""

from __future__ import annotations

import operator
import os
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..export.text import one_line
from .errors import DataError
from .parcel import Parcel

if TYPE_CHECKING:
    from .columns import Column, Rows


@dataclass(frozen=True)
class Files:
    """A column of paths, for `Map`: the worker that maps a row reads its image file.

    An engine then sends a path to the worker instead of the file's content, which for small files takes most
    of Ray's time. Paths are local, or on a file system that all nodes share. The column is passed through.

    Parameters
    ----------
    column
        The column's name. Its rows are strings, or in NumPy also paths.

    Examples
    --------
    >>> from chiasm.data import Files, Map
    >>> preprocess = Map("build/bundles/pipelines.preprocess.chiasm", columns={"frame": Files("path")})
    >>> list(preprocess({"path": ["photos/0000.jpg"]}))
    ['path', 'output']
    """

    column: str


_ERRORS = ("raise", "null", "column")
#: As the runtime's
_MOST_THREADS = 1024
#: The column that says what is wrong with a row.
ERROR = "error"


class Map:
    """A bundle's method as a function of batches of rows, to be sent to workers.

    A row is one sample: (C, H, W) for an image (B, C, H, W), and the whole frame for a frame (H, W, C). A
    batch is a dict of NumPy arrays, or an Arrow record batch or table; the result is of the same kind. The
    outputs' columns replace the columns that the op reads; all other columns are passed through unchanged.

    If the manifest says that samples are independent, rows of one shape run as one batch; else each row runs
    alone. Numbers in Arrow are read without a copy. If the op takes an image, bytes are decoded: JPEG, PNG
    and any other format that Pillow reads, rotated by EXIF, in the colour order of the op's input. So are
    images of Pillow, and in Arrow structs with the bytes in a field `bytes`, as Hugging Face's datasets have.

    In Arrow an output is a fixed-shape tensor if the manifest, the constants and the columns' types tell the
    shape of a row; else a struct of the lists `data` (row-major) and `shape`. In NumPy it is an array (rows,
    ...), or an object array with an array for each row. Outputs without dimensions are plain numbers.
    Booleans become uint8 in Arrow, whose own booleans are bits.

    A pickle of a Map holds the bundle's files. At the first use in a process they are written to
    $CHIASM_CACHE (~/.cache/chiasm), once per node; an existing copy is compared. Then the method is loaded
    for one thread, as native code if the bundle has some for this node's CPU.

    Parameters
    ----------
    bundle
        The folder ``NAME.chiasm``, or the name of an installed bundle, as in `chiasm.runtime.open`.
    columns
        The column of each input of the op, by default the one of the same name; ``Files("path")`` for a
        column that names image files. Instead of a name, a value may be a constant for every row: a number,
        lists or an array: ``{"frame": "image", "sigma": [[1.5, 1.5]]}``.
    outputs
        The wanted outputs, and the column for each: ``{"output": "embedding"}``. By default all, by their own
        names.
    method
        One of the bundle's methods.
    errors
        What happens if the op cannot take a row, or an image cannot be read. "raise": a DataError names the
        row. "column": a column "error" says why, and is null for the other rows; the outputs of the bad row
        are zeros if rows have one shape, else null (in NumPy empty arrays, because Ray accepts no None among
        arrays). "null": as "column", but the outputs are null, and always structs (object arrays), because
        Arrow cannot read null tensors back from parquet.
    id
        A column by which errors identify the row, besides its index in the batch.
    backend, dtype, num_threads
        As in `chiasm.runtime.Bundle.method`.

    Raises
    ------
    DataError
        If an argument does not fit the bundle.

    Examples
    --------
    >>> import numpy as np
    >>> from chiasm.data import Map
    >>> edges = Map("build/bundles/filters.sobel.chiasm", columns={"input": "image"})
    >>> batch = {"id": np.arange(4), "image": np.zeros((4, 3, 32, 48), np.float32)}
    >>> result = edges(batch)
    >>> list(result), result["output"].shape
    (['id', 'output'], (4, 3, 32, 48))
    """

    def __init__(
        self,
        bundle: str | os.PathLike[str],
        columns: Mapping[str, Any] | None = None,
        outputs: Mapping[str, str] | None = None,
        method: str = "forward",
        errors: str = "raise",
        id: str | None = None,
        backend: str = "auto",
        dtype: str | None = None,
        num_threads: int = 1,
    ) -> None:
        import chiasm.runtime

        _typed("bundle", bundle, (str, bytes, os.PathLike), "a folder or a name")
        _typed("method", method, (str,), "a name")
        _typed("id", id, (str, type(None)), "a column's name")
        _typed("backend", backend, (str,), "a name")
        try:
            opened = chiasm.runtime.open(bundle)
            inputs, results = opened.signature(method)
        except (chiasm.runtime.ChiasmError, ValueError) as error:  # ValueError: a path that is not UTF-8
            raise DataError(str(error)) from error
        if errors not in _ERRORS:
            raise DataError(f"errors: expected one of {', '.join(_ERRORS)}, got {errors!r}")
        given = _named("columns", "INPUT", columns)
        _known("columns", given, [t.name for t in inputs], opened.name)
        sources = {t.name: given.get(t.name, t.name) for t in inputs}
        for source in sources.values():
            if isinstance(source, Files):
                _typed("columns", source.column, (str,), "a column's name in Files(NAME)")
        #: The columns that have paths.
        self.files = {source.column for source in sources.values() if isinstance(source, Files)}
        named = {n: s.column if isinstance(s, Files) else s for n, s in sources.items()}
        self.columns = {name: source for name, source in named.items() if isinstance(source, str)}
        self.constants = {name: source for name, source in sources.items() if name not in self.columns}
        if not self.columns:
            raise DataError(
                "columns: every input is a constant, so that no row differs from another: expected a column's"
                f" name or Files(NAME) for one of them, got {one_line(given, 200)}"
            )
        self.outputs = _named("outputs", "OUTPUT", outputs, {t.name: t.name for t in results})
        _known("outputs", self.outputs, [t.name for t in results], opened.name)
        made = [*self.outputs.values(), *([ERROR] if errors == "column" else [])]
        if not self.outputs or len({column for column in made if isinstance(column, str)}) < len(made):
            raise DataError(f"outputs: expected a column of its own for each output, got {made}")
        self.method, self.errors, self.id = method, errors, id
        self.backend, self.dtype, self.num_threads = backend, _dtype(dtype), _threads(num_threads)
        self.parcel = Parcel.of(Path(opened._handle.path))

    def __repr__(self) -> str:
        return f"<chiasm map {self.parcel.name} {self.method}: {self.columns} -> {self.outputs}>"

    def __call__(self, batch: Any) -> Any:
        """Map a batch, or an iterator of Arrow record batches, as Spark's ``mapInArrow`` calls it.

        For an iterator, returns the results one by one. Tensors are plain lists, because Spark has no
        tensors: the row-major values, in a struct with their shape if shapes differ.

        Raises
        ------
        DataError
            If the batch lacks a column or, with errors="raise", a row cannot be mapped.
        """
        if isinstance(batch, Mapping):
            return self._numpy(batch)
        if hasattr(batch, "to_batches") or hasattr(batch, "to_struct_array"):  # a table, a record batch
            return self._table(batch) if hasattr(batch, "to_batches") else self._record_batch(batch)
        if isinstance(batch, Iterator):
            return (self._plain_batch(part) for part in batch)
        raise DataError(
            "batch: expected a dict of arrays or an Arrow record batch or table, got"
            f" {type(batch).__module__}.{type(batch).__name__}"
        )

    def _plain_batch(self, batch: Any) -> Any:
        if not hasattr(batch, "to_struct_array") or hasattr(batch, "to_batches"):
            raise DataError(
                "batch: expected an iterator of Arrow record batches, got one of"
                f" {type(batch).__module__}.{type(batch).__name__}"
            )
        return self._record_batch(batch, plain=True)

    def collate(self, samples: Any) -> dict[str, Any]:
        """The ``collate_fn`` of a ``torch.utils.data.DataLoader``: samples become a batch of tensors.

        A sample is a dict, one row of the batch. The entries that the op reads are arrays, tensors, numbers
        or the bytes of an image; PyTorch's default collates the others. An output is a tensor (rows, ...), or
        a list of tensors if rows differ in shape.

        A worker opens the bundle at its first batch, and runs it on one thread.

        Raises
        ------
        DataError
            If samples are not dicts with the same columns, or a row cannot be mapped.
        """
        from .tensors import collate

        return collate(self, samples, self._replaced())

    def _numpy(self, batch: Mapping[str, Any]) -> dict[str, Any]:
        import numpy as np

        from .columns import from_numpy

        columns, replaced = self._columns(batch, from_numpy), self._replaced()
        kept = {name: values for name, values in batch.items() if name not in replaced}
        sized = {n: v for n, v in batch.items() if isinstance(v, (list, tuple)) or getattr(v, "ndim", 0)}
        _expect_equal({name: len(values) for name, values in sized.items()})
        rows, errors = self.run(columns, self._name_of(batch))
        valid = np.array([e is None for e in errors], bool)
        result = {name: output.to_numpy(valid) for name, output in rows.items()}
        if self.errors == "column":
            result[ERROR] = np.array(errors, object)
        return {**kept, **self._fresh(kept, result)}

    def _record_batch(self, batch: Any, plain: bool = False, first: int = 0) -> Any:
        import pyarrow as pa

        from .columns import from_arrow

        names, replaced = batch.schema.names, self._replaced()
        columns = self._columns(batch, from_arrow)
        rows, errors = self.run(columns, self._name_of(batch), first)
        # by their places, because several may have one name
        kept = [i for i, name in enumerate(names) if name not in replaced]
        result = self._fresh([names[i] for i in kept], self.to_arrow(rows, errors, plain))
        arrays = [*(batch.column(i) for i in kept), *result.values()]
        fields = [
            *(batch.schema.field(i) for i in kept),
            *(pa.field(name, array.type) for name, array in result.items()),
        ]
        return pa.RecordBatch.from_arrays(arrays, schema=pa.schema(fields, batch.schema.metadata))

    def _table(self, table: Any) -> Any:
        import pyarrow as pa

        from .columns import empty_batch

        first, parts = 0, []
        for batch in table.to_batches() or [empty_batch(table.schema)]:
            parts.append(self._record_batch(batch, first=first))
            first += batch.num_rows
        return pa.Table.from_batches(parts)

    def to_arrow(
        self, rows: Mapping[str, Rows], errors: list[str | None], plain: bool = False
    ) -> dict[str, Any]:
        """The results of `run` as Arrow arrays by column."""
        import numpy as np
        import pyarrow as pa

        valid = np.array([e is None for e in errors], bool)
        result = {name: output.to_arrow(valid, plain) for name, output in rows.items()}
        if self.errors == "column":
            result[ERROR] = pa.array(errors, pa.string())
        return result

    def _columns(self, batch: Any, read: Callable[[str, Any], Column]) -> dict[str, Column]:
        """The columns that the op reads, each once."""
        from .columns import from_files

        return {
            name: (from_files if name in self.files else read)(name, self._find(batch, name))
            for name in dict.fromkeys(self.columns.values())
        }

    def _replaced(self) -> set[str]:
        """The columns that the outputs replace."""
        return set(self.columns.values()) - self.files

    @staticmethod
    def _find(
        batch: Any, name: str, other: str = "columns={INPUT: COLUMN}, or --column INPUT=COLUMN of chiasm map"
    ) -> Any:
        has = list(batch) if isinstance(batch, Mapping) else batch.schema.names
        if has.count(name) != 1:
            what = "has no" if name not in has else "has more than one"
            raise DataError(
                f"the batch {what} column {name!r}: it has {', '.join(map(repr, has)) or 'none'}; name"
                f" another by {other}"
            )
        return batch[name] if isinstance(batch, Mapping) else batch.column(has.index(name))

    def _name_of(self, batch: Any) -> Callable[[int], str]:
        if self.id is None:
            return lambda i: ""
        ids = self._find(batch, self.id, "id=COLUMN")
        return lambda i: f" ({self.id} {one_line(ids[i], 200)!r})"

    @staticmethod
    def _fresh(kept: Iterable[str], made: dict[str, Any]) -> dict[str, Any]:
        if twice := [name for name in made if name in kept]:
            rename = "name the output's by outputs={OUTPUT: COLUMN}"
            other = "take errors='null'" if twice[0] == ERROR else rename
            raise DataError(
                f"the batch has a column {twice[0]!r} already: rename or drop it; or, in Python, {other}"
            )
        return made

    def open(self) -> Opened:
        """The method, loaded once in this process; a DataError if it cannot run here."""
        key = (self.parcel.sha256, self.method, self.backend, self.dtype, self.num_threads)
        with _lock:
            if key not in _opened:
                _opened[key] = _open(self)
            return _opened[key]

    def run(
        self, columns: Mapping[str, Column], name_of: Callable[[int], str] = lambda i: "", first: int = 0
    ) -> tuple[dict[str, Rows], list[str | None]]:
        """Map rows that are not an Arrow or NumPy batch. `columns` has them by name.

        Returns the outputs' rows by column, and for each row its error, or None.
        """
        from .running import run

        _expect_equal({name: column.length for name, column in columns.items()})
        return run(self, self.open(), columns, name_of, first)


@dataclass
class Opened:
    """A method of a bundle in this process."""

    method: Any
    #: The symbol that counts samples, if they are independent, and its limit.
    samples: str | None
    most: int
    #: Symbols that are the first dimension of a batch, which a row lacks.
    leading: set[str] = field(default_factory=set)


_opened: dict[tuple[Any, ...], Opened] = {}
_lock = threading.Lock()


def _renew_lock() -> None:
    """A thread that is loading a method while the process forks is not in the child."""
    global _lock
    _lock = threading.Lock()


os.register_at_fork(after_in_child=_renew_lock)


def _open(wanted: Map) -> Opened:
    import hashlib

    import chiasm.runtime

    try:
        bundle = chiasm.runtime.open(wanted.parcel.folder())
        # Hash the text that the runtime has read: the file may have changed since it was compared
        if hashlib.sha256(bundle._handle.manifest.encode()).hexdigest() != wanted.parcel.sha256:
            raise DataError(f"{wanted.parcel.name}: this node's copy was changed while it was opened")
        method = bundle.method(
            wanted.method, backend=wanted.backend, dtype=wanted.dtype, num_threads=wanted.num_threads
        )
    except (chiasm.runtime.ChiasmError, ValueError) as error:  # ValueError: a folder that is not UTF-8
        raise DataError(f"{wanted.parcel.name}: {error}") from error
    for tensor in (*method.inputs, *method.outputs):
        if "bfloat16" in tensor.dtypes:
            raise DataError(
                f"{wanted.parcel.name}: {tensor.name!r} is bfloat16, which NumPy and Arrow do not have: take"
                " another dtype, or use chiasm.runtime with torch"
            )
    samples = bundle.info["methods"][wanted.method].get("samples")
    most = bundle.info["symbols"][samples]["max"] if samples else 1
    leading = {samples} if samples else set()
    leading |= {t.shape[0] for t in method.inputs if t.layout.startswith("N")}
    return Opened(method, samples, most, leading)


def _typed(what: str, value: Any, kinds: tuple[type, ...], expected: str) -> None:
    if not isinstance(value, kinds):
        raise DataError(f"{what}: expected {expected}, got {one_line(repr(value), 200)}")


def _dtype(given: Any) -> str | None:
    """The name of a dtype that bundles know. (Whether this bundle has it, the worker finds out.)"""
    from chiasm import _runtime
    from chiasm.runtime import _dtype_name

    name = None if given is None else _dtype_name(given)
    if name is not None and name not in _runtime.dtypes():
        raise DataError(
            f"dtype: expected one of {', '.join(_runtime.dtypes())}, got {one_line(repr(given), 200)}"
        )
    return name


def _threads(given: Any) -> int:
    try:
        number = operator.index(given)
    except TypeError:
        number = -1
    if not 0 <= number <= _MOST_THREADS:
        raise DataError(
            f"num_threads: expected a number from 0 to {_MOST_THREADS}, got {one_line(repr(given), 200)}"
        )
    return number


def _named(what: str, key: str, given: Any, default: Mapping[str, str] | None = None) -> dict[str, Any]:
    """The argument `what` as a dict."""
    if given is None:
        return dict(default or {})
    if not isinstance(given, Mapping):
        raise DataError(f"{what}: expected a dict {{{key}: COLUMN}}, got {one_line(repr(given), 200)}")
    return dict(given)


def _expect_equal(lengths: Mapping[str, int]) -> None:
    if len(set(lengths.values())) > 1:
        raise DataError(f"the columns have different numbers of rows: {lengths}")


def _known(what: str, given: Mapping[str, Any], names: list[str], bundle: str) -> None:
    for name in given:
        if name not in names:
            raise DataError(
                f"{what}: {bundle} has no {what[:-1]} {name!r}: it has {', '.join(names)}".replace(
                    "no column", "no input"
                )
            )
