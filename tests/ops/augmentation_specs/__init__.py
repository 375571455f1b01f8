"""How the augmentations are to be deployed. They are not in the catalog yet: their code has been compared on
every engine for sequences alone (tests/export/test_augmentation.py), not op by op."""

import importlib
import pkgutil

from chiasm.export.catalog import STENCIL, Entry
from chiasm.export.spec import Spec

__all__ = ["SPECS", "STENCIL", "add"]

SPECS: dict[str, Entry] = {}


def add(spec: Spec) -> None:
    """Note an op."""
    SPECS[spec.name] = Entry(spec, spec.name)


for _module in pkgutil.iter_modules(__path__):
    importlib.import_module(f"{__name__}.{_module.name}")
