"""Kernel descriptors of patches: sums of explicit feature maps, whose inner product sums a kernel over all
pairs of pixels of two patches.

A. Bursuc, G. Tolias, H. Jégou, Kernel Local Descriptors with Implicit Rotation Matching, ICMR 2015; A.
Mukundan, G. Tolias, O. Chum, Multiple-Kernel Local-Patch Descriptor, BMVC 2017; A. Mukundan, G. Tolias, A.
Bursuc, H. Jégou, O. Chum, Understanding and Improving Kernel Local Descriptors, IJCV 127, 2019.
"""

import math
from typing import List, Optional, Tuple

import torch
from torch import Tensor

from ..filters.gradient import spatial_gradient
from ..primitives.core.checks import check_choice, check_floating, check_tensor
from ..primitives.core.modules import Module, hold
from ..primitives.linalg.matrices import small_matmul
from ..primitives.numbers.power import power as positive_power
from ..primitives.resampling.warping import position_dtype
from .gradients import check_patches, gaussian_window, unit


def mkd_describe(
    patches: Tensor,
    kernel_type: str = "concat",
    whitening: Optional[Tensor] = None,
    mean: Optional[Tensor] = None,
    power: float = 1.0,
) -> Tensor:
    """Kernel descriptors of patches: they encode the gradient and the position of every pixel without bins.
    The inner product of two descriptors, before normalization to unit vectors, is the sum over all pairs of
    pixels, one of each patch, of w(p) w(q) k(direction) k(place) k(place), where w is the root of the
    gradient's length times exp(-r^2), where r is the distance from the patch's centre (1 in its corners), and
    k is the von Mises kernel (exp(kappa cos d) - exp(-kappa)) / (2 sinh kappa) of the difference d of two
    angles, truncated after some terms of its Fourier series:

    * "cart": the gradient's direction (kappa 8, 3 frequencies), x and y (kappa 1, 1 frequency), which go from
      0 in the first to pi in the last pixel. It tolerates a small shift of a patch.
    * "polar": the gradient's direction relative to the pixel's direction from the centre (kappa 8, 3
      frequencies), the pixel's direction, and the distance r, which goes from 0 to pi (kappa 8, 2 frequencies
      each). It tolerates a small rotation of a patch. A pixel exactly at the centre counts as lying in the
      direction of x.
    * "concat": both unit vectors, concatenated.

    The papers whiten descriptors by a matrix learned from many patches. This package has no such matrix:
    without ``whitening`` the result is the raw descriptors. Patches are not blurred first.

    Args:
        patches: (N, 1, PS, PS), floating point, oriented, PS at least 2. Half precision is computed in
            float32.
        kernel_type: "concat", "cart" or "polar".
        whitening: (D, d), floating point, a projection of your own, by which the descriptors are multiplied.
        mean: (D,), floating point, subtracted before that.
        power: exponent that the entries' magnitudes are raised to at the end, positive; the ICMR paper has
            0.5, after the projection.

    Returns:
        (N, D), or (N, d) where there is a projection, unit vectors; D is 63 for "cart", 175 for "polar" and
        238 for both, polar first. The direction is outermost, then r or y, then the pixel's direction or x;
        of each the constant, then cosine and sine of each frequency. Zeros for a patch without gradients,
        unless a mean is subtracted.

    Raises:
        TypeError: if an input is not floating point.
        ValueError: if a shape, kernel_type or power is not as above.

    Example:
        >>> ramp = torch.arange(16.0).expand(1, 1, 16, 16)
        >>> cart = mkd_describe(ramp, "cart").reshape(7, 3, 3)
        >>> cart[:, 0, 0].round(decimals=2)
        tensor([0.2800, 0.3800, 0.0000, 0.3400, 0.0000, 0.2900, 0.0000])
        >>> mkd_describe(ramp).shape
        torch.Size([1, 238])
    """
    check_patches(patches)
    check_choice(kernel_type, ["concat", "cart", "polar"], "kernel_type")
    if patches.size(3) < 2:
        raise ValueError(f"patches: expected at least 2 x 2 pixels, got {list(patches.shape)}")
    if not power > 0.0:
        raise ValueError(f"power: expected a positive number, got {power}")
    weight, cosine, sine = _gradient(patches.to(position_dtype(patches.dtype)))
    parts: List[Tensor] = []
    if kernel_type != "cart":
        parts.append(_polar(weight, cosine, sine))
    if kernel_type != "polar":
        parts.append(_cartesian(weight, cosine, sine))
    vectors = unit(torch.cat(parts, 1), True)
    if mean is not None:
        _check_learned(mean, "mean", "(D,)", 1, vectors)
        vectors = vectors - mean.to(vectors.dtype)
    if whitening is not None:
        _check_learned(whitening, "whitening", "(D, d)", 2, vectors)
        vectors = small_matmul(vectors, whitening.to(vectors.dtype))
    if power != 1.0:
        empty = vectors == 0
        size = torch.where(empty, torch.ones_like(vectors), vectors.abs())
        vectors = torch.where(
            empty, torch.zeros_like(vectors), torch.sign(vectors) * positive_power(size, power)
        )
    return unit(vectors, True).to(patches.dtype)


class MKDDescriptor(Module):
    """``mkd_describe`` for patches of one size, as a module for ``LAFDescriptor``. Kornia takes the name of a
    whitening that it downloads; this class takes your own projection, or none.

    Args:
        patch_size: side PS of the patches.
        kernel_type, mean, power: see ``mkd_describe``.
        whitening: see ``mkd_describe``. A tensor becomes a member, as mean does: a Parameter is learned with
            the module.
        training_set: for compatibility with Kornia, which takes a whitening of this name; it has no effect.
        output_dims: how many of a projection's dimensions to keep, the first ones; None, or more than it has:
            all. Without a projection it has no effect.

    >>> describe = MKDDescriptor(16, "polar")
    >>> describe(torch.rand(3, 1, 16, 16)).shape, describe.output_dims
    (torch.Size([3, 175]), 175)
    >>> MKDDescriptor(16, "cart", torch.eye(63), output_dims=8)(torch.rand(3, 1, 16, 16)).shape
    torch.Size([3, 8])
    """

    def __init__(
        self,
        patch_size: int = 32,
        kernel_type: str = "concat",
        whitening: Optional[Tensor] = None,
        training_set: str = "liberty",
        output_dims: Optional[int] = None,
        mean: Optional[Tensor] = None,
        power: float = 1.0,
    ) -> None:
        super().__init__()
        check_choice(kernel_type, ["concat", "cart", "polar"], "kernel_type")
        if isinstance(whitening, str):
            raise TypeError(
                f"whitening: expected None or a projection (D, d), for no weights are here, got {whitening!r}"
            )
        if output_dims is not None and output_dims < 1:
            raise ValueError(f"output_dims: expected a positive number, got {output_dims}")
        if whitening is not None and output_dims is not None and output_dims < whitening.size(-1):
            whitening = whitening[..., :output_dims]
        self.patch_size = patch_size
        self.kernel_type, self.training_set = kernel_type, training_set
        self.power = float(power)
        self.output_dims = (
            {"concat": 238, "cart": 63, "polar": 175}[kernel_type]
            if whitening is None
            else whitening.size(-1)
        )
        self.whitening: Optional[Tensor]
        self.mean: Optional[Tensor]
        hold(self, "whitening", whitening)  # pyright: ignore[reportArgumentType]: or None
        hold(self, "mean", mean)  # pyright: ignore[reportArgumentType]

    def forward(self, patches: Tensor) -> Tensor:
        if patches.size(-1) != self.patch_size:
            raise ValueError(
                f"patches: expected shape (N, 1, {self.patch_size}, {self.patch_size}), got"
                f" {list(patches.shape)}"
            )
        return mkd_describe(patches, self.kernel_type, self.whitening, self.mean, self.power)


def von_mises_coefficients(kappa: float, frequencies: int) -> List[float]:
    """a_0 to a_n of sum a_k cos(k d), the Fourier series of (exp(kappa cos d) - exp(-kappa)) / (2 sinh
    kappa), for kappa up to 30.

    As exp(kappa cos d) = I_0(kappa) + 2 sum I_k(kappa) cos(k d), with the modified Bessel functions I_k,
    whose power series has no negative terms.

    >>> [round(a, 4) for a in von_mises_coefficients(1.0, 1)]
    [0.3821, 0.4809]
    """
    coefficients: List[float] = []
    first = 1.0
    for k in range(frequencies + 1):
        if k > 0:
            first = first * 0.5 * kappa / k
        term, bessel = first, first
        for m in range(1, 80):
            term = term * 0.25 * kappa * kappa / (m * (m + k))
            bessel = bessel + term
        if k == 0:
            coefficients.append((bessel - math.exp(-kappa)) / (2.0 * math.sinh(kappa)))
        else:
            coefficients.append(bessel / math.sinh(kappa))
    return coefficients


def _check_learned(value: Tensor, name: str, layout: str, rank: int, vectors: Tensor) -> None:
    check_tensor(value, name)
    if value.dim() != rank or value.size(0) != vectors.size(1):
        raise ValueError(
            f"{name}: expected shape {layout} with D = {vectors.size(1)}, got {list(value.shape)}"
        )
    check_floating(value, name)


def _gradient(patches: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """Root of the length of the central differences, and the cosine and sine of their direction, (N, PS, PS)
    each; all 0 where there is no gradient."""
    gradient = spatial_gradient(patches, "diff")[:, 0]
    dx, dy = gradient[:, 0], gradient[:, 1]
    squared = dx * dx + dy * dy
    flat = squared == 0
    length = torch.sqrt(torch.where(flat, torch.ones_like(squared), squared))
    return torch.where(flat, torch.zeros_like(length), torch.sqrt(length)), dx / length, dy / length


def _cartesian(weight: Tensor, cosine: Tensor, sine: Tensor) -> Tensor:
    size = weight.size(2)
    angle = torch.arange(size, device=weight.device).to(weight.dtype) * math.pi / (size - 1)
    side = torch.stack(_feature_map(torch.cos(angle), torch.sin(angle), 1.0, 1))
    places = side[:, None, :, None] * side[:, None]
    return _summed(weight, cosine, sine, places)


def _polar(weight: Tensor, cosine: Tensor, sine: Tensor) -> Tensor:
    size = weight.size(2)
    offset = torch.arange(size, device=weight.device).to(weight.dtype) - 0.5 * (size - 1)
    squared = offset[:, None] * offset[:, None] + offset * offset
    middle = squared == 0
    distance = torch.sqrt(torch.where(middle, torch.ones_like(squared), squared))
    # The pixel in the very centre has no direction: it counts as lying to the right.
    across = torch.where(middle, torch.ones_like(distance), offset / distance)
    down = offset[:, None] / distance
    angle = torch.where(middle, torch.zeros_like(distance), distance) * (math.pi * 2.0**0.5) / (size - 1)
    far = torch.stack(_feature_map(torch.cos(angle), torch.sin(angle), 8.0, 2))
    turn = torch.stack(_feature_map(across, down, 8.0, 2))
    places = far[:, None] * turn
    return _summed(weight, cosine * across + sine * down, sine * across - cosine * down, places)


def _feature_map(cosine: Tensor, sine: Tensor, kappa: float, frequencies: int) -> List[Tensor]:
    """Feature vectors of an angle; the inner product of two is the kernel of the angles' difference."""
    coefficients = von_mises_coefficients(kappa, frequencies)
    c, s = cosine, sine
    features = [torch.full_like(cosine, math.sqrt(coefficients[0]))]
    for k in range(1, frequencies + 1):
        features.append(c * math.sqrt(coefficients[k]))
        features.append(s * math.sqrt(coefficients[k]))
        # The next multiple of the angle, by the addition theorems.
        c, s = c * cosine - s * sine, s * cosine + c * sine
    return features


def _summed(weight: Tensor, cosine: Tensor, sine: Tensor, places: Tensor) -> Tensor:
    """(N, 7 R S) unit vectors: products of the direction's features and the places' (R, S, PS, PS), summed
    over the pixels."""
    size = weight.size(2)
    weight = weight * gaussian_window(size, 0.5 * (size - 1), weight)
    directions = torch.stack([feature * weight for feature in _feature_map(cosine, sine, 8.0, 3)], 1)
    sums = small_matmul(directions.flatten(2), places.flatten(2).flatten(0, 1).transpose(0, 1))
    return unit(sums.flatten(1), True)
