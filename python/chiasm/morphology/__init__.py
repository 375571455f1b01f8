"""Mathematical morphology."""

from .dilation import dilation

__all__ = ["dilation"]
