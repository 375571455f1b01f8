"""Intensity transforms."""

from .normalize import Normalize, normalize

__all__ = ["Normalize", "normalize"]
