"""Histograms of gradients: SIFT of patches and dense SIFT.

D. Lowe, Distinctive Image Features from Scale-Invariant Keypoints, IJCV 60(2), 2004; RootSIFT: R.
Arandjelovic, A. Zisserman, Three things everyone should know to improve object retrieval, CVPR 2012.
"""

from typing import List

import torch
import torch.nn.functional as F
from torch import Tensor

from ..primitives.core.checks import check_choice, check_image, check_one_channel, check_tensor
from ..primitives.features.orientations import directed, orientation_histograms, polar_gradient
from ..primitives.filters.padding import check_inside
from ..primitives.resampling.warping import position_dtype
from .gradients import check_patches, gaussian_window, unit


def sift_describe(
    patches: Tensor,
    num_ang_bins: int = 8,
    num_spatial_bins: int = 4,
    rootsift: bool = True,
    clipval: float = 0.2,
) -> Tensor:
    """SIFT descriptors of patches.

    As in Lowe's paper, gradients are weighted by a Gaussian with sigma of half the patch's side and split
    linearly between neighbouring directions and spatial bins. The vector of histograms is normalized to
    length 1, clipped at clipval and normalized again. (Kornia's spatial bins overlap less, their centres are
    shifted by a pixel, and its Gaussian is wider; the descriptors are similar, but must not be mixed.)

    Args:
        patches: (N, 1, PS, PS), floating point, oriented, PS at least num_spatial_bins. Half precision is
            computed in float32.
        num_ang_bins: directions, from x towards y (down).
        num_spatial_bins: number of spatial bins along each side.
        rootsift: return the square roots of the vector divided by its sum; their Euclidean distance is the
            Hellinger distance of the histograms.
        clipval: the largest value of an entry of the unit vector.

    Returns:
        (N, num_ang_bins * num_spatial_bins^2), unit vectors, the direction outermost, then rows, then
        columns; zeros for a patch without gradients.

    Raises:
        TypeError: if patches is not floating point.
        ValueError: if patches is not (N, 1, PS, PS) or too small, a number of bins not as above or clipval
            not positive.

    Example:
        >>> ramp = torch.arange(16.0).expand(1, 1, 16, 16)
        >>> described = sift_describe(ramp).reshape(8, 16)
        >>> described.norm(dim=1).round(decimals=2)
        tensor([1., 0., 0., 0., 0., 0., 0., 0.])
    """
    check_patches(patches)
    _check_bins(num_ang_bins, num_spatial_bins, clipval)
    size = patches.size(3)
    if size < num_spatial_bins:
        raise ValueError(
            f"patches: expected at least {num_spatial_bins} x {num_spatial_bins} pixels, got"
            f" {list(patches.shape)}"
        )
    exact = patches.to(position_dtype(patches.dtype))
    window, near = gaussian_window(size, 0.5 * size, exact), _nearness(size, num_spatial_bins, exact)
    return _finished(
        orientation_histograms(exact, window, near, num_ang_bins).flatten(1), rootsift, clipval
    ).to(patches.dtype)


def dense_sift(
    input: Tensor,
    num_ang_bins: int = 8,
    num_spatial_bins: int = 4,
    spatial_bin_size: int = 4,
    rootsift: bool = True,
    clipval: float = 0.2,
    stride: int = 1,
    padding: int = 0,
) -> Tensor:
    """Dense SIFT: descriptors of upright windows on a grid over the image. There is no Gaussian weight, and
    gradients outside a window contribute to its outer spatial bins.

    A. Bosch, A. Zisserman, X. Munoz, Image Classification using Random Forests and Ferns, ICCV 2007.

    Args:
        input: (B, 1, H, W), floating point, at least as large as a window. Half precision is computed in
            float32.
        num_ang_bins, num_spatial_bins, rootsift, clipval: see ``sift_describe``.
        spatial_bin_size: size of a spatial bin in pixels; a window is num_spatial_bins * spatial_bin_size
            pixels wide and high.
        stride: pixels from one window to the next.
        padding: how many pixels a window may reach beyond the image, where there are no gradients.

    Returns:
        (B, num_ang_bins * num_spatial_bins^2, h, w), in the order of ``sift_describe``; entry (i, j) is that
        of the window whose first pixel is (i stride - padding, j stride - padding), for all windows inside
        the padded image.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not (B, 1, H, W) or smaller than a window, or a number not positive.

    Example:
        >>> dense_sift(torch.rand(1, 1, 20, 30), stride=2).shape
        torch.Size([1, 128, 3, 8])
    """
    check_one_channel(input, "input")
    _check_bins(num_ang_bins, num_spatial_bins, clipval)
    if spatial_bin_size < 1 or stride < 1:
        raise ValueError(
            f"spatial_bin_size, stride: expected positive numbers, got {spatial_bin_size} and {stride}"
        )
    if padding < 0:
        raise ValueError(f"padding: expected a number >= 0, got {padding}")
    check_inside(input.size(2) + 2 * padding, num_spatial_bins * spatial_bin_size, "rows")
    check_inside(input.size(3) + 2 * padding, num_spatial_bins * spatial_bin_size, "columns")
    length, direction = polar_gradient(input.to(position_dtype(input.dtype)))
    planes = directed(length, direction, num_ang_bins)
    if padding > 0:
        planes = F.pad(planes, [padding, padding, padding, padding])
    rows = _placed(planes, 2, num_spatial_bins, spatial_bin_size, stride)
    places: List[Tensor] = []
    for row in rows:
        places += _placed(row, 3, num_spatial_bins, spatial_bin_size, stride)
    return _finished(torch.stack(places, 2).flatten(1, 2), rootsift, clipval).to(input.dtype)


def mean_patch(patches: Tensor) -> Tensor:
    """The mean of each channel of patches: the simplest descriptor.

    Args:
        patches: (N, C, PS, PS), floating point.

    Returns:
        (N, C).

    Raises:
        TypeError: if patches is not floating point.
        ValueError: if patches is not 4-D.

    Example:
        >>> mean_patch(torch.arange(8.0).reshape(1, 2, 2, 2))
        tensor([[1.5000, 5.5000]])
    """
    check_image(patches, "patches")
    return patches.mean([2, 3])


def convert_sift_descriptor_layout(
    descriptors: Tensor, source: str, target: str, num_ang_bins: int = 8, num_spatial_bins: int = 4
) -> Tensor:
    """Reorder the entries of SIFT descriptors from another library.

    "kornia", as ``sift_describe``: directions outermost, then rows and columns; directions turn from x
    towards y, which points down. "vlfeat": rows, columns, directions, turning the same way. "opencv", which
    is Lowe's: rows, columns, directions, turning the other way.

    Args:
        descriptors: (*, num_ang_bins * num_spatial_bins^2), of any dtype.
        source, target: "kornia", "opencv" or "vlfeat".
        num_ang_bins, num_spatial_bins: see ``sift_describe``.

    Returns:
        (*, num_ang_bins * num_spatial_bins^2).

    Raises:
        ValueError: if a layout is not known or the number of entries not as above.

    Example:
        >>> convert_sift_descriptor_layout(torch.arange(8), "opencv", "kornia", 8, 1)
        tensor([0, 7, 6, 5, 4, 3, 2, 1])
    """
    cells = num_spatial_bins * num_spatial_bins
    check_tensor(descriptors, "descriptors")
    if descriptors.dim() < 1 or descriptors.size(-1) != num_ang_bins * cells:
        raise ValueError(
            f"descriptors: expected shape (*, {num_ang_bins * cells}), got {list(descriptors.shape)}"
        )
    before, after = (
        _entries(source, "source", num_ang_bins, cells),
        _entries(target, "target", num_ang_bins, cells),
    )
    order = [0 for _ in before]
    for k in range(len(before)):
        order[after[k]] = before[k]
    return descriptors.index_select(-1, torch.tensor(order, device=descriptors.device))


def _entries(layout: str, name: str, bins: int, cells: int) -> List[int]:
    """The positions of the entries of Kornia's layout in this layout, in order."""
    check_choice(layout, ["kornia", "opencv", "vlfeat"], name)
    entries: List[int] = []
    for angle in range(bins):
        for cell in range(cells):
            if layout == "kornia":
                entries.append(angle * cells + cell)
            elif layout == "vlfeat":
                entries.append(cell * bins + angle)
            else:
                entries.append(cell * bins + (bins - angle) % bins)
    return entries


def _check_bins(num_ang_bins: int, num_spatial_bins: int, clipval: float) -> None:
    if num_ang_bins < 2:
        raise ValueError(f"num_ang_bins: expected at least 2, got {num_ang_bins}")
    if num_spatial_bins < 1:
        raise ValueError(f"num_spatial_bins: expected a positive number, got {num_spatial_bins}")
    if not clipval > 0.0:
        raise ValueError(f"clipval: expected a positive number, got {clipval}")


def _nearness(size: int, bins: int, like: Tensor) -> Tensor:
    """(bins, size): 1 minus the distance of each pixel from the centre of each spatial bin, in units of bins,
    at least 0."""
    pixel = (torch.arange(size, device=like.device).to(like.dtype) + 0.5) * bins / size
    centre = torch.arange(bins, device=like.device).to(like.dtype) + 0.5
    return (1.0 - (pixel - centre[:, None]).abs()).clamp(min=0)


def _placed(x: Tensor, dim: int, bins: int, bin_size: int, stride: int) -> List[Tensor]:
    """The sum of each spatial bin of all windows along ``dim``, from (B, C, H, W) with zeros outside."""
    size, half = x.size(dim), bin_size // 2
    edge = torch.zeros_like(x.narrow(dim, 0, 1))
    padded = torch.cat([edge] * half + [x] + [edge] * half, dim)
    taps = 2 * bin_size - bin_size % 2
    count = size - bin_size + 1
    pooled = torch.zeros_like(x.narrow(dim, 0, 1))
    for k in range(taps):
        pooled = pooled + padded.narrow(dim, k, count) * (1.0 - abs(k - 0.5 * (taps - 1)) / bin_size)
    first = torch.arange((size - bins * bin_size) // stride + 1, device=x.device) * stride
    return [pooled.index_select(dim, first + k * bin_size) for k in range(bins)]


def _finished(histograms: Tensor, rootsift: bool, clipval: float) -> Tensor:
    """Unit vectors along the second axis."""
    vectors = unit(unit(histograms, True).clamp(max=clipval), True)
    if not rootsift:
        return vectors
    shares = unit(vectors, False)
    empty = shares == 0
    return torch.where(
        empty, torch.zeros_like(shares), torch.sqrt(torch.where(empty, torch.ones_like(shares), shares))
    )
