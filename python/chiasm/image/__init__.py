"""Input and output of images: conversion from and to uint8, grids, drawing."""

from ..primitives.core.modules import lazy_modules
from .conversion import image_to_tensor, tensor_to_image
from .draw import draw_line, draw_point2d
from .grid import make_grid
from .shapes import draw_convex_polygon, draw_rectangle
from .size import ImageSize

__all__ = [
    "ImageSize",
    "draw_convex_polygon",
    "draw_line",
    "draw_point2d",
    "draw_rectangle",
    "image_to_tensor",
    "make_grid",
    "tensor_to_image",
]

__getattr__, __dir__ = lazy_modules(__name__, globals())
