"""The colours of black bodies and of daylight."""

import torch
from torch import Tensor

from ..primitives.core.checks import check_choice


def planckian_gains(mode: str, device: torch.device) -> Tensor:
    """The colours of light (N, 3), in linear sRGB with green 1: of a black body at 3000, 3500, ... 15000 K,
    or of daylight ("CIED") at 4000, 4500, ... 15000 K."""
    check_choice(mode, ["blackbody", "CIED"], "mode")
    if mode == "CIED":
        xyz = _daylight(torch.arange(4000, 15001, 500, device=device).to(torch.float64))
    else:
        xyz = _black_body(torch.arange(3000, 15001, 500, device=device).to(torch.float64))
    x, y, z = xyz[:, 0], xyz[:, 1], xyz[:, 2]
    # IEC 61966-2-1
    red = 3.2404542 * x - 1.5371385 * y - 0.4985314 * z
    green = -0.9692660 * x + 1.8760108 * y + 0.0415560 * z
    blue = 0.0556434 * x - 0.2040259 * y + 1.0572252 * z
    return torch.stack([red / green, torch.ones_like(green), blue / green], 1)


def _black_body(kelvin: Tensor) -> Tensor:
    """(N, 3) XYZ, up to a factor, of temperatures (N,)."""
    wavelength = torch.arange(380, 781, 5, device=kelvin.device).to(torch.float64)  # nm
    # Planck's law; hc / k is 1.438776877e-2 m K
    power = wavelength.pow(-5) / torch.expm1(1.438776877e7 / (wavelength * kelvin[:, None]))
    x = (
        1.056 * _lobe(wavelength, 599.8, 37.9, 31.0)
        + 0.362 * _lobe(wavelength, 442.0, 16.0, 26.7)
        - 0.065 * _lobe(wavelength, 501.1, 20.4, 26.2)
    )
    y = 0.821 * _lobe(wavelength, 568.8, 46.9, 40.5) + 0.286 * _lobe(wavelength, 530.9, 16.3, 31.1)
    z = 1.217 * _lobe(wavelength, 437.0, 11.8, 36.0) + 0.681 * _lobe(wavelength, 459.0, 26.0, 13.8)
    return torch.stack([(power * x).sum(1), (power * y).sum(1), (power * z).sum(1)], 1)


def _lobe(wavelength: Tensor, middle: float, below: float, above: float) -> Tensor:
    """A Gaussian with a different width on each side."""
    distance = wavelength - middle
    scaled = torch.where(distance < 0.0, distance / below, distance / above)
    return torch.exp(-0.5 * scaled * scaled)


def _daylight(kelvin: Tensor) -> Tensor:
    """(N, 3) XYZ with Y = 1: CIE 15:2004, equations 3.3 and 3.4."""
    t = 1000.0 / kelvin
    near = ((-4.6070 * t + 2.9678) * t + 0.09911) * t + 0.244063
    far = ((-2.0064 * t + 1.9018) * t + 0.24748) * t + 0.237040
    x = torch.where(kelvin <= 7000.0, near, far)
    y = (-3.0 * x + 2.870) * x - 0.275
    return torch.stack([x / y, torch.ones_like(y), (1.0 - x - y) / y], 1)
