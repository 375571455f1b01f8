"""Blends of an image with a degenerate one, as Pillow's ``Image.blend`` makes them."""

from torch import Tensor

from ..core.lowering import primitive
from ..filters.stencil import join_channels, split_channels


def blended(degenerate: Tensor, image: Tensor, factor: Tensor) -> Tensor:
    """Values between two images in [0, 1]: a factor of 0 gives the degenerate image, 1 the image, one above 1
    extrapolates."""
    return (degenerate + (image - degenerate) * factor).clamp(0.0, 1.0)


@primitive
def blended_with_plane(plane: Tensor, image: Tensor, factor: Tensor) -> Tensor:
    """``blended``, where the degenerate image (*, 1, H, W) is a plane that all channels share."""
    return blended(plane, image, factor)


# Otherwise every channel would compute the plane again, and what the image is computed of.
@blended_with_plane.lowering("native", when=lambda _, __, factor: factor.dim() < 3 or factor.size(-3) == 1)
def _channel_by_channel(plane: Tensor, image: Tensor, factor: Tensor) -> Tensor:
    return join_channels([blended(plane, channel, factor) for channel in split_channels(image)])
