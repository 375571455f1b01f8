"""An image as an object, for eager Python: a tensor that knows its colours and its layout."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor
from torch.utils.dlpack import from_dlpack, to_dlpack

from ..color import bgr_to_grayscale, grayscale_to_rgb, rgb_to_bgr, rgb_to_grayscale
from ..primitives.core.checks import check_tensor
from .base import ChannelsOrder, ColorSpace, ImageLayout, ImageSize, PixelFormat
from .files import ImageLoadType, load_image, write_image
from .terminal import image_to_string

_CHANNELS = {ColorSpace.GRAY: 1, ColorSpace.RGB: 3, ColorSpace.BGR: 3}


class Image:
    """One image, (C, H, W) or (H, W, C), with its colours and its layout; Kornia's class.

    A method returns another image, or this one if nothing changes. The ops take ``image.data``; what exports
    is a function of tensors.

    Args:
        data: the pixels, of the shape that layout says.
        pixel_format: the colours, and the bits of a value of data.
        layout: the size, the channels and their place.

    Raises:
        TypeError: if data is not a tensor.
        ValueError: if data's shape, its bits or the colours do not fit together.

    Example:
        >>> import numpy as np
        >>> image = Image.from_numpy(np.zeros((4, 6, 3), np.uint8), ColorSpace.BGR)
        >>> image.width, image.to_gray().shape, image.float().dtype
        (6, torch.Size([4, 6, 1]), torch.float32)
    """

    def __init__(self, data: Tensor, pixel_format: PixelFormat, layout: ImageLayout) -> None:
        check_tensor(data, "data")
        size, channels = layout.image_size, layout.channels
        first = _is_first(layout.channels_order)
        shape = [channels, *size] if first else [*size, channels]
        if list(data.shape) != shape:
            raise ValueError(f"data: expected the layout's shape {shape}, got {list(data.shape)}")
        if pixel_format.bit_depth != 8 * data.element_size():
            raise ValueError(
                f"pixel_format: expected a bit_depth of {8 * data.element_size()} for {data.dtype}, got"
                f" {pixel_format.bit_depth}"
            )
        wanted = _CHANNELS.get(pixel_format.color_space, channels)
        if channels != wanted:
            raise ValueError(
                f"layout: expected {wanted} channels for {pixel_format.color_space.name}, got {channels}"
            )
        self._data, self._pixel_format, self._layout = data, pixel_format, layout

    @property
    def data(self) -> Tensor:
        """The tensor."""
        return self._data

    @property
    def pixel_format(self) -> PixelFormat:
        """The colours, and the bits of a value."""
        return self._pixel_format

    @property
    def layout(self) -> ImageLayout:
        """The size, the channels and their place."""
        return self._layout

    @property
    def shape(self) -> torch.Size:
        """The tensor's shape."""
        return self._data.shape

    @property
    def dtype(self) -> torch.dtype:
        """The tensor's dtype."""
        return self._data.dtype

    @property
    def device(self) -> torch.device:
        """The tensor's device."""
        return self._data.device

    @property
    def channels(self) -> int:
        """The number of channels."""
        return self._layout.channels

    @property
    def image_size(self) -> ImageSize:
        """Height and width."""
        return self._layout.image_size

    @property
    def height(self) -> int:
        """The number of rows."""
        return self._layout.image_size.height

    @property
    def width(self) -> int:
        """The number of columns."""
        return self._layout.image_size.width

    @property
    def channels_order(self) -> ChannelsOrder:
        """The place of the channels."""
        return self._layout.channels_order

    def __repr__(self) -> str:
        return f"Image data: {self.data}\nPixel Format: {self.pixel_format}\n Layout: {self.layout}"

    def to(
        self, device: str | torch.device | torch.dtype | None = None, dtype: torch.dtype | None = None
    ) -> Image:
        """The image on another device or of another dtype; values are not scaled. The first argument may be
        the dtype."""
        if isinstance(device, torch.dtype):
            device, dtype = None, device
        data = self._data.to(device=device, dtype=dtype)
        return Image(data, PixelFormat(self._pixel_format.color_space, 8 * data.element_size()), self._layout)

    def float(self) -> Image:
        """The image as float32; values are not scaled."""
        return self.to(dtype=torch.float32)

    def clone(self) -> Image:
        """A copy."""
        return Image(self._data.clone(), self._pixel_format, self._layout)

    def to_gray(self) -> Image:
        """The image in shades of grey."""
        return self._as(ColorSpace.GRAY)

    def to_rgb(self) -> Image:
        """The image as red, green and blue."""
        return self._as(ColorSpace.RGB)

    def to_bgr(self) -> Image:
        """The image as blue, green and red."""
        return self._as(ColorSpace.BGR)

    def _as(self, wanted: ColorSpace) -> Image:
        has = self._pixel_format.color_space
        if has == wanted:
            return self
        if has == ColorSpace.UNKNOWN:
            raise ValueError("pixel_format: expected GRAY, RGB or BGR to convert from, got UNKNOWN")
        planes = self._planes()
        if wanted == ColorSpace.GRAY:
            planes = rgb_to_grayscale(planes) if has == ColorSpace.RGB else bgr_to_grayscale(planes)
        else:
            planes = grayscale_to_rgb(planes) if has == ColorSpace.GRAY else rgb_to_bgr(planes)
        data = planes if _is_first(self.channels_order) else planes.permute(1, 2, 0)
        layout = ImageLayout(self.image_size, _CHANNELS[wanted], self.channels_order)
        return Image(data, PixelFormat(wanted, self._pixel_format.bit_depth), layout)

    def _planes(self) -> Tensor:
        """The tensor as (C, H, W)."""
        return self._data if _is_first(self.channels_order) else self._data.permute(2, 0, 1)

    @classmethod
    def from_numpy(
        cls,
        data: np.ndarray,
        color_space: ColorSpace | None = None,
        channels_order: ChannelsOrder = ChannelsOrder.CHANNELS_LAST,
    ) -> Image:
        """The image of an array, with which it shares memory.

        Args:
            data: (H, W, C), (C, H, W) or, of one channel, (H, W).
            color_space: the colours; None is GRAY for one channel, RGB for three, else UNKNOWN.
            channels_order: the place of the channels in data.

        Raises:
            ValueError: if data has another number of dimensions, or color_space does not fit.
        """
        if data.ndim == 2:
            data = data[None] if _is_first(channels_order) else data[..., None]
        return cls._of(torch.from_numpy(data), color_space, channels_order)

    def to_numpy(self) -> np.ndarray:
        """The tensor as an array, in the layout of the image; it shares the memory of a tensor on the CPU."""
        return self._data.detach().cpu().numpy()

    @classmethod
    def from_dlpack(
        cls,
        data: Any,
        color_space: ColorSpace | None = None,
        channels_order: ChannelsOrder = ChannelsOrder.CHANNELS_FIRST,
    ) -> Image:
        """``from_numpy`` of a DLPack capsule, or of another library's tensor that has ``__dlpack__``."""
        _is_first(channels_order)  # a capsule can be read once only
        return cls._of(from_dlpack(data), color_space, channels_order)

    def to_dlpack(self) -> Any:
        """A DLPack capsule of the tensor, which shares its memory."""
        return to_dlpack(self._data)

    @classmethod
    def from_file(cls, file_path: str | Path) -> Image:
        """The image of a file: (3, H, W), uint8, RGB (``io.load_image``)."""
        data = load_image(file_path, ImageLoadType.RGB8)
        return cls._of(data, ColorSpace.RGB, ChannelsOrder.CHANNELS_FIRST)

    def write(self, file_path: str | Path) -> None:
        """Write the image to a file, whose name says the format (``io.write_image``)."""
        write_image(file_path, self._shown())

    def print(self, max_width: int = 256) -> None:
        """Print the image to the terminal, in the colours that it has (``image_to_string``)."""
        print(image_to_string(self._shown(), max_width))

    def _shown(self) -> Tensor:
        """The tensor (C, H, W) in the order of colours of files."""
        bgr = self._pixel_format.color_space == ColorSpace.BGR
        return (self.to_rgb() if bgr else self)._planes()

    @classmethod
    def _of(cls, data: Tensor, color_space: ColorSpace | None, order: ChannelsOrder) -> Image:
        """The image of a tensor, whose shape says the size."""
        first = _is_first(order)
        if data.dim() != 3:
            shape = "(C, H, W)" if first else "(H, W, C)"
            raise ValueError(f"data: expected shape {shape}, got {list(data.shape)}")
        channels, height, width = data.shape if first else (data.size(2), data.size(0), data.size(1))
        if color_space is None:
            color_space = {1: ColorSpace.GRAY, 3: ColorSpace.RGB}.get(channels, ColorSpace.UNKNOWN)
        layout = ImageLayout(ImageSize(height, width), channels, order)
        return cls(data, PixelFormat(color_space, 8 * data.element_size()), layout)


def _is_first(order: ChannelsOrder) -> bool:
    if not isinstance(order, ChannelsOrder):
        raise ValueError(f"channels_order: expected CHANNELS_FIRST or CHANNELS_LAST, got {order!r}")
    return order == ChannelsOrder.CHANNELS_FIRST
