"""Kornia's enumerations of settings. Augmentations take a member as they take its name, a string."""

from __future__ import annotations

from enum import Enum
from typing import TypeVar

_Member = TypeVar("_Member", bound="_Named")


class _Named(Enum):
    @classmethod
    def get(cls: type[_Member], value: str | int | _Member) -> _Member:
        """The member of a name, in any case, or of a number; a member stays as it is."""
        if isinstance(value, str):
            if value.upper() not in cls.__members__:
                raise ValueError(
                    f"value: expected one of {[name.lower() for name in cls.__members__]}, got {value!r}"
                )
            return cls[value.upper()]
        return cls(value)


class Resample(_Named):
    """How values between pixels are found.

    >>> Resample.get("nearest").name
    'NEAREST'
    """

    NEAREST = 0
    BILINEAR = 1
    BICUBIC = 2


class BorderType(_Named):
    """What a filter reads beyond the border."""

    CONSTANT = 0
    REFLECT = 1
    REPLICATE = 2
    CIRCULAR = 3


class SamplePadding(_Named):
    """What a warp reads beyond the border."""

    ZEROS = 0
    BORDER = 1
    REFLECTION = 2
    FILL = 3


class DataKey(_Named):
    """What an argument of a sequence of augmentations is."""

    IMAGE = 0
    INPUT = 0
    MASK = 1
    BBOX = 2
    BBOX_XYXY = 3
    BBOX_XYWH = 4
    KEYPOINTS = 5
    LABEL = 6
    CLASS = 6
