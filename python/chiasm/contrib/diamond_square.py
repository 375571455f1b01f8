"""Random textures."""

from typing import Optional, Tuple, Union

import torch
from torch import Tensor

from ..enhance.normalize import normalize_min_max
from ..primitives.core.checks import check_image, check_interval, check_number
from ..primitives.images.diamond_square import midpoint_displacement


def diamond_square(
    random: Tensor,
    roughness: Union[float, Tensor] = 0.5,
    random_scale: Union[float, Tensor] = 1.0,
    normalize_range: Optional[Tuple[float, float]] = None,
) -> Tensor:
    """Plasma noise by midpoint displacement: random heights on a coarse grid are refined step by step.

    A. Fournier, D. Fussell, L. Carpenter, Computer rendering of stochastic models, Communications of the ACM
    25(6), 1982, in the form of G. Miller, The definition and rendering of terrain maps, SIGGRAPH 1986. The
    cell size of the first grid is the least power of two for which one cell covers the image; there the
    result is ``random_scale * random``. Each following step computes the centre of each cell as the mean of
    the cell's corners, and the centre of each side as the mean of the four points around it (only points
    within the image count), each plus ``random_scale * roughness**k * random``, where k = 0, 1, ... is the
    step.

    Kornia draws the random numbers by a function. Here they are an input, so that every backend computes the
    same texture; the texture has their shape, dtype and device. The textures are similar to Kornia's, but not
    equal.

    Args:
        random: (B, C, H, W), floating point, a random number for each pixel, which should have a mean of 0
            (for example uniform in [-1, 1], or normal). H and W are at most 32768.
        roughness: factor of the displacement from step to step: a number, or a tensor of one for all or of
            one for each sample.
        random_scale: the first displacement, a number or a tensor like roughness.
        normalize_range: scale each channel of each sample to this range, (least, greatest).

    Returns:
        (B, C, H, W).

    Raises:
        TypeError: if random is not floating point.
        ValueError: if random is not 4-D, or roughness or random_scale is a tensor of another number of
            entries.

    Example:
        >>> flat = torch.zeros(1, 1, 3, 3)
        >>> flat[0, 0, 0, 0] = 4.0
        >>> diamond_square(flat)[0, 0]
        tensor([[4.0000, 1.6667, 0.0000],
                [1.6667, 1.0000, 0.3333],
                [0.0000, 0.3333, 0.0000]])
    """
    check_image(random, "random")
    factor, scale = (
        _per_sample(roughness, random, "roughness"),
        _per_sample(random_scale, random, "random_scale"),
    )
    state = midpoint_displacement(random, factor, scale)
    if normalize_range is None:
        return state
    check_interval(normalize_range, "normalize_range")
    return normalize_min_max(state, normalize_range[0], normalize_range[1])


def _per_sample(value: Union[float, Tensor], random: Tensor, name: str) -> Tensor:
    if not isinstance(value, Tensor):
        check_number(value, name)
        return torch.full([1, 1, 1, 1], value, dtype=random.dtype, device=random.device)
    if value.dim() > 1 or (value.dim() == 1 and value.size(0) != 1 and value.size(0) != random.size(0)):
        raise ValueError(
            f"{name}: expected a number, or a scalar tensor, (1,) or (B,), got {list(value.shape)}"
        )
    return value.to(random.dtype).reshape(-1, 1, 1, 1)
