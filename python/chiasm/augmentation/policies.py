"""Policies: random sequences of operations; each sample has its own sequence."""

from typing import List

import torch
from torch import Tensor

from ..primitives.core.broadcasting import each
from ..primitives.core.checks import check_choice, check_pixels, check_rgb
from ..primitives.random.draws import integers
from .decisions import as_given, drawn, numbers_of
from .distributions import beta, dirichlet
from .operations import amounts, operated
from .policy_tables import policy_table


def rand_augment(input: Tensor, seed: Tensor, n: int = 2, m: int = 9, mode: str = "bilinear") -> Tensor:
    """RandAugment: n operations, each one of 14 with equal probability, all of the same strength.

    E. Cubuk et al., RandAugment: practical automated data augmentation with a reduced search space, CVPR
    workshops 2020, with torchvision's ranges: shears of up to 0.3, translations of up to 150/331 of the side,
    30 degrees, factors of 1 +- 0.9, 4 bits less; signs are random. Identity, Solarize, AutoContrast and
    Equalize are the others. At each of the n places, all operations are computed and one is selected.

    Args:
        input: RGB (B, 3, H, W), floating point in [0, 1] or uint8, H and W at least 3.
        seed: (B,), int64, one for each sample.
        n: how many operations, one after the other.
        m: strength, 0 to 30.
        mode: the interpolation of operations that move pixels, "bilinear" or "nearest".

    Returns:
        (B, 3, H, W), of the input's dtype; bytes are rounded once, after all operations.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> rand_augment(torch.rand(2, 3, 8, 9), torch.tensor([7, 8])).shape
        torch.Size([2, 3, 8, 9])
    """
    _check(input, mode)
    if n < 1:
        raise ValueError(f"n: expected at least 1, got {n}")
    if not (m >= 0 and m <= 30):  # NaN neither
        raise ValueError(f"m: expected 0 to 30, got {m}")
    sign = torch.where(drawn(seed, n, input) < 0.5, -1.0, 1.0)
    operation = integers(seed, 14, n, 1)
    level = torch.full_like(sign[:, 0], m / 30.0)
    x = numbers_of(input)
    for i in range(n):
        x = _step(
            x, operation[:, i], level, sign[:, i], [0.3, 150.0 / 331.0, 30.0, 0.9, 4.0, 8.0], True, mode
        )
    return as_given(x, input)


def trivial_augment(input: Tensor, seed: Tensor, mode: str = "bilinear") -> Tensor:
    """TrivialAugment in its wide form: one of 14 operations, of one of 31 strengths, all equally likely.

    S. Mueller, F. Hutter, TrivialAugment: tuning-free yet state-of-the-art data augmentation, ICCV 2021:
    shears of up to 0.99, translations of up to 32 pixels, 135 degrees, factors of 1 +- 0.99, 6 bits less;
    signs are random. Identity, Solarize, AutoContrast and Equalize are the others. All operations are
    computed and one is selected.

    Args:
        input: RGB (B, 3, H, W), floating point in [0, 1] or uint8, H and W at least 3.
        seed: (B,), int64, one for each sample.
        mode: the interpolation of operations that move pixels, "bilinear" or "nearest".

    Returns:
        (B, 3, H, W), of the input's dtype; bytes are rounded once, after all operations.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or mode is not as above.

    Example:
        >>> trivial_augment(torch.rand(2, 3, 8, 9), torch.tensor([7, 8])).shape
        torch.Size([2, 3, 8, 9])
    """
    _check(input, mode)
    sign = torch.where(drawn(seed, 1, input)[:, 0] < 0.5, -1.0, 1.0)
    operation = integers(seed, 14, 1, 1)[:, 0]
    level = integers(seed, 31, 1, 2)[:, 0].to(torch.float32) / 30.0
    x = numbers_of(input)
    return as_given(_step(x, operation, level, sign, [0.99, 32.0, 135.0, 0.99, 6.0, 8.0], False, mode), input)


def auto_augment(input: Tensor, seed: Tensor, policy: str = "imagenet", mode: str = "bilinear") -> Tensor:
    """AutoAugment: one of 25 pairs of operations with equal probability. Each operation of a pair has its own
    probability and strength.

    E. Cubuk et al., AutoAugment: learning augmentation policies from data, CVPR 2019, tables 7 to 9, with
    torchvision's ranges, the same as in ``rand_augment``. At both places, all operations are computed and one
    is selected.

    Args:
        input: RGB (B, 3, H, W), floating point in [0, 1] or uint8, H and W at least 3.
        seed: (B,), int64, one for each sample.
        policy: the data set that the policy was optimized for: "imagenet", "cifar10" or "svhn".
        mode: the interpolation of operations that move pixels, "bilinear" or "nearest".

    Returns:
        (B, 3, H, W), of the input's dtype; bytes are rounded once, after all operations.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> auto_augment(torch.rand(2, 3, 8, 9), torch.tensor([7, 8])).shape
        torch.Size([2, 3, 8, 9])
    """
    _check(input, mode)
    check_choice(policy, ["imagenet", "cifar10", "svhn"], "policy")
    u = drawn(seed, 4, input)
    table = torch.tensor(policy_table(policy), device=input.device).reshape(25, 2, 3)
    pair = table.index_select(0, integers(seed, 25, 1, 1)[:, 0])
    sign = torch.where(u[:, 2:] < 0.5, -1.0, 1.0)
    x = numbers_of(input)
    for i in range(2):
        operation = pair[:, i, 0].to(torch.int64)
        operation = torch.where(u[:, i] < pair[:, i, 1], operation, torch.zeros_like(operation))
        level = pair[:, i, 2] / 9.0
        x = _step(x, operation, level, sign[:, i], [0.3, 150.0 / 331.0, 30.0, 0.9, 4.0, 8.0], True, mode)
    return as_given(x, input)


def aug_mix(
    input: Tensor,
    seed: Tensor,
    severity: int = 3,
    mixture_width: int = 3,
    chain_depth: int = -1,
    alpha: float = 1.0,
    all_ops: bool = True,
    mode: str = "bilinear",
) -> Tensor:
    """AugMix: a blend of the image with a blend of chains of operations.

    D. Hendrycks et al., AugMix: a simple data processing method to improve robustness and uncertainty, ICLR
    2020, with torchvision's ranges: shears of up to 0.3, translations of up to a third of the side, 30
    degrees, Posterize to 4 bits and less, Solarize, AutoContrast, Equalize, and with all_ops factors of 1 +-
    0.9. The chains' weights are Dirichlet(alpha), the image's is Beta(alpha, alpha). At each place of each
    chain, all operations are computed and one is selected: nine times by default.

    Args:
        input: RGB (B, 3, H, W), floating point in [0, 1] or uint8, H and W at least 3.
        seed: (B,), int64, one for each sample.
        severity: 1 to 10; the strength is 0 to severity - 1, all equally likely, on a scale of ten strengths.
        mixture_width: number of chains.
        chain_depth: operations of each chain; -1 draws 1 to 3.
        alpha: the parameter of both distributions, positive.
        all_ops: True uses Brightness, Color, Contrast and Sharpness too; they overlap with the corruptions of
            common robustness tests.
        mode: the interpolation of operations that move pixels, "bilinear" or "nearest".

    Returns:
        (B, 3, H, W), of the input's dtype; bytes are rounded once, after all operations.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> aug_mix(torch.rand(2, 3, 8, 9), torch.tensor([7, 8])).shape
        torch.Size([2, 3, 8, 9])
    """
    _check(input, mode)
    if severity < 1 or severity > 10:
        raise ValueError(f"severity: expected 1 to 10, got {severity}")
    if mixture_width < 1:
        raise ValueError(f"mixture_width: expected at least 1, got {mixture_width}")
    if chain_depth == 0 or chain_depth < -1:
        raise ValueError(f"chain_depth: expected -1 or at least 1, got {chain_depth}")
    if not alpha > 0.0:
        raise ValueError(f"alpha: expected a positive number, got {alpha}")
    depth = 3 if chain_depth < 0 else chain_depth
    count = mixture_width * depth
    sign = torch.where(drawn(seed, count, input) < 0.5, -1.0, 1.0)
    known: List[int] = [1, 2, 3, 4, 5, 10, 11, 12, 13]
    if all_ops:
        known = known + [6, 7, 8, 9]
    operations = torch.tensor(known, device=input.device)
    operation = operations.index_select(0, integers(seed, len(known), count, 1).flatten()).reshape(-1, count)
    level = integers(seed, severity, count, 2).to(torch.float32) / 9.0
    length = integers(seed, 3, mixture_width, 3) + 1
    image = numbers_of(input)
    weight = dirichlet(seed, alpha, mixture_width, 4).to(image.dtype)
    own = beta(seed, alpha, 1, 7)[:, 0].to(image.dtype)
    mixed = image * each(own, image)
    for i in range(mixture_width):
        x = image
        for j in range(depth):
            k = i * depth + j
            here = operation[:, k]
            if chain_depth < 0:
                here = torch.where(length[:, i] > j, here, torch.zeros_like(here))
            x = _step(x, here, level[:, k], sign[:, k], [0.3, 1.0 / 3.0, 30.0, 0.9, 4.0, 4.0], True, mode)
        mixed = mixed + x * each(weight[:, i] * (1.0 - own), x)
    return as_given(mixed, input)


def _step(
    x: Tensor, operation: Tensor, level: Tensor, sign: Tensor, reach: List[float], relative: bool, mode: str
) -> Tensor:
    amount = amounts(operation, level, sign, reach, x.size(2), x.size(3), relative)
    return operated(x, operation, amount, mode)


def _check(input: Tensor, mode: str) -> None:
    check_rgb(input, "input")
    check_pixels(input, "input")
    check_choice(mode, ["bilinear", "nearest"], "mode")
