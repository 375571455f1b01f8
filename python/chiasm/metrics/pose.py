"""Errors of camera poses, and the area under the curve of recall."""

import math
from typing import List, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_last, check_leading, check_matrix, check_tensor
from ..primitives.geometry.angles import angle_of
from ..primitives.linalg.matrices import cross
from ..primitives.numbers.loss_reduction import widened
from .reductions import vector_length


def angle_error_mat(R1: Tensor, R2: Tensor) -> Tensor:
    """Angle of the rotation between two rotations, in degrees.

    Computed from the sine and the cosine of R1^T R2. This is accurate for small angles, unlike the arc cosine
    of the trace, whose limit in float32 is 0.02 degrees.

    Args:
        R1: (*, 3, 3), rotation matrices, floating point.
        R2: like R1.

    Returns:
        (*), in [0, 180]. At 0 and 180 the derivatives are 0.

    Raises:
        TypeError, ValueError: if R1 or R2 is not a floating-point (*, 3, 3) tensor.

    Example:
        >>> angle_error_mat(torch.eye(3), torch.tensor([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
        tensor(90.)
    """
    check_matrix(R1, 3, 3, "R1")
    check_matrix(R2, 3, 3, "R2")
    check_leading([R1, R2], ["R1", "R2"], [2, 2])
    # R1^T R2 is the sum of outer products of rows: its antisymmetric part is the sum of cross products, its
    # trace the sum of dot products.
    a, b = widened(R1), widened(R2)
    sine = 0.5 * vector_length(cross(a, b).sum(-2))
    cosine = 0.5 * ((a * b).sum(-1).sum(-1) - 1.0)
    return (angle_of(sine, cosine) * (180.0 / math.pi)).to(torch.promote_types(R1.dtype, R2.dtype))


def angle_error_vec(v1: Tensor, v2: Tensor) -> Tensor:
    """Angle between the directions of two vectors, in degrees.

    Computed as twice the arc tangent of |u - w| / |u + w| of the unit vectors (W. Kahan), which is accurate
    for small angles and for nearly opposite vectors. The lengths are computed in float64.

    Args:
        v1: (*, D), D at least 1, floating point, of any length.
        v2: like v1.

    Returns:
        (*), in [0, 180]; 90 if a vector is zero, since it has no direction and must not count as correct. In
        this case, and at 0 and 180, the derivatives are 0.

    Raises:
        TypeError: if v1 or v2 is not floating point.
        ValueError: if v1 or v2 has no dimension or no component, or the last ones are not of one size.

    Example:
        >>> angle_error_vec(torch.tensor([1.0, 0.0, 0.0]), torch.tensor([0.0, 3.0, 0.0]))
        tensor(90.)
    """
    check_floating(v1, "v1")
    check_floating(v2, "v2")
    if v1.dim() < 1 or v1.size(-1) < 1:
        raise ValueError(f"v1: expected shape (*, D), D at least 1, got {list(v1.shape)}")
    if v2.dim() < 1 or v1.size(-1) != v2.size(-1):
        raise ValueError(f"v2: expected shape (*, D) for v1 {list(v1.shape)}, got {list(v2.shape)}")
    check_leading([v1, v2], ["v1", "v2"], [1, 1])
    a, b = _scaled(v1), _scaled(v2)
    length1, length2 = vector_length(a), vector_length(b)
    lost = (length1 == 0) | (length2 == 0)
    u = a / torch.where(lost, torch.ones_like(length1), length1)[..., None]
    w = b / torch.where(lost, torch.ones_like(length2), length2)[..., None]
    # ONNX Runtime has no arc tangent of float64, so float32 vectors need one of float32.
    wide = torch.promote_types(widened(v1).dtype, widened(v2).dtype)
    across, along = vector_length(u - w).to(wide), vector_length(u + w).to(wide)
    angle = 2.0 * angle_of(across, torch.where(lost, torch.ones_like(along), along))
    degrees = torch.where(lost, torch.full_like(angle, 90.0), angle * (180.0 / math.pi))
    return degrees.to(torch.promote_types(v1.dtype, v2.dtype))


def pose_errors(P: Tensor, P_gt: Tensor, fold_translation: bool = True) -> Tuple[Tensor, Tensor]:
    """Errors of poses [R | t] with unknown length of t: the angles between rotations and between
    translations, in degrees.

    Args:
        P: (*, 3, 4) or (*, 4, 4), the estimated poses, floating point.
        P_gt: the true poses, in either form.
        fold_translation: True treats t and -t as the same direction, since an essential matrix does not
            distinguish them: the second error is then at most 90.

    Returns:
        (*) and (*): of the rotations (`angle_error_mat`) and of the translations (`angle_error_vec`).
        Kornia returns a dict, which artifacts cannot return. The usual input of `auc_from_errors` is
        `torch.maximum` of both.

    Raises:
        TypeError, ValueError: if P or P_gt is not a floating-point (*, 3, 4) or (*, 4, 4) tensor.

    Example:
        >>> pose_errors(torch.eye(4), torch.eye(4))
        (tensor(0.), tensor(90.))
    """
    _check_pose(P, "P")
    _check_pose(P_gt, "P_gt")
    check_leading([P, P_gt], ["P", "P_gt"], [2, 2])
    turned = angle_error_mat(P[..., :3, :3], P_gt[..., :3, :3])
    moved = angle_error_vec(P[..., :3, 3], P_gt[..., :3, 3])
    if fold_translation:
        moved = torch.minimum(moved, 180.0 - moved)
    return turned, moved


def translation_ate(t: Tensor, t_gt: Tensor) -> Tensor:
    """Absolute translation error: the distance between two positions.

    J. Sturm et al., A benchmark for the evaluation of RGB-D SLAM systems, IROS 2012, here for one pose of an
    aligned trajectory. The error of a trajectory is the root of the mean of its squares.

    Args:
        t: (*, 3), the estimated positions, floating point.
        t_gt: (*, 3), the true positions.

    Returns:
        (*), in the unit of the positions.

    Raises:
        TypeError, ValueError: if t or t_gt is not a floating-point (*, 3) tensor.

    Example:
        >>> translation_ate(torch.tensor([1.0, 2.0, 2.0]), torch.zeros(3))
        tensor(3.)
    """
    check_last(t, 3, "t")
    check_last(t_gt, 3, "t_gt")
    check_leading([t, t_gt], ["t", "t_gt"], [1, 1])
    return vector_length(t - t_gt)


def auc_from_errors(
    errors: Tensor,
    thresholds: List[float] = (1.0, 3.0, 5.0, 10.0),  # pyright: ignore[reportArgumentType]
) -> Tensor:
    """Area under the curve (AUC) of recall, the share of errors up to e, for e from 0 to a threshold.

    The area is divided by the threshold. P.-E. Sarlin et al., SuperGlue, CVPR 2020, section 5.2: the curve
    starts at (0, 0), is linear from one error to the next, and constant after the last error below the
    threshold. Its area is the sum of (threshold - error) over the errors below the threshold, plus half the
    largest of them, divided by the number of errors: no sort is needed.

    Args:
        errors: (*), at least one, floating point and not negative; those that are infinite or NaN are
            failures.
        thresholds: numbers above 0.

    Returns:
        (K,) in errors' dtype, in [0, 1]: an area for each threshold, in their order. Kornia returns a dict
        from threshold to number, which artifacts cannot return; use ``dict(zip(thresholds,
        areas.tolist()))``.

    Raises:
        TypeError: if errors is not floating point.
        ValueError: if errors or thresholds is empty, or a threshold is not positive.

    Example:
        >>> auc_from_errors(torch.tensor([0.0, 1.0, 20.0, 30.0]), [2.0, 10.0])
        tensor([0.4375, 0.4875])
    """
    check_floating(errors, "errors")
    e = errors.to(torch.float64).reshape(-1)
    if e.size(0) < 1:
        raise ValueError("errors: expected at least one, got none")
    if len(thresholds) == 0:
        raise ValueError("thresholds: expected at least one, got none")
    areas: List[Tensor] = []
    for t in thresholds:
        if not t > 0:
            raise ValueError(f"thresholds: expected positive numbers, got {t}")
        below = e < t
        sure = torch.where(below, e, torch.zeros_like(e))
        gain = torch.where(below, t - sure, torch.zeros_like(e)).mean()
        areas.append((gain + sure.amax(0) / (2.0 * e.size(0))) / t)
    return torch.stack(areas).to(errors.dtype)


def _scaled(v: Tensor) -> Tensor:
    """Vectors in float64, of lengths whose squares float64 has."""
    if v.dtype != torch.float64:
        return v.to(torch.float64)
    largest = v.detach().abs().amax(-1, keepdim=True)
    return v / torch.where(largest == 0, torch.ones_like(largest), largest)


def _check_pose(value: Tensor, name: str) -> None:
    check_tensor(value, name)
    if value.dim() < 2 or value.size(-1) != 4 or (value.size(-2) != 3 and value.size(-2) != 4):
        raise ValueError(f"{name}: expected shape (*, 3, 4) or (*, 4, 4), got {list(value.shape)}")
    check_floating(value, name)
