"""Brightness, contrast, saturation, gamma and the logarithmic and sigmoid curves."""

from typing import Union

import torch
from torch import Tensor

from ..color.gray import rgb_to_grayscale
from ..primitives.core.broadcasting import per_sample
from ..primitives.core.checks import check_floating, check_number, check_rgb, check_values
from ..primitives.images.blending import blended, blended_with_plane
from ..primitives.images.tables import levels, looked_up
from ..primitives.numbers.power import power_each
from ..primitives.numbers.rounding import known_or


def adjust_brightness(image: Tensor, factor: Union[float, Tensor], clip_output: bool = True) -> Tensor:
    """Add ``factor`` to every value.

    R. Szeliski, Computer Vision: Algorithms and Applications, 2nd ed., 3.1.1.

    Args:
        image: (B, *), floating point in [0, 1], or uint8.
        factor: the number to add, usually in [-1, 1]; for uint8 in levels, [-255, 255]; 0 changes nothing. A
            number, a scalar tensor or (B,), one for each sample.
        clip_output: limit the result to [0, 1]; uint8 always saturates.

    Returns:
        Tensor of the image's shape and dtype.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if factor's shape is not as above.

    Example:
        >>> adjust_brightness(torch.tensor([[0.25, 0.75]]), 0.5)
        tensor([[0.7500, 1.0000]])
    """
    check_values(image, "image")
    if image.dtype == torch.uint8:
        x = levels(image, 255.0)
        return looked_up(image, x + per_sample(factor, x, "factor"), 255.0)
    return _clipped(image + per_sample(factor, image, "factor"), clip_output)


def adjust_brightness_accumulative(
    image: Tensor, factor: Union[float, Tensor], clip_output: bool = True
) -> Tensor:
    """Multiply every value by ``factor``, like Pillow's ``ImageEnhance.Brightness`` does.

    Args:
        image: (B, *), floating point in [0, 1], or uint8.
        factor: not negative; 0 gives black, 1 changes nothing. A number, a scalar tensor or (B,), one for
            each sample, whose values are not checked.
        clip_output: limit the result to [0, 1]; uint8 always saturates.

    Returns:
        Tensor of the image's shape and dtype.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if factor's shape is not as above.

    Example:
        >>> adjust_brightness_accumulative(torch.tensor([[0.25, 0.75]]), 2.0)
        tensor([[0.5000, 1.0000]])
    """
    check_values(image, "image")
    if image.dtype == torch.uint8:
        x = levels(image, 255.0)
        return looked_up(image, x * per_sample(factor, x, "factor"), 255.0)
    return _clipped(image * per_sample(factor, image, "factor"), clip_output)


def adjust_contrast(image: Tensor, factor: Union[float, Tensor], clip_output: bool = True) -> Tensor:
    """Multiply every value by ``factor``.

    R. Szeliski, Computer Vision: Algorithms and Applications, 2nd ed., 3.1.1. Pillow's contrast is
    ``adjust_contrast_with_mean_subtraction``.

    Args:
        image: (B, *), floating point in [0, 1], or uint8.
        factor: not negative; 0 gives black, 1 changes nothing. A number, a scalar tensor or (B,), one for
            each sample, whose values are not checked.
        clip_output: limit the result to [0, 1]; uint8 always saturates.

    Returns:
        Tensor of the image's shape and dtype.

    Raises:
        TypeError: if image is neither floating point nor uint8.
        ValueError: if factor's shape is not as above, or a number below 0.

    Example:
        >>> adjust_contrast(torch.tensor([[0.25, 0.75]]), 0.5)
        tensor([[0.1250, 0.3750]])
    """
    _check_not_negative(factor, "factor")
    return adjust_brightness_accumulative(image, factor, clip_output)


def adjust_contrast_with_mean_subtraction(image: Tensor, factor: Union[float, Tensor]) -> Tensor:
    """Stretch the values about the image's mean grey, like Pillow's ``ImageEnhance.Contrast`` does (which
    rounds the mean).

    Args:
        image: (*, C, H, W) in [0, 1], floating point. The grey of three channels is their BT.601 luma; for
            another number of channels it is their mean.
        factor: not negative; 0 gives the mean grey, 1 changes nothing. A number, a scalar tensor or (B,), one
            for each sample.

    Returns:
        Tensor of the image's shape and dtype, in [0, 1].

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image has fewer than three dimensions or factor's shape is not as above.

    Example:
        >>> adjust_contrast_with_mean_subtraction(torch.tensor([[[0.25, 0.75]]]), 0.5)
        tensor([[[0.3750, 0.6250]]])
    """
    check_floating(image, "image")
    if image.dim() < 3:
        raise ValueError(f"image: expected shape (*, C, H, W), got {list(image.shape)}")
    if image.size(-3) == 3:
        mean = rgb_to_grayscale(image).mean([-3, -2, -1], keepdim=True)
    else:
        mean = image.mean([-3, -2, -1], keepdim=True)
    return blended(mean, image, per_sample(factor, image, "factor"))


def adjust_saturation_with_gray_subtraction(image: Tensor, factor: Union[float, Tensor]) -> Tensor:
    """Blend each colour with its grey, like Pillow's ``ImageEnhance.Color`` does.

    Args:
        image: RGB (*, 3, H, W) in [0, 1], floating point.
        factor: not negative; 0 gives the grey image, 1 changes nothing. A number, a scalar tensor or (B,),
            one for each sample.

    Returns:
        Tensor of the image's shape and dtype, in [0, 1].

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not (*, 3, H, W) or factor's shape is not as above.

    Example:
        >>> adjust_saturation_with_gray_subtraction(
        ...     torch.tensor([1.0, 0.0, 0.0]).reshape(3, 1, 1), 0.0
        ... ).flatten()
        tensor([0.2990, 0.2990, 0.2990])
    """
    check_rgb(image, "image")
    check_floating(image, "image")
    grey = rgb_to_grayscale(image)
    return blended_with_plane(grey, image, per_sample(factor, image, "factor"))


def adjust_gamma(input: Tensor, gamma: Union[float, Tensor], gain: Union[float, Tensor] = 1.0) -> Tensor:
    """Power law: gain * input ** gamma, limited to [0, 1]. The gradient is zero where the input is zero,
    although it is infinite there for a gamma below 1.

    Args:
        input: (B, *), floating point in [0, 1], or uint8; negative values count as zero.
        gamma: exponent, not negative. A number, a scalar tensor or (B,), one for each sample.
        gain: factor, like gamma.

    Returns:
        Tensor of the input's shape and dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8.
        ValueError: if the shape of gamma or gain is not as above, or one is a number below 0.

    Example:
        >>> adjust_gamma(torch.tensor([[0.25, 1.0]]), 0.5)
        tensor([[0.5000, 1.0000]])
    """
    check_values(input, "input")
    _check_not_negative(gamma, "gamma")
    _check_not_negative(gain, "gain")
    if input.dtype == torch.uint8:
        x = levels(input, 1.0)
        # From 1e4 on every level except white is black; engines differ in powers of NaN and infinity.
        exponent = known_or(per_sample(gamma, x, "gamma"), 0.0).clamp(0.0, 1e4)
        return looked_up(input, power_each(x, exponent) * per_sample(gain, x, "gain"), 1.0)
    return (power_each(input, per_sample(gamma, input, "gamma")) * per_sample(gain, input, "gain")).clamp(
        0.0, 1.0
    )


def adjust_log(image: Tensor, gain: float = 1.0, inv: bool = False, clip_output: bool = True) -> Tensor:
    """Logarithmic curve gain * log2(1 + image), or its inverse gain * (2 ** image - 1), like scikit-image's
    ``adjust_log``.

    Args:
        image: (*) in [0, 1], floating point.
        gain: factor.
        inv: use the inverse (exponential) curve.
        clip_output: limit the result to [0, 1].

    Returns:
        Tensor of the image's shape and dtype.

    Raises:
        TypeError: if image is not floating point.

    Example:
        >>> adjust_log(torch.tensor([0.0, 1.0]))
        tensor([0., 1.])
    """
    check_floating(image, "image")
    if inv:
        return _clipped((torch.exp2(image) - 1.0) * gain, clip_output)
    return _clipped(torch.log2(image + 1.0) * gain, clip_output)


def adjust_sigmoid(image: Tensor, cutoff: float = 0.5, gain: float = 10.0, inv: bool = False) -> Tensor:
    """Sigmoid curve 1 / (1 + exp(gain * (cutoff - image))), or one minus this, like scikit-image's
    ``adjust_sigmoid``.

    G. J. Braun, Image lightness rescaling using sigmoidal contrast enhancement functions, J. Electronic
    Imaging 8(4), 1999.

    Args:
        image: (*) in [0, 1], floating point.
        cutoff: the input value that becomes 0.5.
        gain: steepness.
        inv: use one minus the curve.

    Returns:
        Tensor of the image's shape and dtype, in [0, 1].

    Raises:
        TypeError: if image is not floating point.

    Example:
        >>> adjust_sigmoid(torch.tensor([0.5]))
        tensor([0.5000])
    """
    check_floating(image, "image")
    slope = -gain if inv else gain
    return torch.sigmoid((image - cutoff) * slope)


def _check_not_negative(value: Union[float, Tensor], name: str) -> None:
    if not isinstance(value, Tensor):
        check_number(value, name)
        if not value >= 0.0:
            raise ValueError(f"{name}: expected a number that is not negative, got {value}")


def _clipped(image: Tensor, clip_output: bool) -> Tensor:
    return image.clamp(0.0, 1.0) if clip_output else image
