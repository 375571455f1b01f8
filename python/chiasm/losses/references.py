# An attribute of an nn.Module is declared as a Tensor or a Module, whichever it is.
# pyright: reportArgumentType=false
"""Mutual information with a fixed reference, for registration; and the names of the kernels."""

from enum import Enum
from typing import Optional

from torch import Tensor

from ..primitives.core.modules import Module, hold
from .mutual_information import (
    mutual_information_loss,
    mutual_information_loss_2d,
    mutual_information_loss_3d,
    normalized_mutual_information_loss,
    normalized_mutual_information_loss_2d,
    normalized_mutual_information_loss_3d,
)


class MIKernel(str, Enum):
    """Kernels of the joint histogram; members are equal to the strings that the losses take.

    >>> MIKernel.xu == "xu"
    True
    """

    xu = "xu"
    rectangular = "rectangular"
    truncated_gaussian = "truncated_gaussian"


class MILossFromRef(Module):
    """``mutual_information_loss`` as a module with a fixed reference.

    Args:
        reference_signal, mask: ``target`` and ``target_mask`` of the function.
        kernel_function, num_bins, window_radius: see the function.

    >>> MILossFromRef(torch.rand(2, 64))(torch.rand(2, 64)).shape
    torch.Size([2])
    """

    loss = staticmethod(mutual_information_loss)

    def __init__(
        self,
        reference_signal: Tensor,
        mask: Optional[Tensor] = None,
        kernel_function: str = "xu",
        num_bins: int = 64,
        window_radius: float = 1.0,
    ) -> None:
        super().__init__()
        hold(self, "reference_signal", reference_signal)
        self.mask: Optional[Tensor] = None
        if mask is not None:
            del self.mask
            hold(self, "mask", mask)
        self.kernel_function = MIKernel(kernel_function).value
        self.num_bins, self.window_radius = num_bins, float(window_radius)

    def forward(self, other_signal: Tensor, other_mask: Optional[Tensor] = None) -> Tensor:
        return self.loss(
            other_signal,
            self.reference_signal,
            other_mask,
            self.mask,
            self.kernel_function,
            self.num_bins,
            self.window_radius,
        )


class MILossFromRef2D(MILossFromRef):
    """``mutual_information_loss_2d`` with a reference, see ``MILossFromRef``.

    >>> x = torch.rand(2, 1, 8, 8)
    >>> MILossFromRef2D(x)(x).equal(mutual_information_loss_2d(x, x))
    True
    """

    loss = staticmethod(mutual_information_loss_2d)


class MILossFromRef3D(MILossFromRef):
    """``mutual_information_loss_3d`` with a reference, see ``MILossFromRef``.

    >>> x = torch.rand(2, 1, 8, 8, 8)
    >>> MILossFromRef3D(x)(x).equal(mutual_information_loss_3d(x, x))
    True
    """

    loss = staticmethod(mutual_information_loss_3d)


class NMILossFromRef(MILossFromRef):
    """``normalized_mutual_information_loss`` with a reference, see ``MILossFromRef``.

    >>> x = torch.rand(2, 64)
    >>> NMILossFromRef(x)(x).equal(normalized_mutual_information_loss(x, x))
    True
    """

    loss = staticmethod(normalized_mutual_information_loss)


class NMILossFromRef2D(MILossFromRef):
    """``normalized_mutual_information_loss_2d`` with a reference, see ``MILossFromRef``.

    >>> x = torch.rand(2, 1, 8, 8)
    >>> NMILossFromRef2D(x)(x).equal(normalized_mutual_information_loss_2d(x, x))
    True
    """

    loss = staticmethod(normalized_mutual_information_loss_2d)


class NMILossFromRef3D(MILossFromRef):
    """``normalized_mutual_information_loss_3d`` with a reference, see ``MILossFromRef``.

    >>> x = torch.rand(2, 1, 8, 8, 8)
    >>> NMILossFromRef3D(x)(x).equal(normalized_mutual_information_loss_3d(x, x))
    True
    """

    loss = staticmethod(normalized_mutual_information_loss_3d)
