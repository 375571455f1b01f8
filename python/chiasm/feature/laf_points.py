"""Conversions of local affine frames to points and ellipses, tests of their position, and their transforms by
homographies."""

import math

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_image, check_leading
from ..primitives.linalg.matrices import small_matmul
from ..primitives.resampling.warping import away_from_zero, check_matrices, position_dtype
from .laf import check_laf, determinants


def laf_to_three_points(laf: Tensor) -> Tensor:
    """Local affine frames as three points: the ends of both axes, and the centre.

    Args:
        laf: (B, N, 2, 3), floating point.

    Returns:
        (B, N, 2, 3), a point in each column.

    Raises:
        TypeError: if laf is not floating point.
        ValueError: if laf is not (B, N, 2, 3).

    Example:
        >>> laf_to_three_points(torch.tensor([[[[2.0, 0.0, 7.0], [1.0, 3.0, 5.0]]]]))
        tensor([[[[9., 7., 7.],
                  [6., 8., 5.]]]])
    """
    check_laf(laf, "laf")
    centre = laf[..., 2:]
    return torch.cat([laf[..., :2] + centre, centre], -1)


def laf_from_three_points(threepts: Tensor) -> Tensor:
    """The inverse of ``laf_to_three_points``.

    Args:
        threepts: (B, N, 2, 3), floating point, whose columns are the ends of both axes and the centre.

    Returns:
        (B, N, 2, 3).

    Raises:
        TypeError: if threepts is not floating point.
        ValueError: if threepts is not (B, N, 2, 3).

    Example:
        >>> laf_from_three_points(torch.tensor([[[[9.0, 7.0, 7.0], [6.0, 8.0, 5.0]]]]))
        tensor([[[[2., 0., 7.],
                  [1., 3., 5.]]]])
    """
    check_laf(threepts, "threepts")
    centre = threepts[..., 2:]
    return torch.cat([threepts[..., :2] - centre, centre], -1)


def laf_to_boundary_points(LAF: Tensor, n_pts: int = 50) -> Tensor:
    """The centre of each frame, and points around its ellipse.

    Args:
        LAF: (B, N, 2, 3), floating point.
        n_pts: number of points, at least 2: the centre, and n_pts - 1 from the end of the second axis on, at
            equal steps of the unit circle's angle; the last is the first again.

    Returns:
        (B, N, n_pts, 2), x and y.

    Raises:
        TypeError: if LAF is not floating point.
        ValueError: if LAF is not (B, N, 2, 3) or n_pts less than 2.

    Example:
        >>> points = laf_to_boundary_points(torch.tensor([[[[2.0, 0.0, 7.0], [0.0, 2.0, 5.0]]]]), 6)
        >>> points[0, 0, :3].round()
        tensor([[7., 5.],
                [7., 7.],
                [9., 5.]])
    """
    check_laf(LAF, "LAF")
    if n_pts < 2:
        raise ValueError(f"n_pts: expected at least 2, got {n_pts}")
    step = 2.0 * math.pi / max(n_pts - 2, 1)
    angle = torch.arange(n_pts - 1, device=LAF.device).to(torch.float64) * step
    around = torch.stack([torch.sin(angle), torch.cos(angle)]).to(LAF.dtype)
    disk = torch.cat([torch.zeros_like(around[:, :1]), around], 1)
    return (small_matmul(LAF[..., :2], disk) + LAF[..., 2:]).transpose(-1, -2)


def ellipse_to_laf(ells: Tensor) -> Tensor:
    """Upright frames of ellipses a dx^2 + 2 b dx dy + c dy^2 = 1 (the form of the Oxford affine regions).

    A is lower triangular with A^T M A = 1 for M = ((a, b), (b, c)). Kornia uses the inverse of a square root
    of ((a, 0), (b, c)), which is the same for b = 0 and otherwise a different ellipse.

    Args:
        ells: (B, N, 5), floating point: x, y, a, b, c.

    Returns:
        (B, N, 2, 3); zeros where the form is not positive definite. Computed in float64.

    Raises:
        TypeError: if ells is not floating point.
        ValueError: if ells is not (B, N, 5).

    Example:
        >>> ellipse_to_laf(torch.tensor([[[7.0, 5.0, 0.265625, -0.03125, 0.0625]]]))
        tensor([[[[2., 0., 7.],
                  [1., 4., 5.]]]])
    """
    check_floating(ells, "ells")
    if ells.dim() != 3 or ells.size(2) != 5:
        raise ValueError(f"ells: expected shape (B, N, 5), got {list(ells.shape)}")
    x = ells.to(torch.float64)
    a, b, c = x[..., 2], x[..., 3], x[..., 4]
    proper = (c > 0) & (a * c - b * b > 0)
    one, zero = torch.ones_like(a), torch.zeros_like(a)
    c = torch.where(proper, c, one)
    area = torch.where(proper, a * c - b * b, one)
    across = torch.sqrt(c / area)
    rows = [
        torch.stack([across, zero, x[..., 0]], -1),
        torch.stack([-across * b / c, torch.rsqrt(c), x[..., 1]], -1),
    ]
    frame = torch.stack(rows, -2)
    return torch.where(proper[..., None, None], frame, torch.zeros_like(frame)).to(ells.dtype)


def laf_is_filled(laf: Tensor) -> Tensor:
    """A mask of the slots that hold a frame; detectors with a fixed capacity fill the other slots with zeros.

    Args:
        laf: (B, N, 2, 3), floating point.

    Returns:
        (B, N), bool: whether any entry is not 0.

    Raises:
        TypeError: if laf is not floating point.
        ValueError: if laf is not (B, N, 2, 3).

    Example:
        >>> laf_is_filled(torch.stack([torch.zeros(2, 3), torch.eye(2, 3)])[None])
        tensor([[False,  True]])
    """
    check_laf(laf, "laf")
    return (laf != 0).any(-1).any(-1)


def laf_is_valid(laf: Tensor) -> Tensor:
    """A mask of the frames that are finite and have a finite, nonzero determinant.

    Args:
        laf: (B, N, 2, 3), floating point.

    Returns:
        (B, N), bool.

    Raises:
        TypeError: if laf is not floating point.
        ValueError: if laf is not (B, N, 2, 3).

    Example:
        >>> laf_is_valid(torch.stack([torch.ones(2, 3), torch.eye(2, 3)])[None])
        tensor([[False,  True]])
    """
    check_laf(laf, "laf")
    area = determinants(laf).abs()
    finite = (laf.abs() < float("inf")).all(-1).all(-1)
    return finite & (area > 0) & (area < float("inf"))


def laf_is_inside_image(laf: Tensor, images: Tensor, border: int = 0) -> Tensor:
    """A mask of the frames that lie inside their images. Twelve points, the centre and eleven around the
    ellipse, must be between border and W - border or H - border.

    Args:
        laf: (B, N, 2, 3), floating point, in pixels.
        images: (B, C, H, W), floating point; only their size is used.
        border: the least distance from the image border, in pixels.

    Returns:
        (B, N), bool.

    Raises:
        TypeError: if an input is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> frames = torch.tensor([[[[2.0, 0.0, 1.0], [0.0, 2.0, 5.0]], [[2.0, 0.0, 5.0], [0.0, 2.0, 5.0]]]])
        >>> laf_is_inside_image(frames, torch.zeros(1, 1, 9, 9))
        tensor([[False,  True]])
    """
    check_laf(laf, "laf")
    check_image(images, "images")
    points = laf_to_boundary_points(laf, 12)
    x, y = points[..., 0], points[..., 1]
    inside = (x >= border) & (y >= border) & (x <= images.size(3) - border) & (y <= images.size(2) - border)
    return inside.all(-1)


def perspective_transform_lafs(trans_01: Tensor, lafs_1: Tensor) -> Tensor:
    """Transform frames by homographies: the centre is mapped, and A is multiplied by the homography's
    derivative there.

    K. Koeser, R. Koch, Differential Spatial Resection, ECCV 2008. Kornia maps the centre and the ends of both
    axes instead. This is the same for an affine homography; otherwise the difference is of the order of the
    frame's size times the perspective.

    Args:
        trans_01: (B, 3, 3), floating point, from the frames' image to the other one, in pixels.
        lafs_1: (B, N, 2, 3), floating point.

    Returns:
        (B, N, 2, 3).

    Raises:
        TypeError: if an input is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> twice = torch.diag(torch.tensor([2.0, 2.0, 1.0]))[None]
        >>> perspective_transform_lafs(twice, torch.tensor([[[[2.0, 0.0, 7.0], [1.0, 3.0, 5.0]]]]))
        tensor([[[[ 4.,  0., 14.],
                  [ 2.,  6., 10.]]]])
    """
    check_matrices(trans_01, 3, 3, "trans_01")
    check_laf(lafs_1, "lafs_1")
    check_leading([trans_01, lafs_1], ["trans_01", "lafs_1"], [2, 3])
    precision = position_dtype(lafs_1.dtype)
    m, frame = trans_01.to(precision)[:, None], lafs_1.to(precision)
    # The homography of the centre, and of both axes as directions.
    mapped = small_matmul(m[..., :2], frame) + torch.cat([torch.zeros_like(m[..., :2]), m[..., 2:]], -1)
    depth = away_from_zero(mapped[..., 2:, 2:])
    centre = mapped[..., :2, 2:] / depth
    matrix = (mapped[..., :2, :2] - centre * mapped[..., 2:, :2]) / depth
    return torch.cat([matrix, centre], -1).to(lafs_1.dtype)
