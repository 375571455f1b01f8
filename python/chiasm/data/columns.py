# pyarrow and Ray are optional, and not in .venv:
# pyright: reportMissingImports=false
"""Columns of a batch as rows that the runtime can read without a copy."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..export.files import MOST_OF_IMAGE, read_regular
from ..export.text import one_line
from .errors import DataError

#: A row: an array, the bytes of an image file or an image of Pillow, or None for a missing row.
Row = Any


@dataclass(frozen=True)
class Column:
    """The rows of a column.

    `stack` is all rows as one array (rows, ...), if they are contiguous and none is missing. `shape` is a
    row's shape if the type tells it, even without rows. `encoded`: the type says that rows are image files.
    """

    length: int
    row: Callable[[int], Row]
    stack: np.ndarray | None = None
    shape: tuple[int, ...] | None = None
    encoded: bool = False


def from_numpy(name: str, values: Any) -> Column:
    """A column of a NumPy batch: an array (rows, ...), or an object array or a list of rows."""
    if isinstance(values, (list, tuple)):
        return Column(len(values), lambda i: _plain_row(name, values[i]))
    if not isinstance(values, np.ndarray) or values.ndim == 0 or isinstance(values, np.ma.MaskedArray):
        raise DataError(
            f"column {name!r}: expected an array (rows, ...) or a list of rows, got {type(values).__name__}"
        )
    if values.dtype.kind in "OS":
        if values.ndim != 1:
            raise DataError(
                f"column {name!r}: expected one object a row, got an array of shape {values.shape}"
            )
        if values.dtype.kind == "S":  # NumPy's own bytes end before the zeros that a file may end with
            return Column(len(values), lambda i: values[i : i + 1].tobytes())
        return Column(len(values), lambda i: _plain_row(name, values[i]))
    if values.dtype.kind not in "biuf":
        raise DataError(f"column {name!r}: expected numbers or the bytes of images, got {values.dtype}")
    return _stacked(values)


def from_arrow(name: str, array: Any) -> Column:
    """A column of an Arrow batch. Numbers are views of Arrow's memory.

    Rows of one shape: ``arrow.fixed_shape_tensor``, Ray's tensors, fixed-size lists and plain numbers. Rows
    of several shapes: Ray's variable-shaped tensors, structs of a list `data` and a list `shape`, and lists,
    which are rows of one dimension. Binary rows are image files, and so are structs with binary `bytes`, as
    the images of Hugging Face's datasets are stored.
    """
    import pyarrow as pa
    import pyarrow.compute

    kind, shape = array.type, None
    if isinstance(kind, pa.BaseExtensionType):
        order = getattr(kind, "permutation", None)
        if order is not None and list(order) != sorted(order):
            raise DataError(
                f"column {name!r}: its tensors are permuted ({order}): write them in row-major order"
            )
        shape = getattr(kind, "shape", None)
        array, kind = array.storage, array.storage.type
    if pa.types.is_null(kind):  # of bytes, if pyarrow has found the type and every row is missing
        return Column(len(array), lambda i: None, encoded=True)
    if _is_bytes(kind):
        return Column(len(array), lambda i: array[i].as_buffer() if array[i].is_valid else None, encoded=True)
    if pa.types.is_struct(kind) and any(field.name == "bytes" and _is_bytes(field.type) for field in kind):
        return from_arrow(name, pa.compute.struct_field(array, "bytes"))  # null where the struct is
    if pa.types.is_struct(kind) and {"data", "shape"} <= {field.name for field in kind}:
        return _shaped(name, array)
    if pa.types.is_list(kind) or pa.types.is_large_list(kind):
        return _lists(name, array, shape)
    sizes: list[int] = []
    values, valid = array, _valid(array)
    while pa.types.is_fixed_size_list(values.type):
        size = values.type.list_size
        sizes.append(size)
        # .values is the whole buffer, even if this array is a part of it
        values = values.values.slice(values.offset * size, len(values) * size)
        if values.null_count:
            valid = valid & _valid(values).reshape(len(array), -1).all(1)
    if not _is_number(values.type):
        raise DataError(
            f"column {name!r}: expected numbers, tensors or the bytes of images, got {array.type}"
        )
    shape = tuple(shape if shape is not None else sizes)
    if valid.all():
        return _stacked(_numbers(name, values).reshape(len(array), *shape))
    stack = _numbers(name, values.fill_null(False if pa.types.is_boolean(values.type) else 0)).reshape(
        len(array), *shape
    )
    return Column(len(array), lambda i: stack[i, ...] if valid[i] else None, None, shape)


def from_files(name: str, paths: Any) -> Column:
    """A column of paths, in NumPy or Arrow: rows are the files' bytes, each read when it is asked for."""

    def row(i: int) -> Row:
        path = paths[i].as_py() if hasattr(paths[i], "as_py") else paths[i]
        if path is None:
            return None
        if not isinstance(path, (str, os.PathLike)):
            raise DataError(f"column {name!r}: expected the path of a file, got {type(path).__name__}")
        try:
            return read_regular(path, MOST_OF_IMAGE)
        except (OSError, ValueError) as error:  # ValueError: a NUL in the path
            raise DataError(
                f"{one_line(path) or repr(path)}: {getattr(error, 'strerror', None) or error}"
            ) from error

    return Column(len(paths), row, encoded=True)


def _lists(name: str, array: Any, shape: Sequence[int] | None) -> Column:
    """Rows of one dimension; or Ray's tensors, whose shape the type tells."""
    if not _is_number(array.type.value_type):
        raise DataError(
            f"column {name!r}: expected lists of numbers, got {array.type}: give their shape too, in a struct"
            " of `data` and `shape`"
        )
    offsets = array.offsets.to_numpy()
    if shape is None:
        numbers = _parts(name, array.values, offsets)
        return Column(len(array), lambda i: numbers(i) if array[i].is_valid else None)
    flat, size = _numbers(name, array.values), int(np.prod(shape, dtype=np.int64))
    if array.null_count or (np.diff(offsets) != size).any():
        raise DataError(f"column {name!r}: its tensors of shape {tuple(shape)} have missing or short rows")
    return _stacked(flat[offsets[0] : offsets[-1]].reshape(len(array), *shape))


def _parts(name: str, array: Any, offsets: np.ndarray) -> Callable[[int], np.ndarray]:
    """The numbers of a row. One that is null is an error of its row."""
    import pyarrow as pa

    inside = _valid(array) if array.null_count else None
    flat = _numbers(name, array.fill_null(False if pa.types.is_boolean(array.type) else 0))

    def numbers(i: int) -> np.ndarray:
        part = slice(offsets[i], offsets[i + 1])
        if inside is not None and not inside[part].all():
            raise DataError(f"column {name!r}: a number inside the row is null")
        return flat[part]

    return numbers


def _valid(array: Any) -> np.ndarray:
    """Which elements are not null."""
    return array.is_valid().to_numpy(zero_copy_only=False)


def empty_batch(schema: Any) -> Any:
    """A record batch of no rows. (pyarrow's own does not know tensors.)"""
    import pyarrow as pa

    def empty(kind: Any) -> Any:
        if isinstance(kind, pa.BaseExtensionType):
            return pa.ExtensionArray.from_storage(kind, empty(kind.storage_type))
        return pa.array([], kind)

    return pa.RecordBatch.from_arrays([empty(field.type) for field in schema], schema=schema)


def _stacked(values: np.ndarray) -> Column:
    return Column(len(values), lambda i: values[i, ...], values, values.shape[1:])


def _shaped(name: str, array: Any) -> Column:
    import pyarrow as pa

    data, shapes = array.field("data"), array.field("shape")
    for field, kind, is_wanted in (
        ("data", data.type, _is_number),
        ("shape", shapes.type, pa.types.is_integer),
    ):
        if not (pa.types.is_list(kind) or pa.types.is_large_list(kind)) or not is_wanted(kind.value_type):
            raise DataError(f"column {name!r}: expected lists of numbers in the field {field!r}, got {kind}")
    numbers = _parts(name, data.values, data.offsets.to_numpy())

    def row(i: int) -> Row:
        if not (array[i].is_valid and data[i].is_valid and shapes[i].is_valid):
            return None
        values, shape = numbers(i), shapes[i].as_py()
        if len(shape) > 8:  # as the runtime's
            raise DataError(f"column {name!r}: expected at most 8 dimensions, its shape has {len(shape)}")
        if any(d is None or d < 0 for d in shape) or int(np.prod(shape, dtype=object)) != len(values):
            raise DataError(f"column {name!r}: {len(values)} values, but its shape is {shape}")
        return values.reshape(shape)

    return Column(len(array), row)


def _is_bytes(kind: Any) -> bool:
    import pyarrow as pa

    return pa.types.is_binary(kind) or pa.types.is_large_binary(kind) or pa.types.is_binary_view(kind)


def _is_number(kind: Any) -> bool:
    import pyarrow as pa

    return pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_boolean(kind)


def _numbers(name: str, array: Any) -> np.ndarray:
    import pyarrow as pa

    if array.null_count:
        raise DataError(f"column {name!r}: a number inside a row is null")
    return array.to_numpy(zero_copy_only=not pa.types.is_boolean(array.type))


def is_array_or_file(value: Any) -> bool:
    """Whether this is a row already. Images of Pillow are rows: as an array, one would be in RGB for an op
    that takes BGR."""
    pillow = sys.modules.get("PIL.Image")
    kinds = (np.ndarray, bytes, bytearray, memoryview, *((pillow.Image,) if pillow else ()))
    return value is None or isinstance(value, kinds)


def _plain_row(name: str, value: Any) -> Row:
    if is_array_or_file(value):
        return value
    try:
        array = np.asarray(value)
    # TypeError, RuntimeError: a tensor on a GPU or of bfloat16, and one that requires its gradient
    except (ValueError, TypeError, OverflowError, RuntimeError) as error:
        raise DataError(
            f"column {name!r}: expected an array, got {type(value).__name__}: {one_line(error)}"
        ) from error
    if array.dtype.kind not in "biuf":
        raise DataError(
            f"column {name!r}: expected an array or the bytes of an image, got {type(value).__name__}"
        )
    return array


class Rows:
    """The rows of an output: one array if the shape of a row is known, else an array for each row.

    `dims` are a row's sizes, None for unknown ones. `nullable`: failed rows become null. The result then has
    structs or objects, even if no row failed, because a null fixed-size list cannot be read back from parquet
    (pyarrow 25).
    """

    def __init__(self, count: int, dims: Sequence[int | None], dtype: str, nullable: bool) -> None:
        sizes = tuple(d for d in dims if d is not None)
        self.shape = sizes if len(sizes) == len(dims) else None
        self.rank, self.dtype, self.nullable = len(dims), np.dtype(dtype), nullable
        self.stack = None if self.shape is None else np.empty((count, *self.shape), dtype)
        self.rows: list[np.ndarray | None] = [] if self.stack is not None else [None] * count

    def place(self, index: int, full: Sequence[int], row: Sequence[int]) -> np.ndarray:
        """Memory for a row, in the shape that the op writes."""
        if self.stack is not None:
            return self.stack[index : index + 1].reshape(full)
        made = np.empty(full, self.dtype)
        self.rows[index] = made.reshape(row)
        return made

    def drop(self, index: int) -> None:
        """Clears a row that failed, so that the user does not get uninitialised memory or a partial
        result."""
        if self.stack is not None:
            self.stack[index] = 0
        else:
            self.rows[index] = None

    def to_numpy(self, valid: np.ndarray) -> np.ndarray:
        """(rows, ...), or an object array of rows if they differ in shape or may be None."""
        if self.stack is not None and not self.nullable:
            return self.stack
        missing = None if self.nullable else np.empty((0,) * self.rank, self.dtype)
        objects = np.empty(len(valid), object)
        for i, ok in enumerate(valid):
            objects[i] = missing if not ok else self.rows[i] if self.stack is None else self.stack[i]
        return objects

    def to_arrow(self, valid: np.ndarray, plain: bool) -> Any:
        """Fixed-shape tensors, or structs of `data` and `shape`. `plain`: lists in place of tensors, and the
        next larger signed type in place of an unsigned one, for Spark."""
        import pyarrow as pa

        if self.stack is not None and self.stack.ndim == 1:
            mask = ~valid if self.nullable else None
            return pa.array(_storable(self.stack, plain), mask=mask)
        if self.stack is None or self.nullable:
            return self._structs(valid, plain)
        values = pa.array(_storable(self.stack.reshape(-1), plain))
        shape = self.stack.shape[1:]
        count, size = len(valid), int(np.prod(shape))
        if plain:
            offsets = _offsets(np.full(count, size, np.int64))
            return pa.Array.from_buffers(pa.list_(values.type), count, [None, offsets], children=[values])
        storage = pa.Array.from_buffers(pa.list_(values.type, size), count, [None], children=[values])
        return pa.ExtensionArray.from_storage(pa.fixed_shape_tensor(values.type, shape), storage)

    def _structs(self, valid: np.ndarray, plain: bool) -> Any:
        import pyarrow as pa

        every = self.rows if self.stack is None else self.stack
        rows = [row for row, ok in zip(every, valid) if ok and row is not None]
        flat = np.concatenate([row.reshape(-1) for row in rows]) if rows else np.empty(0, self.dtype)
        values = pa.array(_storable(flat, plain))
        dims = pa.array(np.array([d for row in rows for d in row.shape], np.int32))
        lengths, ranks = np.zeros(len(valid), np.int64), np.zeros(len(valid), np.int64)
        lengths[valid], ranks[valid] = [row.size for row in rows], [row.ndim for row in rows]
        data = pa.Array.from_buffers(
            pa.list_(values.type), len(valid), [None, _offsets(lengths)], children=[values]
        )
        shapes = pa.Array.from_buffers(
            pa.list_(dims.type), len(valid), [None, _offsets(ranks)], children=[dims]
        )
        mask = None if valid.all() else pa.py_buffer(np.packbits(valid, bitorder="little"))
        kind = pa.struct({"data": data.type, "shape": shapes.type})
        return pa.Array.from_buffers(kind, len(valid), [mask], children=[data, shapes])


#: Types that Spark lacks, each with a type that holds its values.
_SPARK = {"uint8": "int16", "uint16": "int32", "float16": "float32"}


def _storable(array: np.ndarray, plain: bool) -> np.ndarray:
    if array.dtype == bool:  # Arrow's are bits
        array = array.view(np.uint8)
    return array.astype(_SPARK.get(array.dtype.name, array.dtype), copy=False) if plain else array


def _offsets(lengths: np.ndarray) -> Any:
    import pyarrow as pa

    ends = np.concatenate([[0], np.cumsum(lengths)])
    if ends[-1] > np.iinfo(np.int32).max:
        raise DataError(
            f"{ends[-1]} values in a column of a batch, Arrow's lists hold 2147483647: use smaller batches"
        )
    return pa.py_buffer(ends.astype(np.int32))
