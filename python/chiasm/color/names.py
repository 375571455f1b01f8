"""Kornia's enumerations; their members are equal to the strings that the functions take."""

from enum import Enum


class CFA(str, Enum):
    """Patterns of the colour filter array, see ``raw_to_rgb``.

    >>> CFA.RG == "rg"
    True
    """

    BG = "bg"
    GB = "gb"
    RG = "rg"
    GR = "gr"


class ColorMapType(str, Enum):
    """Maps of ``apply_colormap``.

    >>> ColorMapType.viridis == "viridis", ColorMapType("jet").name
    (True, 'jet')
    """

    autumn = "autumn"
    bone = "bone"
    jet = "jet"
    winter = "winter"
    rainbow = "rainbow"
    ocean = "ocean"
    summer = "summer"
    spring = "spring"
    cool = "cool"
    hsv = "hsv"
    pink = "pink"
    hot = "hot"
    plasma = "plasma"
    viridis = "viridis"
    cividis = "cividis"
    twilight = "twilight"
    turbo = "turbo"
    deepgreen = "deepgreen"
    inferno = "inferno"
    magma = "magma"
    twilight_shifted = "twilight_shifted"
