"""Names of choices by Kornia's enumerations: members are the strings that the functions take."""

from enum import Enum


class ThresholdType(str, Enum):
    """What ``threshold`` does.

    >>> ThresholdType.THRESH_TRUNC == "trunc"
    True
    """

    THRESH_BINARY = "binary"
    THRESH_BINARY_INV = "binary_inv"
    THRESH_TRUNC = "trunc"
    THRESH_TOZERO = "tozero"
    THRESH_TOZERO_INV = "tozero_inv"
