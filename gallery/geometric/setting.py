"""The setting for which inputs are made, and shapes that several inputs share."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import torch
from torch import Tensor

from chiasm.export.spec import Spec
from chiasm.geometry import conversions

Inputs = dict[str, Tensor]
#: Corners, clockwise from the upper left one; a box has those of its front first.
FACE = torch.tensor([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
BOX = torch.cat([torch.cat([FACE, torch.full((4, 1), z)], 1) for z in (0.0, 1.0)])


@dataclass(frozen=True)
class Setting:
    """The setting for which inputs are made: the op, the sizes of its dimensions, photographs (B, 3, H,
    W)."""

    spec: Spec
    sizes: dict[str, int]
    rgb: Tensor

    @property
    def width(self) -> int:
        return self.rgb.shape[-1]

    @property
    def height(self) -> int:
        return self.rgb.shape[-2]

    def shape(self, name: str) -> tuple[int | str, ...]:
        """The shape of an input in the spec; () if the op has no input of that name."""
        return next((tuple(t.shape) for t in self.spec.inputs if t.name == name), ())

    def repeated(self, values: Tensor) -> Tensor:
        """``values``, repeated for every sample of the batch."""
        batch = self.sizes.get("B", 1)
        return values.float().expand(batch, *values.shape).contiguous()


def made_by(makers: Mapping[str, Callable[[Setting], Inputs]], setting: Setting) -> Inputs:
    """The inputs from all makers with whose name the op's name begins; longer names take precedence."""
    spec = setting.spec
    known = sorted((name for name in makers if spec.name.startswith(name)), key=len)
    made = {key: value for name in known for key, value in makers[name](setting).items()}
    return {t.name: made[t.name] for t in spec.inputs if t.name in made}


def mesh(w: int, h: int) -> Tensor:
    """A grid (h, w, 2) of coordinates from -1 to 1."""
    y, x = torch.meshgrid(torch.linspace(-1, 1, h), torch.linspace(-1, 1, w), indexing="ij")
    return torch.stack([x, y], -1)


def motion(shift: tuple[float, float, float], turn: tuple[float, float, float]) -> Tensor:
    """The matrix (4, 4) of a translation and a rotation vector in degrees."""
    made = torch.eye(4)
    made[:3, :3] = conversions.axis_angle_to_rotation_matrix(torch.deg2rad(torch.tensor([turn])))[0]
    made[:3, 3] = torch.tensor(shift)
    return made
