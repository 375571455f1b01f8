"""Errors of optical flow."""

from torch import Tensor

from ..primitives.core.checks import check_last, check_reduction
from .reductions import check_pair, reduced_valid, vector_length


def aepe(input: Tensor, target: Tensor, reduction: str = "mean") -> Tensor:
    """Average end-point error: the mean distance between the ends of two fields of flow vectors.

    S. Baker et al., A database and evaluation methodology for optical flow, IJCV 92, 2011, section 4.1.

    Args:
        input: (*, 2), the estimated flow, floating point.
        target: the true flow, of input's shape.
        reduction: "mean", "sum" or "none".

    Returns:
        A scalar in the flow's unit (pixels), for "sum" float32 of half precision; or (*) for "none".

    Raises:
        TypeError: if a flow is not floating point.
        ValueError: if input is not (*, 2), target is of another shape, or reduction is unknown.

    Example:
        >>> aepe(torch.tensor([[3.0, 4.0], [1.0, 1.0]]), torch.tensor([[0.0, 0.0], [1.0, 1.0]]))
        tensor(2.5000)
    """
    check_last(input, 2, "input")
    check_pair(input, target)
    check_reduction(reduction)
    return reduced_valid(vector_length(input - target), None, reduction)


average_endpoint_error = aepe
