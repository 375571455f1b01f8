"""Mirror images."""

from torch import Tensor

from ..core.lowering import primitive
from ..kernels import operators as kernels


@primitive
def reversed_rows(x: Tensor) -> Tensor:
    """(*, H, W) with each row from its end to its beginning."""
    return x.flip([-1])


# Compiled tensor code loads and stores the pixels one by one.
reversed_rows.lowering("native", when=kernels.has_kernel)(kernels.hflip)
