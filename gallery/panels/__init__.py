"""What to show of an op: its inputs and what the C++ program made of them, as labelled pictures, and a
caption."""

from .choice import caption, panels
from .model import WIDE, Panel, Shown

__all__ = ["WIDE", "Panel", "Shown", "caption", "panels"]
