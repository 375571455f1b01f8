"""Summed-area tables."""

import torch
from torch import Tensor

from ..core.layout import as_rows, from_rows, in_planes
from ..core.lowering import primitive
from ..kernels import operators as kernels


@primitive
def integral(x: Tensor) -> Tensor:
    """For each pixel of (*, H, W), the sum over all pixels above and to the left, including its own row and
    column.

    >>> integral(torch.ones(2, 3))
    tensor([[1., 2., 3.],
            [2., 4., 6.]])
    """
    return x.cumsum(-1).cumsum(-2)


integral.lowering("native", when=kernels.has_kernel)(kernels.integral)


@primitive
def integral_of_bytes(x: Tensor) -> Tensor:
    """`integral` of bytes as int32; larger sums become the largest int32.

    >>> integral_of_bytes(torch.ones(2, 3, dtype=torch.uint8))
    tensor([[1, 2, 3],
            [2, 4, 6]], dtype=torch.int32)
    """
    return whole_sums(integral(in_planes(x).to(torch.float64)))


@integral_of_bytes.lowering("native", when=kernels.available)
def _integral_kernel(x: Tensor) -> Tensor:
    if x.dim() == 4:
        rows, step = as_rows(x)
        return from_rows(kernels.integral_bytes(rows, step), x)
    return kernels.integral_bytes(x.reshape(-1, x.size(-2), x.size(-1)), 1).reshape(x.shape)


def whole_sums(sums: Tensor) -> Tensor:
    """Sums of bytes, exact in float64, as int32; larger sums become the largest int32.

    >>> whole_sums(torch.tensor([3.0, 2.0**31], dtype=torch.float64))
    tensor([         3, 2147483647], dtype=torch.int32)
    """
    return sums.clamp(max=2147483647.0).to(torch.int32)
