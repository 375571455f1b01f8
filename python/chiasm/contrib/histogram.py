"""Histogram matching, and the linear interpolation that it uses."""

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_not_empty, check_rank, check_tensor
from ..primitives.images.histograms import bincount, lut, quantize_u8, running_sum
from ..primitives.numbers.search import interpolate


def interp(x: Tensor, xp: Tensor, fp: Tensor) -> Tensor:
    """Piecewise linear interpolation through the points (xp, fp) at x, like ``numpy.interp``; constant beyond
    the ends, NaN at NaN.

    Args:
        x: (*), floating point.
        xp: (N,), ascending, at most 2^20 entries.
        fp: (N,), the values at xp.

    Returns:
        Tensor of x's shape and dtype.

    Raises:
        TypeError: if x is not floating point.
        ValueError: if xp is not 1-D or empty, or fp not of its shape.

    Example:
        >>> interp(torch.tensor([-1.0, 0.5, 3.0]), torch.tensor([0.0, 1.0]), torch.tensor([10.0, 20.0]))
        tensor([10., 15., 20.])
    """
    check_floating(x, "x")
    check_rank(xp, 1, "(N,)", "xp")
    if xp.size(0) < 1:
        raise ValueError("xp: expected at least one entry, got none")
    check_tensor(fp, "fp")
    if fp.shape != xp.shape:
        raise ValueError(f"fp: expected xp's shape {list(xp.shape)}, got {list(fp.shape)}")
    y = interpolate(x.reshape(1, -1), xp.to(x.dtype)[None], fp.to(x.dtype)[None]).reshape(x.shape)
    return torch.where(torch.isnan(x), x, y)


def histogram_matching(source: Tensor, template: Tensor, per_plane: bool = False) -> Tensor:
    """Change the levels of an image so that its histogram resembles that of another.

    R. C. Gonzalez, R. E. Woods, Digital Image Processing, 3.3.2; equals scikit-image's ``match_histograms``
    for uint8 except for its rounding. Both images are rounded to the nearest of 256 levels; Kornia accepts
    any values. There is no gradient.

    Args:
        source: (*, H, W) in [0, 1], floating point.
        template: (*, h, w) in [0, 1], floating point.
        per_plane: match each plane of source with the same plane of template, which must then have the same
            leading dimensions; otherwise all values of a tensor form one histogram, as in Kornia.

    Returns:
        Tensor of source's shape and dtype.

    Raises:
        TypeError: if source or template is not floating point.
        ValueError: if source or template has fewer than two dimensions or no pixels, template no planes
            although source has some, or with per_plane other leading dimensions.

    Example:
        >>> histogram_matching(torch.tensor([[0.0, 0.2]]), torch.tensor([[0.6, 1.0]]))
        tensor([[0.6000, 1.0000]])
    """
    check_floating(source, "source")
    check_floating(template, "template")
    if source.dim() < 2 or template.dim() < 2:
        raise ValueError(
            f"source: expected shapes (*, H, W), got {list(source.shape)} and {list(template.shape)}"
        )
    check_not_empty(source, 2, "source")
    check_not_empty(template, 2, "template")
    if template.numel() == 0 and source.numel() > 0:
        raise ValueError(f"template: expected at least one plane, got {list(template.shape)}")
    if per_plane:
        if source.shape[:-2] != template.shape[:-2]:
            raise ValueError(
                f"template: expected source's leading dimensions {list(source.shape[:-2])}, got"
                f" {list(template.shape)}"
            )
        levels = quantize_u8(source).reshape([-1, source.size(-2) * source.size(-1)])
        wanted = quantize_u8(template).reshape([-1, template.size(-2) * template.size(-1)])
    else:
        levels = quantize_u8(source).reshape(1, -1)
        wanted = quantize_u8(template).reshape(1, -1)
    counts = bincount(wanted, 256)
    quantiles = _quantiles(bincount(levels, 256))
    # A level that does not occur is replaced by the next lower level that occurs (or by the first), so that
    # equal quantiles have equal values and none of them is the end of an interval.
    level = torch.arange(256, device=source.device)
    occurs = counts > 0
    first = torch.where(occurs, level, torch.full_like(level, 255)).amin(1, keepdim=True)
    below = torch.where(occurs[:, None] & (level <= level[:, None]), level, first[:, :, None]).amax(2)
    table = interpolate(quantiles, _quantiles(counts), below.to(torch.float64)) / 255.0
    return lut(table.to(source.dtype), levels).reshape(source.shape)


def _quantiles(counts: Tensor) -> Tensor:
    upto = running_sum(counts)
    # equal fractions must give equal numbers, so that a quantile of both images is found: one division,
    # exactly rounded
    return upto.to(torch.float64) / upto[:, 255:].to(torch.float64)
