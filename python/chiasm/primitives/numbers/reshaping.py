"""Splitting and merging of dimensions whose sizes are symbolic."""

from typing import List

from torch import Tensor

from ..core.lowering import primitive


@primitive
def reshaped(x: Tensor, shape: List[int]) -> Tensor:
    """``x.reshape(shape)`` through one dimension: a direct merge of symbolic sizes asks whether one divides
    another.

    >>> reshaped(torch.arange(6).reshape(3, 2), [2, 3])
    tensor([[0, 1, 2],
            [3, 4, 5]])
    """
    return x.contiguous().reshape([-1]).reshape(shape)


@reshaped.lowering("vjp")
def _with_dense_gradient(x: Tensor, shape: List[int]) -> Tensor:
    # In the backward pass, the gradient must be dense to become one dimension. A mean's gradient is not; a
    # product's is.
    return x.contiguous().reshape([-1]).reshape(shape) * 1
