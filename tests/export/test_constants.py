"""Values of an input that a user writes."""

import warnings

import numpy as np
import pytest

from chiasm.export.constants import in_dtype


@pytest.mark.parametrize(
    ("value", "dtype"),
    [
        ([1.5], "int64"),
        ([[1, np.nan]], "int32"),
        (2.0**63, "int64"),
        (2**63, "int64"),
        (np.array(2**63, np.uint64), "int64"),
        (np.array([300]), "uint8"),
        (-1, "uint8"),
        (2, "bool"),
        (1e39, "float32"),
        (70000, "float16"),
        (10**400, "float64"),
    ],
)
def test_no_value_becomes_another(value: object, dtype: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises((ValueError, OverflowError)):
            in_dtype(value, dtype)


def test_values_keep_their_shape_in_another_dtype() -> None:
    for value, dtype in ((3.0, "int64"), (True, "bool"), ([[np.inf, 0.1]], "float32"), ([], "uint8")):
        made = in_dtype(value, dtype)
        assert made.dtype == dtype and made.shape == np.shape(value)
        np.testing.assert_array_equal(made, np.array(value, dtype))
