"""The parts of a picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch

from chiasm.export.spec import Spec

HALF, THIRD, WHOLE = (236, 177), (154, 154), (480, 170)
#: The weight of a panel that fills a row.
WIDE = 3.0


@dataclass(frozen=True)
class Panel:
    """One picture.

    given: whether it is an input.
    weight: its width in a row, relative to the other panels.
    matrix: whether it is the values of a small matrix.
    """

    label: str
    image: np.ndarray
    note: str = ""
    given: bool = False
    weight: float = 1.0
    matrix: bool = False


@dataclass(frozen=True)
class Shown:
    """An op, the photograph, the inputs and outputs by name, and the manifest's descriptions of the
    outputs."""

    spec: Spec
    photo: np.ndarray
    inputs: dict[str, torch.Tensor]
    described: list[dict]
    outputs: dict[str, torch.Tensor]

    @property
    def first(self) -> torch.Tensor:
        return next(iter(self.outputs.values()))


def numbers(name: str, tensor: torch.Tensor) -> str:
    """A name and a few values."""
    rows = tensor if tensor.dim() == 0 or len(tensor) > 1 else tensor[0]
    texts = [f"{v:.3g}" for v in rows.flatten().tolist()]
    return f"{name} {texts[0] if len(set(texts)) == 1 else ' '.join(texts)}"
