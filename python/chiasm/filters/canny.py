"""Canny's edges."""

from typing import Tuple, Union

import torch
from torch import Tensor

from ..color.gray import rgb_to_grayscale
from ..primitives.core.checks import check_pixels
from ..primitives.core.layout import in_planes
from ..primitives.features.canny import canny_hysteresis, canny_nms
from .gaussian import gaussian_blur2d


def canny(
    input: Tensor,
    low_threshold: float = 0.1,
    high_threshold: float = 0.2,
    kernel_size: Union[int, Tuple[int, int]] = (5, 5),
    sigma: Union[Tuple[float, float], Tensor] = (1.0, 1.0),
    hysteresis: bool = True,
    eps: float = 1e-6,
    num_iterations: int = 100,
) -> Tuple[Tensor, Tensor]:
    """Thin edges: ridges of the gradient's magnitude above a low threshold that touch one above a high
    threshold.

    J. Canny, A computational approach to edge detection, IEEE TPAMI 8(6), 1986. The gradient is the
    unnormalised Sobel one of the blurred image. A pixel is on a ridge where its magnitude exceeds both
    neighbours' along the gradient's direction, rounded to 45 degrees; outside the image the magnitude is 0.
    Of two equal pixels on the sides of an ideal step the left or upper one is the ridge, as in OpenCV; in
    Kornia neither is.

    Weak edges are followed by union-find, to their end: the number of steps grows with the logarithm of their
    length, and a spiral one pixel wide over a whole 1080p frame takes fewer than ten.

    For uint8, grey and blur are bytes too, and derivatives whole numbers. The edges are OpenCV's, to the bit:
    ``cv2.Canny(cv2.GaussianBlur(grey, kernel_size, sigma), low, high, L2gradient=True)``; with kernel_size 1
    those of an image that is not blurred.

    Args:
        input: (B, 3, H, W) RGB or (B, 1, H, W) grey, floating point or uint8.
        low_threshold: least magnitude of an edge, in units of the unnormalised Sobel operator: of bytes from
            0 to 1442, and 100 and 200 say.
        high_threshold: least magnitude of an edge's strongest pixel.
        kernel_size: odd size of the Gaussian, one for both axes or (rows, columns).
        sigma: standard deviations in pixels, (y, x) or a tensor (B, 2).
        hysteresis: keep of the weak edges those that touch strong ones, instead of all.
        eps: added to the squared magnitude, which keeps its derivative finite; of bytes it has no meaning.
        num_iterations: bound on the steps by which weak edges are followed. Not in Kornia.

    Returns:
        The magnitude on the ridges, 0 elsewhere, and the edges: 1, or without hysteresis 1 for strong and 0.5
        for weak ones; both (B, 1, H, W). Only the magnitude has a gradient. For uint8, the magnitude is
        int16, rounded, and the edges are bytes: 255, and 128 for weak ones.

    Raises:
        TypeError: if input is neither floating point nor uint8.
        ValueError: if a shape is not as above, or the thresholds are negative or in the wrong order.

    Example:
        >>> step = torch.zeros(1, 1, 8, 8)
        >>> step[..., 4:] = 1.0
        >>> step[..., 5:] = 1.5
        >>> canny(step)[1][0, 0, 4]
        tensor([0., 0., 0., 0., 1., 0., 0., 0.])
        >>> canny((100.0 * step).to(torch.uint8), 100.0, 200.0)[1][0, 0, 4]
        tensor([  0,   0,   0,   0, 255,   0,   0,   0], dtype=torch.uint8)
    """
    check_pixels(input, "input")
    if input.size(1) != 1 and input.size(1) != 3:
        raise ValueError(f"input: expected shape (B, 1, H, W) or (B, 3, H, W), got {list(input.shape)}")
    if low_threshold < 0.0 or high_threshold < low_threshold:
        raise ValueError(
            f"low_threshold: expected 0 <= low_threshold <= high_threshold, got {low_threshold} and"
            f" {high_threshold}"
        )
    gray = rgb_to_grayscale(input) if input.size(1) == 3 else input
    blurred = gaussian_blur2d(gray, kernel_size, sigma)
    if input.dtype == torch.uint8:
        # Squared magnitudes are whole numbers below 2^24, whose roots float32 tells apart.
        magnitude = canny_nms(in_planes(blurred).to(torch.float32), 0.0)
        shares = _edges(magnitude, low_threshold, high_threshold, hysteresis, num_iterations)
        return torch.round(magnitude).to(torch.int16), torch.round(255.0 * shares).to(torch.uint8)
    magnitude = canny_nms(blurred, eps)
    return magnitude, _edges(magnitude.detach(), low_threshold, high_threshold, hysteresis, num_iterations)


def _edges(magnitude: Tensor, low: float, high: float, hysteresis: bool, num_iterations: int) -> Tensor:
    """1 on edges, or without hysteresis 1 on strong and 0.5 on weak ones, in the dtype of the magnitude."""
    if hysteresis:
        return canny_hysteresis(magnitude, low, high, num_iterations).to(magnitude.dtype)
    return 0.5 * (magnitude > low).to(magnitude.dtype) + 0.5 * (magnitude > high).to(magnitude.dtype)
