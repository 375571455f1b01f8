"""False colours."""

from typing import List

import torch
from torch import Tensor

from ..primitives.core.checks import check_not_empty
from ..primitives.images.color_planes import check_channels
from ..primitives.images.tables import table_colours
from ..primitives.numbers.rounding import to_index
from .colormap_tables import colormap_levels


def apply_colormap(input_tensor: Tensor, colormap: str) -> Tensor:
    """Apply a colour map to a one-channel image.

    The maps are OpenCV's, with 256 colours. Bytes are looked up, like ``cv2.applyColorMap`` does, and give
    bytes. Values in [0, 1] are interpolated linearly between neighbouring colours (0 is the first, 1 the
    last), so that they have a gradient. Unlike Kornia, this op does not guess the range from the data.

    Args:
        input_tensor: (*, 1, H, W); floating point in [0, 1] (saturated), or uint8.
        colormap: "autumn", "bone", "cividis", "cool", "deepgreen", "hot", "hsv", "inferno", "jet", "magma",
            "ocean", "pink", "plasma", "rainbow", "spring", "summer", "turbo", "twilight", "twilight_shifted",
            "viridis" or "winter".

    Returns:
        RGB image (*, 3, H, W) in the dtype of the input: in [0, 1], or bytes.

    Raises:
        TypeError: if input_tensor is neither floating point nor uint8.
        ValueError: if input_tensor is not (*, 1, H, W) or has no pixels, or there is no such map.

    Example:
        >>> apply_colormap(torch.tensor([0, 255], dtype=torch.uint8).reshape(1, 1, 2), "autumn").reshape(3, 2)
        tensor([[255, 255],
                [  0, 255],
                [  0,   0]], dtype=torch.uint8)
    """
    check_channels(input_tensor, 1, "input_tensor")
    check_not_empty(input_tensor, 2, "input_tensor")
    if input_tensor.dtype == torch.uint8:
        tables = torch.stack(_levels(colormap, torch.uint8, input_tensor.device))
        if input_tensor.dim() == 4:  # not reshaped, so that a frame stays one
            return table_colours(input_tensor, tables)
        size = list(input_tensor.shape)
        images = input_tensor.reshape([-1] + size[-3:])
        return table_colours(images, tables).reshape(size[:-3] + [3] + size[-2:])
    plane = input_tensor.select(-3, 0)
    if not plane.is_floating_point():
        raise TypeError(f"input_tensor: expected a floating-point or uint8 tensor, got dtype {plane.dtype}")
    position = plane.clamp(0.0, 1.0) * 255.0
    first = torch.floor(position.detach())
    index = to_index(first, 256).reshape(-1)
    planes = []
    for levels in _levels(colormap, plane.dtype, plane.device):
        table = levels / 255.0
        colour = table.index_select(0, index).reshape(plane.shape)
        beyond = table.index_select(0, (index + 1).clamp(max=255)).reshape(plane.shape)
        planes.append(colour + (position - first) * (beyond - colour))
    return torch.stack(planes, -3)


def _levels(colormap: str, dtype: torch.dtype, device: torch.device) -> List[Tensor]:
    """The red, green and blue (256,) of a map's colours, 0 to 255."""
    packed = colormap_levels(colormap)
    return [
        torch.tensor([(colour >> shift) & 255 for colour in packed], dtype=dtype, device=device)
        for shift in [16, 8, 0]
    ]
