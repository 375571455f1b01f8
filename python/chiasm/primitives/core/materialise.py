"""Deciding what native code stores instead of recomputing."""

import torch
from torch import Tensor

from .lowering import primitive


@primitive
def materialised(x: Tensor, dim: int) -> Tensor:
    """x, which native code computes once and stores.

    AOTInductor inlines cheap arithmetic into every place that reads it: into each tap of a stencil, into each
    pixel that looks up a table. A concatenation is always stored, so this one appends an extra slice, which
    is cut off again.
    """
    return x


@materialised.lowering("native")
def _concatenated(x: Tensor, dim: int) -> Tensor:
    return torch.cat([x, x.narrow(dim, 0, 1)], dim).narrow(dim, 0, x.size(dim))


materialised.lowering("cuda")(materialised.definition)  # Inductor decides what a GPU stores


@primitive
def stored_index(index: Tensor) -> Tensor:
    """A one-dimensional table of int64 indices, stored. Native code stores 32 bits, for twice the vector
    lanes."""
    return index


@stored_index.lowering("native")
def _stored_in_32_bits(index: Tensor) -> Tensor:
    return materialised(index.to(torch.int32), 0)
