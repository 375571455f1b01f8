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


@primitive
def split_dim(x: Tensor, dim: int, first: int, second: int) -> Tensor:
    """``x.unflatten(dim, [first, second])`` of sizes that may be symbolic.

    >>> split_dim(torch.arange(6)[None], 1, 3, 2)
    tensor([[[0, 1],
             [2, 3],
             [4, 5]]])
    """
    # The tracer does not know that a product of symbolic sizes divides by one of them: it computes the other.
    return x.unflatten(dim, [first, -1])


@split_dim.lowering("vjp")
def _split_with_dense_gradient(x: Tensor, dim: int, first: int, second: int) -> Tensor:
    sizes = list(x.shape)
    return _with_dense_gradient(x, [*sizes[:dim], first, second, *sizes[dim + 1 :]])
