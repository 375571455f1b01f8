"""Cameras with lenses, and depth maps of a ball in front of a wall."""

from __future__ import annotations

import torch
from torch import Tensor

from chiasm.geometry import calibration, transform

from .plane import lattice
from .setting import Inputs, Setting, mesh, motion

#: The coefficients of a lens in OpenCV's order: radial and tangential, rational, thin prism, tilt.
LENS = [-0.24, 0.06, 0.004, -0.003, -0.01, 0.02, 0.01, 0.005, 0.02, 0.01, -0.02, 0.01, 0.05, -0.04]


def relief(h: int, w: int) -> Tensor:
    """Depths (h, w) of a ball in front of a leaning wall."""
    grid = mesh(w, h) * torch.tensor([w / h, 1.0])
    x, y = grid.unbind(-1)
    wall = 5.0 + 0.5 * x - 0.4 * y
    height = (0.55 - (x + 0.1) ** 2 - (y - 0.05) ** 2).clamp(min=0)
    return torch.where(height > 0, 4.0 - 1.6 * height.sqrt(), wall)


def camera_of(h: int, w: int) -> Tensor:
    return torch.tensor([[0.9 * w, 0.0, 0.5 * (w - 1)], [0.0, 0.9 * w, 0.5 * (h - 1)], [0.0, 0.0, 1.0]])


def depths(s: Setting) -> Inputs:
    h, w = s.sizes.get("H", s.height), s.sizes.get("W", s.width)
    depth, camera, still = relief(h, w), camera_of(h, w), torch.eye(4)
    moved = motion((0.4, -0.1, 0.3), (0.0, -6.0, 4.0))
    shape = (1, h, w) if 1 in s.shape("depth") + s.shape("depth_src") + s.shape("depth_dst") else (h, w)
    made = {
        "depth": depth.reshape(shape),
        "depth_src": depth[None],
        "depth_dst": depth[None],
        "disparity": 100.0 / depth[None],
        "camera_matrix": camera,
        "intrinsics_src": camera,
        "intrinsics_dst": camera,
        "extrinsics_src": still,
        "extrinsics_dst": moved,
        "src_trans_dst": moved,
        "plane_normals": torch.tensor([0.25, -0.5, 1.0]),
        "plane_offsets": torch.tensor([4.0]),
        "points_uv": (mesh(15, 12).flatten(0, 1) + 1) / 2 * torch.tensor([s.width - 1.0, s.height - 1.0]),
    }
    if "N" in s.sizes:
        made["camera_matrix"] = camera_of(s.height, s.width)
    return {name: s.repeated(value) for name, value in made.items()} | {
        "baseline": torch.tensor([0.2]),
        "focal": torch.tensor([500.0]),
    }


def cameras(s: Setting) -> Inputs:
    """One camera for all points, which sees 640 x 480 pixels."""
    n, h, w = s.sizes.get("N", 1), s.sizes.get("H", 2), s.sizes.get("W", 2)
    camera = torch.tensor([[520.0, 0.0, 320.0], [0.0, 520.0, 240.0], [0.0, 0.0, 1.0]])
    grid = mesh(15, 12).flatten(0, 1)
    bend = torch.tensor([520.0, 520.0, 320.0, 240.0, 0.15, 0.06, 0.02, 0.0])
    size = s.shape("params")[1:] or (8,)
    made: Inputs = {
        "camera_matrix": camera.expand(n, 3, 3).contiguous(),
        "params": bend[: int(size[0])].expand(n, -1).contiguous(),
    }
    if n == len(grid) and "params" in {t.name for t in s.spec.inputs}:
        made["projected_points_in_camera_z1_plane"] = grid * torch.tensor([0.9, 0.7])
        made["distorted_points_in_camera"] = (grid + 1) * torch.tensor([320.0, 240.0])
    small = camera_of(h, w)
    inverse = torch.eye(4)
    inverse[:3, :3] = torch.linalg.inv(small)
    projection = torch.eye(4)
    projection[:3, :3] = camera
    rays = torch.cat([mesh(w, h) * torch.tensor([2.0, 1.5]), relief(h, w)[..., None]], -1)
    pixels = torch.cat([(mesh(w, h) + 1) / 2 * torch.tensor([w - 1.0, h - 1.0]), torch.ones(h, w, 1)], -1)
    return (
        made
        | {
            "depth": relief(h, w)[None, None],
            "intrinsics_inv": inverse[None],
            "pixel_coords": pixels[None].contiguous(),
            "cam_coords_src": rays[None].contiguous(),
            "dst_proj_src": projection[None],
        }
        if "H" in s.sizes
        else made
    )


def lenses(s: Setting) -> Inputs:
    """A lens on a camera that sees 640 x 480 pixels, and a grid of its pixels."""
    camera = torch.tensor([[520.0, 0.0, 320.0], [0.0, 520.0, 240.0], [0.0, 0.0, 1.0]])
    size = int((s.shape("dist") or (1, 4))[1])
    made = {
        "points": (mesh(15, 12).flatten(0, 1) + 1) * torch.tensor([320.0, 240.0]),
        "K": camera,
        "new_K": camera,
        "dist": torch.tensor(LENS[:size]),
    }
    return {name: s.repeated(value) for name, value in made.items()}


def bent_photo(s: Setting) -> Inputs:
    """The photograph as taken through a wide-angle lens."""
    camera, bend = camera_of(s.height, s.width)[None], torch.tensor([[-0.45, 0.18, 0.0, 0.0, 0.0]])
    pixels = ((mesh(s.width, s.height) + 1) / 2 * torch.tensor([s.width - 1.0, s.height - 1.0])).flatten(
        0, 1
    )[None]
    x, y = (
        calibration.undistort_points(pixels, camera, bend)
        .reshape(1, s.height, s.width, 2)
        .expand(len(s.rgb), -1, -1, -1)
        .unbind(-1)
    )
    taken = transform.remap(
        lattice(s.rgb), x.contiguous(), y.contiguous(), padding_mode="border", align_corners=True
    )
    if s.spec.interleaved:
        taken = (255.0 * taken).round().to(torch.uint8).permute(0, 2, 3, 1)
    return {"image": taken.contiguous(), "K": s.repeated(camera[0]), "dist": s.repeated(bend[0])}
