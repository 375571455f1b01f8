"""Non-local means."""

import torch
from torch import Tensor

from ..primitives.core.checks import check_image
from ..primitives.core.loops import repeated
from ..primitives.core.materialise import materialised
from ..primitives.filters.padding import padded
from ..primitives.filters.stencil import weigh_shifts
from ..primitives.numbers.loss_reduction import narrowed, widened


def non_local_means(
    input: Tensor,
    patch_size: int = 7,
    patch_distance: int = 11,
    h: float = 0.1,
    sigma: float = 0.0,
    border_type: str = "reflect",
) -> Tensor:
    """Average over the pixels of a search window, weighted by the similarity of the patches around them.

    A. Buades, B. Coll, J.-M. Morel, A non-local algorithm for image denoising, CVPR 2005, with uniform
    patches: the weight is exp(-max(d - 2 sigma^2, 0) / h^2), where d is the mean squared difference of the
        patches over pixels and channels. With sigma = 0, this is OpenCV's ``fastNlMeansDenoising`` on the
        scale 0 to 255, without its rounding; scikit-image uses weighted patches.

    The (2 patch_distance + 1)^2 shifts of the image are one loop. An exported gradient would unroll this
    loop, so no gradient is exported.

    Args:
        input: (B, C, H, W), floating point; the channels share their weights.
        patch_size: odd size of the patches.
        patch_distance: the radius of the search window in pixels.
        h: the patch difference at which weights become small, in input's units, > 0.
        sigma: standard deviation of the noise, in input's units.
        border_type: "reflect" (needs H and W above patch_distance + patch_size // 2), "replicate", "circular"
            or "constant" (zeros).

    Returns:
        (B, C, H, W).

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D, or a size, h or the border is not as above.

    Example:
        >>> non_local_means(torch.ones(1, 3, 8, 8), 3, 2).mean()
        tensor(1.)
    """
    check_image(input, "input")
    if patch_size < 1 or patch_size % 2 == 0:
        raise ValueError(f"patch_size: expected an odd positive size, got {patch_size}")
    if patch_distance < 0:
        raise ValueError(f"patch_distance: expected at least 0, got {patch_distance}")
    if not h > 0.0:
        raise ValueError(f"h: expected a positive number, got {h}")
    margin = patch_distance + patch_size // 2
    image = widened(input)
    wide = padded(image, (margin, margin), (margin, margin), border_type)
    # The weighted sums of the channels, and the sum of the weights.
    sums = torch.zeros_like(torch.cat([image, image[:, :1]], 1))
    side = 2 * patch_distance + 1
    sums = _with_shifts(sums, side * side, wide, side, patch_size, h, sigma)
    channels = input.size(1)
    return narrowed(sums[:, :channels] / sums[:, channels:], input)


@repeated
def _with_shifts(
    sums: Tensor, k: Tensor, padded: Tensor, side: int, patch_size: int, h: float, sigma: float
) -> Tensor:
    height, width = sums.size(2), sums.size(3)
    reach, radius = side // 2, patch_size // 2
    row = torch.div(k, side, rounding_mode="floor")
    column = k - row * side
    rows = torch.arange(height + patch_size - 1, device=sums.device)
    columns = torch.arange(width + patch_size - 1, device=sums.device)
    shifted = padded.index_select(2, rows + row).index_select(3, columns + column)
    here = padded[:, :, reach : reach + height + patch_size - 1, reach : reach + width + patch_size - 1]
    difference = shifted - here
    taps = [1.0 / patch_size for _ in range(patch_size)]
    squared = materialised((difference * difference).mean(1, keepdim=True), 2)
    distance = weigh_shifts(materialised(weigh_shifts(squared, 2, taps), 2), 3, taps)
    weight = torch.exp(-(distance - 2.0 * sigma * sigma).clamp(min=0.0) / (h * h))
    values = shifted[:, :, radius : radius + height, radius : radius + width]
    return sums + torch.cat([values * weight, weight], 1)
