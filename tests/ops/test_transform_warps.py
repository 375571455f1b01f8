"""Affine warps, remap, homography_warp, polar and elastic warps against SciPy in float64, OpenCV and
grid_sample."""

import cv2
import numpy as np
import pytest
import torch
import torch.nn.functional as F
from photos import chw, hwc, photo
from sampled import by_keys, by_scipy, pulled
from skimage.transform import warp_polar as warp_polar_skimage
from torch import Tensor

from chiasm.geometry.transform import (
    affine,
    elastic_transform2d,
    get_rotation_matrix2d,
    homography_warp,
    remap,
    rotate,
    scale,
    shear,
    translate,
    warp_affine,
    warp_grid,
    warp_perspective,
    warp_polar,
)

D = torch.float64
MATRICES = torch.tensor(
    [[[1.1, 0.13, -3.3], [-0.08, 0.93, 2.7]], [[0.4, -0.9, 30.0], [0.8, 0.5, -4.0]]], dtype=D
)
HOMOGRAPHIES = torch.cat([MATRICES, torch.tensor([[[1.1e-3, -7e-4, 1.0]], [[1e-3, 2e-3, 1.2]]], dtype=D)], 1)
PADDINGS = ["zeros", "border", "reflection"]
CV_BORDER = {
    "zeros": cv2.BORDER_CONSTANT,
    "border": cv2.BORDER_REPLICATE,
    "reflection": cv2.BORDER_REFLECT_101,
}
CV_MODE = {"bilinear": cv2.INTER_LINEAR, "bicubic": cv2.INTER_CUBIC}


def full(matrix: Tensor) -> np.ndarray:
    return np.concatenate([matrix.numpy(), [[0, 0, 1]]])


@pytest.mark.parametrize("padding", PADDINGS)
@pytest.mark.parametrize("mode", ["bilinear", "bicubic"])
def test_affine_equals_scipy(mode: str, padding: str) -> None:
    x = photo(2, 5, 37, 53, D)
    actual = warp_affine(x, MATRICES, (41, 39), mode, padding)
    for b in range(2):
        rows, columns = pulled(full(MATRICES[b]), 41, 39)
        sampled = (
            by_scipy(x[b].numpy(), [rows, columns], padding)
            if mode == "bilinear"
            else by_keys(x[b].numpy(), rows, columns, padding)
        )
        np.testing.assert_allclose(actual[b], sampled, atol=1e-9)


@pytest.mark.parametrize("padding", PADDINGS)
@pytest.mark.parametrize("mode", ["bilinear", "bicubic"])
def test_float32_equals_opencv(mode: str, padding: str) -> None:
    """OpenCV 5 computes bilinear positions in float32 too; its cubic weights come from a table of 1/32
    pixels."""
    x = photo(2, 3, 37, 53)
    tolerance = 1e-4 if mode == "bilinear" else 0.05
    ours = warp_affine(x, MATRICES.float(), (41, 39), mode, padding)
    perspective = warp_perspective(x, HOMOGRAPHIES.float(), (41, 39), mode, padding)
    for b in range(2):
        flags = {"flags": CV_MODE[mode], "borderMode": CV_BORDER[padding]}
        np.testing.assert_allclose(
            ours[b], chw(cv2.warpAffine(hwc(x, b), MATRICES[b].numpy(), (39, 41), **flags)), atol=tolerance
        )
        np.testing.assert_allclose(
            perspective[b],
            chw(cv2.warpPerspective(hwc(x, b), HOMOGRAPHIES[b].numpy(), (39, 41), **flags)),
            atol=tolerance,
        )


@pytest.mark.parametrize("padding", PADDINGS)
def test_bicubic_perspective_equals_the_definition(padding: str) -> None:
    x = photo(2, 3, 37, 53, D)
    actual = warp_perspective(x, HOMOGRAPHIES, (41, 39), "bicubic", padding)
    for b in range(2):
        np.testing.assert_allclose(
            actual[b], by_keys(x[b].numpy(), *pulled(HOMOGRAPHIES[b].numpy(), 41, 39), padding), atol=1e-9
        )


def positions(height: int, width: int) -> tuple[Tensor, Tensor]:
    """Columns and rows, a sixth of them outside, not near the borders between pixels."""
    generator = torch.Generator().manual_seed(3)
    x = torch.floor(torch.rand((2, 31, 29), generator=generator, dtype=D) * (width + 10) - 5)
    y = torch.floor(torch.rand((2, 31, 29), generator=generator, dtype=D) * (height + 10) - 5)
    fraction = torch.rand((2, 2, 31, 29), generator=generator, dtype=D) * 0.4 + 0.05
    return x + fraction[0], y + fraction[1]


@pytest.mark.parametrize("align", [True, False])
@pytest.mark.parametrize("padding", PADDINGS)
@pytest.mark.parametrize("mode", ["bilinear", "nearest", "bicubic"])
def test_remap_equals_grid_sample(mode: str, padding: str, align: bool) -> None:
    height, width = 23, 34
    x = photo(2, 3, height, width, D)
    map_x, map_y = positions(height, width)
    edge = torch.tensor([width - 1.0, height - 1.0], dtype=D)
    grid = torch.stack([map_x, map_y], -1) * 2 / edge - 1
    expected = F.grid_sample(x, grid, mode, padding, align)
    torch.testing.assert_close(remap(x, map_x, map_y, mode, padding, align), expected, rtol=0, atol=1e-9)
    normalized = remap(x, grid[..., 0], grid[..., 1], mode, padding, align, normalized_coordinates=True)
    torch.testing.assert_close(normalized, expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("padding", PADDINGS)
def test_remap_equals_scipy_and_opencv(padding: str) -> None:
    x = photo(2, 3, 23, 34, D)
    map_x, map_y = positions(23, 34)
    exact = remap(x, map_x, map_y, "bilinear", padding, True)
    for b in range(2):
        np.testing.assert_allclose(
            exact[b], by_scipy(x[b].numpy(), [map_y[b].numpy(), map_x[b].numpy()], padding), atol=1e-12
        )
        maps = map_x[b].float().numpy(), map_y[b].float().numpy()
        nearest = chw(cv2.remap(hwc(x.float(), b), *maps, cv2.INTER_NEAREST, borderMode=CV_BORDER[padding]))
        linear = chw(cv2.remap(hwc(x.float(), b), *maps, cv2.INTER_LINEAR, borderMode=CV_BORDER[padding]))
        np.testing.assert_allclose(exact[b], linear, atol=0.04)  # positions are rounded to 1/32 pixel there
        np.testing.assert_array_equal(
            remap(x.float(), *[m.float() for m in (map_x, map_y)], "nearest", padding, True)[b], nearest
        )


def test_nearest_affine_takes_the_nearest() -> None:
    x = photo(2, 3, 37, 53, D)
    matrices = MATRICES + 0.00123  # no position is halfway between two pixels
    actual = warp_affine(x, matrices, (41, 39), "nearest", "border")
    for b in range(2):
        rows, columns = pulled(full(matrices[b]), 41, 39)
        expected = x[b].numpy()[
            :, np.clip(np.rint(rows), 0, 36).astype(int), np.clip(np.rint(columns), 0, 52).astype(int)
        ]
        np.testing.assert_array_equal(actual[b], expected)


def test_reflection_without_corners_is_about_the_edges() -> None:
    x = photo(2, 3, 37, 53, D)
    mirrored = torch.cat([x.flip(-2), x, x.flip(-2)], -2)
    mirrored = torch.cat([mirrored.flip(-1), mirrored, mirrored.flip(-1)], -1)
    moved = MATRICES.clone()
    # the same positions in the larger image
    moved[:, :, 2] = MATRICES[:, :, 2] - (MATRICES[:, :, :2] @ torch.tensor([53.0, 37.0], dtype=D))
    for mode in ("bilinear", "bicubic"):
        actual = warp_affine(x, MATRICES, (30, 40), mode, "reflection", False)
        torch.testing.assert_close(actual, warp_affine(mirrored, moved, (30, 40), mode), rtol=0, atol=1e-9)


@pytest.mark.parametrize("mode", ["bilinear", "nearest", "bicubic"])
def test_fill_is_what_is_not_covered(mode: str) -> None:
    x = photo(2, 3, 37, 53, D)
    fill = torch.tensor([0.1, 0.5, 0.9], dtype=D)
    actual = warp_affine(x, MATRICES, (41, 39), mode, "fill", True, fill)
    shifted = warp_affine(x - fill[:, None, None], MATRICES, (41, 39), mode)
    torch.testing.assert_close(actual, shifted + fill[:, None, None], rtol=0, atol=1e-12)


def test_wrappers_are_affine_warps_about_the_middle() -> None:
    x = photo(2, 3, 37, 53, D)
    middle, angle = torch.tensor([[26.0, 18.0]] * 2, dtype=D), torch.tensor([30.0, -75.0], dtype=D)
    factor = torch.tensor([[1.5, 0.7], [0.8, 1.2]], dtype=D)
    move = torch.tensor([[3.2, -4.1], [-7.7, 0.4]], dtype=D)
    one, zero = torch.ones(2, dtype=D), torch.zeros(2, dtype=D)
    rotation = np.stack([cv2.getRotationMatrix2D((26, 18), a, 1.0) for a in angle.tolist()])
    scaling = np.stack([[[a, 0, 26 * (1 - a)], [0, b, 18 * (1 - b)]] for a, b in factor.tolist()])
    moving = torch.stack(
        [torch.stack([one, zero, move[:, 0]], -1), torch.stack([zero, one, move[:, 1]], -1)], 1
    )
    shearing = torch.stack(
        [torch.stack([one, move[:, 0] / 10, zero], -1), torch.stack([move[:, 1] / 10, one, zero], -1)], 1
    )
    for actual, matrix in (
        (rotate(x, angle), torch.from_numpy(rotation)),
        (rotate(x, angle, middle), torch.from_numpy(rotation)),
        (scale(x, factor), torch.from_numpy(scaling)),
        (translate(x, move), moving),
        (shear(x, move / 10, align_corners=True), shearing),
        (affine(x, MATRICES), MATRICES),
    ):
        for b in range(2):
            expected = by_scipy(x[b].numpy(), list(pulled(full(matrix[b]), 37, 53)), "zeros")
            np.testing.assert_allclose(actual[b], expected, atol=1e-9)
    torch.testing.assert_close(scale(x, factor[:, 0]), scale(x, factor[:, :1].expand(-1, 2)), rtol=0, atol=0)
    other = torch.tensor([[4.0, 9.0]] * 2, dtype=D)
    about = warp_affine(x, get_rotation_matrix2d(other, angle, torch.ones(2, 2, dtype=D)), (37, 53))
    torch.testing.assert_close(rotate(x, angle, other), about, rtol=0, atol=1e-9)


NORMALIZED = torch.tensor([[[0.9, 0.1, 0.05], [-0.1, 0.8, 0.02], [0.03, -0.02, 1.0]]] * 2, dtype=D)


@pytest.mark.parametrize("align", [True, False])
@pytest.mark.parametrize("mode", ["bilinear", "bicubic"])
def test_homography_warp_equals_grid_sample(mode: str, align: bool) -> None:
    x = photo(2, 3, 37, 53, D)
    grid = F.affine_grid(torch.eye(3, dtype=D)[None, :2].expand(2, 2, 3), [2, 1, 20, 31], align)
    warped = warp_grid(grid, NORMALIZED)
    points = torch.cat([grid, torch.ones_like(grid[..., :1])], -1).numpy() @ NORMALIZED[0].numpy().T
    np.testing.assert_allclose(warped, points[..., :2] / points[..., 2:], atol=1e-12)
    expected = F.grid_sample(x, warped, mode, "border", align)
    torch.testing.assert_close(
        homography_warp(x, NORMALIZED, (20, 31), mode, "border", align), expected, rtol=0, atol=1e-9
    )


def test_homography_warp_in_pixels() -> None:
    x = photo(2, 3, 37, 53, D)
    expected = warp_perspective(x, HOMOGRAPHIES, (20, 31))
    back = torch.linalg.inv(HOMOGRAPHIES)
    torch.testing.assert_close(
        homography_warp(x, back, (20, 31), normalized_coordinates=False), expected, rtol=0, atol=1e-9
    )
    torch.testing.assert_close(
        homography_warp(x, HOMOGRAPHIES, (20, 31), normalized_homography=False), expected, rtol=0, atol=1e-9
    )


@pytest.mark.parametrize("mapping", ["linear", "log"])
def test_polar_equals_opencv(mapping: str) -> None:
    x = photo(2, 3, 61, 83)
    center, radius = torch.tensor([[40.5, 31.25], [33.0, 28.0]]), torch.tensor([25.0, 38.0])
    actual = warp_polar(x, (72, 48), center, radius, mapping)
    for b in range(2):
        # OpenCV does not write pixels outside unless it fills them.
        flags = cv2.INTER_LINEAR + cv2.WARP_FILL_OUTLIERS
        flags += cv2.WARP_POLAR_LOG if mapping == "log" else cv2.WARP_POLAR_LINEAR
        expected = chw(cv2.warpPolar(hwc(x, b), (48, 72), center[b].tolist(), float(radius[b]), flags))
        # Positions are rounded to 1/32 pixel there
        np.testing.assert_allclose(actual[b], expected, atol=0.04)
        assert np.abs(actual[b].numpy() - expected).mean() < 2e-3


def test_polar_equals_scikit_image() -> None:
    x = photo(1, 1, 61, 83, D)
    radius = torch.tensor([25.3], dtype=D)
    expected = warp_polar_skimage(x[0, 0].numpy(), center=(30.0, 41.0), radius=25.3, output_shape=(72, 48))
    np.testing.assert_allclose(warp_polar(x, (72, 48), max_radius=radius)[0, 0], expected, atol=1e-9)


@pytest.mark.parametrize("align", [True, False])
def test_elastic_equals_blurred_noise(align: bool) -> None:
    x = photo(2, 3, 37, 53, D)
    noise = torch.rand((2, 2, 37, 53), generator=torch.Generator().manual_seed(0), dtype=D) * 2 - 1
    grid = F.affine_grid(torch.eye(3, dtype=D)[None, :2].expand(2, 2, 3), [2, 1, 37, 53], align).clone()
    for b in range(2):
        for axis, factor in ((0, 0.5), (1, 0.3)):
            smooth = cv2.GaussianBlur(
                noise[b, axis].numpy(), (7, 9), sigmaX=1.5, sigmaY=2.5, borderType=cv2.BORDER_CONSTANT
            )
            grid[b, ..., axis] += torch.from_numpy(smooth) * factor
    expected = F.grid_sample(x, grid, "bilinear", "reflection", align)
    actual = elastic_transform2d(x, noise, (9, 7), (2.5, 1.5), (0.5, 0.3), align, padding_mode="reflection")
    torch.testing.assert_close(actual, expected, rtol=0, atol=1e-9)
    each = torch.tensor([[2.5, 1.5]] * 2, dtype=D), torch.tensor([[0.5, 0.3]] * 2, dtype=D)
    torch.testing.assert_close(
        elastic_transform2d(x, noise, (9, 7), *each, align, padding_mode="reflection"),
        expected,
        rtol=0,
        atol=1e-9,
    )
