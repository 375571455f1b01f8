"""Kornia's enumerations; their members are equal to the strings that the functions take."""

from enum import Enum


class ThresholdType(str, Enum):
    """The types of ``threshold``.

    >>> ThresholdType.THRESH_TRUNC == "trunc"
    True
    """

    THRESH_BINARY = "binary"
    THRESH_BINARY_INV = "binary_inv"
    THRESH_TRUNC = "trunc"
    THRESH_TOZERO = "tozero"
    THRESH_TOZERO_INV = "tozero_inv"
