"""Guided filter."""

from typing import List, Tuple, Union

import torch
from torch import Tensor

from ..geometry.transform.resize import resize
from ..primitives.core.checks import check_image, odd_pair
from ..primitives.filters.padding import check_border
from ..primitives.filters.stencil import separable as separable_sums


def guided_blur(
    guidance: Tensor,
    input: Tensor,
    kernel_size: Union[int, Tuple[int, int]],
    eps: Union[float, Tensor],
    border_type: str = "reflect",
    subsample: int = 1,
    separable: bool = False,
) -> Tensor:
    """Smooth by local linear models of a guidance image: output = a . guidance + b.

    The models are fitted in each window and averaged. K. He, J. Sun, X. Tang, Guided image filtering, ECCV
    2010; subsample is from K. He, J. Sun, Fast guided filter, 2015.

    Args:
        guidance: (B, C, H, W), floating point. All its channels guide each channel of input.
        input: (B, D, H, W), floating point.
        kernel_size: odd size of the window, one for both axes or (rows, columns).
        eps: the variance of guidance up to which a window counts as flat, > 0; a float, or a tensor (B,) or
            scalar.
        border_type: "reflect", "replicate", "circular" or "constant" (zeros).
        subsample: fit the models on images reduced by this factor (nearest pixels), in windows whose radius
            is reduced by the same factor, and enlarge a and b bilinearly.
        separable: for compatibility with Kornia; it has no effect, since the box sums are always separable.

    Returns:
        (B, D, H, W).

    Raises:
        TypeError: if guidance or input is not floating point.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> x = torch.rand(1, 3, 8, 8)
        >>> guided_blur(x, x, 3, 0.1).shape
        torch.Size([1, 3, 8, 8])
    """
    check_image(guidance, "guidance")
    check_image(input, "input")
    if (
        guidance.size(0) != input.size(0)
        or guidance.size(2) != input.size(2)
        or guidance.size(3) != input.size(3)
    ):
        raise ValueError(
            f"guidance: expected input's batch, height and width {list(input.shape)}, got"
            f" {list(guidance.shape)}"
        )
    if subsample < 1:
        raise ValueError(f"subsample: expected at least 1, got {subsample}")
    check_border(border_type)
    ky, kx = odd_pair(kernel_size, "kernel_size")
    if isinstance(eps, Tensor):
        flat = eps.to(guidance.dtype).reshape(-1, 1, 1, 1)
    else:
        flat = torch.full([1, 1, 1, 1], eps, dtype=guidance.dtype, device=guidance.device)
    height, width = input.size(2), input.size(3)
    small_guidance, small_input = guidance, input
    if subsample > 1:
        small = (height // subsample, width // subsample)
        if small[0] < 1 or small[1] < 1:
            raise ValueError(f"subsample: expected at most a side of {height} x {width}, got {subsample}")
        small_guidance = resize(guidance, small, "nearest")
        small_input = resize(input, small, "nearest")
        ky = 2 * (ky // 2 // subsample) + 1
        kx = 2 * (kx // 2 // subsample) + 1
    slopes, offset = _linear_models(small_guidance, small_input, ky, kx, flat, border_type)
    if subsample > 1:
        slopes = [resize(a, (height, width)) for a in slopes]
        offset = resize(offset, (height, width))
    out = offset
    for i in range(len(slopes)):
        out = out + slopes[i] * guidance[:, i : i + 1]
    return out


def _linear_models(
    guidance: Tensor, input: Tensor, ky: int, kx: int, eps: Tensor, border_type: str
) -> Tuple[List[Tensor], Tensor]:
    """The slope for each channel of guidance and the offset, (B, D, H, W) each, averaged over the windows of
    each pixel."""
    channels = guidance.size(1)
    guides = [guidance[:, i : i + 1] for i in range(channels)]
    products: List[Tensor] = []
    for i in range(channels):
        products += [guides[i] * guides[j] for j in range(i, channels)]
    sums = _boxes(guides + products + [input] + [guide * input for guide in guides], ky, kx, border_type)
    means, mean = sums[:channels], sums[channels + len(products)]
    # The normal equations (covariance + eps I) a = covariance with input, solved by elimination, which needs
    # no pivoting for a positive definite matrix. rows[i][j - i] is the upper triangle.
    rows: List[List[Tensor]] = []
    right: List[Tensor] = []
    n = channels
    for i in range(channels):
        row: List[Tensor] = []
        for j in range(i, channels):
            covariance = sums[n] - means[i] * means[j]
            row.append(covariance + eps if i == j else covariance)
            n += 1
        rows.append(row)
        right.append(sums[channels + len(products) + 1 + i] - means[i] * mean)
    for i in range(channels):
        for j in range(i + 1, channels):
            factor = rows[i][j - i] / rows[i][0]
            rows[j] = [rows[j][k - j] - factor * rows[i][k - i] for k in range(j, channels)]
            right[j] = right[j] - factor * right[i]
    for step in range(channels):
        i = channels - 1 - step
        for j in range(i + 1, channels):
            right[i] = right[i] - rows[i][j - i] * right[j]
        right[i] = right[i] / rows[i][0]
    offset = mean
    for i in range(channels):
        offset = offset - right[i] * means[i]
    averaged = _boxes(right + [offset], ky, kx, border_type)
    return averaged[:channels], averaged[channels]


def _boxes(images: List[Tensor], ky: int, kx: int, border_type: str) -> List[Tensor]:
    """The means of the windows of images of one height and width, all channels in one pass."""
    together = torch.cat(images, 1)
    # Taps that are Python numbers would become convolutions in ONNX, which fold channels into the batch; for
    # a subsampled image, torch.export then cannot prove sizes such as H // 2.
    kernel_y = torch.full([1, ky], 1.0 / ky, dtype=together.dtype, device=together.device)
    kernel_x = torch.full([1, kx], 1.0 / kx, dtype=together.dtype, device=together.device)
    means = separable_sums(together, kernel_y, kernel_x, border_type)
    outs: List[Tensor] = []
    first = 0
    for image in images:
        outs.append(means.narrow(1, first, image.size(1)))
        first += image.size(1)
    return outs
