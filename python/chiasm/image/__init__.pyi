# Written by `make stubs` from the signatures of the functions; do not edit.

from typing import Optional

from torch import Tensor, nn

from .arrays import ImageToTensor as ImageToTensor
from .arrays import image_list_to_tensor as image_list_to_tensor
from .arrays import image_to_tensor as image_to_tensor
from .arrays import tensor_to_image as tensor_to_image
from .base import ChannelsOrder as ChannelsOrder
from .base import ColorSpace as ColorSpace
from .base import ImageLayout as ImageLayout
from .base import ImageSize as ImageSize
from .base import PixelFormat as PixelFormat
from .conversion import frames_to_tensor as frames_to_tensor
from .conversion import tensor_to_frames as tensor_to_frames
from .draw import draw_line as draw_line
from .draw import draw_point2d as draw_point2d
from .grid import make_grid as make_grid
from .image import Image as Image
from .shapes import draw_convex_polygon as draw_convex_polygon
from .shapes import draw_rectangle as draw_rectangle
from .terminal import image_to_string as image_to_string
from .terminal import print_image as print_image

class DrawConvexPolygon(nn.Module):
    """`draw_convex_polygon` as a module: Fill one convex polygon in each image: all pixels whose centre
    lies in it or on its edge."""
    def __init__(self) -> None: ...
    def forward(self, images: Tensor, polygons: Tensor, colors: Tensor) -> Tensor: ...
    def __call__(self, images: Tensor, polygons: Tensor, colors: Tensor) -> Tensor: ...

class DrawLine(nn.Module):
    """`draw_line` as a module: Draw straight lines one pixel wide, 8-connected, both ends included."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor, p1: Tensor, p2: Tensor, color: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor, p1: Tensor, p2: Tensor, color: Tensor) -> Tensor: ...

class DrawPoint2d(nn.Module):
    """`draw_point2d` as a module: Draw points of one pixel. Unlike Kornia, this op does not change its
    input, rounds coordinates instead of truncating them, ignores points outside the image, and takes a
    batch."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor, points: Tensor, color: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor, points: Tensor, color: Tensor) -> Tensor: ...

class DrawRectangle(nn.Module):
    """`draw_rectangle` as a module: Draw rectangles, later ones over earlier ones."""

    color: Optional[Tensor]
    fill: Optional[bool]
    line_width: int
    def __init__(
        self, color: Optional[Tensor] = None, fill: Optional[bool] = None, line_width: int = 1
    ) -> None: ...
    def forward(self, image: Tensor, rectangle: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor, rectangle: Tensor) -> Tensor: ...

class FramesToTensor(nn.Module):
    """`frames_to_tensor` as a module: Convert uint8 with channels last to floating point in [0, 1] with
    channels first. The order of the channels is kept: OpenCV's images are BGR. ``image_to_tensor`` takes
    an array and does not scale."""

    keepdim: bool
    def __init__(self, keepdim: bool = False) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class MakeGrid(nn.Module):
    """`make_grid` as a module: Arrange a batch of images in a grid, row by row, with zeros between
    images and in empty cells."""

    n_row: Optional[int]
    padding: int
    def __init__(self, n_row: Optional[int] = None, padding: int = 2) -> None: ...
    def forward(self, tensor: Tensor) -> Tensor: ...
    def __call__(self, tensor: Tensor) -> Tensor: ...

class TensorToFrames(nn.Module):
    """`tensor_to_frames` as a module: Convert floating point in [0, 1] with channels first to uint8 with
    channels last."""
    def __init__(self) -> None: ...
    def forward(self, tensor: Tensor) -> Tensor: ...
    def __call__(self, tensor: Tensor) -> Tensor: ...

__all__ = [
    "ChannelsOrder",
    "ColorSpace",
    "DrawConvexPolygon",
    "DrawLine",
    "DrawPoint2d",
    "DrawRectangle",
    "FramesToTensor",
    "Image",
    "ImageLayout",
    "ImageSize",
    "ImageToTensor",
    "MakeGrid",
    "PixelFormat",
    "TensorToFrames",
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
