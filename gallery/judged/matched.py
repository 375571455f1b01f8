"""Key points of the motorcycle's two photographs, and a photograph with a view of it in another
perspective."""

from __future__ import annotations

from functools import cache

import torch
from torch import Tensor

from chiasm import color, feature
from chiasm.geometry import transform
from gallery.geometric.setting import Inputs, Setting
from gallery.photographs import photograph

from .frames import found
from .pairs import motorcycle_disparity, noise

#: The photographs are reduced by this step. One image has more key points than the other.
STEP, COUNTS = 2, (60, 70)
Found = tuple[Tensor, Tensor]


def view(side: str) -> Tensor:
    """(3, H, W)."""
    return (
        torch.from_numpy(photograph(f"motorcycle_{side}.png")[::STEP, ::STEP].copy()).permute(2, 0, 1).float()
        / 255
    )


@cache
def key_points() -> tuple[Found, Found]:
    """Frames (1, N, 2, 3) and descriptors (1, N, 128) of both photographs."""
    made = []
    for side, count in zip(("left", "right"), COUNTS, strict=True):
        gray = color.rgb_to_grayscale(view(side)[None])
        lafs = found(gray, count, octaves=3, apart=0.6)
        patches = feature.extract_patches_from_pyramid(gray, lafs)
        made.append((lafs, feature.sift_describe(patches[0])[None]))
    return made[0], made[1]


def partners(points: Tensor) -> Tensor:
    """The positions in the right photograph of the left one's pixels (N, 2), by the true disparity; NaN if
    that is unknown."""
    true = motorcycle_disparity()[::STEP, ::STEP] / STEP
    x, y = (points[:, i].round().long().clamp(0, true.shape[1 - i] - 1) for i in (0, 1))
    return torch.stack([points[:, 0] - true[y, x], points[:, 1]], 1)


def described(s: Setting) -> Inputs:
    """Descriptors of both photographs; masks exclude the right side."""
    made: Inputs = {}
    for index, (lafs, descriptors) in enumerate(key_points(), 1):
        made |= {f"lafs{index}": lafs, f"desc{index}": descriptors, f"mask{index}": lafs[..., 0, 2] < 230}
    return {name: value.contiguous() for name, value in made.items()}


def two_images(s: Setting) -> Inputs:
    """The photograph, and the same scene from another view, by a worse camera, with the left part
    displaced."""
    gray = color.rgb_to_grayscale(s.rgb)
    w, h = s.width, s.height
    bend = s.repeated(
        torch.tensor([[0.8, -0.22, 0.2 * w], [0.2, 0.78, -0.02 * h], [0.15 / w, -0.12 / h, 1.0]])
    )
    slipped = torch.cat([gray[..., : w // 3].roll(h // 8, 2), gray[..., w // 3 :]], 3)
    other = transform.warp_perspective(slipped, bend, (h, w)) + noise(tuple(gray.shape), 0.04)
    uniforms = torch.rand((500, 4), generator=torch.Generator().manual_seed(0))
    return {"image1": gray, "image2": other.clamp(0, 1).contiguous(), "uniforms": s.repeated(uniforms)}
