"""Lie groups against matrix exponentials: the group's, the adjoint's, and the integral that a Jacobian is."""

import math
from typing import Callable

import numpy as np
import pytest
import torch
from scipy.linalg import expm, logm
from torch import Tensor

from chiasm.geometry import lie

GROUPS = {"so2": 1, "so3": 3, "se2": 3, "se3": 6}
ANGLES = [0.0, 1e-12, 1e-6, 1e-3, 0.5, 1.999, 2.001, 3.0, math.pi - 1e-3, math.pi - 1e-6]
every_group = pytest.mark.parametrize("group", GROUPS)


def op(group: str, name: str) -> Callable[[Tensor], Tensor]:
    return getattr(lie, f"{group}_{name}")


def tangents(group: str, angle: float, count: int = 4) -> Tensor:
    """Tangents that rotate by `angle`, some in the opposite direction."""
    random = np.random.default_rng(0)
    sign = np.array([1.0, -1.0] * (count // 2))[:, None]
    axis = random.normal(size=(count, 3 if group[-1] == "3" else 1))
    turn = sign * angle * axis / np.linalg.norm(axis, axis=1, keepdims=True)
    if group == "so2":
        return torch.from_numpy(turn[:, 0])
    dimensions = int(group[-1])
    velocity = random.normal(size=(count, dimensions)) if group[1] == "e" else np.zeros((count, 0))
    return torch.from_numpy(np.concatenate([velocity, turn], 1))


def hats(group: str, v: Tensor) -> np.ndarray:
    """The generators' sum, entry by entry from the definition."""
    v = v.numpy().reshape(len(v), -1)
    n = int(group[-1])
    made = np.zeros((len(v), n + (group[1] == "e"), n + (group[1] == "e")))
    if group[1] == "e":
        made[:, :n, n] = v[:, :n]
    turn = v[:, -1:] if n == 2 else v[:, -3:]
    if n == 2:
        made[:, 1, 0], made[:, 0, 1] = turn[:, 0], -turn[:, 0]
    else:
        for axis, (i, j) in enumerate(((2, 1), (0, 2), (1, 0))):
            made[:, i, j], made[:, j, i] = turn[:, axis], -turn[:, axis]
    return made


def brackets(group: str, v: Tensor) -> np.ndarray:
    """ad(v) with ad(v) u = vee([hat(v), hat(u)]), from commutators of generators."""
    size = GROUPS[group]
    basis = torch.eye(size, dtype=torch.float64) if group != "so2" else torch.ones(1, dtype=torch.float64)
    columns = [hats(group, v) @ g - g @ hats(group, v) for g in hats(group, basis)]
    return np.stack(
        [op(group, "vee")(torch.from_numpy(c)).numpy().reshape(len(v), size) for c in columns], -1
    )


def mean_exponential(m: np.ndarray) -> np.ndarray:
    """The integral of expm(s m) over s from 0 to 1, a corner of a larger exponential (C. Van Loan, 1978)."""
    n = len(m)
    return expm(np.block([[m, np.eye(n)], [np.zeros((n, 2 * n))]]))[:n, n:]


def close(actual: Tensor, expected: object, dtype: torch.dtype = torch.float64) -> None:
    assert actual.dtype == dtype
    np.testing.assert_allclose(actual.numpy(), expected, atol=1e-12 if dtype == torch.float64 else 2e-6)


@every_group
def test_hat_and_vee(group: str) -> None:
    v = tangents(group, 0.7)
    close(op(group, "hat")(v), hats(group, v))
    close(op(group, "vee")(op(group, "hat")(v)), v)


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
@pytest.mark.parametrize("angle", [*ANGLES, math.pi, 5.0, 7.0])
@every_group
def test_exp(group: str, angle: float, dtype: torch.dtype) -> None:
    v = tangents(group, angle)
    close(op(group, "exp")(v.to(dtype)), [expm(h) for h in hats(group, v)], dtype)


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
@pytest.mark.parametrize("angle", ANGLES)
@every_group
def test_log(group: str, angle: float, dtype: torch.dtype) -> None:
    v = tangents(group, angle)
    elements = torch.from_numpy(np.stack([expm(h) for h in hats(group, v)]))
    close(op(group, "log")(elements.to(dtype)), v, dtype)
    if angle in (0.5, 2.001):
        close(op(group, "hat")(op(group, "log")(elements)), [logm(e).real for e in elements.numpy()])


@every_group
def test_log_at_half_a_turn(group: str) -> None:
    """Either axis is right: the exponentials are the same."""
    element = op(group, "exp")(tangents(group, math.pi)).requires_grad_(True)
    v = op(group, "log")(element)
    np.testing.assert_allclose(op(group, "exp")(v).detach(), element.detach(), atol=1e-7)
    v.sum().backward()
    assert torch.isfinite(element.grad).all()


@every_group
def test_adjoint(group: str) -> None:
    """exp(Ad v) = g exp(v) g^-1, and Ad exp(v) = exp(ad v)."""
    v, size = tangents(group, 1.2), GROUPS[group]
    ad = op(group, "adjoint")(op(group, "exp")(v))
    close(ad, [expm(b) for b in brackets(group, v)])
    g, u = op(group, "exp")(v).numpy(), tangents(group, 0.3)
    moved = (ad @ u.reshape(len(u), size, 1)).reshape(u.shape)
    np.testing.assert_allclose(
        op(group, "exp")(moved), g @ op(group, "exp")(u).numpy() @ np.linalg.inv(g), atol=1e-12
    )


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
@pytest.mark.parametrize("angle", [*ANGLES, math.pi, 5.0, 7.0])
@every_group
def test_jacobians(group: str, angle: float, dtype: torch.dtype) -> None:
    v = tangents(group, angle)
    ad = brackets(group, v)
    close(op(group, "left_jacobian")(v.to(dtype)), [mean_exponential(a) for a in ad], dtype)
    close(op(group, "right_jacobian")(v.to(dtype)), [mean_exponential(-a) for a in ad], dtype)


@every_group
def test_jacobians_are_derivatives(group: str) -> None:
    """exp(v + d) = exp(J d) exp(v) and exp(v) exp(J d) to first order."""
    v, size = tangents(group, 1.1), GROUPS[group]
    d = 1e-6 * torch.ones_like(v)
    moved, at = op(group, "exp")(v + d), op(group, "exp")(v)
    for side in ("left", "right"):
        step = (op(group, f"{side}_jacobian")(v) @ d.reshape(len(v), size, 1)).reshape(v.shape)
        step = op(group, "exp")(step)
        np.testing.assert_allclose(moved, step @ at if side == "left" else at @ step, atol=1e-10)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1.0, 2.0, math.pi - 1e-4])
@every_group
def test_gradients(group: str, angle: float) -> None:
    v = tangents(group, angle, 2)
    for name in ("exp", "left_jacobian", "right_jacobian"):
        active = v.clone().requires_grad_(True)
        if op(group, name)(active).requires_grad:  # so2's is constant
            assert torch.autograd.gradcheck(op(group, name), (active,), atol=1e-6), name
    there = torch.autograd.functional.jacobian(lambda u: op(group, "log")(op(group, "exp")(u)), v)
    np.testing.assert_allclose(there.reshape(v.numel(), v.numel()), np.eye(v.numel()), atol=1e-6)


@every_group
def test_batches_of_any_shape(group: str) -> None:
    v = tangents(group, 0.8, 6)
    many = v.reshape(2, 3, *v.shape[1:])
    for name in ("exp", "hat", "left_jacobian"):
        result = op(group, name)(v)
        torch.testing.assert_close(op(group, name)(many), result.reshape(2, 3, *result.shape[1:]))
        torch.testing.assert_close(op(group, name)(v[0]), result[0])
    torch.testing.assert_close(op(group, "log")(op(group, "exp")(many)), many)


WRONG = [
    (lambda: lie.so2_exp(torch.zeros(2).int()), TypeError, "theta: expected a floating-point"),
    (
        lambda: lie.so2_log(torch.zeros(3, 3)),
        ValueError,
        r"rotation: expected shape \(\*, 2, 2\), got \[3, 3\]",
    ),
    (lambda: lie.so3_exp(torch.zeros(2)), ValueError, r"v: expected shape \(\*, 3\)"),
    (lambda: lie.so3_log(torch.zeros(2, 2)), ValueError, r"rotation: expected shape \(\*, 3, 3\)"),
    (lambda: lie.so3_hat(torch.zeros(2)), ValueError, r"v: expected shape \(\*, 3\)"),
    (lambda: lie.se2_log(torch.zeros(2, 3)), ValueError, r"motion: expected shape \(\*, 3, 3\)"),
    (lambda: lie.se3_exp(torch.zeros(3)), ValueError, r"v: expected shape \(\*, 6\)"),
    (lambda: lie.se3_adjoint(torch.zeros(3, 3)), ValueError, r"motion: expected shape \(\*, 4, 4\)"),
    (lambda: lie.se3_vee(torch.zeros(3, 3)), ValueError, r"omega: expected shape \(\*, 4, 4\)"),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
