"""A running mean."""

from typing import Union

import torch
from torch import Tensor


class AverageMeter:
    """Keeps the last value and the weighted mean of all values, which it sums in float64.

    >>> meter = AverageMeter()
    >>> meter.update(1.0, 3)
    >>> meter.update(5.0)
    >>> meter.val, meter.avg
    (5.0, 2.0)
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Reset to the initial state."""
        self.val: Union[float, Tensor] = 0.0
        self.sum: Union[float, Tensor] = 0.0
        self.count = 0

    def update(self, val: Union[float, bool, Tensor], n: int = 1) -> None:
        """Add a value n times; a tensor is detached from its graph."""
        self.val = val.detach() if isinstance(val, Tensor) else val
        self.sum = self.sum + (self.val.to(torch.float64) if isinstance(self.val, Tensor) else self.val) * n
        self.count += n

    @property
    def avg(self) -> float:
        """The mean; 0 if there are no values."""
        return float(self.sum) / self.count if self.count else 0.0
