"""Outlines of the shapes in masks as polygons."""

from typing import Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_rank
from ..primitives.features.borders import find_contours


def masks_to_polygons(
    masks: Tensor, max_polygons: int = 16, max_points: int = 256
) -> Tuple[Tensor, Tensor, Tensor]:
    """The outlines of 8-connected shapes in masks and of their holes, as polygons, the largest first.

    A polygon goes through the centres of border pixels; around a hole, these are also pixels of the shape. As
    seen, it runs counterclockwise around a shape and clockwise around a hole. It is the result of OpenCV's
    findContours with CHAIN_APPROX_SIMPLE, which keeps the ends of horizontal, vertical and diagonal runs (S.
    Suzuki and K. Abe, Topological structural analysis of digitized binary images by border following, CVGIP
    1985). For a map of scores, call ``masks_to_polygons(scores > 0.5)``.

    Args:
        masks: (N, H, W), any dtype: what is not 0 belongs to the mask.
        max_polygons: the number P of slots for each mask. Polygons with the most pixels inside come first; of
            equal ones, the one whose first pixel comes first, row by row.
        max_points: the number M of slots for each polygon. If a polygon has more points, M of them are
            selected, evenly by their index.

    Returns:
        Points (N, P, M, 2) as x, y, float32; the number of each polygon's points, (N, P), int64; and a mask
        of the polygons around holes, (N, P), bool. Empty slots are 0.

    Raises:
        ValueError: if masks is not (N, H, W) with a pixel at least, or a number of slots is not positive.

    Example:
        >>> mask = torch.zeros(1, 4, 5)
        >>> mask[0, 1:3, 1:4] = 1
        >>> points, count, is_hole = masks_to_polygons(mask, 1, 5)
        >>> points[0, 0], count, is_hole
        (tensor([[1., 1.],
                [1., 2.],
                [3., 2.],
                [3., 1.],
                [0., 0.]]), tensor([[4]]), tensor([[False]]))
    """
    check_rank(masks, 3, "(N, H, W)", "masks")
    if masks.size(1) < 1 or masks.size(2) < 1:
        raise ValueError(f"masks: expected H and W of at least 1, got {list(masks.shape)}")
    if max_polygons < 1:
        raise ValueError(f"max_polygons: expected a positive number, got {max_polygons}")
    if max_points < 1:
        raise ValueError(f"max_points: expected a positive number, got {max_points}")
    found = find_contours(masks.to(torch.bool), max_polygons, max_points)
    pixel, width = found[..., 2:], masks.size(2)
    y = pixel // width
    points = torch.stack([pixel - y * width, y], 3)
    points = torch.where((pixel >= 0)[..., None], points, torch.zeros_like(points))
    return points.to(torch.float32), found[..., 0], found[..., 1] > 0
