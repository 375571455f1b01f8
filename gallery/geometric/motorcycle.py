"""A scene photographed by two cameras: scikit-image's stereo pair of a motorcycle (Middlebury 2014), with the
right camera rotated."""

from __future__ import annotations

from functools import cache

import numpy as np
import torch

from chiasm.geometry import transform
from gallery.photographs import DATA, photograph

from .setting import Inputs, Setting

#: The homography from the right photograph to the rotated camera: a roll and a pan, so that epipolar lines
#: are not image rows.
TURN = np.array([[0.93, -0.25, 80.0], [0.24, 0.97, -95.0], [-1.6e-4, 5e-5, 1.0]])


@cache
def views() -> tuple[np.ndarray, np.ndarray]:
    """The left photograph and the rotated right one, (500, 741, 3), uint8."""
    right = torch.from_numpy(photograph("motorcycle_right.png").copy()).permute(2, 0, 1)[None].float()
    turned = transform.warp_perspective(right, torch.from_numpy(TURN).float()[None], right.shape[-2:])
    return photograph("motorcycle_left.png"), turned[0].permute(1, 2, 0).round().byte().numpy()


def stereo_pair(s: Setting) -> Inputs:
    """Pixels of the left photograph, and their positions in the rotated right one, by the true disparity; for
    RANSAC, a quarter of the latter are random."""
    if "N" not in s.shape("points1")[1:]:  # samples of seven points are too few for a picture
        return {}
    count = s.sizes["N"]
    with np.load(DATA / "motorcycle_disp.npz") as data:
        disparity = data["arr_0"].astype(np.float64)
    random = np.random.default_rng(3)
    rows, columns = np.nonzero(np.isfinite(disparity))
    pick = random.choice(len(rows), 20 * count, replace=False)
    left = np.stack([columns[pick], rows[pick]], 1).astype(np.float64)
    right = (
        np.concatenate(
            [
                left - np.stack([disparity[rows[pick], columns[pick]], 0 * left[:, 0]], 1),
                np.ones((len(left), 1)),
            ],
            1,
        )
        @ TURN.T
    )
    right = right[:, :2] / right[:, 2:]
    height, width = disparity.shape
    seen = ((right > 5) & (right < [width - 6, height - 6])).all(1)
    left, right = left[seen][:count], right[seen][:count]
    if "uniforms" in {t.name for t in s.spec.inputs}:
        right[::4] = random.uniform(5, [width - 5, height - 5], right[::4].shape)
    batch = s.sizes.get("P", s.sizes.get("B", 1))
    return {
        name: torch.from_numpy(points).float().expand(batch, -1, -1).contiguous()
        for name, points in (("points1", left), ("points2", right))
    }
