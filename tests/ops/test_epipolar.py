"""Fundamental and essential matrices, projections and triangulation against OpenCV, NumPy's SVD and scenes
with known truth."""

import cv2
import numpy as np
import pytest
import torch
from scenes import camera_matrix, points_in_front, pose, project

from chiasm.geometry import epipolar
from chiasm.geometry.calibration import solve_pnp_dlt


class Views:
    """Two cameras, the first at the origin, and points that both see."""

    def __init__(self, seed: int = 0, count: int = 40, noise: float = 0.0) -> None:
        self.K1, self.K2 = camera_matrix(seed), camera_matrix(seed + 100)
        self.R, self.t = pose(seed)
        self.X = points_in_front(count, seed)
        generator = np.random.default_rng(seed)
        self.x1 = project(self.K1, np.eye(3), np.zeros((3, 1)), self.X) + noise * generator.normal(
            size=(count, 2)
        )
        self.x2 = project(self.K2, self.R, self.t, self.X) + noise * generator.normal(size=(count, 2))
        self.E = skew(self.t[:, 0]) @ self.R
        self.F = np.linalg.inv(self.K2).T @ self.E @ np.linalg.inv(self.K1)
        self.P1, self.P2 = self.K1 @ np.eye(3, 4), self.K2 @ np.hstack([self.R, self.t])

    def rays(self) -> tuple[np.ndarray, np.ndarray]:
        return tuple(
            (np.c_[x, np.ones(len(x))] @ np.linalg.inv(K).T)[:, :2]
            for x, K in ((self.x1, self.K1), (self.x2, self.K2))
        )


def skew(v: np.ndarray) -> np.ndarray:
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def tensors(*arrays: np.ndarray) -> list[torch.Tensor]:
    return [torch.from_numpy(np.ascontiguousarray(a)) for a in arrays]


def batch(*arrays: np.ndarray) -> list[torch.Tensor]:
    return [t[None] for t in tensors(*arrays)]


def unit(m: np.ndarray) -> np.ndarray:
    """The matrix, scaled to length 1 with a positive largest entry."""
    m = np.asarray(m)
    return m / np.linalg.norm(m) * np.sign(m.flat[np.abs(m).argmax()])


# --- matrices -----------------------------------------------------------------------------------------------


def test_truth_obeys_the_definitions() -> None:
    v = Views()
    np.testing.assert_allclose(epipolar.cross_product_matrix(torch.from_numpy(v.t[:, 0])), skew(v.t[:, 0]))
    origin = (np.eye(3), np.zeros((3, 1)))
    np.testing.assert_allclose(epipolar.essential_from_Rt(*tensors(*origin, v.R, v.t)), v.E, atol=1e-14)
    np.testing.assert_allclose(
        epipolar.essential_from_fundamental(*tensors(v.F, v.K1, v.K2)), v.E, atol=1e-12
    )
    np.testing.assert_allclose(
        epipolar.fundamental_from_essential(*tensors(v.E, v.K1, v.K2)), v.F, atol=1e-12
    )
    np.testing.assert_allclose(epipolar.projection_from_KRt(*tensors(v.K2, v.R, v.t)), v.P2)
    np.testing.assert_allclose(
        unit(epipolar.fundamental_from_projections(*tensors(v.P1, v.P2))), unit(v.F), atol=1e-12
    )
    R0, t0 = pose(7)
    R, t = epipolar.relative_camera_motion(*tensors(R0, t0, v.R @ R0, v.R @ t0 + v.t))
    np.testing.assert_allclose(R, v.R, atol=1e-14)
    np.testing.assert_allclose(t, v.t, atol=1e-14)
    np.testing.assert_allclose(
        epipolar.depth_from_point(*tensors(v.R, v.t, v.X)), (v.X @ v.R.T + v.t.T)[:, 2]
    )


def test_fundamental_from_projections_is_determinants() -> None:
    P1, P2 = np.random.default_rng(0).normal(size=(2, 3, 4))
    expected = [
        [np.linalg.det(np.vstack([np.roll(P1, -j, 0)[1:], np.roll(P2, -i, 0)[1:]])) for j in range(3)]
        for i in range(3)
    ]
    np.testing.assert_allclose(epipolar.fundamental_from_projections(*tensors(P1, P2)), expected, atol=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_projections_from_fundamental(seed: int) -> None:
    v = Views(seed)
    P = epipolar.projections_from_fundamental(torch.from_numpy(v.F))
    assert P.shape == (3, 4, 2)
    np.testing.assert_allclose(
        unit(epipolar.fundamental_from_projections(P[..., 0], P[..., 1])), unit(v.F), atol=1e-9
    )
    np.testing.assert_allclose(P[:, 3, 1] @ v.F, np.zeros(3), atol=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_KRt_equal_opencv(seed: int) -> None:
    v = Views(seed)
    for P in (v.P2, -3.0 * v.P2, np.random.default_rng(seed).normal(size=(3, 4))):
        K, R, t = epipolar.KRt_from_projection(torch.from_numpy(P))
        sign = np.sign(np.linalg.det(P[:, :3]))
        np.testing.assert_allclose(K @ torch.cat([R, t], 1), sign * P, atol=1e-9)
        np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(R) > 0 and (K.diagonal() > 0).all() and K.tril(-1).abs().max() == 0
        expected_K, expected_R = cv2.decomposeProjectionMatrix(sign * P)[:2]
        np.testing.assert_allclose(K / K[2, 2], expected_K / expected_K[2, 2], rtol=1e-7, atol=1e-7)
        np.testing.assert_allclose(R, expected_R, atol=1e-9)


def test_intrinsics() -> None:
    K = epipolar.intrinsics_like(500.0, torch.zeros(2, 3, 480, 640))
    assert K.shape == (2, 3, 3) and K[1].tolist() == [
        [500.0, 0.0, 320.0],
        [0.0, 500.0, 240.0],
        [0.0, 0.0, 1.0],
    ]
    scaled = epipolar.scale_intrinsics(K, torch.tensor([0.5, 2.0]))
    assert scaled[0].equal(epipolar.scale_intrinsics(K[0], 0.5)) and scaled[1, 0].tolist() == [
        1000.0,
        0.0,
        640.0,
    ]


# --- lines and distances ------------------------------------------------------------------------------------


def test_lines_equal_opencv() -> None:
    v = Views(noise=2.0)
    F, x1, x2 = tensors(v.F, v.x1, v.x2)
    lines = epipolar.compute_correspond_epilines(x1, F)
    np.testing.assert_allclose(lines, cv2.computeCorrespondEpilines(v.x1[:, None], 1, v.F)[:, 0], atol=1e-9)
    np.testing.assert_allclose(
        epipolar.compute_correspond_epilines(x2, F.T),
        cv2.computeCorrespondEpilines(v.x2[:, None], 2, v.F)[:, 0],
        atol=1e-9,
    )
    distance = np.abs((lines.numpy() * np.c_[v.x2, np.ones(40)]).sum(1))
    np.testing.assert_allclose(epipolar.left_to_right_epipolar_distance(x1, x2, F), distance, atol=1e-9)
    np.testing.assert_allclose(epipolar.right_to_left_epipolar_distance(x2, x1, F.T), distance, atol=1e-9)
    closest = epipolar.get_closest_point_on_epipolar_line(x1, x2, F)
    np.testing.assert_allclose((closest - x2).norm(dim=1), distance, atol=1e-9)
    np.testing.assert_allclose((lines[:, :2] * closest).sum(1) + lines[:, 2], np.zeros(40), atol=1e-9)
    perpendicular = epipolar.get_perpendicular(lines, x2)
    for point in (closest, x2):
        np.testing.assert_allclose(
            (perpendicular[:, :2] * point).sum(1) + perpendicular[:, 2], np.zeros(40), atol=1e-9
        )


@pytest.mark.parametrize("homogeneous", [False, True])
def test_distances_equal_opencv(homogeneous: bool) -> None:
    v = Views(noise=2.0)
    h1, h2 = np.c_[v.x1, np.ones(40)], np.c_[v.x2, np.ones(40)]
    sampson = [cv2.sampsonDistance(a[:, None], b[:, None], v.F) for a, b in zip(h1, h2, strict=True)]
    x1, x2, F = tensors(3.0 * h1, -2.0 * h2, v.F) if homogeneous else tensors(v.x1, v.x2, v.F)
    np.testing.assert_allclose(epipolar.sampson_epipolar_distance(x1, x2, F), sampson, rtol=1e-9)
    np.testing.assert_allclose(
        epipolar.sampson_epipolar_distance(x1, x2, F, False, 0.0), np.sqrt(sampson), rtol=1e-9
    )
    left, right = (
        epipolar.left_to_right_epipolar_distance(x1, x2, F),
        epipolar.right_to_left_epipolar_distance(x1, x2, F),
    )
    np.testing.assert_allclose(
        epipolar.symmetrical_epipolar_distance(x1, x2, F), left**2 + right**2, rtol=1e-9
    )


def test_distances_where_there_is_no_line_are_finite() -> None:
    x = torch.zeros(3, 2, dtype=torch.float64, requires_grad=True)
    F = torch.zeros(3, 3, dtype=torch.float64)
    for name in ("sampson", "symmetrical", "left_to_right", "right_to_left"):
        d = getattr(epipolar, f"{name}_epipolar_distance")(x, x, F)
        (gradient,) = torch.autograd.grad(d.sum(), x)
        assert d.tolist() == [0.0] * 3 and gradient.isfinite().all(), name


# --- fundamental matrices -----------------------------------------------------------------------------------


def by_svd(v: Views, weights: np.ndarray) -> np.ndarray:
    """The eight-point algorithm with NumPy's SVD."""

    def hartley(x: np.ndarray) -> np.ndarray:
        w = weights / weights.sum()
        c = w @ x
        s = np.sqrt(2) / (w @ np.linalg.norm(x - c, axis=1))
        return np.array([[s, 0, -s * c[0]], [0, s, -s * c[1]], [0, 0, 1]])

    t1, t2 = hartley(v.x1), hartley(v.x2)
    a, b = np.c_[v.x1, np.ones(len(v.x1))] @ t1.T, np.c_[v.x2, np.ones(len(v.x2))] @ t2.T
    rows = (b[:, :, None] * a[:, None]).reshape(-1, 9) * np.sqrt(weights)[:, None]
    u, s, vt = np.linalg.svd(np.linalg.svd(rows)[2][-1].reshape(3, 3))
    return t2.T @ (u * [s[0], s[1], 0]) @ vt @ t1


@pytest.mark.parametrize("count", [8, 12, 200])
def test_eight_points_equal_the_svd(count: int) -> None:
    v = Views(1, count, 0.5)
    weights = np.random.default_rng(2).uniform(0.5, 1.5, count)
    for w in (np.ones(count), weights):
        expected = by_svd(v, w)
        F = epipolar.find_fundamental(*batch(v.x1, v.x2, w))[0]
        np.testing.assert_allclose(F, expected / expected[2, 2], rtol=1e-5, atol=1e-9)
        assert abs(np.linalg.det(unit(F))) < 1e-14
    if count > 8:  # OpenCV uses the SVD of the normal matrix
        F, _ = cv2.findFundamentalMat(v.x1, v.x2, cv2.FM_8POINT)
        np.testing.assert_allclose(epipolar.find_fundamental(*batch(v.x1, v.x2))[0], F, rtol=1e-4, atol=1e-8)


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_eight_exact_points_find_the_truth(dtype: torch.dtype) -> None:
    for seed in range(8):
        v = Views(seed, 8)
        F = epipolar.find_fundamental(*[t.to(dtype) for t in batch(v.x1, v.x2)])[0]
        error = epipolar.symmetrical_epipolar_distance(*tensors(v.x1, v.x2), F.double(), False)
        assert error.max() < (0.02 if dtype == torch.float32 else 1e-3), seed


def test_seven_points_equal_opencv() -> None:
    counts = []
    for seed in range(30):
        v = Views(seed, 7, 0.3)
        F, exists = epipolar.find_fundamental_7point(*batch(v.x1, v.x2))
        found = [unit(f) for f in F[0][exists[0]].numpy()]
        stacked, _ = cv2.findFundamentalMat(v.x1, v.x2, cv2.FM_7POINT)
        expected = [unit(f) for f in stacked.reshape(-1, 3, 3)]
        assert len(found) == len(expected), seed
        for f in expected:
            assert min(np.abs(f - g).max() for g in found) < 1e-4, seed
        for f in found:
            assert abs(np.linalg.det(f)) < 1e-16, seed
            np.testing.assert_allclose(
                epipolar.symmetrical_epipolar_distance(*tensors(v.x1, v.x2, f)), np.zeros(7), atol=1e-14
            )
        assert F[0][~exists[0]].abs().sum() == 0
        assert epipolar.find_fundamental(*batch(v.x1, v.x2), None, "7POINT").equal(F)
        counts.append(len(found))
    assert set(counts) == {1, 3}


def test_seven_exact_points_find_the_truth() -> None:
    for seed in range(8):
        v = Views(seed, 7)
        F, exists = epipolar.find_fundamental_7point(*batch(v.x1, v.x2))
        assert min(np.abs(unit(f) - unit(v.F)).max() for f in F[0][exists[0]].numpy()) < 1e-7, seed


def test_gradients_of_fundamental_matrices() -> None:
    v = Views(3, 9, 0.3)
    scale = 1e-2  # in units of 100 pixels: finite differences are inaccurate for entries that differ by 1e6
    x1, x2 = (t[None].clone().requires_grad_(True) for t in tensors(v.x1 * scale, v.x2 * scale))
    weights = torch.linspace(0.5, 1.5, 9, dtype=torch.float64)[None].requires_grad_(True)
    assert torch.autograd.gradcheck(
        epipolar.find_fundamental, (x1, x2, weights), atol=1e-4, rtol=1e-3, fast_mode=True
    )
    a, b = (x[:, :7].detach().requires_grad_(True) for x in (x1, x2))
    assert torch.autograd.gradcheck(
        lambda p, q: epipolar.find_fundamental_7point(p, q)[0], (a, b), atol=1e-3, rtol=1e-3, fast_mode=True
    )


def test_normalized_points() -> None:
    v = Views()
    w = np.random.default_rng(0).uniform(0.1, 1.0, 40)
    for weights in (None, w):
        points, similarity = epipolar.normalize_points(
            *batch(v.x1), 0.0, None if weights is None else torch.from_numpy(weights)[None]
        )
        share = (np.ones(40) if weights is None else w) / (40 if weights is None else w.sum())
        np.testing.assert_allclose(share @ points[0].numpy(), [0, 0], atol=1e-12)
        np.testing.assert_allclose(share @ np.linalg.norm(points[0], axis=1), np.sqrt(2), rtol=1e-12)
        np.testing.assert_allclose(
            (np.c_[v.x1, np.ones(40)] @ similarity[0].numpy().T)[:, :2], points[0], atol=1e-12
        )


@pytest.mark.parametrize("dtype", [torch.float16, torch.float32])
def test_gradient_of_normalized_points_with_one_at_the_centroid(dtype: torch.dtype) -> None:
    cross = torch.tensor([[[0.0, 0.0], [2.0, 0.0], [-2.0, 0.0], [0.0, 1.0], [0.0, -1.0]]])
    gradients = []
    for of in (dtype, torch.float64):
        points = cross.to(of, copy=True).requires_grad_()
        epipolar.normalize_points(points)[0][0, :3].square().sum().backward()
        gradients.append(points.grad.double())
    tolerance = 1e-2 if dtype == torch.float16 else 1e-6
    torch.testing.assert_close(*gradients, rtol=tolerance, atol=tolerance)


def test_normalize_transformation() -> None:
    m = torch.tensor([[[2.0, 4.0], [6.0, 2.0]], [[2.0, 4.0], [6.0, 0.0]]])
    assert epipolar.normalize_transformation(m).tolist() == [
        [[1.0, 2.0], [3.0, 1.0]],
        [[2.0, 4.0], [6.0, 0.0]],
    ]


# --- essential matrices -------------------------------------------------------------------------------------


def same_set(found: list[np.ndarray], expected: list[np.ndarray], tolerance: float) -> bool:
    return all(min(np.abs(f - e).max() for f in found) < tolerance for e in expected)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("name", ["decompose_essential_matrix", "decompose_essential_matrix_no_svd"])
def test_decompositions_equal_opencv(name: str, seed: int) -> None:
    v = Views(seed)
    for E in (v.E, -5.0 * v.E):
        R1, R2, t = (a.numpy() for a in getattr(epipolar, name)(torch.from_numpy(E)))
        expected1, expected2, expected_t = cv2.decomposeEssentialMat(E)
        assert same_set([R1, R2], [expected1, expected2], 1e-7)
        assert same_set([t, -t], [expected_t], 1e-7)
        np.testing.assert_allclose(unit(skew(t[:, 0]) @ R1), unit(E), atol=1e-9)
        assert (skew(t[:, 0]) @ R1 * E).sum() > 0 > (skew(t[:, 0]) @ R2 * E).sum()


@pytest.mark.parametrize("seed", range(6))
def test_what_is_not_quite_essential_equals_the_svd(seed: int) -> None:
    E = Views(seed).E + 0.1 * np.random.default_rng(seed).normal(size=(3, 3))
    u, s, vt = np.linalg.svd(E)
    mean = (s[0] + s[1]) / 2
    np.testing.assert_allclose(
        epipolar.project_to_essential(torch.from_numpy(E)), u @ np.diag([mean, mean, 0]) @ vt, atol=1e-9
    )
    u, vt = u * np.linalg.det(u), vt * np.linalg.det(vt)
    W = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    R1, R2, t = (a.numpy() for a in epipolar.decompose_essential_matrix(torch.from_numpy(E)))
    assert same_set([R1, R2], [u @ W @ vt, u @ W.T @ vt], 1e-9)
    assert same_set([t[:, 0], -t[:, 0]], [u[:, 2]], 1e-9)


def test_gradients_of_decompositions() -> None:
    E = (Views(2).E + 0.05 * np.random.default_rng(1).normal(size=(3, 3)))[None]
    x = torch.from_numpy(E).requires_grad_(True)
    for function in (
        epipolar.decompose_essential_matrix,
        epipolar.project_to_essential,
        epipolar.decompose_essential_matrix_no_svd,
    ):
        assert torch.autograd.gradcheck(function, (x,), atol=1e-5)
    truth = torch.from_numpy(Views(2).E).requires_grad_(True)
    sum(part.sum() for part in epipolar.decompose_essential_matrix(truth)).backward()
    assert truth.grad.isfinite().all()


@pytest.mark.parametrize("seed", range(6))
def test_motion_equals_opencv(seed: int) -> None:
    v = Views(seed, 30, 0.2)
    mask = torch.ones(30, dtype=torch.bool)
    mask[3:6] = False
    R, t, X, seen = epipolar.motion_from_essential_choose_solution(
        *tensors(v.E, v.K1, v.K2, v.x1, v.x2), mask
    )
    np.testing.assert_allclose(R, v.R, atol=1e-9)
    np.testing.assert_allclose(t, v.t, atol=1e-9)
    assert seen.equal(mask)
    np.testing.assert_allclose(X, v.X, atol=0.5)
    a, b = v.rays()
    _, expected_R, expected_t, _ = cv2.recoverPose(v.E, a, b, np.eye(3))
    np.testing.assert_allclose(R, expected_R, atol=1e-7)
    np.testing.assert_allclose(t, expected_t, atol=1e-7)
    Rs, Ts = epipolar.motion_from_essential(torch.from_numpy(v.E))
    assert Rs.shape == (4, 3, 3) and Ts.shape == (4, 3, 1)
    stacked = epipolar.motion_from_essential_choose_solution(*batch(v.E, v.K1, v.K2, v.x1, v.x2))
    assert [s.shape[0] for s in stacked] == [1] * 4
    np.testing.assert_allclose(stacked[2][0], X)


@pytest.mark.parametrize("seed", range(10))
def test_five_points_equal_opencv(seed: int) -> None:
    v = Views(seed, 5)
    a, b = v.rays()
    E, exists = epipolar.find_essential_5point(*batch(a, b))
    found = E[0][exists[0]].numpy()
    assert min(np.abs(unit(e) - unit(v.E)).max() for e in found) < 1e-9
    for e in found:
        np.testing.assert_allclose(
            np.einsum("ni,ij,nj->n", np.c_[b, np.ones(5)], e, np.c_[a, np.ones(5)]), np.zeros(5), atol=1e-12
        )
        np.testing.assert_allclose(np.linalg.svd(e)[1], [np.sqrt(0.5), np.sqrt(0.5), 0], atol=1e-8)
    stacked, _ = cv2.findEssentialMat(a, b, np.eye(3), cv2.RANSAC, 0.999, 1e9)
    for e in stacked.reshape(-1, 3, 3):
        assert min(np.abs(unit(e) - unit(f)).max() for f in found) < 1e-5
    assert E[0][~exists[0]].abs().sum() == 0 and epipolar.find_essential(*batch(a, b)).equal(E)
    single = epipolar.find_essential(*[x.float() for x in batch(a, b)])[0].numpy()
    assert min(np.abs(unit(e) - unit(v.E)).max() for e in single if np.abs(e).max() > 0) < 1e-3


@pytest.mark.parametrize("seed", range(4))
def test_many_points_fit_a_space(seed: int) -> None:
    v = Views(seed, 60, 0.3)
    a, b = v.rays()
    weights = np.random.default_rng(0).uniform(0.5, 1.5, 60)
    E, exists = epipolar.find_essential_5point(*batch(a, b, weights))
    rows = (np.c_[b, np.ones(60)][:, :, None] * np.c_[a, np.ones(60)][:, None]).reshape(-1, 9) * np.sqrt(
        weights
    )[:, None]
    others = np.linalg.svd(rows)[2][:5]
    for e in E[0][exists[0]].numpy():
        np.testing.assert_allclose(others @ e.ravel(), np.zeros(5), atol=1e-9)
    assert min(np.abs(unit(e) - unit(v.E)).max() for e in E[0][exists[0]].numpy()) < 0.05


def test_gradient_of_five_points() -> None:
    for count in (5, 9):
        v = Views(4, count, 0.1)
        a, b = (x.clone().requires_grad_(True) for x in batch(*v.rays()))
        weights = torch.linspace(0.5, 1.5, count, dtype=torch.float64)[None].requires_grad_(True)
        assert torch.autograd.gradcheck(
            lambda *p: epipolar.find_essential_5point(*p)[0],
            (a, b, weights),
            atol=1e-3,
            rtol=1e-3,
            fast_mode=True,
        )


# --- points and poses ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("solver", ["eigh", "svd"])
def test_triangulation_equals_opencv(solver: str) -> None:
    v = Views(5, 40, 1.0)
    X = epipolar.triangulate_points(*tensors(v.P1, v.P2, v.x1, v.x2), solver)
    expected = cv2.triangulatePoints(v.P1, v.P2, v.x1.T, v.x2.T)
    np.testing.assert_allclose(X, (expected[:3] / expected[3]).T, rtol=1e-7)
    exact = Views(5, 40)
    np.testing.assert_allclose(
        epipolar.triangulate_points(*tensors(v.P1, v.P2, exact.x1, exact.x2)), v.X, rtol=1e-9
    )
    single = epipolar.triangulate_points(*[t.float() for t in tensors(v.P1, v.P2, exact.x1, exact.x2)])
    np.testing.assert_allclose(single, v.X, rtol=1e-4, atol=1e-4)


def test_gradient_of_triangulation() -> None:
    v = Views(5, 3, 1.0)
    inputs = [t.clone().requires_grad_(True) for t in tensors(v.P1 / 500, v.P2 / 500, v.x1 / 500, v.x2 / 500)]
    assert torch.autograd.gradcheck(epipolar.triangulate_points, inputs, atol=1e-5)


@pytest.mark.parametrize("count", [6, 20])
def test_pose_equals_opencv(count: int) -> None:
    for seed in range(4):
        v = Views(seed, count)
        pose_exact = solve_pnp_dlt(*batch(v.X, v.x2, v.K2))[0]
        np.testing.assert_allclose(pose_exact, np.hstack([v.R, v.t]), atol=1e-7)
        _, rotation, t = cv2.solvePnP(v.X, v.x2, v.K2, None, flags=cv2.SOLVEPNP_ITERATIVE)
        np.testing.assert_allclose(pose_exact, np.hstack([cv2.Rodrigues(rotation)[0], t]), atol=1e-4)
    noisy = Views(3, 200, 0.3)
    weights = torch.ones(1, 200, dtype=torch.float64)
    weights[:, 100:] = 0.0
    world = noisy.X.copy()
    world[100:] += 1.0
    found = solve_pnp_dlt(*batch(world, noisy.x2, noisy.K2), weights)[0]
    np.testing.assert_allclose(found, np.hstack([noisy.R, noisy.t]), atol=0.02)
    np.testing.assert_allclose(found[:, :3] @ found[:, :3].T, np.eye(3), atol=1e-12)


def test_gradient_of_the_pose() -> None:
    v = Views(3, 8, 0.3)
    inputs = [
        t.clone().requires_grad_(True) for t in batch(v.X, v.x2 / 500, v.K2 / np.array([[500], [500], [1.0]]))
    ]
    assert torch.autograd.gradcheck(solve_pnp_dlt, inputs, atol=1e-4, rtol=1e-3)


P, M, X = torch.zeros(1, 8, 2), torch.eye(3), torch.zeros(1, 3, 4)
WRONG = [
    (lambda: epipolar.find_fundamental(P[0], P[0]), ValueError, r"points1: expected shape \(B, N, 2\)"),
    (
        lambda: epipolar.find_fundamental(P[:, :7], P[:, :7]),
        ValueError,
        "points1: expected at least 8 points, got 7",
    ),
    (lambda: epipolar.find_fundamental(P, P[:, :7]), ValueError, "points2: expected as many points"),
    (lambda: epipolar.find_fundamental(P, P, P), ValueError, "weights: expected shape"),
    (lambda: epipolar.find_fundamental(P, P, None, "8point"), ValueError, "method: expected one of"),
    (lambda: epipolar.find_fundamental_7point(P, P), ValueError, "points1: expected 7 points, got 8"),
    (
        lambda: epipolar.find_essential(P[:, :4], P[:, :4]),
        ValueError,
        "points1: expected shape .* at least 5",
    ),
    (lambda: epipolar.triangulate_points(X, X[:, :2], P, P), ValueError, r"P2: expected shape \(\*, 3, 4\)"),
    (lambda: epipolar.triangulate_points(X, X, P, P, "qr"), ValueError, "solver: expected one of"),
    (
        lambda: epipolar.compute_correspond_epilines(P[0, 0], M),
        ValueError,
        r"points: expected shape \(\*, N, 2\) or \(\*, N, 3\)",
    ),
    (lambda: epipolar.sampson_epipolar_distance(P, P.int(), M), TypeError, "pts2: expected a floating-point"),
    (lambda: epipolar.intrinsics_like(0.0, P[None]), ValueError, "focal: expected a positive number"),
    (lambda: epipolar.depth_from_point(M, M[:, :1], P), ValueError, r"X: expected shape \(\*, N, 3\)"),
    (lambda: epipolar.normalize_points(P, 1e-8, P), ValueError, r"weights: expected shape \(B, N\)"),
    (
        lambda: solve_pnp_dlt(torch.zeros(1, 5, 3), P[:, :5], M[None]),
        ValueError,
        "world_points: expected at least 6",
    ),
    (
        lambda: solve_pnp_dlt(torch.zeros(1, 6, 3), P, M[None]),
        ValueError,
        "img_points: expected as many points",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
