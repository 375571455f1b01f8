"""Random affine maps, rotations and homographies of volumes. Matrices are in voxels."""

import math
from typing import Any, Dict, List, Optional, Tuple

import torch
from torch import Tensor

from ..geometry.transform.matrices import homogeneous
from ..geometry.transform.matrices3d import (
    get_affine_matrix3d,
    get_perspective_transform3d,
    get_projective_transform,
)
from ..geometry.transform.volume import warp_perspective3d
from ..primitives.core.checks import check_interval, check_triple
from ..primitives.linalg.matrices import inverse
from ..primitives.random.draws import between, check_seed, uniform
from ..primitives.resampling.volumes import check_volume
from .annotations import moved_mask
from .base import AugmentationBase3D, as_mode, identity
from .decisions import below, check_positive_bounds
from .settings import fixed, number, numbers, ranges

Range = Tuple[float, float]


def random_affine3d(
    input: Tensor,
    seed: Tensor,
    degrees: List[Tuple[float, float]],
    translate: Tuple[float, float, float] = (0.0, 0.0, 0.0),
    scale: Optional[List[Tuple[float, float]]] = None,
    shears: Optional[List[Tuple[float, float]]] = None,
    resample: str = "bilinear",
    align_corners: bool = False,
    p: float = 0.5,
) -> Tensor:
    """Shear, scale, rotate (about their centres) and translate some volumes, by ``get_affine_matrix3d``.

    Args:
        input: (B, C, D, H, W), floating point.
        seed: (B,), int64.
        degrees: the ranges of the components of the rotation vector along x, y and z, in degrees.
        translate: the largest translation to either side, as fractions of the width, the height and the
            depth.
        scale: one range of the scale factor for all axes, or three ranges, for x, y and z; 1 by default.
        shears: the six ranges of shearing angles in degrees, sxy, sxz, syx, syz, szx and szy; none by
            default.
        resample: "bilinear" (trilinear, of eight voxels) or "nearest".
        align_corners: for compatibility with Kornia; it has no effect, since pixels outside the image are
            black.
        p: the probability of each volume.

    Returns:
        (B, C, D, H, W). Differentiable in input.

    Raises:
        TypeError: if input is not floating point, or seed not int64.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> x, still = torch.arange(5.0).expand(1, 1, 3, 3, 5), [(0.0, 0.0)] * 3
        >>> random_affine3d(x, torch.tensor([0]), still, scale=[(2.0, 2.0)], p=1.0)[0, 0, 1, 1]
        tensor([1.0000, 1.5000, 2.0000, 2.5000, 3.0000])
    """
    _check(input, seed)
    params = _draw_affine(seed, list(input.shape), degrees, translate, scale, shears, p)
    return _warped(input, _affine_matrix(params), resample)


def random_rotation3d(
    input: Tensor,
    seed: Tensor,
    degrees: List[Tuple[float, float]],
    resample: str = "bilinear",
    align_corners: bool = False,
    p: float = 0.5,
) -> Tensor:
    """Rotate some volumes about their centres by rotation vectors, by ``rotate3d``.

    Args:
        input: (B, C, D, H, W), floating point.
        seed: (B,), int64.
        degrees: the ranges of the rotation vector's components along x, y and z (yaw, pitch, roll).
        resample: "bilinear" (trilinear, of eight voxels) or "nearest".
        align_corners: for compatibility with Kornia; it has no effect, since pixels outside the image are
            black.
        p: the probability of each volume.

    Returns:
        (B, C, D, H, W). Differentiable in input.

    Raises:
        TypeError: if input is not floating point, or seed not int64.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> x, about_z = torch.arange(4.0).reshape(1, 1, 1, 2, 2), [(0.0, 0.0), (0.0, 0.0), (180.0, 180.0)]
        >>> random_rotation3d(x, torch.tensor([0]), about_z, p=1.0)[0, 0, 0].round()
        tensor([[3., 2.],
                [1., 0.]])
    """
    _check(input, seed)
    params = _draw_rotation(seed, degrees, p)
    return _warped(input, _rotation_matrix(params, list(input.shape)), resample)


def random_perspective3d(
    input: Tensor,
    seed: Tensor,
    distortion_scale: float = 0.5,
    resample: str = "bilinear",
    align_corners: bool = False,
    p: float = 0.5,
) -> Tensor:
    """Warp some volumes by 3D homographies: each corner moves towards the centre independently, and
    ``get_perspective_transform3d`` computes the homography from the corners that it reads.

    Args:
        input: (B, C, D, H, W), floating point, D, H and W at least 2.
        seed: (B,), int64.
        distortion_scale: the largest move of a corner along each side, as a fraction of half the side, 0 to
            1.
        resample: "bilinear" (trilinear, of eight voxels) or "nearest".
        align_corners: for compatibility with Kornia; it has no effect, since pixels outside the image are
            black.
        p: the probability of each volume.

    Returns:
        (B, C, D, H, W). Differentiable in input.

    Raises:
        TypeError: if input is not floating point, or seed not int64.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> x = torch.arange(27.0).reshape(1, 1, 3, 3, 3)
        >>> random_perspective3d(x, torch.tensor([0]), 0.0, p=1.0).round().equal(x)
        True
    """
    _check(input, seed)
    params = _draw_perspective(seed, list(input.shape), distortion_scale, p)
    return _warped(input, _perspective_matrix(params), resample)


def _check(input: Tensor, seed: Tensor) -> None:
    check_volume(input, "input")
    check_seed(seed, input.size(0))


def _warped(input: Tensor, matrix: Tensor, resample: str) -> Tensor:
    return warp_perspective3d(input, matrix, (input.size(2), input.size(3), input.size(4)), resample)


def _chosen(matrix: Tensor, params: Dict[str, Tensor]) -> Tensor:
    """The matrices (B, 4, 4) of samples that "batch_prob" chooses, and the identity, which leaves a volume
    unchanged, for other samples."""
    eye = identity(params["batch_prob"], 4)
    return torch.where(params["batch_prob"][:, None, None], matrix.to(torch.float64), eye)


def _middle(like: Tensor, shape: List[int]) -> Tensor:
    """The centres (B, 3), float64, of volumes, (x, y, z)."""
    one = torch.ones_like(like, dtype=torch.float64)
    sides = [one * ((shape[4 - axis] - 1) * 0.5) for axis in range(3)]
    return torch.stack(sides, -1)


def _each_between(u: Tensor, bounds: List[Tuple[float, float]], name: str) -> Tensor:
    """Uniform numbers (B, N) in [0, 1), mapped to each column's bounds: (B, N)."""
    for interval in bounds:
        check_interval(interval, name)
    columns = [between(u[:, i], bounds[i][0], bounds[i][1]) for i in range(len(bounds))]
    return torch.stack(columns, -1)


def _draw_affine(
    seed: Tensor,
    shape: List[int],
    degrees: List[Tuple[float, float]],
    translate: Tuple[float, float, float],
    scale: Optional[List[Tuple[float, float]]],
    shears: Optional[List[Tuple[float, float]]],
    p: float,
) -> Dict[str, Tensor]:
    u = uniform(seed, 16)
    _check_count(len(degrees), [3], "degrees")
    check_triple(translate, "translate")
    sides = [
        between(u[:, 4], -translate[0], translate[0]) * shape[4],
        between(u[:, 5], -translate[1], translate[1]) * shape[3],
        between(u[:, 6], -translate[2], translate[2]) * shape[2],
    ]
    factors = torch.ones_like(u[:, 7:10])
    if scale is not None:
        _check_count(len(scale), [1, 3], "scale")
        for factor in scale:
            check_positive_bounds(factor, "scale")
        factors = _each_between(u[:, 7 : 7 + len(scale)], scale, "scale").expand(-1, 3)
    angles = torch.zeros_like(u[:, 10:16])
    if shears is not None:
        _check_count(len(shears), [6], "shears")
        angles = _each_between(u[:, 10:16], shears, "shears")
    return {
        "batch_prob": below(u[:, 0], p),
        "angles": _each_between(u[:, 1:4], degrees, "degrees"),
        "translations": torch.stack(sides, -1),
        "scale": factors,
        "shears": angles,
        "center": _middle(u[:, 0], shape),
    }


def _affine_matrix(params: Dict[str, Tensor]) -> Tensor:
    shears = params["shears"].to(torch.float64) * (math.pi / 180.0)
    matrix = get_affine_matrix3d(
        params["translations"].to(torch.float64),
        params["center"].to(torch.float64),
        params["scale"].to(torch.float64),
        params["angles"].to(torch.float64),
        shears[:, 0],
        shears[:, 1],
        shears[:, 2],
        shears[:, 3],
        shears[:, 4],
        shears[:, 5],
    )
    return _chosen(matrix, params)


def _draw_rotation(seed: Tensor, degrees: List[Tuple[float, float]], p: float) -> Dict[str, Tensor]:
    u = uniform(seed, 4)
    _check_count(len(degrees), [3], "degrees")
    return {"batch_prob": below(u[:, 0], p), "angles": _each_between(u[:, 1:], degrees, "degrees")}


def _rotation_matrix(params: Dict[str, Tensor], shape: List[int]) -> Tensor:
    angles = params["angles"].to(torch.float64)
    rotation = get_projective_transform(_middle(angles[:, 0], shape), angles, torch.ones_like(angles))
    return _chosen(homogeneous(rotation), params)


def _draw_perspective(seed: Tensor, shape: List[int], scale: float, p: float) -> Dict[str, Tensor]:
    if shape[2] < 2 or shape[3] < 2 or shape[4] < 2:
        # The corners would lie in a plane, and so determine no homography.
        raise ValueError(f"input: expected at least 2 voxels along each side, got {shape}")
    if not (scale >= 0.0 and scale <= 1.0):
        raise ValueError(f"distortion_scale: expected 0 to 1, got {scale}")
    u = uniform(seed, 25)
    front = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
    back = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0]]
    unit = torch.tensor(front + back, dtype=torch.float64, device=seed.device)
    last = 2.0 * _middle(u[:, 0], shape)[:, None]  # the last voxel of each axis
    start = unit * last
    moved = u[:, 1:].to(torch.float64).reshape(-1, 8, 3) * (1.0 - 2.0 * unit)
    return {
        "batch_prob": below(u[:, 0], p),
        "start_points": start,
        "end_points": start + moved * ((last + 1.0) * (0.5 * scale)),
    }


def _perspective_matrix(params: Dict[str, Tensor]) -> Tensor:
    start, end = params["start_points"].to(torch.float64), params["end_points"].to(torch.float64)
    return _chosen(get_perspective_transform3d(start, end), params)


def _check_count(count: int, known: List[int], name: str) -> None:
    if count not in known:
        raise ValueError(f"{name}: expected {known} ranges (least, greatest), got {count}")


class Warp3D(AugmentationBase3D):
    """An augmentation that samples volumes by the matrices of ``compute_transformation``.

    Args:
        resample: "bilinear" or "nearest".
        align_corners: for compatibility with Kornia; it has no effect.
        p, same_on_batch, keepdim: as in ``AugmentationBase``.
    """

    def __init__(
        self, resample: Any, align_corners: bool, p: float, same_on_batch: bool, keepdim: bool
    ) -> None:
        super().__init__(p, 1.0, same_on_batch, keepdim)
        self.resample, self.align_corners = as_mode(resample), align_corners
        if self.resample == "bicubic":
            raise ValueError("resample: expected 'bilinear' or 'nearest' for volumes, got 'bicubic'")

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return _warped(input, self.compute_transformation(params, list(input.shape)), self.resample)

    @torch.jit.unused
    def transform_mask(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        matrix = self.compute_transformation(params, list(input.shape))
        return moved_mask(input, lambda values, _: _warped(values, matrix, "nearest"))

    @torch.jit.unused
    def inverse_transform(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return _warped(input, inverse(self.compute_transformation(params, shape)), self.resample)

    @torch.jit.unused
    def inverse_mask(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        back = inverse(self.compute_transformation(params, shape))
        return moved_mask(input, lambda values, _: _warped(values, back, "nearest"))


class RandomAffine3D(Warp3D):
    """``random_affine3d`` as a module.

    Args:
        degrees: the ranges of the rotation vector's components along x, y and z: a number x, which means [-x,
            x] for all, (least, greatest) for all, three numbers, or three ranges.
        translate: the largest translation, as fractions of the width, the height and the depth; none by
            default.
        scale: the range of scale factors, or three ranges, for x, y and z; 1 by default.
        shears: the ranges of the six shearing angles in degrees, as ``degrees``; none by default.
        resample, align_corners: as in ``random_affine3d``.
        same_on_batch, p, keepdim: as in ``AugmentationBase``.

    Example:
        >>> augment = RandomAffine3D((15.0, 20.0, 20.0), scale=(0.8, 1.2), p=1.0)
        >>> augment(torch.rand(2, 3, 4, 5, 6)).shape
        torch.Size([2, 3, 4, 5, 6])
        >>> augment.transform_matrix.shape
        torch.Size([2, 4, 4])
    """

    degrees: List[Tuple[float, float]]
    scale: Optional[List[Tuple[float, float]]]
    shears: Optional[List[Tuple[float, float]]]

    def __init__(
        self,
        degrees: Any,
        translate: Optional[Any] = None,
        scale: Optional[Any] = None,
        shears: Optional[Any] = None,
        resample: Any = "bilinear",
        same_on_batch: bool = False,
        align_corners: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None:
        super().__init__(resample, align_corners, p, same_on_batch, keepdim)
        self.degrees = ranges("degrees", degrees, 3)
        moved = [0.0, 0.0, 0.0] if translate is None else numbers("translate", translate)
        if len(moved) != 3 or min(moved) < 0.0 or max(moved) > 1.0:
            raise ValueError(f"translate: expected three numbers of 0 to 1, got {translate}")
        self.translate = (moved[0], moved[1], moved[2])
        self.scale = None if scale is None else _factors(scale)
        self.shears = None if shears is None else ranges("shears", shears, 6)

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        return _draw_affine(seed, shape, self.degrees, self.translate, self.scale, self.shears, self.p)

    def compute_transformation(self, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return _affine_matrix(params)


def _factors(scale: Any) -> List[Range]:
    """One range of factors, or one for each axis."""
    rows = scale.tolist() if isinstance(scale, Tensor) else scale
    several = isinstance(rows, (list, tuple)) and len(rows) > 0 and isinstance(rows[0], (list, tuple))
    found = [fixed("scale", row) for row in (rows if several else [rows])]
    if len(found) not in (1, 3) or min(low for low, _ in found) <= 0.0:
        raise ValueError(f"scale: expected a range of positive factors, or three, got {scale}")
    return found


class RandomRotation3D(Warp3D):
    """``random_rotation3d`` as a module.

    Args:
        degrees: as in ``RandomAffine3D``.
        resample, align_corners: as in ``random_rotation3d``.
        same_on_batch, p, keepdim: as in ``AugmentationBase``.

    Example:
        >>> augment = RandomRotation3D((15.0, 20.0, 20.0), p=1.0)
        >>> augment(torch.rand(2, 3, 4, 5, 6)).shape
        torch.Size([2, 3, 4, 5, 6])
        >>> augment.transform_matrix.shape
        torch.Size([2, 4, 4])
    """

    degrees: List[Tuple[float, float]]

    def __init__(
        self,
        degrees: Any,
        resample: Any = "bilinear",
        same_on_batch: bool = False,
        align_corners: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None:
        super().__init__(resample, align_corners, p, same_on_batch, keepdim)
        self.degrees = ranges("degrees", degrees, 3)

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        return _draw_rotation(seed, self.degrees, self.p)

    def compute_transformation(self, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return _rotation_matrix(params, shape)


class RandomPerspective3D(Warp3D):
    """``random_perspective3d`` as a module.

    Args:
        distortion_scale, resample, align_corners: as in ``random_perspective3d``.
        same_on_batch, p, keepdim: as in ``AugmentationBase``.

    Example:
        >>> augment = RandomPerspective3D(0.5, p=1.0)
        >>> augment(torch.rand(2, 3, 4, 5, 6)).shape
        torch.Size([2, 3, 4, 5, 6])
        >>> augment.transform_matrix.shape
        torch.Size([2, 4, 4])
    """

    def __init__(
        self,
        distortion_scale: Any = 0.5,
        resample: Any = "bilinear",
        same_on_batch: bool = False,
        align_corners: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None:
        super().__init__(resample, align_corners, p, same_on_batch, keepdim)
        self.distortion_scale = number("distortion_scale", distortion_scale)
        if not 0.0 <= self.distortion_scale <= 1.0:
            raise ValueError(f"distortion_scale: expected 0 to 1, got {distortion_scale}")

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        return _draw_perspective(seed, shape, self.distortion_scale, self.p)

    def compute_transformation(self, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return _perspective_matrix(params)
