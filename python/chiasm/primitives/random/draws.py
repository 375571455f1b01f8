"""Random draws: the numbers of each sample of a batch depend only on its own seed.

A seed and a stream identify a draw. A second draw from the same seed must use another stream. The numbers of
a draw do not depend on their count: the first two of five are those of a draw of two.
"""

import math

import torch
from torch import Tensor

from ..core.checks import check_tensor
from .philox import key_of, philox4x32, seed_of


def check_seed(seed: Tensor, batch: int, name: str = "seed") -> None:
    """Raise unless ``seed`` is an int64 tensor (batch,)."""
    check_tensor(seed, name)
    if seed.dtype != torch.int64:
        raise TypeError(f"{name}: expected an int64 tensor, got dtype {seed.dtype}")
    if seed.dim() != 1 or seed.size(0) != batch:
        raise ValueError(f"{name}: expected shape ({batch},), one seed a sample, got {list(seed.shape)}")


def split(seed: Tensor, count: int) -> Tensor:
    """Seeds for each of ``count`` ops in sequence: (count, B) from (B,).

    >>> one, other = split(torch.tensor([7]), 2)
    >>> one.equal(other)
    False
    """
    index = torch.arange(count, device=seed.device)[:, None]
    zero = torch.zeros_like(index)
    # Draws have 0 in the third word of the counter, so these words differ from theirs.
    drawn = philox4x32([index, zero, zero + 1, zero], key_of(seed))
    return seed_of(drawn[0], drawn[1])


def words(seed: Tensor, count: int, stream: int = 0) -> Tensor:
    """Random words, 0 to 2^32 - 1: int64, (B, count) from seeds (B,)."""
    block = torch.arange((count + 3) // 4, device=seed.device)[None, :]
    zero = torch.zeros_like(block)
    drawn = philox4x32([block, zero + stream, zero, zero], [k[:, None] for k in key_of(seed)])
    return torch.stack(drawn, -1).flatten(1)[:, :count]


def uniform(seed: Tensor, count: int, stream: int = 0) -> Tensor:
    """Multiples of 2^-24 in [0, 1), float32: (B, count) from seeds (B,).

    >>> uniform(torch.tensor([0, 1]), 2).shape
    torch.Size([2, 2])
    """
    return (words(seed, count, stream) >> 8).to(torch.float32) * 5.9604644775390625e-08


def _values_of_a_sample(input: Tensor) -> int:
    """How many values each sample of a batch (B, ...) has, where B may be 0."""
    count = 1
    for i in range(1, input.dim()):
        count = count * input.size(i)
    return count


def uniform_like(input: Tensor, seed: Tensor, stream: int = 0) -> Tensor:
    """``uniform`` for every value of a batch (B, ...), float32."""
    return uniform(seed, _values_of_a_sample(input), stream).reshape(input.shape)


def between(u: Tensor, low: float, high: float) -> Tensor:
    """Uniform numbers in [0, 1), scaled to [low, high); rounding may give ``high`` itself."""
    return u * (high - low) + low


def normal(seed: Tensor, count: int, stream: int = 0) -> Tensor:
    """Standard normal numbers, float32: (B, count) from seeds (B,). All magnitudes are below 5.8.

    G. Box, M. Muller, A note on the generation of random normal deviates, Annals of Mathematical Statistics
    29(2), 1958.
    """
    pair = uniform(seed, (count + 1) // 2 * 2, stream).reshape(seed.size(0), (count + 1) // 2, 2)
    radius = torch.sqrt(-2.0 * torch.log(1.0 - pair[:, :, 0]))
    angle = pair[:, :, 1] * (2.0 * math.pi)
    drawn = torch.stack([radius * torch.cos(angle), radius * torch.sin(angle)], -1)
    return drawn.flatten(1)[:, :count]


def normal_like(input: Tensor, seed: Tensor, stream: int = 0) -> Tensor:
    """``normal`` for every value of a batch (B, ...), float32."""
    return normal(seed, _values_of_a_sample(input), stream).reshape(input.shape)


def integers(seed: Tensor, high: int, count: int, stream: int = 0) -> Tensor:
    """Integers from 0 to high - 1, int64: (B, count) from seeds (B,). ``high`` is at most 2^31.

    Their probabilities have a relative difference of less than high / 2^32.
    """
    return (words(seed, count, stream) * high) >> 32


def ranks(keys: Tensor) -> Tensor:
    """For each number along the last dimension, its position in ascending order; for independent draws, a
    uniform permutation. Equal numbers keep their order.

    >>> ranks(torch.tensor([[0.5, 0.1, 0.9]]))
    tensor([[1, 0, 2]])
    """
    position = torch.arange(keys.size(-1), device=keys.device)
    mine, other = keys.unsqueeze(-1), keys.unsqueeze(-2)
    before = (other < mine) | ((other == mine) & (position < position[:, None]))
    return before.to(torch.int64).sum(-1)
