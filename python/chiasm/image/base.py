"""What an ``Image`` says about its tensor, for eager Python."""

from enum import Enum
from typing import NamedTuple


class ImageSize(NamedTuple):
    """Height and width in pixels; a pair (height, width) too.

    >>> ImageSize(480, 640).width
    640
    """

    height: int
    width: int


class ColorSpace(Enum):
    """The colours of an image: what its channels are. UNKNOWN is any number of channels, such as RGBA.

    >>> ColorSpace.RGB.name
    'RGB'
    """

    UNKNOWN = 0
    GRAY = 1
    RGB = 2
    BGR = 3


class ChannelsOrder(Enum):
    """Whether an image is (C, H, W) or (H, W, C).

    >>> ChannelsOrder.CHANNELS_LAST.value
    1
    """

    CHANNELS_FIRST = 0
    CHANNELS_LAST = 1


class PixelFormat(NamedTuple):
    """The colours of an image and the bits of one value: 8 of uint8, 32 of float32.

    >>> PixelFormat(ColorSpace.GRAY, 8).bit_depth
    8
    """

    color_space: ColorSpace
    bit_depth: int


class ImageLayout(NamedTuple):
    """The size of an image, the number of its channels and their place.

    >>> ImageLayout(ImageSize(480, 640), 3, ChannelsOrder.CHANNELS_FIRST).image_size.height
    480
    """

    image_size: ImageSize
    channels: int
    channels_order: ChannelsOrder
