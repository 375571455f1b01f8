"""Every kernel, declared once, in the file of its family: see schema.py for the language."""

# In the order of docs/kernels.md.
from . import filters, shapes, frames, levels, resampling, features, networks, matrices  # isort: skip
from ..registry import CONSTANTS, ENUMERATIONS, KERNELS

__all__ = ["CONSTANTS", "ENUMERATIONS", "KERNELS"]
