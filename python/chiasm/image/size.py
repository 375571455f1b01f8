"""The size of an image as an object, for eager Python."""

from typing import NamedTuple


class ImageSize(NamedTuple):
    """Height and width in pixels; a pair (height, width) too.

    >>> ImageSize(480, 640).width
    640
    """

    height: int
    width: int
