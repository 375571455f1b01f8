"""Canny's edges."""

from typing import Tuple, Union

from torch import Tensor

from ..color.gray import rgb_to_grayscale
from ..primitives.core.checks import check_image
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

    Args:
        input: (B, 3, H, W) RGB or (B, 1, H, W) grey, floating point.
        low_threshold: least magnitude of an edge, in units of the unnormalised Sobel operator.
        high_threshold: least magnitude of an edge's strongest pixel.
        kernel_size: odd size of the Gaussian, one for both axes or (rows, columns).
        sigma: standard deviations in pixels, (y, x) or a tensor (B, 2).
        hysteresis: keep of the weak edges those that touch strong ones, instead of all.
        eps: added to the squared magnitude, which keeps its derivative finite.
        num_iterations: bound on the steps by which weak edges are followed. Not in Kornia.

    Returns:
        The magnitude on the ridges, 0 elsewhere, and the edges: 1, or without hysteresis 1 for strong and 0.5
        for weak ones; both (B, 1, H, W). Only the magnitude has a gradient.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if a shape is not as above, or the thresholds are negative or in the wrong order.

    Example:
        >>> step = torch.zeros(1, 1, 8, 8)
        >>> step[..., 4:] = 1.0
        >>> step[..., 5:] = 1.5
        >>> canny(step)[1][0, 0, 4]
        tensor([0., 0., 0., 0., 1., 0., 0., 0.])
    """
    check_image(input, "input")
    if input.size(1) != 1 and input.size(1) != 3:
        raise ValueError(f"input: expected shape (B, 1, H, W) or (B, 3, H, W), got {list(input.shape)}")
    if low_threshold < 0.0 or high_threshold < low_threshold:
        raise ValueError(
            f"low_threshold: expected 0 <= low_threshold <= high_threshold, got {low_threshold} and"
            f" {high_threshold}"
        )
    gray = rgb_to_grayscale(input) if input.size(1) == 3 else input
    blurred = gaussian_blur2d(gray, kernel_size, sigma)
    magnitude = canny_nms(blurred, eps)
    detached = magnitude.detach()
    if hysteresis:
        edges = canny_hysteresis(detached, low_threshold, high_threshold, num_iterations).to(input.dtype)
    else:
        edges = 0.5 * (detached > low_threshold).to(input.dtype) + 0.5 * (detached > high_threshold).to(
            input.dtype
        )
    return magnitude, edges
