"""Dilation."""

from typing import List, Optional

from torch import Tensor

from .element import check_engine, extreme


def dilation(
    tensor: Tensor,
    kernel: Tensor,
    structuring_element: Optional[Tensor] = None,
    origin: Optional[List[int]] = None,
    border_type: str = "geodesic",
    border_value: float = 0.0,
    max_val: float = 1e4,
    engine: str = "auto",
) -> Tensor:
    """Dilate: out(p) = max over the kernel's nonzero offsets b of tensor(p - b) + height(b).

    J. Serra, Image Analysis and Mathematical Morphology, 1982. As in SciPy's ``grey_dilation``, the element
    is reflected; OpenCV's ``dilate`` does not reflect it.

    Args:
        tensor: (B, C, H, W), floating point, without NaN, of magnitude well below max_val; or uint8, int16 or
            uint16, planes or a permuted frame.
        kernel: (kh, kw); nonzero entries are the neighbourhood.
        structuring_element: (kh, kw) heights b of a non-flat element; zeros (flat) by default. Elements for
            integer dtypes must be flat.
        origin: [row, column] of the element's origin, [kh // 2, kw // 2] by default.
        border_type: "geodesic" (pixels outside the image are ignored), "reflect", "replicate", "circular" or
            "constant".
        border_value: the value outside the image for "constant".
        max_val: represents infinity. For integer dtypes, the limits of the dtype are used instead.
        engine: not used, for compatibility with Kornia: "auto", "unfold", "convolution" or "shift".

    Returns:
        (B, C, H, W), of tensor's dtype.

    Raises:
        TypeError: if tensor is of another dtype, or of whole numbers with a structuring_element.
        ValueError: if a shape, origin or border is not as above, or border_value no number of tensor's dtype.

    Example:
        >>> x = torch.zeros(1, 1, 3, 5)
        >>> x[0, 0, 1, 2] = 1.0
        >>> dilation(x, torch.ones(1, 3))[0, 0, 1]
        tensor([0., 1., 1., 1., 0.])
    """
    check_engine(engine)
    return extreme(tensor, kernel, structuring_element, origin, border_type, border_value, max_val, True)
