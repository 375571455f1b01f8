"""Volumes made from the photographs, boxes in them, and their transforms, in voxels."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional

from chiasm import filters
from chiasm.export.spec import Spec
from chiasm.geometry import transform

from .plane import lattice
from .setting import BOX, Inputs, Setting

#: The depth of a photograph's volume; its other sides are a third of the photograph's.
DEPTH, SHARE = 12, 3


def volume_sizes(spec: Spec, height: int, width: int) -> dict[str, int]:
    """The sizes of the op's volumes, if it has any."""
    if not any(t.layout == "NCDHW" for t in spec.inputs):
        return {}
    d, h, w = DEPTH, height // SHARE, width // SHARE
    return {"D": d, "H": h, "W": w, "OD": d, "OH": h, "OW": w}


def solid(rgb: Tensor) -> Tensor:
    """A barrel filled with the photographs and a lattice, (B, 3, D, H, W)."""
    h, w = rgb.shape[-2] // SHARE, rgb.shape[-1] // SHARE
    small = functional.interpolate(lattice(rgb, 5), (h, w), mode="bilinear", antialias=True).clamp(0, 1)
    z, y, x = torch.meshgrid(
        torch.linspace(-1, 1, DEPTH), torch.linspace(-1, 1, h), torch.linspace(-1, 1, w), indexing="ij"
    )
    inside = (x.abs() ** 4 + y.abs() ** 4) < (1.1 - 0.4 * z.abs()) ** 4
    return torch.where(inside, small[:, :, None], torch.full_like(z, 0.1)).contiguous()


def scale_space(rgb: Tensor) -> Tensor:
    """Differences of Gaussians of the photographs, whose sigma grows from slice to slice: blobs are extrema.
    (B, 3, D, H, W), from 0 to 1."""
    size = rgb.shape[-2] // SHARE, rgb.shape[-1] // SHARE
    small = functional.interpolate(rgb, size, mode="bilinear", antialias=True)
    spreads = [1.2**k for k in range(DEPTH + 1)]
    blurred = [filters.gaussian_blur2d(small, (31, 31), (s, s)) for s in spreads]
    return (0.5 + 4.0 * (torch.stack(blurred[:-1], 2) - torch.stack(blurred[1:], 2))).clamp(0, 1).contiguous()


def spatial(s: Setting) -> Inputs:
    """Transforms of volumes, in voxels; if the op has no volume, of a box of 24 x 16 x 12 voxels."""
    d, h, w = (s.sizes.get(n, default) for n, default in (("D", 12), ("H", 16), ("W", 24)))
    size = torch.tensor([w, h, d], dtype=torch.float32)
    center, angles, scales = (size - 1) / 2, torch.tensor([1.0, 2.0, 28.0]), torch.tensor([0.85, 0.85, 0.9])
    affine = transform.get_projective_transform(center[None], angles[None], scales[None])[0]
    turn = transform.get_projective_transform(
        torch.zeros(1, 3), torch.tensor([[0.0, 0.0, -28.0]]), torch.tensor([[1.2, 1.2, 1.1]])
    )[0]
    last = torch.tensor([[0.0, 0.0, 0.0, 1.0]])
    bent = BOX + torch.tensor([[0.1, 0.1, 0.0], [-0.1, 0.0, 0.0], [0.0, -0.1, 0.0], [0.0, 0.0, 0.0]]).repeat(
        2, 1
    )
    out = torch.tensor([s.sizes.get(n, default) - 1.0 for n, default in (("OW", 25), ("OH", 17), ("OD", 13))])
    made = {
        "M": (
            torch.cat([affine, last + torch.tensor([0.006, 0.0, 0.0, 0.0])])
            if s.shape("M")[1:] == (4, 4)
            else affine
        ),
        "matrix": affine,
        "transform": torch.cat([affine, last]),
        "src_homo_dst": torch.cat([turn, last + torch.tensor([0.25, 0.0, 0.0, 0.0])]),
        "boxes": (0.2 + 0.6 * bent) * size,
        "src_box": (0.2 + 0.6 * bent) * size,
        "dst_box": BOX * out,
        "center": center,
        "angles": angles,
        "scale": scales,
        "scales": scales,
        "translations": torch.tensor([4.0, -3.0, 2.0]),
        "sxy": torch.tensor(0.25),
        "sxz": torch.tensor(0.0),
        "syx": torch.tensor(-0.15),
        "syz": torch.tensor(0.0),
        "szx": torch.tensor(0.3),
        "szy": torch.tensor(0.0),
        "yaw": torch.tensor(1.0),
        "pitch": torch.tensor(2.0),
        "roll": torch.tensor(28.0),
    }
    if s.shape("src") == ("B", 8, 3):
        made |= {"src": bent * size, "dst": (0.2 + 0.6 * BOX) * size}
    grid = torch.stack(
        torch.meshgrid(*(torch.linspace(-1, 1, s.sizes.get(n, 2)) for n in "DHW"), indexing="ij")[::-1], -1
    )
    return {name: s.repeated(value) for name, value in made.items()} | {"grid": s.repeated(grid)}
