"""The policies, under Kornia's path."""

from torch import nn

from .classes import CLASSES

__all__ = ["AutoAugment", "RandAugment", "TrivialAugment"]

AutoAugment: type[nn.Module] = CLASSES["AutoAugment"]
RandAugment: type[nn.Module] = CLASSES["RandAugment"]
TrivialAugment: type[nn.Module] = CLASSES["TrivialAugment"]


def __dir__() -> list[str]:
    return __all__
