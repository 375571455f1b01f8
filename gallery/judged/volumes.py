"""Pairs of volumes to compare."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional

from gallery.geometric.setting import Inputs, Setting

from .pairs import noise

DEPTH, HEIGHT, WIDTH = 12, 44, 58


def coordinates() -> tuple[Tensor, Tensor, Tensor]:
    """z, y, x from -1 to 1; x as wide as the volume."""
    axes = (
        torch.linspace(-1, 1, DEPTH),
        torch.linspace(-1, 1, HEIGHT),
        torch.linspace(-1, 1, WIDTH) * WIDTH / HEIGHT,
    )
    return torch.meshgrid(*axes, indexing="ij")


def ball(place: tuple[float, float, float], radius: float) -> Tensor:
    """(D, H, W): 1 inside, 0 outside, smooth at the surface."""
    z, y, x = coordinates()
    distance = ((z - place[0]) ** 2 + (y - place[1]) ** 2 + (x - place[2]) ** 2).sqrt()
    return torch.sigmoid(12 * (radius - distance))


def balls(s: Setting) -> Inputs:
    """A ball, with two classes also a smaller one; the estimates are displaced."""
    true = torch.stack([ball((0.0, 0.0, -0.4), 0.6), ball((0.2, 0.1, 0.8), 0.4)])
    found = torch.stack([ball((0.2, 0.1, -0.3), 0.55), ball((0.0, -0.1, 0.9), 0.45)])
    if s.shape("pred")[1] == 1:
        return {"pred": found[None, :1], "target": (true[None, :1] > 0.5).long()}
    labels = (true > 0.5).long() * torch.tensor([1, 2]).view(2, 1, 1, 1)
    rest = (1 - found.sum(0, keepdim=True)).clamp(min=0)
    return {"pred": torch.cat([rest, found])[None], "target": labels.amax(0)[None, None]}


def frames_of(rgb: Tensor) -> Tensor:
    """(B, C, D, H, W): the frames of a camera that moves over the photograph."""
    step = 3
    small = functional.interpolate(
        rgb, (HEIGHT, WIDTH + step * DEPTH), mode="bilinear", antialias=True
    ).clamp(0, 1)
    return torch.stack([small[..., step * i : step * i + WIDTH] for i in range(DEPTH)], 2).contiguous()


def noisy_volumes(s: Setting) -> Inputs:
    """Frames of the photograph, and the same with noise that grows from frame to frame."""
    made = frames_of(s.rgb)
    growing = torch.linspace(0.02, 0.25, DEPTH).view(1, 1, -1, 1, 1)
    return {"img1": made, "img2": (made + growing * noise(tuple(made.shape), 1.0)).clamp(0, 1)}


def related_volumes(s: Setting) -> Inputs:
    """Frames of the photograph, and their negative with noise; masks exclude one side."""
    made = frames_of(s.rgb.mean(1, keepdim=True))[:, 0]
    x = coordinates()[2][None]
    other = (1 - made**2 + noise(tuple(made.shape), 0.1)).clamp(0, 1)
    return {"input": made, "target": other, "input_mask": x > -0.8, "target_mask": x < 0.9}
