"""A mean that grows with what comes in."""

from typing import Union

from torch import Tensor


class AverageMeter:
    """The last value, and the mean of all, each counted as often as was said.

    >>> meter = AverageMeter()
    >>> meter.update(1.0, 3)
    >>> meter.update(5.0)
    >>> meter.val, meter.avg
    (5.0, 2.0)
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.val: Union[float, Tensor] = 0.0
        self.sum: Union[float, Tensor] = 0.0
        self.count = 0

    def update(self, val: Union[float, bool, Tensor], n: int = 1) -> None:
        """Count a value n times; of a tensor, without its graph."""
        self.val = val.detach() if isinstance(val, Tensor) else val
        self.sum = self.sum + self.val * n
        self.count += n

    @property
    def avg(self) -> float:
        """The mean; 0 of nothing."""
        return float(self.sum) / self.count if self.count else 0.0
