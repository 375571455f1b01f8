"""`Map.collate`: from the samples of a PyTorch loader to a map, and back to tensors."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .columns import is_array_or_file
from .errors import DataError

if TYPE_CHECKING:
    from .mapping import Map


def collate(mapping: Map, samples: Sequence[Mapping[str, Any]], read: Collection[str]) -> dict[str, Any]:
    """The samples as a batch of tensors, in which the columns `read` are replaced by the op's outputs."""
    import torch
    from torch.utils.data import default_collate

    columns: dict[str, list[Any]] = {}
    for i, sample in enumerate(samples):
        if not isinstance(sample, Mapping):
            raise DataError(f"sample {i}: expected a dict of columns, got {type(sample).__name__}")
        if sample.keys() != samples[0].keys():
            raise DataError(f"sample {i}: expected the columns {list(samples[0])}, got {list(sample)}")
        for name, value in sample.items():
            columns.setdefault(name, []).append(value)
    kept = {name: default_collate(values) for name, values in columns.items() if name not in read}
    made = mapping({name: _column(values) if name in read else values for name, values in columns.items()})
    return kept | {name: _tensors(values, torch) for name, values in made.items() if name not in kept}


def _column(values: list[Any]) -> Any:
    """Rows of one shape as one array, so that they run as one batch; others, and files, as they are."""
    if any(is_array_or_file(value) and not isinstance(value, np.ndarray) for value in values):
        return values
    try:
        rows = [np.asarray(value) for value in values]
    except (ValueError, TypeError, RuntimeError):
        return values  # the row that NumPy cannot read is named when it is mapped
    alike = all(row.shape == rows[0].shape and row.dtype == rows[0].dtype for row in rows)
    return np.stack(rows) if alike else rows


def _tensors(values: np.ndarray, torch: Any) -> Any:
    """An output as a tensor, or a list if rows differ in shape or have none."""
    if values.dtype != object:
        return torch.from_numpy(values)
    return [torch.from_numpy(row) if isinstance(row, np.ndarray) else row for row in values]
