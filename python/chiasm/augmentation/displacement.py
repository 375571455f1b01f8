"""Random deformations: each pixel is read from another position. Boxes and keypoints do not move, as in
Kornia."""

from typing import Any, Dict, List, Tuple

import torch
from torch import Tensor

from ..geometry.transform.elastic import elastic_transform2d
from ..geometry.transform.remap import remap
from ..geometry.transform.thin_plate import get_tps_transform, warp_image_tps
from ..primitives.core.checks import check_floating, check_interval
from ..primitives.random.draws import between, uniform
from ..primitives.resampling.warping import normalized_axis, position_dtype
from .annotations import moved_mask
from .base import AugmentationBase2D, Range, as_mode, check_batch, select
from .decisions import below
from .settings import fixed, number, whole, word


def _noise(seed: Tensor, height: int, width: int) -> Tensor:
    """(B, 2, H, W), uniform in [-1, 1)."""
    return between(uniform(seed, 2 * height * width, 1), -1.0, 1.0).reshape(-1, 2, height, width)


def random_elastic_transform(
    input: Tensor,
    seed: Tensor,
    kernel_size: Tuple[int, int] = (63, 63),
    sigma: Tuple[float, float] = (32.0, 32.0),
    alpha: Tuple[float, float] = (1.0, 1.0),
    align_corners: bool = False,
    resample: str = "bilinear",
    padding_mode: str = "zeros",
    p: float = 0.5,
) -> Tensor:
    """Deform some images by smoothed random displacements, by ``elastic_transform2d``.

    Args:
        input: (B, C, H, W), floating point.
        seed: (B,), int64.
        kernel_size, sigma, alpha, align_corners, padding_mode: as in ``elastic_transform2d``.
        resample: "bilinear", "nearest" or "bicubic".
        p: the probability of each image.

    Returns:
        (B, C, H, W). Differentiable in input.

    Raises:
        TypeError: if input is not floating point, or seed is not int64.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> x = torch.rand(1, 3, 8, 9)
        >>> random_elastic_transform(x, torch.tensor([0]), (3, 3), (1.0, 1.0)).shape
        torch.Size([1, 3, 8, 9])
    """
    check_batch(input, seed)
    check_floating(input, "input")
    noise = _noise(seed, input.size(2), input.size(3)).to(position_dtype(input.dtype))
    moved = elastic_transform2d(
        input, noise, kernel_size, sigma, alpha, align_corners, resample, padding_mode
    )
    return select({"batch_prob": below(uniform(seed, 1)[:, 0], p)}, moved, input)


class RandomElasticTransform(AugmentationBase2D):
    """``random_elastic_transform`` as a module.

    Args:
        kernel_size, sigma, alpha, align_corners, resample, padding_mode: as in ``random_elastic_transform``.
        same_on_batch, p, keepdim: as in ``AugmentationBase``.

    Example:
        >>> RandomElasticTransform((3, 3), (1.0, 1.0))(torch.rand(2, 3, 8, 9)).shape
        torch.Size([2, 3, 8, 9])
    """

    def __init__(
        self,
        kernel_size: Tuple[int, int] = (63, 63),
        sigma: Tuple[float, float] = (32.0, 32.0),
        alpha: Tuple[float, float] = (1.0, 1.0),
        align_corners: bool = False,
        resample: Any = "bilinear",
        padding_mode: str = "zeros",
        same_on_batch: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None:
        super().__init__(p, 1.0, same_on_batch, keepdim)
        self.kernel_size = whole("kernel_size", kernel_size)
        self.sigma, self.alpha = fixed("sigma", sigma), fixed("alpha", alpha)
        self.align_corners, self.resample, self.padding_mode = (
            bool(align_corners),
            as_mode(resample),
            word("padding_mode", padding_mode),
        )

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        noise = _noise(seed, shape[2], shape[3])
        return {"batch_prob": below(uniform(seed, 1)[:, 0], self.p), "noise": noise}

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return self.moved(input, params, self.resample)

    def moved(self, input: Tensor, params: Dict[str, Tensor], resample: str) -> Tensor:
        """The images, sampled with the given interpolation."""
        changed = elastic_transform2d(
            input,
            params["noise"].to(position_dtype(input.dtype)),  # the same for all dtypes that move together
            self.kernel_size,
            self.sigma,
            self.alpha,
            self.align_corners,
            resample,
            self.padding_mode,
        )
        return select(params, changed, input)

    @torch.jit.unused
    def transform_mask(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return moved_mask(input, lambda values, _: self.moved(values, params, "nearest"), bytes_too=False)


def _control_points(seed: Tensor, scale: float) -> Tuple[Tensor, Tensor]:
    """The corners and the centre (B, 5, 2), and their new positions."""
    corners = torch.tensor(
        [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0], [0.0, 0.0]],
        dtype=torch.float32,
        device=seed.device,
    )
    source = corners[None].expand(seed.size(0), 5, 2)
    return source, source + between(uniform(seed, 10, 1), -scale, scale).reshape(-1, 5, 2)


def _bent(input: Tensor, source: Tensor, target: Tensor, align_corners: bool, padding_mode: str) -> Tensor:
    """The images, warped so that the points ``source`` move to ``target``."""
    source, target = source.to(input.dtype), target.to(input.dtype)
    bends, plane = get_tps_transform(target, source)
    return warp_image_tps(input, source, bends, plane, align_corners, padding_mode)


def random_thin_plate_spline(
    input: Tensor,
    seed: Tensor,
    scale: float = 0.2,
    align_corners: bool = False,
    padding_mode: str = "zeros",
    p: float = 0.5,
) -> Tensor:
    """Warp some images by a thin-plate spline: the corners and the centre move at random.

    F. Bookstein, Principal warps: thin-plate splines and the decomposition of deformations, IEEE TPAMI 11(6),
    1989.

    Args:
        input: (B, C, H, W), floating point.
        seed: (B,), int64.
        scale: the largest shift of a point along each axis, as a fraction of half the image's side.
        align_corners, padding_mode: as in ``warp_image_tps``.
        p: the probability of each image.

    Returns:
        (B, C, H, W). Differentiable in input.

    Raises:
        TypeError: if input is not floating point, or seed is not int64.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> random_thin_plate_spline(torch.rand(1, 3, 8, 9), torch.tensor([0])).shape
        torch.Size([1, 3, 8, 9])
    """
    check_batch(input, seed)
    check_floating(input, "input")
    source, target = _control_points(seed, scale)
    moved = _bent(input, source, target, align_corners, padding_mode)
    return select({"batch_prob": below(uniform(seed, 1)[:, 0], p)}, moved, input)


class RandomThinPlateSpline(AugmentationBase2D):
    """``random_thin_plate_spline`` as a module. Masks stay as they are, as in Kornia.

    Args:
        scale, align_corners, padding_mode: as in ``random_thin_plate_spline``.
        same_on_batch, p, keepdim: as in ``AugmentationBase``.

    Example:
        >>> RandomThinPlateSpline()(torch.rand(2, 3, 8, 9)).shape
        torch.Size([2, 3, 8, 9])
    """

    def __init__(
        self,
        scale: float = 0.2,
        align_corners: bool = False,
        padding_mode: str = "zeros",
        same_on_batch: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None:
        super().__init__(p, 1.0, same_on_batch, keepdim)
        self.scale, self.align_corners = number("scale", scale), bool(align_corners)
        self.padding_mode = word("padding_mode", padding_mode)

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        source, target = _control_points(seed, self.scale)
        return {"batch_prob": below(uniform(seed, 1)[:, 0], self.p), "src": source, "dst": target}

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        changed = _bent(input, params["src"], params["dst"], self.align_corners, self.padding_mode)
        return select(params, changed, input)


def _drawn_fisheye(
    seed: Tensor, center_x: Tuple[float, float], center_y: Tuple[float, float], gamma: Tuple[float, float]
) -> Tensor:
    """(B, 3): the centre and the exponent."""
    check_interval(center_x, "center_x")
    check_interval(center_y, "center_y")
    check_interval(gamma, "gamma")
    u = uniform(seed, 3, 1)
    x, y = between(u[:, 0], center_x[0], center_x[1]), between(u[:, 1], center_y[0], center_y[1])
    return torch.stack([x, y, between(u[:, 2], gamma[0], gamma[1])], -1)


def _fisheye(input: Tensor, lens: Tensor) -> Tensor:
    precision = position_dtype(input.dtype)
    center_x, center_y, gamma = lens.to(precision)[:, :, None, None].unbind(1)
    column = normalized_axis(input.size(3), True, precision, input.device)[None, None, :]
    row = normalized_axis(input.size(2), True, precision, input.device)[None, :, None]
    across, down = column - center_x, row - center_y
    squared = across * across + down * down
    # 0 to any power is 0, and has no gradient
    away = torch.where(squared > 0.0, squared, torch.ones_like(squared))
    stretch = 1.0 + torch.where(squared > 0.0, torch.exp(torch.log(away) * (0.5 * gamma)), squared)
    return remap(input, column * stretch, row * stretch, align_corners=True, normalized_coordinates=True)


def random_fisheye(
    input: Tensor,
    seed: Tensor,
    center_x: Tuple[float, float] = (-0.3, 0.3),
    center_y: Tuple[float, float] = (-0.3, 0.3),
    gamma: Tuple[float, float] = (0.9, 1.1),
    p: float = 0.5,
) -> Tensor:
    """Distort some images like a fisheye lens, by Kornia's model: a pixel is read at (x, y) (1 + d^gamma),
    where d is its distance from a centre. Coordinates range from -1 to 1 between the centres of the corner
    pixels.

    Args:
        input: (B, C, H, W), floating point or uint8.
        seed: (B,), int64.
        center_x, center_y: the ranges of the centre.
        gamma: the range of the exponent, which is positive.
        p: the probability of each image.

    Returns:
        (B, C, H, W), black where the position lies outside the image. Differentiable in input.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a range is not as above.

    Example:
        >>> random_fisheye(torch.rand(1, 3, 8, 9), torch.tensor([0])).shape
        torch.Size([1, 3, 8, 9])
    """
    check_batch(input, seed)
    if gamma[0] <= 0.0:
        raise ValueError(f"gamma: expected a positive range, got ({gamma[0]}, {gamma[1]})")
    moved = _fisheye(input, _drawn_fisheye(seed, center_x, center_y, gamma))
    return select({"batch_prob": below(uniform(seed, 1)[:, 0], p)}, moved, input)


class RandomFisheye(AugmentationBase2D):
    """``random_fisheye`` as a module. Masks stay as they are, as in Kornia.

    Args:
        center_x, center_y, gamma: the ranges, two numbers each.
        same_on_batch, p, keepdim: as in ``AugmentationBase``.

    Example:
        >>> augment = RandomFisheye(
        ...     torch.tensor([-0.3, 0.3]), torch.tensor([-0.3, 0.3]), torch.tensor([0.9, 1.0])
        ... )
        >>> augment(torch.rand(2, 3, 8, 9)).shape
        torch.Size([2, 3, 8, 9])
    """

    def __init__(
        self,
        center_x: Range,
        center_y: Range,
        gamma: Range,
        same_on_batch: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None:
        super().__init__(p, 1.0, same_on_batch, keepdim)
        self.center_x, self.center_y = fixed("center_x", center_x), fixed("center_y", center_y)
        self.gamma = fixed("gamma", gamma)
        if self.gamma[0] <= 0.0:
            raise ValueError(f"gamma: expected a positive range, got {gamma}")

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        lens = _drawn_fisheye(seed, self.center_x, self.center_y, self.gamma)
        return {"batch_prob": below(uniform(seed, 1)[:, 0], self.p), "lens": lens}

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return select(params, _fisheye(input, params["lens"]), input)
