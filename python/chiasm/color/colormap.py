"""False colours."""

from typing import List

import torch
from torch import Tensor

from ..primitives.core.checks import check_not_empty
from ..primitives.images.color_planes import check_channels
from ..primitives.images.histograms import lut
from ..primitives.numbers.rounding import to_index
from .colormap_tables import colormap_levels


def apply_colormap(input_tensor: Tensor, colormap: str) -> Tensor:
    """Apply a colour map to a one-channel image.

    The maps are OpenCV's, with 256 colours. uint8 values are looked up, like ``cv2.applyColorMap`` does.
    Values in [0, 1] are interpolated linearly between neighbouring colours (0 is the first, 1 the last), so
    that they have a gradient. Unlike Kornia, this op does not guess the range from the data.

    Args:
        input_tensor: (*, 1, H, W); floating point in [0, 1] (saturated), or uint8.
        colormap: "autumn", "bone", "cividis", "cool", "deepgreen", "hot", "hsv", "inferno", "jet", "magma",
            "ocean", "pink", "plasma", "rainbow", "spring", "summer", "turbo", "twilight", "twilight_shifted",
            "viridis" or "winter".

    Returns:
        RGB image (*, 3, H, W) in [0, 1], in the dtype of the input; float32 for uint8.

    Raises:
        TypeError: if input_tensor is neither floating point nor uint8.
        ValueError: if input_tensor is not (*, 1, H, W) or has no pixels, or there is no such map.

    Example:
        >>> apply_colormap(torch.tensor([0, 255], dtype=torch.uint8).reshape(1, 1, 2), "autumn").reshape(3, 2)
        tensor([[1., 1.],
                [0., 1.],
                [0., 0.]])
    """
    check_channels(input_tensor, 1, "input_tensor")
    check_not_empty(input_tensor, 2, "input_tensor")
    plane = input_tensor.select(-3, 0)
    if plane.dtype == torch.uint8:
        images = plane.reshape(-1, 1, plane.size(-2) * plane.size(-1))
        tables = torch.stack(_levels(colormap, torch.float32, plane.device))
        colours = lut(tables.repeat(images.size(0), 1), images.expand(-1, 3, -1).reshape(-1, images.size(2)))
        return colours.reshape(list(plane.shape[:-2]) + [3, plane.size(-2), plane.size(-1)])
    if not plane.is_floating_point():
        raise TypeError(f"input_tensor: expected a floating-point or uint8 tensor, got dtype {plane.dtype}")
    position = plane.clamp(0.0, 1.0) * 255.0
    first = torch.floor(position.detach())
    index = to_index(first, 256).reshape(-1)
    planes = []
    for level in _levels(colormap, plane.dtype, plane.device):
        colour = level.index_select(0, index).reshape(plane.shape)
        beyond = level.index_select(0, (index + 1).clamp(max=255)).reshape(plane.shape)
        planes.append(colour + (position - first) * (beyond - colour))
    return torch.stack(planes, -3)


def _levels(colormap: str, dtype: torch.dtype, device: torch.device) -> List[Tensor]:
    """The red, green and blue (256,) of a map's colours, in [0, 1]."""
    packed = colormap_levels(colormap)
    return [
        torch.tensor([float((colour >> shift) & 255) for colour in packed], dtype=dtype, device=device)
        / 255.0
        for shift in [16, 8, 0]
    ]
