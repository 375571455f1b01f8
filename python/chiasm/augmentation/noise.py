"""Random noise for every pixel, and random changes of whole channels."""

from typing import Tuple

import torch
from torch import Tensor

from ..enhance.jpeg import jpeg_codec_differentiable
from ..primitives.core.checks import check_image, check_pixels
from ..primitives.random.draws import normal_like, ranks, uniform, uniform_like
from .decisions import applied, between, check_bounds, check_chance, drawn, fitting, white_of


def random_gaussian_noise(
    input: Tensor, seed: Tensor, mean: float = 0.0, std: float = 1.0, p: float = 0.5
) -> Tensor:
    """Add an independent normally distributed number to every value.

    Args:
        input: (B, C, H, W), floating point.
        seed: (B,), int64, one for each sample.
        mean: the mean of the numbers.
        std: the standard deviation of the numbers, not negative.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype.

    Raises:
        TypeError: if input is not floating point, or seed not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> random_gaussian_noise(torch.zeros(1, 1, 1, 2), torch.tensor([7]), 1.0, 0.0, 1.0)
        tensor([[[[1., 1.]]]])
    """
    check_image(input, "input")
    check_chance(p)
    if std < 0.0:
        raise ValueError(f"std: expected a number that is not negative, got {std}")
    u = drawn(seed, 1, input)
    noise = normal_like(input, seed, 1).to(input.dtype) * std + mean
    return applied(input + noise, input, u[:, 0], p)


def random_salt_and_pepper_noise(
    input: Tensor,
    seed: Tensor,
    amount: Tuple[float, float] = (0.01, 0.06),
    salt_vs_pepper: Tuple[float, float] = (0.4, 0.6),
    p: float = 0.5,
) -> Tensor:
    """Make random pixels white or black, in all channels.

    Args:
        input: (B, C, H, W), floating point in [0, 1] or uint8.
        seed: (B,), int64, one for each sample.
        amount: (least, greatest) share of the pixels that change, within [0, 1], uniform.
        salt_vs_pepper: (least, greatest) share of the changed pixels that become white, within [0, 1],
            uniform.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> x, seed = torch.zeros(1, 3, 1, 2), torch.tensor([7])
        >>> random_salt_and_pepper_noise(x, seed, (1.0, 1.0), (1.0, 1.0), 1.0).min()
        tensor(1.)
    """
    check_pixels(input, "input")
    check_bounds(amount, 0.0, 1.0, "amount")
    check_bounds(salt_vs_pepper, 0.0, 1.0, "salt_vs_pepper")
    check_chance(p)
    u = drawn(seed, 3, input)
    share = between(u[:, 1], amount, u)[:, None, None, None]
    white = between(u[:, 2], salt_vs_pepper, u)[:, None, None, None]
    plane = input[:, :1]
    # The colours use their own random numbers: if one random number were compared twice, few numbers below a
    # small share would remain.
    bright = torch.full_like(plane, white_of(input))
    salt = torch.where(uniform_like(plane, seed, 2) < white, bright, torch.zeros_like(plane))
    noisy = torch.where(uniform_like(plane, seed, 1) < share, salt, input)
    return applied(noisy, input, u[:, 0], p)


def random_channel_dropout(
    input: Tensor, seed: Tensor, num_drop_channels: int = 1, fill_value: float = 0.0, p: float = 0.5
) -> Tensor:
    """Fill randomly chosen channels of each sample with a number.

    Args:
        input: (B, C, H, W), floating point or uint8.
        seed: (B,), int64, one for each sample.
        num_drop_channels: how many channels, 0 to C.
        fill_value: what they are filled with, in the units of the image.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> random_channel_dropout(torch.ones(1, 3, 1, 1), torch.tensor([7]), 2, p=1.0).sum()
        tensor(1.)
    """
    check_pixels(input, "input")
    check_chance(p)
    channels = input.size(1)
    if num_drop_channels < 0 or num_drop_channels > channels:
        raise ValueError(f"num_drop_channels: expected 0 to {channels}, got {num_drop_channels}")
    u = drawn(seed, 1, input)
    dropped = _channel_ranks(seed, channels) < num_drop_channels
    filled = torch.where(dropped[:, :, None, None], torch.full_like(input, fitting(fill_value, input)), input)
    return applied(filled, input, u[:, 0], p)


def random_channel_shuffle(input: Tensor, seed: Tensor, p: float = 0.5) -> Tensor:
    """Shuffle the channels; all orders are equally likely.

    Args:
        input: (B, C, H, W), floating point or uint8.
        seed: (B,), int64, one for each sample.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or p is not as above.

    Example:
        >>> x = torch.tensor([1.0, 2.0, 3.0]).reshape(1, 3, 1, 1)
        >>> random_channel_shuffle(x, torch.tensor([7]), 1.0).sum()
        tensor(6.)
    """
    check_pixels(input, "input")
    check_chance(p)
    u = drawn(seed, 1, input)
    return applied(shuffled(input, _channel_ranks(seed, input.size(1))), input, u[:, 0], p)


def _channel_ranks(seed: Tensor, channels: int) -> Tensor:
    """A random order of the channels (B, C)."""
    # Always draw more numbers than needed: a graph may not know how many blocks of four a number fills, or
    # whether a slice is the whole.
    count = channels + 1 if channels > 1024 else 1028
    return ranks(uniform(seed, count, 1)[:, :channels])


def shuffled(input: Tensor, order: Tensor) -> Tensor:
    """The channels of each sample in its own order (B, C)."""
    first = torch.arange(input.size(0), device=input.device)[:, None] * input.size(1)
    return input.flatten(0, 1).index_select(0, (first + order).flatten()).reshape(input.shape)


def random_jpeg(
    input: Tensor, seed: Tensor, jpeg_quality: Tuple[float, float] = (1.0, 100.0), p: float = 1.0
) -> Tensor:
    """Add JPEG artifacts, by ``jpeg_codec_differentiable``; the quality is uniform in ``jpeg_quality``.

    Args:
        input: RGB (B, 3, H, W), floating point in [0, 1].
        seed: (B,), int64, one for each sample.
        jpeg_quality: (least, greatest), within [1, 100].
        p: probability that a sample is changed.

    Returns:
        (B, 3, H, W), of the input's dtype.

    Raises:
        TypeError: if input is not floating point, or seed not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> random_jpeg(torch.full((1, 3, 20, 30), 0.5), torch.tensor([7])).shape
        torch.Size([1, 3, 20, 30])
    """
    check_image(input, "input")
    check_bounds(jpeg_quality, 1.0, 100.0, "jpeg_quality")
    check_chance(p)
    u = drawn(seed, 2, input)
    quality = between(u[:, 1], jpeg_quality, input)
    return applied(jpeg_codec_differentiable(input, quality), input, u[:, 0], p)
