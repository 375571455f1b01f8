"""The policies that AutoAugment found.

E. Cubuk et al., AutoAugment: learning augmentation policies from data, CVPR 2019, tables 7 to 9 of the
appendix.
"""

from typing import List


def policy_table(policy: str) -> List[float]:
    """25 lines of six numbers: an operation (its index in ``operations.names``), its probability and its
    strength, 0 to 9; then the same for a second operation. The strength is 0 for operations without one."""
    if policy == "cifar10":
        return _cifar10()
    if policy == "svhn":
        return _svhn()
    return _imagenet()


# fmt: off
def _imagenet() -> List[float]:
    return [
        10.0, 0.4, 8.0, 5.0, 0.6, 9.0,  # Posterize, Rotate
        11.0, 0.6, 5.0, 12.0, 0.6, 0.0,  # Solarize, AutoContrast
        13.0, 0.8, 0.0, 13.0, 0.6, 0.0,  # Equalize, Equalize
        10.0, 0.6, 7.0, 10.0, 0.6, 6.0,  # Posterize, Posterize
        13.0, 0.4, 0.0, 11.0, 0.2, 4.0,  # Equalize, Solarize
        13.0, 0.4, 0.0, 5.0, 0.8, 8.0,  # Equalize, Rotate
        11.0, 0.6, 3.0, 13.0, 0.6, 0.0,  # Solarize, Equalize
        10.0, 0.8, 5.0, 13.0, 1.0, 0.0,  # Posterize, Equalize
        5.0, 0.2, 3.0, 11.0, 0.6, 8.0,  # Rotate, Solarize
        13.0, 0.6, 0.0, 10.0, 0.4, 6.0,  # Equalize, Posterize
        5.0, 0.8, 8.0, 7.0, 0.4, 0.0,  # Rotate, Color
        5.0, 0.4, 9.0, 13.0, 0.6, 0.0,  # Rotate, Equalize
        13.0, 0.0, 0.0, 13.0, 0.8, 0.0,  # Equalize, Equalize
        14.0, 0.6, 0.0, 13.0, 1.0, 0.0,  # Invert, Equalize
        7.0, 0.6, 4.0, 8.0, 1.0, 8.0,  # Color, Contrast
        5.0, 0.8, 8.0, 7.0, 1.0, 2.0,  # Rotate, Color
        7.0, 0.8, 8.0, 11.0, 0.8, 7.0,  # Color, Solarize
        9.0, 0.4, 7.0, 14.0, 0.6, 0.0,  # Sharpness, Invert
        1.0, 0.6, 5.0, 13.0, 1.0, 0.0,  # ShearX, Equalize
        7.0, 0.4, 0.0, 13.0, 0.6, 0.0,  # Color, Equalize
        13.0, 0.4, 0.0, 11.0, 0.2, 4.0,  # Equalize, Solarize
        11.0, 0.6, 5.0, 12.0, 0.6, 0.0,  # Solarize, AutoContrast
        14.0, 0.6, 0.0, 13.0, 1.0, 0.0,  # Invert, Equalize
        7.0, 0.6, 4.0, 8.0, 1.0, 8.0,  # Color, Contrast
        13.0, 0.8, 0.0, 13.0, 0.6, 0.0,  # Equalize, Equalize
    ]
# fmt: on


# fmt: off
def _cifar10() -> List[float]:
    return [
        14.0, 0.1, 0.0, 8.0, 0.2, 6.0,  # Invert, Contrast
        5.0, 0.7, 2.0, 3.0, 0.3, 9.0,  # Rotate, TranslateX
        9.0, 0.8, 1.0, 9.0, 0.9, 3.0,  # Sharpness, Sharpness
        2.0, 0.5, 8.0, 4.0, 0.7, 9.0,  # ShearY, TranslateY
        12.0, 0.5, 0.0, 13.0, 0.9, 0.0,  # AutoContrast, Equalize
        2.0, 0.2, 7.0, 10.0, 0.3, 7.0,  # ShearY, Posterize
        7.0, 0.4, 3.0, 6.0, 0.6, 7.0,  # Color, Brightness
        9.0, 0.3, 9.0, 6.0, 0.7, 9.0,  # Sharpness, Brightness
        13.0, 0.6, 0.0, 13.0, 0.5, 0.0,  # Equalize, Equalize
        8.0, 0.6, 7.0, 9.0, 0.6, 5.0,  # Contrast, Sharpness
        7.0, 0.7, 7.0, 3.0, 0.5, 8.0,  # Color, TranslateX
        13.0, 0.3, 0.0, 12.0, 0.4, 0.0,  # Equalize, AutoContrast
        4.0, 0.4, 3.0, 9.0, 0.2, 6.0,  # TranslateY, Sharpness
        6.0, 0.9, 6.0, 7.0, 0.2, 8.0,  # Brightness, Color
        11.0, 0.5, 2.0, 14.0, 0.0, 0.0,  # Solarize, Invert
        13.0, 0.2, 0.0, 12.0, 0.6, 0.0,  # Equalize, AutoContrast
        13.0, 0.2, 0.0, 13.0, 0.6, 0.0,  # Equalize, Equalize
        7.0, 0.9, 9.0, 13.0, 0.6, 0.0,  # Color, Equalize
        12.0, 0.8, 0.0, 11.0, 0.2, 8.0,  # AutoContrast, Solarize
        6.0, 0.1, 3.0, 7.0, 0.7, 0.0,  # Brightness, Color
        11.0, 0.4, 5.0, 12.0, 0.9, 0.0,  # Solarize, AutoContrast
        4.0, 0.9, 9.0, 4.0, 0.7, 9.0,  # TranslateY, TranslateY
        12.0, 0.9, 0.0, 11.0, 0.8, 3.0,  # AutoContrast, Solarize
        13.0, 0.8, 0.0, 14.0, 0.1, 0.0,  # Equalize, Invert
        4.0, 0.7, 9.0, 12.0, 0.9, 0.0,  # TranslateY, AutoContrast
    ]
# fmt: on


# fmt: off
def _svhn() -> List[float]:
    return [
        1.0, 0.9, 4.0, 14.0, 0.2, 0.0,  # ShearX, Invert
        2.0, 0.9, 8.0, 14.0, 0.7, 0.0,  # ShearY, Invert
        13.0, 0.6, 0.0, 11.0, 0.6, 6.0,  # Equalize, Solarize
        14.0, 0.9, 0.0, 13.0, 0.6, 0.0,  # Invert, Equalize
        13.0, 0.6, 0.0, 5.0, 0.9, 3.0,  # Equalize, Rotate
        1.0, 0.9, 4.0, 12.0, 0.8, 0.0,  # ShearX, AutoContrast
        2.0, 0.9, 8.0, 14.0, 0.4, 0.0,  # ShearY, Invert
        2.0, 0.9, 5.0, 11.0, 0.2, 6.0,  # ShearY, Solarize
        14.0, 0.9, 0.0, 12.0, 0.8, 0.0,  # Invert, AutoContrast
        13.0, 0.6, 0.0, 5.0, 0.9, 3.0,  # Equalize, Rotate
        1.0, 0.9, 4.0, 11.0, 0.3, 3.0,  # ShearX, Solarize
        2.0, 0.8, 8.0, 14.0, 0.7, 0.0,  # ShearY, Invert
        13.0, 0.9, 0.0, 4.0, 0.6, 6.0,  # Equalize, TranslateY
        14.0, 0.9, 0.0, 13.0, 0.6, 0.0,  # Invert, Equalize
        8.0, 0.3, 3.0, 5.0, 0.8, 4.0,  # Contrast, Rotate
        14.0, 0.8, 0.0, 4.0, 0.0, 2.0,  # Invert, TranslateY
        2.0, 0.7, 6.0, 11.0, 0.4, 8.0,  # ShearY, Solarize
        14.0, 0.6, 0.0, 5.0, 0.8, 4.0,  # Invert, Rotate
        2.0, 0.3, 7.0, 3.0, 0.9, 3.0,  # ShearY, TranslateX
        1.0, 0.1, 6.0, 14.0, 0.6, 0.0,  # ShearX, Invert
        11.0, 0.7, 2.0, 4.0, 0.6, 7.0,  # Solarize, TranslateY
        2.0, 0.8, 4.0, 14.0, 0.8, 0.0,  # ShearY, Invert
        1.0, 0.7, 9.0, 4.0, 0.8, 3.0,  # ShearX, TranslateY
        2.0, 0.8, 5.0, 12.0, 0.7, 0.0,  # ShearY, AutoContrast
        1.0, 0.7, 2.0, 14.0, 0.1, 0.0,  # ShearX, Invert
    ]
# fmt: on
