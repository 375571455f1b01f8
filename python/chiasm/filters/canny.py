"""The Canny edge detector."""

from typing import Tuple, Union

import torch
from torch import Tensor

from ..color.gray import rgb_to_grayscale
from ..primitives.core.checks import check_grey_or_rgb, check_pixels
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
    """Detect thin edges: ridges of the gradient magnitude, with two thresholds and hysteresis.

    J. Canny, A computational approach to edge detection, IEEE TPAMI 8(6), 1986. An edge is a ridge above the
    low threshold that is connected to a pixel above the high threshold. The gradient is the unnormalized
    Sobel gradient of the blurred image. A pixel is on a ridge if its magnitude exceeds that of both
    neighbours along the gradient direction, rounded to 45 degrees; outside the image the magnitude is 0. If
    the two pixels at an ideal step have equal magnitudes, the left or upper one is the ridge, as in OpenCV.

    Weak edges are followed to their end by union-find. The number of steps grows with the logarithm of their
    length; a spiral of one pixel width over a whole 1080p frame needs fewer than ten steps.

    For uint8, the grey image and the blurred image are uint8 too, and derivatives are whole numbers. The
    edges are identical to OpenCV's ``cv2.Canny(cv2.GaussianBlur(grey, kernel_size, sigma), low, high,
    L2gradient=True)``; with kernel_size 1, the image is not blurred.

    Args:
        input: (B, 3, H, W) RGB or (B, 1, H, W) grey, floating point or uint8.
        low_threshold: least magnitude of an edge, in units of the unnormalized Sobel operator; for uint8 from
            0 to 1442, for example 100 (low) and 200 (high).
        high_threshold: least magnitude of the strongest pixel of an edge.
        kernel_size: odd size of the Gaussian, one for both axes or (rows, columns).
        sigma: standard deviations in pixels, (y, x) or a tensor (B, 2).
        hysteresis: True keeps only the weak edges that are connected to strong ones; False keeps all.
        eps: added to the squared magnitude to keep its derivative finite; not used for uint8.
        num_iterations: maximum number of steps that follow weak edges. Not in Kornia.

    Returns:
        The magnitude on the ridges, 0 elsewhere, and the edges: 1, or without hysteresis 1 for strong edges
        and 0.5 for weak edges; both (B, 1, H, W). Only the magnitude has a gradient. For uint8, the magnitude
        is int16, rounded, and the edges are uint8: 255, and 128 for weak edges.

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
    check_grey_or_rgb(input, "input")
    if not (low_threshold >= 0.0 and high_threshold >= low_threshold):
        raise ValueError(
            f"low_threshold: expected 0 <= low_threshold <= high_threshold, got {low_threshold} and"
            f" {high_threshold}"
        )
    gray = rgb_to_grayscale(input) if input.size(1) == 3 else input
    blurred = gaussian_blur2d(gray, kernel_size, sigma)
    if input.dtype == torch.uint8:
        # Squared magnitudes are whole numbers below 2^24; their square roots are different numbers in
        # float32.
        magnitude = canny_nms(in_planes(blurred).to(torch.float32), 0.0)
        shares = _edges(magnitude, low_threshold, high_threshold, hysteresis, num_iterations)
        return torch.round(magnitude).to(torch.int16), torch.round(255.0 * shares).to(torch.uint8)
    magnitude = canny_nms(blurred, eps)
    return magnitude, _edges(magnitude.detach(), low_threshold, high_threshold, hysteresis, num_iterations)


def _edges(magnitude: Tensor, low: float, high: float, hysteresis: bool, num_iterations: int) -> Tensor:
    """1 on edges, or without hysteresis 1 on strong edges and 0.5 on weak edges, in the dtype of the
    magnitude."""
    if hysteresis:
        return canny_hysteresis(magnitude, low, high, num_iterations).to(magnitude.dtype)
    return 0.5 * (magnitude > low).to(magnitude.dtype) + 0.5 * (magnitude > high).to(magnitude.dtype)
