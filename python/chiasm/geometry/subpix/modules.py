"""Non-maximum suppression as modules; each call chooses whether it returns a mask."""

from typing import Tuple, Union

from torch import Tensor

from ...primitives.core.modules import Module
from .suppression import nms2d, nms3d


class NonMaximaSuppression2d(Module):
    """``nms2d`` as a module with a fixed kernel size.

    >>> NonMaximaSuppression2d((3, 3))(torch.rand(1, 1, 8, 9), mask_only=True).dtype
    torch.bool
    """

    def __init__(self, kernel_size: Union[int, Tuple[int, int]]) -> None:
        super().__init__()
        self.kernel_size = kernel_size

    def forward(self, x: Tensor, mask_only: bool = False) -> Tensor:
        return nms2d(x, self.kernel_size, mask_only)


class NonMaximaSuppression3d(Module):
    """``nms3d`` as a module with a fixed kernel size.

    >>> NonMaximaSuppression3d((3, 3, 3))(torch.rand(1, 1, 5, 8, 9)).shape
    torch.Size([1, 1, 5, 8, 9])
    """

    def __init__(self, kernel_size: Union[int, Tuple[int, int, int]]) -> None:
        super().__init__()
        self.kernel_size = kernel_size

    def forward(self, x: Tensor, mask_only: bool = False) -> Tensor:
        return nms3d(x, self.kernel_size, mask_only)
