"""Random light: illumination gradients, plasma noise, and the colour of a black body."""

from typing import List, Optional, Tuple

import torch
from torch import Tensor

from ..contrib.diamond_square import diamond_square
from ..primitives.core.broadcasting import each
from ..primitives.core.checks import check_image, check_rgb
from ..primitives.random.draws import check_seed, integers, uniform_like
from .decisions import applied, between, check_bounds, check_chance, drawn
from .planckian import planckian_gains


def random_linear_illumination(
    input: Tensor,
    seed: Tensor,
    gain: Tuple[float, float] = (0.01, 0.2),
    sign: Tuple[float, float] = (-1.0, 1.0),
    p: float = 0.5,
) -> Tensor:
    """Add or subtract light that rises linearly from 0 at one side to a gain at the opposite side.

    Args:
        input: (B, C, H, W), floating point in [0, 1].
        seed: (B,), int64, one for each sample. The four directions are equally likely.
        gain: (least, greatest) light at the bright side, within [0, 1], uniform.
        sign: (least, greatest) of a uniform number within [-1, 1]; only its sign is used, as the sign of the
            light.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype; a changed sample is limited to [0, 1].

    Raises:
        TypeError: if input is not floating point, or seed not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> x = random_linear_illumination(
        ...     torch.zeros(1, 1, 3, 3), torch.tensor([7]), (0.2, 0.2), (1, 1), 1.0
        ... )
        >>> x.max()
        tensor(0.2000)
    """
    check_image(input, "input")
    check_seed(seed, input.size(0))
    side = integers(seed, 4, 1, 1)[:, 0]
    down, across = _ramps(input, side >= 2, side % 2 == 1)
    return _lit(input, seed, torch.where(each(side % 2 == 0, down), down, across), gain, sign, p)


def random_linear_corner_illumination(
    input: Tensor,
    seed: Tensor,
    gain: Tuple[float, float] = (0.01, 0.2),
    sign: Tuple[float, float] = (-1.0, 1.0),
    p: float = 0.5,
) -> Tensor:
    """Add or subtract light that rises linearly from 0 at one corner to a gain at the opposite corner.

    Args:
        input: (B, C, H, W), floating point in [0, 1].
        seed: (B,), int64, one for each sample. The four corners are equally likely.
        gain: (least, greatest) light in the bright corner, within [0, 1], uniform.
        sign: (least, greatest) of a uniform number within [-1, 1]; only its sign is used, as the sign of the
            light.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype; a changed sample is limited to [0, 1].

    Raises:
        TypeError: if input is not floating point, or seed not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> x = torch.zeros(1, 1, 3, 3)
        >>> random_linear_corner_illumination(x, torch.tensor([7]), (0.2, 0.2), (1, 1), 1.0)[0, 0, 1, 1]
        tensor(0.1000)
    """
    check_image(input, "input")
    check_seed(seed, input.size(0))
    corner = integers(seed, 4, 1, 1)[:, 0]
    down, across = _ramps(input, corner >= 2, corner % 2 == 1)
    return _lit(input, seed, (down + across) * 0.5, gain, sign, p)


def random_gaussian_illumination(
    input: Tensor,
    seed: Tensor,
    gain: Tuple[float, float] = (0.01, 0.15),
    center: Tuple[float, float] = (0.1, 0.9),
    sigma: Tuple[float, float] = (0.2, 1.0),
    sign: Tuple[float, float] = (-1.0, 1.0),
    p: float = 0.5,
) -> Tensor:
    """Add or subtract a Gaussian spot of light.

    Args:
        input: (B, C, H, W), floating point in [0, 1].
        seed: (B,), int64, one for each sample.
        gain: (least, greatest) light at the centre of the spot, within [0, 1], uniform.
        center: (least, greatest) position of the centre as a fraction of each side, within [0, 1], uniform.
        sigma: (least, greatest) standard deviation as a fraction of each side, uniform.
        sign: (least, greatest) of a uniform number within [-1, 1]; only its sign is used, as the sign of the
            light.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype; a changed sample is limited to [0, 1].

    Raises:
        TypeError: if input is not floating point, or seed not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> x, seed = torch.zeros(1, 1, 3, 3), torch.tensor([7])
        >>> random_gaussian_illumination(x, seed, (0.2, 0.2), (0.5, 0.5), sign=(1.0, 1.0), p=1.0)[0, 0, 1, 1]
        tensor(0.2000)
    """
    check_image(input, "input")
    check_bounds(center, 0.0, 1.0, "center")
    check_bounds(sigma, 1e-3, 1e3, "sigma")
    u = drawn(seed, 7, input)
    down, across = _ramps(input, u[:, 0] < 0.0, u[:, 0] < 0.0)
    y = (down - each(between(u[:, 3], center, input), down)) / each(between(u[:, 5], sigma, input), down)
    x = (across - each(between(u[:, 4], center, input), down)) / each(between(u[:, 6], sigma, input), down)
    return _lit(input, seed, torch.exp(-0.5 * y * y) * torch.exp(-0.5 * x * x), gain, sign, p)


def _ramps(input: Tensor, upwards: Tensor, leftwards: Tensor) -> Tuple[Tensor, Tensor]:
    """Ramps from 0 to 1 over the rows (B, 1, H, 1) and over the columns (B, 1, 1, W), each in either
    direction."""
    height, width = input.size(2), input.size(3)
    y = (torch.arange(height, device=input.device).to(input.dtype) / max(height - 1, 1))[None, None, :, None]
    x = (torch.arange(width, device=input.device).to(input.dtype) / max(width - 1, 1))[None, None, None, :]
    return torch.where(each(upwards, input), 1.0 - y, y), torch.where(each(leftwards, input), 1.0 - x, x)


def _lit(
    input: Tensor, seed: Tensor, light: Tensor, gain: Tuple[float, float], sign: Tuple[float, float], p: float
) -> Tensor:
    check_bounds(gain, 0.0, 1.0, "gain")
    check_bounds(sign, -1.0, 1.0, "sign")
    check_chance(p)
    u = drawn(seed, 3, input)
    strength = between(u[:, 1], gain, input)
    strength = torch.where(between(u[:, 2], sign, input) < 0.0, -strength, strength)
    return applied((input + light * each(strength, input)).clamp(0.0, 1.0), input, u[:, 0], p)


def random_plasma_brightness(
    input: Tensor,
    seed: Tensor,
    roughness: Tuple[float, float] = (0.1, 0.7),
    intensity: Tuple[float, float] = (0.0, 1.0),
    p: float = 0.5,
) -> Tensor:
    """Add plasma noise, from ``-intensity`` to ``intensity``; it is the same for all channels.

    A. Nicolaou et al., TorMentor: deterministic dynamic-path, data augmentations with fractals, CVPR
    workshops 2022.

    Args:
        input: (B, C, H, W), floating point in [0, 1].
        seed: (B,), int64, one for each sample.
        roughness: (least, greatest), within [0, 1], of ``diamond_square``, uniform.
        intensity: (least, greatest), within [0, 1], uniform.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype; a changed sample is limited to [0, 1].

    Raises:
        TypeError: if input is not floating point, or seed not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> random_plasma_brightness(torch.zeros(1, 3, 8, 9), torch.tensor([7]), p=1.0).shape
        torch.Size([1, 3, 8, 9])
    """
    plasma, u = _plasma(input, seed, roughness)
    check_bounds(intensity, 0.0, 1.0, "intensity")
    check_chance(p)
    strength = each(between(u[:, 2], intensity, input), input)
    return applied((input + (2.0 * plasma - 1.0) * strength).clamp(0.0, 1.0), input, u[:, 0], p)


def random_plasma_contrast(
    input: Tensor, seed: Tensor, roughness: Tuple[float, float] = (0.1, 0.7), p: float = 0.5
) -> Tensor:
    """Multiply the difference from 0.5 by plasma noise from 0 to 4; it is the same for all channels.

    Args:
        input: (B, C, H, W), floating point in [0, 1].
        seed: (B,), int64, one for each sample.
        roughness: (least, greatest), within [0, 1], of ``diamond_square``, uniform.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype; a changed sample is limited to [0, 1].

    Raises:
        TypeError: if input is not floating point, or seed not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> random_plasma_contrast(torch.full((1, 1, 8, 9), 0.5), torch.tensor([7]), p=1.0).max()
        tensor(0.5000)
    """
    plasma, u = _plasma(input, seed, roughness)
    check_chance(p)
    return applied(((input - 0.5) * (4.0 * plasma) + 0.5).clamp(0.0, 1.0), input, u[:, 0], p)


def random_plasma_shadow(
    input: Tensor,
    seed: Tensor,
    roughness: Tuple[float, float] = (0.1, 0.7),
    shade_intensity: Tuple[float, float] = (-1.0, 0.0),
    shade_quantity: Tuple[float, float] = (0.0, 1.0),
    p: float = 0.5,
) -> Tensor:
    """Darken the pixels where plasma noise is below a level; all channels change by the same amount.

    Args:
        input: (B, C, H, W), floating point in [0, 1].
        seed: (B,), int64, one for each sample.
        roughness: (least, greatest), within [0, 1], of ``diamond_square``, uniform.
        shade_intensity: (least, greatest) number that the shadow adds, within [-1, 0], uniform.
        shade_quantity: (least, greatest) of the level, within [0, 1], uniform.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype; a changed sample is limited to [0, 1].

    Raises:
        TypeError: if input is not floating point, or seed not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> random_plasma_shadow(torch.ones(1, 3, 8, 9), torch.tensor([7]), p=1.0).shape
        torch.Size([1, 3, 8, 9])
    """
    plasma, u = _plasma(input, seed, roughness)
    check_bounds(shade_intensity, -1.0, 0.0, "shade_intensity")
    check_bounds(shade_quantity, 0.0, 1.0, "shade_quantity")
    check_chance(p)
    added = each(between(u[:, 2], shade_intensity, input), input)
    shadow = plasma < each(between(u[:, 3], shade_quantity, input), input)
    shaded = torch.where(shadow, input + added, input).clamp(0.0, 1.0)
    return applied(shaded, input, u[:, 0], p)


def _plasma(input: Tensor, seed: Tensor, roughness: Tuple[float, float]) -> Tuple[Tensor, Tensor]:
    """Plasma noise (B, 1, H, W) in [0, 1], and four more random numbers for each sample."""
    check_image(input, "input")
    check_bounds(roughness, 0.0, 1.0, "roughness")
    u = drawn(seed, 4, input)
    random = uniform_like(input[:, :1], seed, 1).to(input.dtype) * 2.0 - 1.0
    return diamond_square(random, between(u[:, 1], roughness, input), 1.0, (0.0, 1.0)), u


def random_planckian_jitter(
    input: Tensor,
    seed: Tensor,
    mode: str = "blackbody",
    select_from: Optional[List[int]] = None,
    p: float = 0.5,
) -> Tensor:
    """Change the colour of the light: multiply red and blue by those of a radiator whose green is 1.

    S. Zini et al., Planckian jitter: countering the color-crippling effects of color jitter on
    self-supervised training, ICLR 2023. "blackbody" is Planck's law seen with the colour matching functions
    of C. Wyman, P. Sloan, P. Shirley, Simple analytic approximations to the CIE XYZ color matching functions,
    JCGT 2(2), 2013; "CIED" is daylight by CIE 15. Both are in linear sRGB.

    Args:
        input: RGB (B, 3, H, W), floating point in [0, 1].
        seed: (B,), int64, one for each sample.
        mode: "blackbody", 3000 to 15000 K, or "CIED", 4000 to 15000 K; each in steps of 500 K, all equally
            likely.
        select_from: indices of the steps to choose from; the first step is 0; None means all.
        p: probability that a sample is changed.

    Returns:
        (B, 3, H, W), of the input's dtype; a changed sample is limited to [0, 1].

    Raises:
        TypeError: if input is not floating point, or seed not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> random_planckian_jitter(torch.full((1, 3, 1, 1), 0.5), torch.tensor([7]), p=1.0)[0, 1]
        tensor([[0.5000]])
    """
    check_rgb(input, "input")
    check_image(input, "input")
    check_chance(p)
    u = drawn(seed, 1, input)
    table = planckian_gains(mode, input.device)
    if select_from is not None:
        if len(select_from) == 0 or min(select_from) < 0 or max(select_from) >= table.size(0):
            raise ValueError(f"select_from: expected numbers in 0 to {table.size(0) - 1}, got {select_from}")
        table = table.index_select(0, torch.tensor(select_from, device=input.device))
    gains = table.index_select(0, integers(seed, table.size(0), 1, 1)[:, 0]).to(input.dtype)
    return applied((input * gains[:, :, None, None]).clamp(0.0, 1.0), input, u[:, 0], p)
