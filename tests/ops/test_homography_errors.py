"""Transfer errors by definition, and homographies from segments and from points with outliers."""

import cv2
import numpy as np
import pytest
import torch
from test_homography import apply, points, truth
from torch import Tensor

from chiasm.geometry import homography

DOUBLE = torch.float64


def pairs(noise: float = 3.0) -> tuple[Tensor, Tensor, Tensor]:
    H = truth(2, DOUBLE)
    p = points(2, 9)
    return (
        p,
        apply(H, p) + noise * torch.randn(2, 9, 2, generator=torch.Generator().manual_seed(1), dtype=DOUBLE),
        H,
    )


def by_opencv(H: np.ndarray, p: np.ndarray) -> np.ndarray:
    return cv2.perspectiveTransform(p[None], H)[0]


@pytest.mark.parametrize("homogeneous", [False, True])
def test_transfer_errors(homogeneous: bool) -> None:
    p, q, H = pairs()
    given = (
        [torch.cat([x, torch.ones_like(x[..., :1])], -1) * -2.5 for x in (p, q)] if homogeneous else [p, q]
    )
    for b in range(2):
        there = ((q[b].numpy() - by_opencv(H[b].numpy(), p[b].numpy())) ** 2).sum(1)
        back = ((p[b].numpy() - by_opencv(np.linalg.inv(H[b].numpy()), q[b].numpy())) ** 2).sum(1)
        np.testing.assert_allclose(homography.oneway_transfer_error(*given, H)[b], there, rtol=1e-9)
        np.testing.assert_allclose(
            homography.oneway_transfer_error(*given, H, False, 0.0)[b], np.sqrt(there), rtol=1e-9
        )
        np.testing.assert_allclose(homography.symmetric_transfer_error(*given, H)[b], there + back, rtol=1e-9)
        np.testing.assert_allclose(
            homography.symmetric_transfer_error(*given, H, False, 0.0)[b], np.sqrt(there + back), rtol=1e-9
        )


def test_no_inverse_is_infinitely_far() -> None:
    p, q, H = pairs()
    flat = H.clone()
    flat[1, 2] = 0.0
    H = flat.requires_grad_(True)
    error = homography.symmetric_transfer_error(p, q, H)
    assert error[0].isfinite().all() and error[1].isinf().all()
    error[0].sum().backward()
    assert H.grad.isfinite().all()


def test_sampson_distance() -> None:
    """e^T (J J^T)^-1 e with J by autograd; for small errors it is near the true distance, found by Newton's
    method."""
    p, q, H = pairs(0.5)
    found = homography.sampson_homography_distance(p, q, H)
    np.testing.assert_allclose(homography.sampson_homography_distance(p, q, H, False), found.sqrt())
    for b in range(2):
        for n in range(9):
            x = torch.cat([p[b, n], q[b, n]])

            def residual(x: Tensor, b: int = b) -> Tensor:
                m = H[b] @ torch.cat([x[:2], x.new_ones(1)])
                return m[:2] - x[2:] * m[2]

            def step(at: Tensor, x: Tensor = x, residual=residual) -> Tensor:
                """From x to the nearest point on the tangent at `at`."""
                J = torch.autograd.functional.jacobian(residual, at)
                return x - J.T @ torch.linalg.solve(J @ J.T, residual(at) + J @ (x - at))

            first = step(x)
            np.testing.assert_allclose(found[b, n], ((first - x) ** 2).sum(), rtol=1e-9)
            nearest = step(step(step(first)))
            np.testing.assert_allclose(found[b, n], ((nearest - x) ** 2).sum(), rtol=1e-2)


def test_exact_points_have_no_error_and_a_gradient() -> None:
    p = points(2, 9)
    eye = torch.eye(3, dtype=DOUBLE).repeat(2, 1, 1).requires_grad_(True)
    for name in ("oneway_transfer_error", "symmetric_transfer_error", "sampson_homography_distance"):
        error = getattr(homography, name)(p, p, eye, False)
        (gradient,) = torch.autograd.grad(error.sum(), eye)
        assert error.max() < 1e-3 and gradient.isfinite().all(), name


def segments(count: int, seed: int = 0) -> tuple[Tensor, Tensor, Tensor]:
    """Segments, and segments on the same lines mapped by a homography, with other end points."""
    H = truth(2, DOUBLE)
    ends = points(2, 2 * count, seed)
    moved = apply(H, ends).reshape(2, count, 2, 2)
    along = torch.tensor([[0.9, 0.1], [-0.2, 1.2]], dtype=DOUBLE)
    return ends.reshape(2, count, 2, 2), along @ moved, H


@pytest.mark.parametrize("count", [4, 5, 30])
def test_segments_find_the_truth(count: int) -> None:
    ls1, ls2, H = segments(count)
    np.testing.assert_allclose(homography.find_homography_lines_dlt(ls1, ls2), H, rtol=1e-5, atol=1e-7)
    error = homography.line_segment_transfer_error_one_way(ls1, ls2, H)
    np.testing.assert_allclose(error, np.zeros((2, count)), atol=1e-9)
    single = homography.find_homography_lines_dlt(ls1.float(), ls2.float())
    assert homography.line_segment_transfer_error_one_way(ls1, ls2, single.double()).max() < 0.5


def test_segment_error_is_a_distance() -> None:
    ls1, ls2, H = segments(6)
    line = ls2[..., 1, :] - ls2[..., 0, :]
    normal = torch.stack([-line[..., 1], line[..., 0]], -1) / line.norm(dim=-1, keepdim=True)
    error = homography.line_segment_transfer_error_one_way(ls1, ls2 + 3.0 * normal[:, :, None], H)
    np.testing.assert_allclose(error, np.full((2, 6), 3.0), rtol=1e-9)
    squared = homography.line_segment_transfer_error_one_way(ls1, ls2 + 3.0 * normal[:, :, None], H, True)
    np.testing.assert_allclose(squared, np.full((2, 6), 9.0), rtol=1e-9)


def test_noisy_segments_equal_the_svd() -> None:
    ls1, ls2, _ = segments(12)
    ls2 = ls2 + torch.randn(ls2.shape, generator=torch.Generator().manual_seed(3), dtype=DOUBLE)
    weights = 0.5 + torch.rand(2, 12, generator=torch.Generator().manual_seed(4), dtype=DOUBLE)
    found = homography.find_homography_lines_dlt(ls1, ls2, weights)
    for b in range(2):
        np.testing.assert_allclose(
            found[b], lines_by_svd(ls1[b].numpy(), ls2[b].numpy(), weights[b].numpy()), rtol=1e-5, atol=1e-8
        )


def lines_by_svd(ls1: np.ndarray, ls2: np.ndarray, weights: np.ndarray) -> np.ndarray:
    def hartley(x: np.ndarray) -> np.ndarray:
        c = x.mean(0)
        s = np.sqrt(2) / np.linalg.norm(x - c, axis=1).mean()
        return np.array([[s, 0, -s * c[0]], [0, s, -s * c[1]], [0, 0, 1]])

    t1, t2 = hartley(ls1.reshape(-1, 2)), hartley(ls2.reshape(-1, 2))
    p, q = (np.concatenate([x, np.ones((*x.shape[:2], 1))], -1) @ t.T for x, t in ((ls1, t1), (ls2, t2)))
    line = np.cross(q[:, 0], q[:, 1])
    line /= np.linalg.norm(line[:, :2], axis=1, keepdims=True)
    rows = (line[:, None, :, None] * p[:, :, None, :] * np.sqrt(weights)[:, None, None, None]).reshape(-1, 9)
    h = np.linalg.inv(t2) @ np.linalg.svd(rows)[2][-1].reshape(3, 3) @ t1
    return h / h[2, 2]


def test_iterations_lose_outliers() -> None:
    p, q, _ = pairs(0.0)
    q[:, 4] += 60.0
    w = torch.ones(2, 9, dtype=DOUBLE)
    once = homography.find_homography_dlt(p, q, w)
    assert homography.find_homography_dlt_iterated(p, q, w, n_iter=1).equal(once)
    found = homography.find_homography_dlt_iterated(p, q, w, 3.0, 12)
    inliers = [i for i in range(9) if i != 4]

    def worst(h: Tensor) -> float:
        return homography.oneway_transfer_error(p, q, h, False)[:, inliers].max().item()

    assert worst(found) < 0.1 * worst(once)
    by_hand = once
    for _ in range(3):
        by_hand = homography.find_homography_dlt(
            p, q, torch.exp(-homography.symmetric_transfer_error(p, q, by_hand, False) / 18.0)
        )
    np.testing.assert_allclose(homography.find_homography_dlt_iterated(p, q, w, 3.0, 4), by_hand, rtol=1e-12)


def test_iterations_lose_wrong_segments() -> None:
    ls1, ls2, _ = segments(12)
    ls2[:, 5] += torch.tensor([[40.0, -30.0], [35.0, 45.0]], dtype=DOUBLE)
    w = torch.ones(2, 12, dtype=DOUBLE)
    inliers = [i for i in range(12) if i != 5]

    def worst(h: Tensor) -> float:
        return homography.line_segment_transfer_error_one_way(ls1, ls2, h)[:, inliers].max().item()

    once = homography.find_homography_lines_dlt(ls1, ls2, w)
    assert homography.find_homography_lines_dlt_iterated(ls1, ls2, w, n_iter=1).equal(once)
    assert worst(homography.find_homography_lines_dlt_iterated(ls1, ls2, w, 1.0, 12)) < 0.2 * worst(once)


def test_valid_samples() -> None:
    square = torch.tensor([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    mirrored = square * torch.tensor([-1.0, 1.0])
    crossed = square[[0, 2, 1, 3]]
    flat = torch.tensor([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 1.0]])
    first = torch.stack([square, square, square, square, flat])
    second = torch.stack(
        [apply(truth(1, torch.float32), square[None])[0].float(), mirrored, crossed, flat, flat]
    )
    assert homography.sample_is_valid_for_homography(first, second).tolist() == [
        True,
        False,
        False,
        False,
        False,
    ]
    tiny = first * 1e-18
    assert homography.sample_is_valid_for_homography(tiny[:1], second[:1]).tolist() == [True]


P, L, M = torch.zeros(1, 5, 2), torch.zeros(1, 5, 2, 2), torch.eye(3)[None]
WRONG = [
    (
        lambda: homography.oneway_transfer_error(P[0], P, M),
        ValueError,
        r"pts1: expected shape \(B, N, 2\) or \(B, N, 3\)",
    ),
    (
        lambda: homography.symmetric_transfer_error(P, P.int(), M),
        TypeError,
        "pts2: expected a floating-point",
    ),
    (
        lambda: homography.sampson_homography_distance(P, P, M[0]),
        ValueError,
        r"H: expected shape \(B, 3, 3\)",
    ),
    (
        lambda: homography.line_segment_transfer_error_one_way(P, L, M),
        ValueError,
        r"ls1: expected shape \(B, N, 2, 2\)",
    ),
    (
        lambda: homography.find_homography_lines_dlt(L[:, :3], L[:, :3]),
        ValueError,
        "ls1: expected at least 4 segments, got 3",
    ),
    (lambda: homography.find_homography_lines_dlt(L, L[:, :4]), ValueError, "ls2: expected as many segments"),
    (lambda: homography.find_homography_lines_dlt(L, L, P), ValueError, "weights: expected shape"),
    (
        lambda: homography.find_homography_dlt_iterated(P, P, P[..., 0], n_iter=0),
        ValueError,
        "n_iter: expected at least 1",
    ),
    (
        lambda: homography.find_homography_lines_dlt_iterated(L, L, P[..., 0], n_iter=0),
        ValueError,
        "n_iter: expected at least 1",
    ),
    (
        lambda: homography.sample_is_valid_for_homography(P, P),
        ValueError,
        r"points1: expected shape \(\*, 4, 2\)",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:30] for w in WRONG])
def test_message(call, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
