"""Distributions that need rejection sampling, with a fixed number of tries."""

import math

import torch
from torch import Tensor

from ..primitives.random.draws import integers, normal, uniform

# A try is accepted with a probability of at least 0.95, so that all eight tries fail with a probability of
# about 10^-10.


def gamma(seed: Tensor, alpha: float, count: int, stream: int) -> Tensor:
    """Gamma-distributed numbers of scale 1, float32: (B, count) of seeds (B,).

    G. Marsaglia, W. Tsang, A simple method for generating gamma variables, ACM TOMS 26(3), 2000. Takes the
    streams ``stream`` to ``stream + 2``.
    """
    # An alpha below 1 is computed from alpha + 1: see section 6 of the paper.
    raised = alpha + 1.0 if alpha < 1.0 else alpha
    d = raised - 1.0 / 3.0
    c = 1.0 / math.sqrt(9.0 * d)
    batch = seed.size(0)
    x = normal(seed, 8 * count, stream).reshape(batch, 8, count)
    u = 1.0 - uniform(seed, 8 * count, stream + 1).reshape(batch, 8, count)
    root = 1.0 + c * x
    v = root * root * root
    safe = v.clamp(min=1e-30)
    accepted = (v > 0.0) & (torch.log(u) < 0.5 * x * x + d - d * v + d * torch.log(safe))
    drawn = torch.ones_like(v[:, 0])
    for i in range(8):
        drawn = torch.where(accepted[:, 7 - i], v[:, 7 - i], drawn)
    if alpha < 1.0:
        boost = 1.0 - uniform(seed, count, stream + 2)
        drawn = drawn * torch.exp(torch.log(boost) / alpha)
    return d * drawn


def beta(seed: Tensor, alpha: float, count: int, stream: int) -> Tensor:
    """Beta(alpha, alpha)-distributed numbers, float32: (B, count) of seeds (B,).

    Takes the streams ``stream`` to ``stream + 2``.
    """
    if alpha == 1.0:
        return uniform(seed, count, stream)
    pair = gamma(seed, alpha, 2 * count, stream).reshape(seed.size(0), count, 2)
    # For a small alpha both can be 0: then 0 and 1 are equally likely.
    total = pair.sum(-1)
    share = pair[:, :, 0] / torch.where(total > 0.0, total, torch.ones_like(total))
    return torch.where(total > 0.0, share, torch.round(uniform(seed, count, stream + 1)))


def dirichlet(seed: Tensor, alpha: float, count: int, stream: int) -> Tensor:
    """Dirichlet(alpha, ..., alpha)-distributed numbers, float32: (B, count) of seeds (B,), whose sum is 1.

    Takes the streams ``stream`` to ``stream + 2``.
    """
    drawn = gamma(seed, alpha, count, stream)
    total = drawn.sum(1, keepdim=True)
    if alpha >= 1.0:
        return drawn / total
    # For a small alpha all can be 0: then one is 1, each equally likely.
    only = integers(seed, count, 1, stream + 1) == torch.arange(count, device=seed.device)
    share = drawn / torch.where(total > 0.0, total, torch.ones_like(total))
    return torch.where(total > 0.0, share, only.to(share.dtype))
