"""Summed-area tables."""

from torch import Tensor

from ..core.lowering import primitive
from ..kernels import operators as kernels


@primitive
def integral(x: Tensor) -> Tensor:
    """Sums over all that is above and to the left of each pixel of (*, H, W), and the pixel.

    >>> integral(torch.ones(2, 3))
    tensor([[1., 2., 3.],
            [2., 4., 6.]])
    """
    return x.cumsum(-1).cumsum(-2)


integral.lowering("native", when=kernels.has_kernel)(kernels.integral)
