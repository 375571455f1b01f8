"""Mild warps of the photographs, in pixels."""

from __future__ import annotations

import math

import torch
from torch import Tensor
from torch.nn import functional

from chiasm.geometry import transform

from .setting import FACE, Inputs, Setting, mesh, motion


def lattice(rgb: Tensor, steps: int = 8) -> Tensor:
    """Photographs with a lattice drawn on them, which shows how they are warped."""
    h, w = rgb.shape[-2:]
    step = w / steps
    # No lines at the borders, which some warps repeat
    y, x = (
        torch.arange(h)[:, None] + 0.5 * step,
        torch.arange(w) + 0.5 * step,
    )
    thick = max(1.0, w / 200)
    lines = ((x % step) < thick) | ((y % step) < thick)
    return torch.where(lines, rgb * 0.25 + 0.75 * torch.tensor([1.0, 0.95, 0.35]).view(3, 1, 1), rgb)


def planar(s: Setting) -> Inputs:
    """Transforms of images, in pixels."""
    w, h = s.width, s.height
    affine = torch.tensor([[0.75, -0.28, 0.22 * w], [0.24, 0.7, 0.02 * h]])
    homography = torch.tensor([[0.72, -0.16, 0.14 * w], [0.12, 0.68, 0.02 * h], [0.12 / w, -0.1 / h, 1.0]])
    made = {
        "M": homography if s.shape("M")[1:] == (3, 3) else affine,
        "matrix": affine,
        "transform": homography,
        "src_homo_dst": torch.tensor([[1.0, 0.25, 0.1], [-0.2, 1.1, 0.0], [0.15, 0.25, 1.0]]),
        "center": torch.tensor([0.5 * w, 0.45 * h]),
        "max_radius": torch.tensor(0.55 * h),
        "translations": torch.tensor([0.12 * w, -0.1 * h]),
        "boxes": quadrilateral(w, h),
        "src_box": quadrilateral(w, h),
        "rmat": motion((0.0, 0.0, 0.0), (15.0, 40.0, 10.0))[:3, :3],
        "tvec": torch.tensor([[1.0], [-0.5], [2.0]]),
        "points_src": quadrilateral(w, h),
        "points_dst": FACE * torch.tensor([w - 1.0, h - 1.0]),
        "dst_box": FACE * torch.tensor([s.sizes.get("OW", 9) - 1.0, s.sizes.get("OH", 9) - 1.0]),
    }
    made = {name: s.repeated(value) for name, value in made.items()}
    coarse = torch.rand((1, 2, 5, 7), generator=torch.Generator().manual_seed(3)) * 0.3 - 0.15
    made["noise"] = (
        functional.interpolate(coarse, (h, w), mode="bicubic")
        .expand(s.sizes.get("B", 1), -1, -1, -1)
        .contiguous()
    )
    return (
        made
        | ripples(s)
        | {
            "grid": (
                mesh(s.sizes.get("W", 2), s.sizes.get("H", 2))
                .expand(s.sizes.get("B", 1), -1, -1, -1)
                .contiguous()
            )
        }
    )


def quadrilateral(w: int, h: int) -> Tensor:
    """Four corners around the centre of an image, in perspective."""
    return torch.tensor([[0.22, 0.12], [0.7, 0.04], [0.85, 0.8], [0.3, 0.92]]) * torch.tensor([w, h])


def ripples(s: Setting) -> Inputs:
    """Maps that twist around the centre; those in pixels also reach slightly outside the image."""
    x, y = mesh(s.sizes.get("OW", 2), s.sizes.get("OH", 2)).unbind(-1)
    twist = 0.9 * torch.exp(-2.5 * (x * x + y * y))
    u, v = 1.08 * (x * twist.cos() - y * twist.sin()), 1.08 * (x * twist.sin() + y * twist.cos())
    if s.spec.config.get("normalized_coordinates"):
        return {"map_x": s.repeated(u), "map_y": s.repeated(v)}
    return {
        "map_x": s.repeated((u + 1) / 2 * (s.width - 1)),
        "map_y": s.repeated((v + 1) / 2 * (s.height - 1)),
    }


def whole_box(s: Setting) -> Inputs:
    low, high = (torch.tensor([s.width, s.height]) * share for share in (0.3, 0.68))
    corners = (low + FACE * (high - low)).round().long()
    return {"src_box": corners.expand(s.sizes["B"], 4, 2).contiguous()}


def splines(s: Setting) -> Inputs:
    """Eight points; the inner ones move."""
    ends = torch.tensor(
        [
            [-0.9, -0.9],
            [0.9, -0.9],
            [0.9, 0.9],
            [-0.9, 0.9],
            [-0.35, -0.3],
            [0.35, -0.35],
            [0.4, 0.35],
            [-0.3, 0.35],
        ]
    )
    moved = ends + torch.tensor([[0.0, 0.0]] * 4 + [[0.2, -0.15], [0.15, 0.2], [-0.2, 0.15], [-0.15, -0.2]])
    if s.shape("points_src") == ("B", 6, 2):
        return {"points_src": s.repeated(ends[1:7]), "points_dst": s.repeated(moved[1:7])}
    kernel, affine = transform.get_tps_transform(ends[None], moved[None])
    side = math.isqrt(s.sizes.get("N", 1))
    made = {
        "kernel_centers": moved,
        "kernel_weights": kernel[0],
        "affine_weights": affine[0],
        "points_src": mesh(side, side).flatten(0, 1),
    }
    return {name: s.repeated(value) for name, value in made.items()}
