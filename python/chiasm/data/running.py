"""From rows to an op's inputs, and its outputs to rows."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..export.constants import in_dtype
from ..export.sizes import evaluate
from ..export.text import one_line
from .columns import Column, Rows
from .errors import DataError
from .mapping import Opened

if TYPE_CHECKING:
    from .mapping import Map


#: The layouts of images that are decoded from files.
LAYOUTS = ("HWC", "NHWC", "NCHW")


def channels(tensor: Any) -> str | None:
    """The number of channels of an image, an expression; None if the tensor is no image."""
    if tensor.layout not in LAYOUTS or len(tensor.shape) != len(tensor.layout):
        return None
    return tensor.shape[tensor.layout.index("C")]


def run(
    wanted: Map, opened: Opened, columns: Mapping[str, Column], name_of: Callable[[int], str], first: int
) -> tuple[dict[str, Rows], list[str | None]]:
    """`Map.run`: in batches if the rows allow it, else row by row."""
    method = opened.method
    count = next(iter(columns.values())).length
    by_input = {name: columns[source] for name, source in wanted.columns.items()}
    constants = {
        t.name: _constant(t, wanted.constants[t.name], opened)
        for t in method.inputs
        if t.name in wanted.constants
    }
    shapes = _row_shapes(opened, by_input, constants)
    nullable = wanted.errors == "null"
    outputs = [Rows(count, shape, t.dtypes[0], nullable) for t, shape in zip(method.outputs, shapes)]
    errors: list[str | None] = [None] * count
    if not _as_batches(opened, by_input, constants, outputs, count):
        for i in range(count):
            try:
                _run_row(opened, by_input, constants, outputs, i)
            except Exception as error:  # any error counts as this row's
                message = one_line(error) or type(error).__name__
                if wanted.errors == "raise":
                    raise DataError(f"row {first + i}{name_of(i)}: {message}") from error
                errors[i] = message
                for output in outputs:
                    output.drop(i)
    named = {t.name: rows for t, rows in zip(method.outputs, outputs)}
    return {column: named[name] for name, column in wanted.outputs.items()}, errors


def _as_batches(
    opened: Opened,
    columns: Mapping[str, Column],
    constants: Mapping[str, np.ndarray],
    outputs: list[Rows],
    count: int,
) -> bool:
    """Run all rows as batches, as large as the manifest allows. False if they cannot be batches, or if the op
    rejects a batch: running row by row then shows which rows are bad."""
    if opened.samples is None or not count or any(rows.stack is None for rows in outputs):
        return False
    inputs = opened.method.inputs
    for t in inputs:
        leads = bool(t.shape) and t.shape[0] == opened.samples
        if t.name in columns:
            stack = columns[t.name].stack
            if stack is None or not leads or stack.ndim != len(t.shape):
                return False
        elif leads and len(constants[t.name]) != 1:
            return False
    try:
        for start in range(0, count, opened.most):
            part = slice(start, min(start + opened.most, count))
            given = []
            for t in inputs:
                if t.name in columns:
                    given.append(_dense(columns[t.name].stack[part]))  # pyright: ignore[reportOptionalSubscript]
                else:
                    value = constants[t.name]
                    leads = bool(t.shape) and t.shape[0] == opened.samples
                    given.append(np.repeat(value, part.stop - start, 0) if leads else value)
            opened.method.run_into(given, [rows.stack[part] for rows in outputs])  # pyright: ignore
    except RuntimeError:  # the runtime's ChiasmError is one
        return False
    return True


def _run_row(
    opened: Opened,
    columns: Mapping[str, Column],
    constants: Mapping[str, np.ndarray],
    outputs: list[Rows],
    i: int,
) -> None:
    given, extended = [], set[str]()
    for t in opened.method.inputs:
        if t.name in constants:
            given.append(constants[t.name])
            continue
        value = columns[t.name].row(i)
        if value is None:
            raise DataError(f"input {t.name!r}: it is missing in this row")
        image = not isinstance(value, np.ndarray)
        array = _dense(_decoded(t, value) if image else value)
        if t.shape and t.shape[0] in opened.leading | {"1"} and array.ndim == len(t.shape) - 1:
            array = array[None]
            extended.add(t.shape[0])
        elif image and t.layout.startswith("N"):
            extended.add(t.shape[0])
        given.append(array)
    method = opened.method
    places = []
    for t, rows, (full, _) in zip(method.outputs, outputs, method.output_shapes(*given)):
        row = full[1:] if _is_single(t, extended) else full
        if rows.shape is not None and tuple(row) != rows.shape:
            raise DataError(f"output {t.name!r}: a row of shape {tuple(row)} among rows of {rows.shape}")
        places.append(rows.place(i, full, row))
    method.run_into(given, places)


def _is_single(tensor: Any, extended: set[str]) -> bool:
    """Whether an output's first dimension counts samples, of which a row is one."""
    return bool(tensor.shape) and (
        tensor.shape[0] in extended or (tensor.shape[0] == "1" and tensor.layout.startswith("N"))
    )


def _row_shapes(
    opened: Opened, columns: Mapping[str, Column], constants: Mapping[str, np.ndarray]
) -> list[list[int | None]]:
    """The sizes of a row of each output, if the types of columns and the constants tell them."""
    known: dict[str, int] = {}
    extended: set[str] = set()
    for t in opened.method.inputs:
        shape: tuple[int, ...] | None = None
        if t.name in constants:
            shape = constants[t.name].shape
        else:
            shape = columns[t.name].shape
            leads = bool(t.shape) and t.shape[0] in opened.leading | {"1"}
            if leads and (shape is None or len(shape) == len(t.shape) - 1):
                extended.add(t.shape[0])
                shape = None if shape is None else (1, *shape)
            if columns[t.name].encoded and (count := channels(t)) is not None:
                known[count] = 3  # if an op takes any number of channels
        if shape is not None and len(shape) == len(t.shape):
            known |= {e: d for e, d in zip(t.shape, shape) if e.isidentifier()}
    shapes: list[list[int | None]] = []
    for t in opened.method.outputs:
        dims = t.shape[1:] if _is_single(t, extended) else t.shape
        shapes.append([_size(d, known) for d in dims])
    return shapes


def _size(dim: str, known: Mapping[str, int]) -> int | None:
    """The size of a dimension; None if it has a symbol without a value, or is no valid size."""
    try:
        size = evaluate(dim, known)
    except (ValueError, ZeroDivisionError):
        return None
    return None if size < 0 else size


def _decoded(tensor: Any, data: Any) -> np.ndarray:
    from .decoding import decode  # imported late: only images need Pillow

    return decode(tensor, data)


def _dense(array: np.ndarray) -> np.ndarray:
    """The array itself if the runtime can read it, else a copy."""
    return np.require(array, requirements=("C", "A"))


def _constant(tensor: Any, value: Any, opened: Opened) -> np.ndarray:
    try:
        array = in_dtype(value, tensor.dtypes[0])
    except (ValueError, TypeError, OverflowError) as error:
        raise DataError(
            f"columns: input {tensor.name!r}: no column's name, and no constant of"
            f" {tensor.dtypes[0]}: {one_line(error)}"
        ) from error
    if tensor.shape and tensor.shape[0] in opened.leading and array.ndim == len(tensor.shape) - 1:
        array = array[None]
    sizes = tuple(str(d) for d in array.shape)
    if len(sizes) != len(tensor.shape) or any(e.isdigit() and e != d for e, d in zip(tensor.shape, sizes)):
        raise DataError(
            f"columns: input {tensor.name!r}: expected a constant of shape ({', '.join(tensor.shape)}), got"
            f" one of shape ({', '.join(sizes)})"
        )
    return array
