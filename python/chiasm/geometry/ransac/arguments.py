"""Checks of the estimators' arguments."""

from torch import Tensor

from ...primitives.core.checks import check_floating, check_one_for_each, check_rank, check_same_leading


def check_arguments(
    points1: Tensor,
    points2: Tensor,
    uniforms: Tensor,
    least: int,
    sample: int,
    inl_th: float,
    refinements: int,
) -> None:
    """Raise unless the arguments fit an estimator with samples of size ``sample`` and at least ``least``
    points."""
    check_floating(points1, "points1")
    check_floating(points2, "points2")
    check_floating(uniforms, "uniforms")
    if points1.dim() != 3 or points1.size(2) != 2 or points1.size(1) < least:
        raise ValueError(
            f"points1: expected shape (B, N, 2) with N of at least {least}, got {list(points1.shape)}"
        )
    if points2.dim() != 3 or points2.size(2) != 2 or points2.size(1) != points1.size(1):
        raise ValueError(
            f"points2: expected shape (B, {points1.size(1)}, 2) like points1, got {list(points2.shape)}"
        )
    check_same_leading([points1, points2], ["points1", "points2"], [2, 2])
    check_rank(uniforms, 3, f"(B, S, {sample})", "uniforms")
    if uniforms.size(2) != sample or uniforms.size(1) < 1:
        raise ValueError(
            f"uniforms: expected shape (B, S, {sample}) with S of at least 1, got {list(uniforms.shape)}"
        )
    check_one_for_each(uniforms, points1, "uniforms", "points1")
    if not inl_th > 0.0:
        raise ValueError(f"inl_th: expected a positive number, got {inl_th}")
    if refinements < 0:
        raise ValueError(f"refinements: expected at least 0, got {refinements}")
