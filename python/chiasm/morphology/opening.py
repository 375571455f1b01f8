"""Openings and closings, and their differences from the image."""

from typing import List, Optional

from torch import Tensor

from ..primitives.core.pixels import difference
from .element import check_engine, extreme, extreme_range


def opening(
    tensor: Tensor,
    kernel: Tensor,
    structuring_element: Optional[Tensor] = None,
    origin: Optional[List[int]] = None,
    border_type: str = "geodesic",
    border_value: float = 0.0,
    max_val: float = 1e4,
    engine: str = "auto",
) -> Tensor:
    """Open: erosion, then dilation, which removes bright details smaller than the element. Like SciPy's
    ``grey_opening``. The dilation counts the origin from the element's other end, so that the result never
    exceeds tensor for any origin.

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
        >>> opening(torch.tensor([[[[0.0, 1.0, 0.0, 1.0, 1.0]]]]), torch.ones(1, 2))
        tensor([[[[0., 0., 0., 1., 1.]]]])
    """
    check_engine(engine)
    low = extreme(tensor, kernel, structuring_element, origin, border_type, border_value, max_val, False)
    return extreme(low, kernel, structuring_element, origin, border_type, border_value, max_val, True, True)


def closing(
    tensor: Tensor,
    kernel: Tensor,
    structuring_element: Optional[Tensor] = None,
    origin: Optional[List[int]] = None,
    border_type: str = "geodesic",
    border_value: float = 0.0,
    max_val: float = 1e4,
    engine: str = "auto",
) -> Tensor:
    """Close: dilation, then erosion, which removes dark details smaller than the element. Like SciPy's
    ``grey_closing``. The dilation counts the origin from the element's other end, so that the result is never
    below tensor for any origin.

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
        >>> closing(torch.tensor([[[[1.0, 0.0, 1.0, 0.0, 0.0]]]]), torch.ones(1, 2))
        tensor([[[[1., 1., 1., 0., 0.]]]])
    """
    check_engine(engine)
    high = extreme(
        tensor, kernel, structuring_element, origin, border_type, border_value, max_val, True, True
    )
    return extreme(high, kernel, structuring_element, origin, border_type, border_value, max_val, False)


def top_hat(
    tensor: Tensor,
    kernel: Tensor,
    structuring_element: Optional[Tensor] = None,
    origin: Optional[List[int]] = None,
    border_type: str = "geodesic",
    border_value: float = 0.0,
    max_val: float = 1e4,
    engine: str = "auto",
) -> Tensor:
    """Top hat: tensor - opening, the bright details that the opening removes. Like SciPy's ``white_tophat``.

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
        (B, C, H, W), of tensor's dtype; for integer dtypes, saturated to its range.

    Raises:
        TypeError: if tensor is of another dtype, or of whole numbers with a structuring_element.
        ValueError: if a shape, origin or border is not as above, or border_value no number of tensor's dtype.

    Example:
        >>> top_hat(torch.tensor([[[[0.0, 1.0, 0.0, 1.0, 1.0]]]]), torch.ones(1, 2))
        tensor([[[[0., 1., 0., 0., 0.]]]])
    """
    check_engine(engine)
    low = opening(tensor, kernel, structuring_element, origin, border_type, border_value, max_val)
    return difference(tensor, low)


def bottom_hat(
    tensor: Tensor,
    kernel: Tensor,
    structuring_element: Optional[Tensor] = None,
    origin: Optional[List[int]] = None,
    border_type: str = "geodesic",
    border_value: float = 0.0,
    max_val: float = 1e4,
    engine: str = "auto",
) -> Tensor:
    """Bottom hat: closing - tensor, the dark details that the closing fills. Like SciPy's ``black_tophat``.

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
        (B, C, H, W), of tensor's dtype; for integer dtypes, saturated to its range.

    Raises:
        TypeError: if tensor is of another dtype, or of whole numbers with a structuring_element.
        ValueError: if a shape, origin or border is not as above, or border_value no number of tensor's dtype.

    Example:
        >>> bottom_hat(torch.tensor([[[[1.0, 0.0, 1.0, 0.0, 0.0]]]]), torch.ones(1, 2))
        tensor([[[[0., 1., 0., 0., 0.]]]])
    """
    check_engine(engine)
    high = closing(tensor, kernel, structuring_element, origin, border_type, border_value, max_val)
    return difference(high, tensor)


def gradient(
    tensor: Tensor,
    kernel: Tensor,
    structuring_element: Optional[Tensor] = None,
    origin: Optional[List[int]] = None,
    border_type: str = "geodesic",
    border_value: float = 0.0,
    max_val: float = 1e4,
    engine: str = "auto",
) -> Tensor:
    """Morphological gradient: dilation minus erosion, bright along edges. Like SciPy's
    ``morphological_gradient`` for centred elements of odd size.

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
        (B, C, H, W), of tensor's dtype; for integer dtypes, saturated to its range.

    Raises:
        TypeError: if tensor is of another dtype, or of whole numbers with a structuring_element.
        ValueError: if a shape, origin or border is not as above, or border_value no number of tensor's dtype.

    Example:
        >>> gradient(torch.tensor([[[[0.0, 0.0, 1.0, 1.0, 1.0]]]]), torch.ones(1, 3))
        tensor([[[[0., 1., 1., 0., 0.]]]])
    """
    check_engine(engine)
    return extreme_range(tensor, kernel, structuring_element, origin, border_type, border_value, max_val)
