"""The one exception of chiasm.data."""

from __future__ import annotations


class DataError(RuntimeError):
    """A batch, a row or an input cannot be mapped: the message names it, the expected and the actual
    value."""
