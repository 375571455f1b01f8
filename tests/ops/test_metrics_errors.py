"""Errors of flow, disparity and poses against scikit-learn, SciPy and plain definitions, also where they have
no derivative."""

import math
from typing import Callable

import numpy as np
import pytest
import torch
from photos import photo
from scipy.spatial.transform import Rotation
from sklearn.metrics import auc, mean_absolute_error, root_mean_squared_error
from torch import Tensor
from torch.autograd import gradcheck

from chiasm.metrics import (
    aepe,
    angle_error_mat,
    angle_error_vec,
    auc_from_errors,
    kitti_d1_error,
    mean_absolute_disparity_error,
    mean_bad_pixel_error,
    pose_errors,
    root_mean_squared_disparity_error,
    translation_ate,
)

DISPARITY = [
    mean_absolute_disparity_error,
    root_mean_squared_disparity_error,
    mean_bad_pixel_error,
    kitti_d1_error,
]
X = torch.zeros(1, 1, 4, 5)
EYE = torch.eye(3, dtype=torch.float64)


def randn(*shape: int, seed: int = 0) -> Tensor:
    return torch.randn(shape, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


# --- flow ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(7, 2), (1, 31, 17, 2), (3, 20, 33, 2)])
def test_aepe_is_the_mean_distance(shape: tuple[int, ...]) -> None:
    a, b = randn(*shape), randn(*shape, seed=1)
    expected = np.hypot(*np.moveaxis((a - b).numpy(), -1, 0))
    np.testing.assert_allclose(aepe(a, b), expected.mean(), rtol=1e-14)
    np.testing.assert_allclose(aepe(a, b, "sum"), expected.sum(), rtol=1e-14)
    np.testing.assert_allclose(aepe(a, b, "none"), expected, rtol=1e-14)


def test_no_error_has_no_gradient() -> None:
    for op in (aepe, root_mean_squared_disparity_error, mean_absolute_disparity_error):
        flow = torch.ones(3, 2, requires_grad=True)
        error = op(flow, flow.detach())
        error.backward()
        assert error.item() == 0.0 and flow.grad.abs().max() == 0.0


# --- disparity ----------------------------------------------------------------------------------------------


def disparities(batch: int, channels: int, dtype: torch.dtype) -> tuple[Tensor, Tensor, Tensor]:
    """Estimated and true disparities of up to 80 pixels, with small and large differences, and a mask of the
    known ones."""
    truth = 80.0 * photo(batch, channels, 37, 29, torch.float64)
    found = truth + randn(*truth.shape) * torch.where(randn(*truth.shape, seed=1) > 0.5, 6.0, 0.5)
    return found.to(dtype), truth.to(dtype), randn(*truth.shape, seed=2) > -0.4


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
@pytest.mark.parametrize(("batch", "channels"), [(1, 1), (3, 1), (3, 5)])
def test_disparity_errors_by_definition(batch: int, channels: int, dtype: torch.dtype) -> None:
    found, truth, valid = disparities(batch, channels, dtype)
    tolerance = 1e-6 if dtype == torch.float32 else 1e-13
    for mask in (None, valid):
        where = np.ones(found.shape, bool) if mask is None else mask.numpy()
        f, t = found.double().numpy()[where], truth.double().numpy()[where]
        for op, expected in (
            (DISPARITY[0], mean_absolute_error(t, f)),
            (DISPARITY[1], root_mean_squared_error(t, f)),
        ):
            actual = op(found, truth, valid_mask=mask)
            assert actual.dtype == dtype
            assert actual.item() == pytest.approx(expected, rel=tolerance)
        bad = sum(abs(a - b) > 2.0 for a, b in zip(f, t, strict=True))
        outliers = sum(abs(a - b) > 3.0 and abs(a - b) > 0.1 * b for a, b in zip(f, t, strict=True))
        assert 0 < outliers < bad < len(f)
        assert mean_bad_pixel_error(found, truth, 2.0, mask, "sum").item() == bad
        assert mean_bad_pixel_error(found, truth, 2.0, mask).item() == pytest.approx(bad / len(f))
        assert kitti_d1_error(found, truth, 3.0, 0.1, mask, "sum").item() == outliers
        assert kitti_d1_error(found, truth, 3.0, 0.1, mask).item() == pytest.approx(outliers / len(f))


@pytest.mark.parametrize("op", DISPARITY)
def test_disparity_reductions(op: Callable[..., Tensor]) -> None:
    found, truth, valid = disparities(2, 1, torch.float64)
    each = op(found, truth, valid_mask=valid, reduction="none")
    assert each.shape == found.shape and each[~valid].abs().max() == 0.0
    square = op is root_mean_squared_disparity_error
    total = op(found, truth, valid_mask=valid, reduction="sum")
    assert total.item() == pytest.approx((each**2).sum().sqrt().item() if square else each.sum().item())


@pytest.mark.parametrize("op", DISPARITY)
def test_unknown_disparities_may_be_anything(op: Callable[..., Tensor]) -> None:
    found, truth, valid = disparities(1, 3, torch.float64)
    spoiled = torch.where(valid, truth, torch.tensor([math.nan, math.inf])[torch.arange(29) % 2].double())
    found.requires_grad_(True)
    actual = op(found, spoiled, valid_mask=valid)
    assert torch.equal(actual, op(found, truth, valid_mask=valid))
    nothing = op(found, spoiled, valid_mask=torch.zeros_like(valid))
    assert torch.isnan(nothing)
    if op in DISPARITY[:2]:
        (actual + nothing).backward()
        assert torch.isfinite(found.grad).all() and found.grad[~valid].abs().max() == 0.0


def test_disparity_that_is_no_number_is_bad() -> None:
    found, truth = torch.tensor([math.nan, 10.0]), torch.tensor([10.0, 10.0])
    assert mean_bad_pixel_error(found, truth).item() == kitti_d1_error(found, truth).item() == 0.5


def test_counts_are_exact_beyond_float32() -> None:
    zeros = torch.zeros((1 << 24) + 1, dtype=torch.float64)
    assert mean_bad_pixel_error(zeros + 9.0, zeros, reduction="sum").item() == (1 << 24) + 1


def test_squares_of_half_precision_do_not_overflow() -> None:
    found = torch.full((10,), 300.0, dtype=torch.float16)
    assert root_mean_squared_disparity_error(found, torch.zeros_like(found)).item() == 300.0
    flow = torch.tensor([[300.0, 400.0], [3e-4, 4e-4]], dtype=torch.float16)
    lengths = torch.tensor([500.0, 5e-4], dtype=torch.float16)
    assert torch.equal(aepe(flow, torch.zeros_like(flow), "none"), lengths)
    assert aepe(flow.expand(200, 2, 2), torch.zeros(200, 2, 2).half(), "sum").item() == pytest.approx(
        100000.1
    )
    place = torch.nn.functional.pad(flow, [0, 1])
    assert torch.equal(translation_ate(place, torch.zeros_like(place)), lengths)


# --- angles -------------------------------------------------------------------------------------------------

DEGREES = (1e-5, 0.01, 1.0, 59.0, 90.0, 137.0, 179.9, 179.99999)


@pytest.mark.parametrize("angle", DEGREES)
def test_angle_of_matrices_equals_scipy(angle: float) -> None:
    axis = randn(5, 3)
    first = Rotation.random(5, rng=0)
    second = first * Rotation.from_rotvec(axis / axis.norm(dim=1, keepdim=True) * math.radians(angle))
    R1, R2 = torch.from_numpy(first.as_matrix()), torch.from_numpy(second.as_matrix())
    expected = np.degrees((first.inv() * second).magnitude())
    np.testing.assert_allclose(angle_error_mat(R1, R2), expected, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(angle_error_mat(R1.float(), R2.float()), expected, atol=3e-5)
    np.testing.assert_allclose(
        angle_error_mat(R2[None], R1[:, None]).diagonal(), expected, rtol=1e-9, atol=1e-9
    )


@pytest.mark.parametrize("axes", [2, 3, 7])
@pytest.mark.parametrize("angle", DEGREES)
def test_angle_of_vectors_is_theirs(angle: float, axes: int) -> None:
    q = torch.linalg.qr(randn(5, axes, 2))[0]
    u, across = q[..., 0], q[..., 1]
    v = (u * math.cos(math.radians(angle)) + across * math.sin(math.radians(angle))) * torch.tensor(
        [1e-3, 0.5, 1.0, 7.0, 1e6]
    )[:, None]
    np.testing.assert_allclose(angle_error_vec(3.0 * u, v), np.full(5, angle), atol=1e-9)
    np.testing.assert_allclose(angle_error_vec(u.float(), v.float()), np.full(5, angle), atol=3e-5)


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16, torch.float32, torch.float64])
def test_angle_of_vectors_of_any_length(dtype: torch.dtype) -> None:
    last, first = torch.finfo(dtype).max, torch.finfo(dtype).smallest_normal
    for scale in (last, 1.0, first):
        x, y = torch.tensor([scale, 0.0, 0.0], dtype=dtype), torch.tensor([0.0, scale, 0.0], dtype=dtype)
        diagonal = (x + y).requires_grad_()
        found = [angle_error_vec(v, w) for v in (x, y) for w in (x, y, -x, diagonal)]
        assert [round(a.item(), 1) for a in found] == [0.0, 90.0, 180.0, 45.0, 90.0, 0.0, 90.0, 45.0]
        assert all(a.dtype == dtype for a in found)
    mixed = angle_error_vec(x, torch.ones(3, dtype=torch.float64))
    assert mixed.dtype == torch.float64
    assert mixed.item() == pytest.approx(math.degrees(math.acos(3.0**-0.5)), rel=1e-12)


def test_vectors_without_direction_are_at_right_angles() -> None:
    zero, one = torch.zeros(3, requires_grad=True), torch.ones(3)
    for a, b in ((zero, one), (one, zero), (zero, zero)):
        angle = angle_error_vec(a, b)
        assert angle.item() == 90.0
        (grad,) = torch.autograd.grad(angle, zero)
        assert grad.abs().max() == 0.0


def test_angles_are_finite_where_they_have_no_derivative() -> None:
    half_turn = torch.diag(torch.tensor([1.0, -1.0, -1.0], dtype=torch.float64))
    for second, degrees in ((EYE, 0.0), (half_turn, 180.0)):
        R = EYE.clone().requires_grad_(True)
        angle = angle_error_mat(R, second)
        angle.backward()
        assert angle.item() == degrees and torch.isfinite(R.grad).all()
    for second, degrees in ((EYE[0], 0.0), (-EYE[0], 180.0)):
        v = EYE[0].clone().requires_grad_(True)
        angle = angle_error_vec(v, second)
        angle.backward()
        assert angle.item() == degrees and torch.isfinite(v.grad).all()


@pytest.mark.parametrize("folded", [True, False])
def test_pose_errors_are_those_of_their_parts(folded: bool) -> None:
    R = torch.from_numpy(Rotation.random(14, rng=1).as_matrix()).reshape(2, 7, 3, 3)
    R_gt = torch.from_numpy(Rotation.random(14, rng=2).as_matrix()).reshape(2, 7, 3, 3)
    t, t_gt = randn(2, 7, 3, 1), randn(2, 7, 3, 1, seed=1)
    P, P_gt = torch.cat([R, t], -1), torch.cat([R_gt, t_gt], -1)
    last = torch.tensor([0.0, 0.0, 0.0, 1.0], dtype=torch.float64).expand(2, 7, 1, 4)
    turned, moved = pose_errors(P, torch.cat([P_gt, last], -2), folded)
    expected = np.degrees(
        (
            Rotation.from_matrix(R.reshape(-1, 3, 3)).inv() * Rotation.from_matrix(R_gt.reshape(-1, 3, 3))
        ).magnitude()
    )
    np.testing.assert_allclose(turned.flatten(), expected, rtol=1e-9)
    cosine = ((t * t_gt).sum((-2, -1)) / t.norm(dim=-2)[..., 0] / t_gt.norm(dim=-2)[..., 0]).numpy()
    np.testing.assert_allclose(moved, np.degrees(np.arccos(np.abs(cosine) if folded else cosine)), rtol=1e-9)


def test_ate_is_the_distance() -> None:
    a, b = randn(3, 9, 3).requires_grad_(True), randn(9, 3, seed=1)
    np.testing.assert_allclose(
        translation_ate(a, b).detach(), np.linalg.norm((a - b).detach().numpy(), axis=-1), rtol=1e-14
    )
    (grad,) = torch.autograd.grad(translation_ate(a, a.detach()).sum(), a)
    assert grad.abs().max() == 0.0


# --- area under the curve -----------------------------------------------------------------------------------


def area(errors: np.ndarray, threshold: float) -> float:
    """The area under the curve, computed point by point."""
    rising = np.sort(errors[errors < threshold])
    recall = np.arange(len(rising) + 1) / len(errors)
    x, y = np.concatenate([[0.0], rising, [threshold]]), np.concatenate([recall, recall[-1:]])
    return auc(x, y) / threshold


@pytest.mark.parametrize("count", [1, 2, 101])
def test_area_equals_sklearn(count: int) -> None:
    errors = 20.0 * torch.rand(count, generator=torch.Generator().manual_seed(3), dtype=torch.float64)
    thresholds = [1.0, 5.0, 10.0, 30.0]
    expected = [area(errors.numpy(), t) for t in thresholds]
    np.testing.assert_allclose(auc_from_errors(errors, thresholds), expected, rtol=1e-13)
    np.testing.assert_allclose(
        auc_from_errors(errors.float().reshape(1, -1), thresholds), expected, rtol=1e-6
    )


def test_area_of_equal_errors_and_of_failures() -> None:
    errors = torch.tensor([0.0, 2.0, 2.0, 3.0, math.inf, math.nan], dtype=torch.float64)
    finite = np.array([0.0, 2.0, 2.0, 3.0, 99.0, 99.0])
    np.testing.assert_allclose(
        auc_from_errors(errors, [3.0, 4.0]), [area(finite, 3.0), area(finite, 4.0)], rtol=1e-14
    )
    assert auc_from_errors(torch.full((3,), math.inf)).tolist() == [0.0] * 4
    assert auc_from_errors(torch.zeros(3)).tolist() == [1.0] * 4


def test_area_has_a_gradient() -> None:
    errors = torch.tensor([0.5, 2.5, 7.0, 11.0], dtype=torch.float64, requires_grad=True)
    assert gradcheck(lambda e: auc_from_errors(e, [3.0, 8.0]), errors)


WRONG = [
    (lambda: aepe(X, X), ValueError, r"input: expected shape \(\*, 2\), got \[1, 1, 4, 5\]"),
    (
        lambda: aepe(X[..., :2], X[0, ..., :2]),
        ValueError,
        r"target: expected input's shape \[1, 1, 4, 2\], got \[1, 4, 2\]",
    ),
    (lambda: aepe(X[..., :2], X[..., :2], "max"), ValueError, "reduction: expected one of .*'max'"),
    (lambda: mean_bad_pixel_error(X, X, -1.0), ValueError, "threshold: expected zero or more, got -1.0"),
    (lambda: kitti_d1_error(X, X, -1.0), ValueError, "abs_threshold: expected zero or more"),
    (lambda: kitti_d1_error(X, X, 1.0, -1.0), ValueError, "rel_threshold: expected zero or more"),
    (lambda: angle_error_mat(X, EYE), ValueError, r"R1: expected shape \(\*, 3, 3\)"),
    (lambda: angle_error_mat(EYE, EYE.int()), TypeError, "R2: expected a floating-point"),
    (
        lambda: angle_error_vec(EYE, EYE[:, :2]),
        ValueError,
        r"v2: expected shape \(\*, D\) for v1 \[3, 3\], got \[3, 2\]",
    ),
    (lambda: angle_error_vec(EYE[:, :0], EYE[:, :0]), ValueError, r"v1: expected shape .*D at least 1"),
    (lambda: angle_error_vec(torch.tensor(1.0), EYE[0]), ValueError, r"v1: expected shape .*got \[\]"),
    (lambda: angle_error_vec(EYE.int(), EYE), TypeError, "v1: expected a floating-point"),
    (
        lambda: pose_errors(EYE, EYE),
        ValueError,
        r"P: expected shape \(\*, 3, 4\) or \(\*, 4, 4\), got \[3, 3\]",
    ),
    (lambda: pose_errors(torch.eye(4), torch.eye(4).int()), TypeError, "P_gt: expected a floating-point"),
    (lambda: translation_ate(EYE, X), ValueError, r"t_gt: expected shape \(\*, 3\)"),
    (lambda: auc_from_errors(EYE.int()), TypeError, "errors: expected a floating-point"),
    (lambda: auc_from_errors(EYE[:0]), ValueError, "errors: expected at least one, got none"),
    (lambda: auc_from_errors(EYE, []), ValueError, "thresholds: expected at least one, got none"),
    (lambda: auc_from_errors(EYE, [1.0, 0.0]), ValueError, "thresholds: expected positive numbers, got 0.0"),
]
WRONG += [
    case
    for op in DISPARITY
    for case in (
        (lambda op=op: op(X.int(), X), TypeError, "input: expected a floating-point"),
        (lambda op=op: op(X, X.int()), TypeError, "target: expected a floating-point"),
        (lambda op=op: op(X, X[0]), ValueError, "target: expected input's shape"),
        (
            lambda op=op: op(X, X, valid_mask=X),
            TypeError,
            "valid_mask: expected a bool tensor, got dtype torch.float32",
        ),
        (lambda op=op: op(X, X, valid_mask=X[0] > 0), ValueError, "valid_mask: expected input's shape"),
        (lambda op=op: op(X, X, reduction="max"), ValueError, "reduction: expected one of .*'max'"),
    )
]


@pytest.mark.parametrize("call, error, message", WRONG)
def test_wrong_arguments(call, error, message) -> None:
    with pytest.raises(error, match=message):
        call()
