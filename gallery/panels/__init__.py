"""The content of an op's picture: its inputs and the C++ program's outputs, as labelled panels, and a
caption."""

from .choice import caption, panels
from .model import WIDE, Panel, Shown

__all__ = ["WIDE", "Panel", "Shown", "caption", "panels"]
