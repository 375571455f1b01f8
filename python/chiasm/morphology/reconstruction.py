"""Morphological reconstruction."""

from typing import Optional

import torch
from torch import Tensor

from ..primitives.core.checks import check_choice, check_image, check_optional, check_rank
from ..primitives.features.reconstruction import reconstructed


def reconstruction(
    seed: Tensor,
    mask: Tensor,
    kernel: Optional[Tensor] = None,
    method: str = "dilation",
    num_iters: Optional[int] = None,
) -> Tensor:
    """Dilate a seed image repeatedly, limited by a mask image, until nothing changes.

    L. Vincent, Morphological grayscale reconstruction in image analysis, IEEE TIP 2(2), 1993. Like
    scikit-image's ``reconstruction``. A step moves values by one element, so a long path takes many steps;
    the exported loop ends as soon as nothing changes. Kornia's ``check_every`` and ``engine`` have no
    counterpart.

    Args:
        seed: (B, C, H, W), floating point; it is limited to mask.
        mask: (B, C, H, W), floating point, without NaN, of magnitude below 1e4.
        kernel: (kh, kw) flat neighbourhood, nonzero at its points, which include the centre; 3x3 ones by
            default.
        method: "dilation", or "erosion", which erodes the seed, never below mask.
        num_iters: the maximum number of steps; None means no limit.

    Returns:
        (B, C, H, W).

    Raises:
        TypeError: if seed or mask is not floating point.
        ValueError: if a shape or method is not as above.

    Example:
        >>> mask = torch.tensor([[[[3.0, 2.0, 0.0, 4.0]]]])
        >>> seed = torch.tensor([[[[0.0, 9.0, 0.0, 0.0]]]])
        >>> reconstruction(seed, mask)
        tensor([[[[2., 2., 0., 0.]]]])
    """
    check_image(seed, "seed")
    check_image(mask, "mask")
    check_choice(method, ["dilation", "erosion"], "method")
    if mask.shape != seed.shape:
        raise ValueError(f"mask: expected seed's shape {list(seed.shape)}, got {list(mask.shape)}")
    if num_iters is not None and num_iters < 0:
        raise ValueError(f"num_iters: expected at least 0, got {num_iters}")
    check_optional(kernel, "kernel")
    element = (
        torch.ones([3, 3], dtype=seed.dtype, device=seed.device) if kernel is None else kernel.to(seed.dtype)
    )
    check_rank(element, 2, "(kh, kw)", "kernel")
    return reconstructed(seed, mask, element, num_iters, method == "dilation")
