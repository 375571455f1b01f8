"""False colours."""

import torch
from torch import Tensor

from ..primitives.images.color_planes import check_channels
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
        ValueError: if input_tensor is not (*, 1, H, W) or there is no such map.

    Example:
        >>> apply_colormap(torch.tensor([0, 255], dtype=torch.uint8).reshape(1, 1, 2), "autumn").reshape(3, 2)
        tensor([[1., 1.],
                [0., 1.],
                [0., 0.]])
    """
    check_channels(input_tensor, 1, "input_tensor")
    packed = colormap_levels(colormap)
    plane = input_tensor.select(-3, 0)
    if plane.is_floating_point():
        position = plane.clamp(0.0, 1.0) * 255.0
        first = torch.floor(position.detach())
        fraction = position - first
        index = to_index(first, 256).reshape(-1)
    elif plane.dtype == torch.uint8:
        fraction = torch.zeros([1], dtype=torch.float32, device=plane.device)
        index = plane.to(torch.int64).reshape(-1)
    else:
        raise TypeError(f"input_tensor: expected a floating-point or uint8 tensor, got dtype {plane.dtype}")
    planes = []
    for shift in [16, 8, 0]:
        level = (
            torch.tensor(
                [float((colour >> shift) & 255) for colour in packed],
                dtype=fraction.dtype,
                device=plane.device,
            )
            / 255.0
        )
        colour = level.index_select(0, index).reshape(plane.shape)
        if plane.is_floating_point():
            beyond = level.index_select(0, (index + 1).clamp(max=255)).reshape(plane.shape)
            colour = colour + fraction * (beyond - colour)
        planes.append(colour)
    return torch.stack(planes, -3)
