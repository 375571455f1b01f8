"""Sepia toning."""

from torch import Tensor

from ..primitives.images.color_planes import mix_channels
from ..primitives.numbers.reductions import greatest


def sepia(input: Tensor, rescale: bool = True, eps: float = 1e-6) -> Tensor:
    """The tone of an old print, by the matrix (0.393, 0.769, 0.189; 0.349, 0.686, 0.168; 0.272, 0.534,
    0.131).

    S. Toub, Sepia Tone, StringLogicalComparer, and More, MSDN Magazine, January 2005. The rows sum to about
    1.35, 1.2 and 0.94.

    Args:
        input: RGB image (*, 3, H, W), floating point.
        rescale: divide each channel by its largest value, so that the result does not exceed 1.
        eps: added to that largest value.

    Returns:
        (*, 3, H, W).

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not (*, 3, H, W).

    Example:
        >>> sepia(torch.ones(1, 3, 1, 1), rescale=False).flatten()
        tensor([1.3510, 1.2030, 0.9370])
    """
    toned = mix_channels(input, [0.393, 0.769, 0.189, 0.349, 0.686, 0.168, 0.272, 0.534, 0.131], 0.0, "input")
    if rescale:
        return toned / (greatest(toned, [-2, -1]) + eps)
    return toned
