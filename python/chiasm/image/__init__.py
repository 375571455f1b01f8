"""Input and output of images: arrays, files, conversion from and to uint8, grids, drawing."""

from ..primitives.core.modules import lazy_modules
from .arrays import ImageToTensor, image_list_to_tensor, image_to_tensor, tensor_to_image
from .base import ChannelsOrder, ColorSpace, ImageLayout, ImageSize, PixelFormat
from .conversion import frames_to_tensor, tensor_to_frames
from .draw import draw_line, draw_point2d
from .grid import make_grid
from .image import Image
from .shapes import draw_convex_polygon, draw_rectangle
from .terminal import image_to_string, print_image

__all__ = [
    "ChannelsOrder",
    "ColorSpace",
    "Image",
    "ImageLayout",
    "ImageSize",
    "ImageToTensor",
    "PixelFormat",
    "draw_convex_polygon",
    "draw_line",
    "draw_point2d",
    "draw_rectangle",
    "frames_to_tensor",
    "image_list_to_tensor",
    "image_to_string",
    "image_to_tensor",
    "make_grid",
    "print_image",
    "tensor_to_frames",
    "tensor_to_image",
]

__getattr__, __dir__ = lazy_modules(__name__, globals())
