"""The structure tensor of an image, and the normalization of responses by scale."""

from typing import Optional, Tuple

from torch import Tensor

from ..filters.gaussian import gaussian_taps
from ..filters.gradient import spatial_gradient
from ..primitives.core.checks import check_broadcastable, check_tensor
from ..primitives.filters.stencil import separable_each
from ..primitives.resampling.warping import position_dtype


def structure_tensor(input: Tensor, grads_mode: str) -> Tuple[Tensor, Tensor, Tensor]:
    """Mean products xx, yy and xy of the derivatives of (B, C, H, W), weighted by a 7x7 Gaussian of sigma 1;
    float32 of half precision."""
    gradient = spatial_gradient(input.to(position_dtype(input.dtype)), grads_mode)
    dx, dy = gradient[:, :, 0], gradient[:, :, 1]
    taps = gaussian_taps(7, 1.0)
    blurred = separable_each([dx * dx, dy * dy, dx * dy], taps, taps, "reflect")
    return blurred[0], blurred[1], blurred[2]


def normalised_by_scale(response: Tensor, sigmas: Optional[Tensor]) -> Tensor:
    """The response (B, C, H, W) times the fourth power of each image's scale (B,), if there is one.

    T. Lindeberg, Feature detection with automatic scale selection, IJCV 30(2), 1998: here the derivatives
    have order four in total.
    """
    if sigmas is None:
        return response
    check_tensor(sigmas, "sigmas")
    if sigmas.dim() != 1:
        raise ValueError(f"sigmas: expected shape (B,), got {list(sigmas.shape)}")
    check_broadcastable(sigmas, response, "sigmas", "input", 0, 3)
    s = sigmas.to(response.dtype)[:, None, None, None]
    return response * (s * s * s * s)
