"""Summed-area tables."""

from torch import Tensor

from .kernels import operators as kernels
from .lowering import primitive


@primitive
def summed_area(x: Tensor) -> Tensor:
    """Sums over all that is above and to the left of each pixel of (*, H, W), and the pixel.

    >>> summed_area(torch.ones(2, 3))
    tensor([[1., 2., 3.],
            [2., 4., 6.]])
    """
    return x.cumsum(-1).cumsum(-2)


summed_area.lowering("native", when=kernels.has_kernel)(kernels.integral)
