"""What inputs are made for, and shapes that several of them are made of."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import torch
from torch import Tensor

from chiasm.export.spec import Spec
from chiasm.geometry import conversions

Inputs = dict[str, Tensor]
#: Corners from the upper left clockwise, of a box the front's first.
FACE = torch.tensor([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
BOX = torch.cat([torch.cat([FACE, torch.full((4, 1), z)], 1) for z in (0.0, 1.0)])


@dataclass(frozen=True)
class Setting:
    """What inputs are made for: the op, the sizes of its dimensions, photographs (B, 3, H, W)."""

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
        """The shape of an input as the spec has it; () where the op has none of that name."""
        return next((tuple(t.shape) for t in self.spec.inputs if t.name == name), ())

    def repeated(self, values: Tensor) -> Tensor:
        """For every entry of the batch."""
        batch = self.sizes.get("B", 1)
        return values.float().expand(batch, *values.shape).contiguous()


def made_by(makers: Mapping[str, Callable[[Setting], Inputs]], setting: Setting) -> Inputs:
    """What those make whose name the op's begins with; longer names win."""
    spec = setting.spec
    known = sorted((name for name in makers if spec.name.startswith(name)), key=len)
    made = {key: value for name in known for key, value in makers[name](setting).items()}
    return {t.name: made[t.name] for t in spec.inputs if t.name in made}


def mesh(w: int, h: int) -> Tensor:
    """(h, w, 2), from -1 to 1."""
    y, x = torch.meshgrid(torch.linspace(-1, 1, h), torch.linspace(-1, 1, w), indexing="ij")
    return torch.stack([x, y], -1)


def motion(shift: tuple[float, float, float], turn: tuple[float, float, float]) -> Tensor:
    """(4, 4) of a rotation vector in degrees."""
    made = torch.eye(4)
    made[:3, :3] = conversions.axis_angle_to_rotation_matrix(torch.deg2rad(torch.tensor([turn])))[0]
    made[:3, 3] = torch.tensor(shift)
    return made
