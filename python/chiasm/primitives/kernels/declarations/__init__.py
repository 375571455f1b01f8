"""Every kernel, declared once, in the file of its family: see schema.py for the language."""

from importlib import import_module

from ..registry import CONSTANTS as CONSTANTS
from ..registry import ENUMERATIONS as ENUMERATIONS
from ..registry import KERNELS as KERNELS

# In the order of docs/kernels.md.
for _family in ["filters", "shapes", "frames", "levels", "resampling", "features", "networks", "matrices"]:
    import_module(f".{_family}", __name__)
