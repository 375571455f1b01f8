"""Points, rotations, boxes and small matrices."""

from __future__ import annotations

import torch

from chiasm.geometry import conversions, lie

from .setting import BOX, FACE, Inputs, Setting, mesh, motion


def pixel_homographies(s: Setting) -> Inputs:
    """Homographies from 640 x 480 to 800 x 360 pixels, or between -1 and 1."""
    n = int(s.shape("dst_pix_trans_src_pix")[1])
    if "denormalize" in s.spec.name:
        made = (
            torch.eye(n)
            + 0.1
            * torch.tensor(
                [[1.0, -2.0, 1.0, 0.0], [2.0, 0.0, -1.0, 1.0], [1.0, 1.0, 0.0, -1.0], [0.0, 1.0, 0.0, 0.0]]
            )[:n, :n]
        )
    elif n == 3:
        made = torch.tensor([[0.9, -0.2, 150.0], [0.1, 0.6, 10.0], [2e-4, -1e-4, 1.0]])
    else:
        made = torch.tensor(
            [[0.9, -0.2, 0.0, 14.0], [0.1, 0.6, 0.0, 2.0], [0.0, 0.1, 0.7, 1.0], [0.0, 0.0, 2e-3, 1.0]]
        )
    return {"dst_pix_trans_src_pix": s.repeated(made)}


def affine_matrices(s: Setting) -> Inputs:
    made = torch.tensor([[0.87, -0.5, 0.0, 12.0], [0.5, 0.87, 0.1, -3.0], [0.0, 0.2, 1.1, 5.0]])
    return {"A": s.repeated(made if s.shape("A")[1] == 3 else made[:2, [0, 1, 3]])}


def pixels_of(s: Setting) -> Inputs:
    """Points everywhere in an image or a volume of the op's size."""
    size = torch.tensor([float(s.spec.config[n]) for n in ("width", "height", "depth") if n in s.spec.config])
    share = torch.rand((s.sizes["N"], len(size)), generator=torch.Generator().manual_seed(0))
    return {"pixel_coordinates": share * 2 - 1 if "denormalize" in s.spec.name else share * (size - 1)}


def moved_points(s: Setting) -> Inputs:
    if s.shape("points_1")[-1:] == (2,):
        bend = torch.tensor([[0.8, -0.35, 0.3], [0.3, 0.85, -0.1], [0.15, 0.2, 1.0]])
        return {"trans_01": s.repeated(bend), "points_1": s.repeated(mesh(9, 9).flatten(0, 1))}
    return {"trans_01": s.repeated(motion((0.6, 0.4, -0.3), (10.0, 25.0, 15.0)))}


def slerp(s: Setting) -> Inputs:
    """Three steps from one rotation to another."""
    ends = conversions.axis_angle_to_quaternion(torch.tensor([[0.2, 0.0, 0.1], [0.3, 1.2, 0.9]]))
    q1, q2 = (q.expand(3, 4).contiguous() for q in ends)
    return {"q1": q1, "q2": q2, "t": torch.tensor([0.1, 0.5, 0.9])}


def one_turn(s: Setting) -> Inputs:
    turn = conversions.axis_angle_to_quaternion(torch.tensor([[0.2, 0.7, 0.3]]))
    return {"quaternion": turn.expand(s.sizes["N"], 4).contiguous()}


def tangents(s: Setting) -> Inputs:
    """Matrices of a Lie algebra."""
    group = s.spec.name.split(".")[-1].partition("_")[0]
    size = {"so2": 1, "so3": 3, "se2": 3, "se3": 6}[group]
    v = torch.randn((s.sizes["N"], size), generator=torch.Generator().manual_seed(0))
    return {"omega": getattr(lie, f"{group}_hat")(v[:, 0] if size == 1 else v)}


def affine_pairs(s: Setting) -> Inputs:
    """Points, and the same points mapped by an affine map, with a little noise."""
    random = torch.Generator().manual_seed(0)
    points = torch.rand((s.sizes["N"], 2), generator=random) * 120
    moved = points @ torch.tensor([[0.9, 0.3], [-0.2, 0.8]]) + 5 + torch.randn(points.shape, generator=random)
    return {"points1": s.repeated(points), "points2": s.repeated(moved)}


def straight_boxes(s: Setting) -> Inputs:
    axes = 2 if s.shape("boxes")[1:] == (4, 2) else 3
    corners = (FACE if axes == 2 else BOX) * torch.tensor([22.0, 15.0, 10.0])[:axes]
    starts = torch.tensor([[3.0, 4.0, 6.0], [30.0, 2.0, 9.0], [8.0, 26.0, 7.0], [34.0, 24.0, 5.0]])[
        :, None, :axes
    ]
    return {"boxes": (starts + corners * torch.tensor([1.0, 0.8, 1.1, 0.9])[:, None, None]).contiguous()}


def bent_boxes(s: Setting) -> Inputs:
    """Four boxes, the last of which is invalid."""
    boxes = straight_boxes(s)["boxes"]
    boxes[3, 2] += torch.tensor([6.0, 8.0, 0.0])[: boxes.shape[-1]]
    return {"boxes": boxes}
