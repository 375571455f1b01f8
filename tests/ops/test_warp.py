"""Perspective warps against OpenCV and grid_sample."""

import cv2
import numpy as np
import pytest
import torch
import torch.nn.functional as F
from photos import chw, hwc, photo
from torch import Tensor

from chiasm.geometry.transform import warp_perspective

MATRICES = torch.tensor(
    [
        [[1.1, 0.13, -3.3], [-0.08, 0.93, 2.7], [1.1e-3, -7e-4, 1.0]],
        [[0.4, -0.9, 30.0], [0.8, 0.5, -4.0], [1e-3, 2e-3, 1.2]],
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    ],
    dtype=torch.float64,
)


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("dsize", [(37, 53), (20, 71)])
def test_equals_opencv(channels: int, dsize: tuple[int, int]) -> None:
    x = photo(3, channels, 37, 53)
    actual = warp_perspective(x, MATRICES.float(), dsize)
    for b in range(3):
        expected = chw(
            cv2.warpPerspective(hwc(x, b), MATRICES[b].numpy(), dsize[::-1], flags=cv2.INTER_LINEAR)
        )
        np.testing.assert_allclose(actual[b], expected, atol=1e-4)


def test_a_plane_is_warped_exactly() -> None:
    """A plane a x + b y + c is reproduced exactly by bilinear sampling, so warped values are known in closed
    form."""
    height, width = 40, 50
    yy, xx = torch.meshgrid(torch.arange(40.0).double(), torch.arange(50.0).double(), indexing="ij")
    x = (0.3 * xx - 0.2 * yy + 5.0).expand(3, 1, height, width)
    actual = warp_perspective(x, MATRICES, (30, 45))
    for b in range(3):
        inverse = np.linalg.inv(MATRICES[b].numpy())
        grid = np.stack([*np.meshgrid(np.arange(45), np.arange(30)), np.ones((30, 45))])
        u, v, w = np.einsum("ij,jhw->ihw", inverse, grid)
        u, v = u / w, v / w
        inside = (u >= 0) & (u <= width - 1) & (v >= 0) & (v <= height - 1)
        outside = (u <= -1) | (u >= width) | (v <= -1) | (v >= height)
        assert inside.sum() > 100
        np.testing.assert_allclose(actual[b, 0].numpy()[inside], (0.3 * u - 0.2 * v + 5.0)[inside], atol=1e-9)
        assert (actual[b, 0].numpy()[outside] == 0).all()


def by_grid_sample(x: Tensor, dsize: tuple[int, int], mode: str, padding: str, align: bool) -> Tensor:
    """grid_sample at positions that are normalised in either convention."""
    height, width = x.shape[2:]
    yy, xx = torch.meshgrid(torch.arange(dsize[0]).double(), torch.arange(dsize[1]).double(), indexing="ij")
    points = torch.stack([xx, yy, torch.ones_like(xx)], -1).reshape(-1, 3)
    source = points @ torch.linalg.inv(MATRICES).transpose(1, 2)
    source = source[..., :2] / source[..., 2:]
    size = torch.tensor([width, height]).double()
    grid = source * 2.0 / (size - 1.0) - 1.0 if align else (source * 2.0 + 1.0) / size - 1.0
    return F.grid_sample(x, grid.reshape(3, *dsize, 2), mode=mode, padding_mode=padding, align_corners=align)


@pytest.mark.parametrize("align", [True, False])
@pytest.mark.parametrize("padding", ["zeros", "border", "reflection"])
@pytest.mark.parametrize("mode", ["bilinear", "nearest"])
def test_equals_grid_sample(mode: str, padding: str, align: bool) -> None:
    x = photo(3, 5, 37, 53, torch.float64)
    actual = warp_perspective(x, MATRICES, (41, 39), mode, padding, align)
    expected = by_grid_sample(x, (41, 39), mode, padding, align)
    if mode == "bilinear":
        torch.testing.assert_close(actual, expected, rtol=0, atol=1e-9)
    else:  # positions within rounding of a half may round to either pixel; the identity has none
        assert (actual != expected).double().mean() < 1e-3


def test_align_corners_is_only_about_reflection() -> None:
    x = photo(3, 2, 37, 53)
    for mode, padding in (
        ("bilinear", "zeros"),
        ("bilinear", "border"),
        ("bicubic", "zeros"),
        ("nearest", "fill"),
    ):
        both = [
            warp_perspective(x, MATRICES.float(), (41, 39), mode, padding, align) for align in (True, False)
        ]
        assert torch.equal(*both)


def test_fill_blends_with_what_is_covered() -> None:
    x = photo(3, 3, 37, 53, torch.float64)
    fill = torch.tensor([0.1, 0.5, 0.9], dtype=torch.float64)
    actual = warp_perspective(x, MATRICES, (41, 39), "bilinear", "fill", True, fill)
    shifted = warp_perspective(x - fill[:, None, None], MATRICES, (41, 39))
    torch.testing.assert_close(actual, shifted + fill[:, None, None], rtol=0, atol=1e-12)
    assert torch.equal(
        warp_perspective(x, MATRICES, (41, 39), "bilinear", "fill"), warp_perspective(x, MATRICES, (41, 39))
    )


def test_points_at_infinity_are_outside() -> None:
    m = torch.tensor([[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.1, 0.0, 1.0]]]).inverse()
    out = warp_perspective(photo(1, 1, 16, 24), m, (16, 24))
    assert torch.isfinite(out).all()
    assert (out[..., 10] == 0).all()
