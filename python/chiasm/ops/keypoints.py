"""Keypoints from heat maps, and from two distributions along the axes."""

from typing import Tuple

import torch
from torch import Tensor

from ..filters.gaussian import gaussian_blur2d
from ..primitives.core.checks import check_choice, check_floating, check_rank
from ..primitives.numbers.ranking import stable_topk
from ..primitives.numbers.reductions import greatest, least
from ..primitives.resampling.warping import position_dtype


def decode_heatmaps(
    heatmaps: Tensor, refinement: str = "none", kernel_size: int = 11
) -> Tuple[Tensor, Tensor]:
    """Decode heat maps to keypoints: the subpixel position of the largest value of each map.

    * "none": the pixel of the largest value; of equal values the first, row by row.
    * "quarter": this pixel moved by 1/4 pixel towards the higher of its two neighbours, independently along
      each axis, if both neighbours are in the image and differ (A. Newell et al., Stacked Hourglass Networks,
      ECCV 2016; B. Xiao et al., Simple Baselines for Human Pose Estimation, ECCV 2018).
    * "dark": one Newton step to the maximum of the logarithm of the map, after smoothing by a Gaussian and
      scaling to the range 0 to 1 (F. Zhang et al., Distribution-Aware Coordinate Representation, CVPR 2020,
      equations 8 to 10). Derivatives are differences of neighbours one pixel apart. There is no step if a
      neighbour is outside the image, or if the logarithm does not curve downwards in every direction. A step
      is limited to the centres of the outermost pixels.

    Args:
        heatmaps: (B, K, H, W), floating point, one for each keypoint.
        refinement: "none", "quarter" or "dark".
        kernel_size: of the smoothing of "dark", odd: the Gaussian should be as wide as those that the network
            was trained with. Its standard deviation is 0.15 kernel_size + 0.35 pixels, OpenCV's rule: 2 for
            11 taps.

    Returns:
        Points (B, K, 2), x and y in pixels of the maps, float32 for half precision, which rounds positions to
        whole pixels or more; and the largest values (B, K).

    Raises:
        TypeError: if heatmaps is not floating point.
        ValueError: if heatmaps is not (B, K, H, W) with a pixel at least, refinement is none of these, or
            kernel_size is not odd and positive.

    Example:
        >>> heatmaps = torch.zeros(1, 1, 5, 6)
        >>> heatmaps[0, 0, 2, 3], heatmaps[0, 0, 2, 4] = 0.8, 0.5
        >>> decode_heatmaps(heatmaps, "quarter")
        (tensor([[[3.2500, 2.0000]]]), tensor([[0.8000]]))
    """
    check_rank(heatmaps, 4, "(B, K, H, W)", "heatmaps")
    check_floating(heatmaps, "heatmaps")
    check_choice(refinement, ["none", "quarter", "dark"], "refinement")
    if heatmaps.size(2) < 1 or heatmaps.size(3) < 1:
        raise ValueError(f"heatmaps: expected a pixel at least, got {list(heatmaps.shape)}")
    if kernel_size < 1 or kernel_size % 2 == 0:
        raise ValueError(f"kernel_size: expected a positive odd size, got {kernel_size}")
    values = heatmaps.to(position_dtype(heatmaps.dtype))
    scores, place = stable_topk(values.flatten(2), 1)
    row = place // heatmaps.size(3)
    column = place - row * heatmaps.size(3)
    points = torch.cat([column, row], 2).to(values.dtype)
    if refinement == "quarter":
        points = points + _towards_the_higher(values, row, column)
    elif refinement == "dark" and heatmaps.size(1) > 0:
        deviation = 0.3 * ((kernel_size - 1) * 0.5 - 1.0) + 0.8
        smooth = gaussian_blur2d(values, (kernel_size, kernel_size), (deviation, deviation), "constant")
        x, y = (points + _newton_step(smooth, row, column)).unbind(2)
        points = torch.stack([x.clamp(0, heatmaps.size(3) - 1), y.clamp(0, heatmaps.size(2) - 1)], 2)
    return points, scores[..., 0].to(heatmaps.dtype)


def decode_simcc(simcc_x: Tensor, simcc_y: Tensor, split_ratio: float = 2.0) -> Tuple[Tensor, Tensor]:
    """Decode SimCC outputs to keypoints: the positions of the largest values along x and along y.

    Y. Li et al., SimCC: a Simple Coordinate Classification Perspective for Human Pose Estimation, ECCV 2022;
    the score is that of RTMPose (T. Jiang et al., arXiv:2303.07399), which treats keypoints whose score is
    not positive as missing.

    Args:
        simcc_x: (B, K, Wx), floating point: for each of K keypoints the values of Wx places from left to
            right.
        simcc_y: (B, K, Hy), floating point: the values of Hy places from top to bottom.
        split_ratio: the number of places for each pixel.

    Returns:
        Points (B, K, 2), x and y in pixels, float32 for half precision (of equal values the first place is
        used); and scores (B, K), the smaller of the largest values along x and along y.

    Raises:
        TypeError: if simcc_x or simcc_y is not floating point.
        ValueError: if a shape is not as above, or split_ratio is not positive.

    Example:
        >>> decode_simcc(torch.tensor([[[0.1, 0.2, 0.7, 0.0]]]), torch.tensor([[[0.1, 0.9]]]))
        (tensor([[[1.0000, 0.5000]]]), tensor([[0.7000]]))
    """
    for name, each in [("simcc_x", simcc_x), ("simcc_y", simcc_y)]:
        check_rank(each, 3, "(B, K, places)", name)
        check_floating(each, name)
        if each.size(2) < 1:
            raise ValueError(f"{name}: expected a place at least, got {list(each.shape)}")
    if simcc_y.shape[:2] != simcc_x.shape[:2]:
        raise ValueError(
            f"simcc_y: expected shape (B, K, Hy) for simcc_x {list(simcc_x.shape)}, got {list(simcc_y.shape)}"
        )
    if not split_ratio > 0.0:
        raise ValueError(f"split_ratio: expected a positive number, got {split_ratio}")
    largest_x, place_x = stable_topk(simcc_x, 1)
    largest_y, place_y = stable_topk(simcc_y, 1)
    points = torch.cat([place_x, place_y], 2).to(position_dtype(simcc_x.dtype)) / split_ratio
    return points, torch.minimum(largest_x, largest_y)[..., 0]


def _around(values: Tensor, row: Tensor, column: Tensor) -> Tensor:
    """The 3 x 3 values (B, K, 9) about a pixel (B, K, 1) of each map, row by row; beyond the border the
    nearest ones."""
    offset = torch.arange(9, device=values.device)
    down = offset // 3
    rows = (row + (down - 1)).clamp(0, values.size(2) - 1)
    columns = (column + (offset - 3 * down - 1)).clamp(0, values.size(3) - 1)
    return values.flatten(2).gather(2, rows * values.size(3) + columns)


def _towards_the_higher(values: Tensor, row: Tensor, column: Tensor) -> Tensor:
    """(B, K, 2): 1/4 in the direction of the higher neighbour along x and y."""
    around = _around(values, row, column)
    before, after = torch.stack([around[..., 3], around[..., 1]], 2), around[..., 5:8:2]
    inside = torch.cat(
        [
            (column > 0) & (column < values.size(3) - 1),
            (row > 0) & (row < values.size(2) - 1),
        ],
        2,
    )
    none = torch.zeros_like(before)
    shift = torch.where(after > before, none + 0.25, torch.where(after < before, none - 0.25, none))
    return torch.where(inside, shift, none)


def _newton_step(values: Tensor, row: Tensor, column: Tensor) -> Tensor:
    """(B, K, 2): from a pixel to the maximum of the quadratic approximation of the logarithm."""
    low, high = least(values, [2, 3])[..., 0], greatest(values, [2, 3])[..., 0]
    span = torch.where(high > low, high - low, torch.ones_like(high))
    # Zhang et al. multiply by the largest value of the map, which cancels in derivatives of the logarithm.
    f = torch.log(((_around(values, row, column) - low) / span).clamp(min=1e-10)).unbind(2)
    gx, gy = 0.5 * (f[5] - f[3]), 0.5 * (f[7] - f[1])
    xx, yy = f[5] - 2.0 * f[4] + f[3], f[7] - 2.0 * f[4] + f[1]
    xy = 0.25 * (f[8] - f[6] - f[2] + f[0])
    determinant = xx * yy - xy * xy
    inside = (column > 0) & (column < values.size(3) - 1) & (row > 0) & (row < values.size(2) - 1)
    # A map that is flat within rounding has no maximum.
    curved = (xx < -1e-5) & (yy < -1e-5) & (determinant > 1e-3 * xx * yy) & inside[..., 0]
    divisor = torch.where(curved, determinant, torch.ones_like(determinant))
    step = torch.stack([(xy * gy - yy * gx) / divisor, (xy * gx - xx * gy) / divisor], 2)
    return torch.where(curved[..., None], step, torch.zeros_like(step))
