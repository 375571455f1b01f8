"""Values that a user writes, in the dtype of an input."""

from __future__ import annotations

from typing import Any

import numpy as np


def in_dtype(value: Any, dtype: str) -> np.ndarray:
    """A number, lists or an array as an array of `dtype`.

    Raises
    ------
    ValueError, TypeError, OverflowError
        If it is none of these, or NumPy would make another number of a value: 1.5 in an integer, 300 in a
        byte, 1e39 in a float32. (Rounding to the nearest float is none.)

    Examples
    --------
    >>> in_dtype([[1, 2]], "float32")
    array([[1., 2.]], dtype=float32)
    """
    array = np.asarray(value)
    if array.dtype == dtype:  # may be large, and only its size be used: not to be touched
        return np.reshape(np.ascontiguousarray(array), array.shape)
    with np.errstate(all="ignore"):
        made = np.reshape(np.ascontiguousarray(value, dtype), array.shape)
        if made.dtype.kind in "biu":
            wrong = made != array
        else:
            wrong = np.isinf(made) & np.isfinite(array.astype(np.float64))
    if wrong.any():
        raise ValueError(f"{array[wrong][0]} is no value of {dtype}")
    return made
