"""Philox-4x32-10: a random number generator without a state.

J. Salmon, M. Moraes, R. Dror, D. Shaw, Parallel random numbers: as easy as 1, 2, 3, SC 2011. A bijection of
128-bit counters for each 64-bit key: the numbers at two counters are practically independent, so every
sample, pixel and op can compute its own, in any order and on any engine.

Words of 32 bits are kept in int64 tensors, which every engine has. Products are computed in halves, so that
none overflows.
"""

from typing import List, Tuple

import torch
from torch import Tensor

from ..core.loops import repeated


def philox4x32(counter: List[Tensor], key: List[Tensor], rounds: int = 10) -> List[Tensor]:
    """Four random words for each counter.

    Args:
        counter: four int64 tensors of words in 0 to 2^32 - 1 that broadcast with each other and the key.
        key: two such tensors.
        rounds: 10 rounds pass all statistical tests known to the authors, 7 rounds most of them.

    Returns:
        Four int64 tensors of words.

    >>> import torch
    >>> zero = torch.zeros(1, dtype=torch.int64)
    >>> [f"{int(word):08x}" for word in philox4x32([zero, zero, zero, zero], [zero, zero])]
    ['6627e8d5', 'e169c58d', 'bc57ac4c', '9b00dbd8']
    """
    state = torch.stack(torch.broadcast_tensors(counter[0], counter[1], counter[2], counter[3], key[0])[:4])
    made = _round(state, rounds, key[0], key[1])
    return [made[0], made[1], made[2], made[3]]


# Exported graphs contain a loop, because ten copies of its body wherever words are read would take minutes to
# compile.
@repeated
def _round(state: Tensor, k: Tensor, key0: Tensor, key1: Tensor) -> Tensor:
    # Weyl sequences: the golden ratio and the square root of 3, minus 1
    k0, k1 = (key0 + k * 0x9E3779B9) & 0xFFFFFFFF, (key1 + k * 0xBB67AE85) & 0xFFFFFFFF
    high0, low0 = _product(state[0], 0xD2511F53)
    high2, low2 = _product(state[2], 0xCD9E8D57)
    return torch.stack([high2 ^ state[1] ^ k0, low2, high0 ^ state[3] ^ k1, low0])


def _product(word: Tensor, factor: int) -> Tuple[Tensor, Tensor]:
    """The high and the low word of a product of two words."""
    low = (word & 0xFFFF) * factor
    high = (word >> 16) * factor + (low >> 16)  # below 2^49
    return high >> 16, ((high & 0xFFFF) << 16) + (low & 0xFFFF)


def key_of(seed: Tensor) -> List[Tensor]:
    """The two words (low, high) of 64-bit seeds."""
    return [seed & 0xFFFFFFFF, (seed >> 32) & 0xFFFFFFFF]


def seed_of(low: Tensor, high: Tensor) -> Tensor:
    """The 64-bit seeds of two words each."""
    return (high - ((high >> 31) << 32)) * 4294967296 + low
