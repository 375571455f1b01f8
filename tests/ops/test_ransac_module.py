"""The class RANSAC, which draws its own samples."""

import cv2
import numpy as np
import pytest
import torch

from chiasm.geometry.ransac import RANSAC


def views(outliers: int = 60, count: int = 200) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Points of a scene in two views, the last `outliers` of them wrong, and the camera matrix."""
    rng = np.random.default_rng(0)
    X = np.concatenate([rng.uniform(-1, 1, (count, 2)), rng.uniform(4, 8, (count, 1))], 1)
    K = np.array([[500.0, 0, 320], [0, 500, 240], [0, 0, 1]])
    seen = [cv2.projectPoints(X, np.array(r), np.array(t), K, None)[0][:, 0] for r, t in _POSES]
    seen[1][count - outliers :] = rng.uniform(0, 500, (outliers, 2))
    return torch.from_numpy(seen[0]), torch.from_numpy(seen[1]), torch.from_numpy(K)


_POSES = (([0.0, 0, 0], [0.0, 0, 0]), ([0.05, -0.1, 0.02], [0.5, 0.1, 0.1]))


@pytest.mark.parametrize("kind", ["fundamental", "fundamental_7pt", "fundamental_8pt"])
def test_fundamental_matrices(kind: str) -> None:
    x1, x2, _ = views()
    F, inliers = RANSAC(kind, 1.0, batch_size=256, seed=1)(x1, x2)
    assert inliers[:140].all() and inliers.sum() < 150
    lines = cv2.computeCorrespondEpilines(x1.numpy(), 1, F.numpy())[:, 0]  # of length 1 in x and y
    away = np.abs((lines[:, :2] * x2.numpy()).sum(1) + lines[:, 2])[:140]
    assert away.max() < 1.0 and away.mean() < 0.2
    assert F[2, 2].item() == pytest.approx(1)


def test_essential_matrices() -> None:
    x1, x2, K = views()
    rays = [cv2.undistortPoints(x.numpy(), K.numpy(), None)[:, 0] for x in (x1, x2)]
    E, inliers = RANSAC("essential", 1e-3, batch_size=128, seed=1)(*map(torch.from_numpy, rays))
    rotation, t = cv2.Rodrigues(np.array(_POSES[1][0]))[0], _POSES[1][1]
    exact = np.array([[0, -t[2], t[1]], [t[2], 0, -t[0]], [-t[1], t[0], 0]]) @ rotation
    exact /= np.linalg.norm(exact)
    assert inliers[:140].all()
    found = E.numpy() / np.linalg.norm(E.numpy())
    np.testing.assert_allclose(found * np.sign((found * exact).sum()), exact, atol=2e-3)


def test_homographies_and_seeds() -> None:
    x1, wrong, _ = views()
    exact = np.array([[1.1, 0.05, 3], [0.02, 0.9, -5], [1e-4, 0, 1]])
    x2 = torch.from_numpy(cv2.perspectiveTransform(x1.numpy()[:, None], exact)[:, 0])
    x2[140:] = wrong[140:]
    ransac = RANSAC(seed=3, batch_size=64)
    H, inliers = ransac(x1, x2)
    np.testing.assert_allclose(H, exact, rtol=1e-5, atol=1e-9)
    assert inliers[:140].all() and not inliers[140:].all()
    again = ransac(x1, x2)
    assert again[0].equal(H) and again[1].equal(inliers)


def test_without_a_model() -> None:
    x = torch.zeros(8, 2)
    H, inliers = RANSAC("homography", batch_size=8, max_iter=2)(x, x)
    assert H.shape == (3, 3) and inliers.shape == (8,)


def test_what_is_refused() -> None:
    with pytest.raises(ValueError, match="model_type: expected one of"):
        RANSAC("affine")
    with pytest.raises(ValueError, match="batch_size, max_iter: expected positive numbers, got 0 and 10"):
        RANSAC(batch_size=0)
    with pytest.raises(ValueError, match="confidence: expected a number above 0, at most 1, got 2"):
        RANSAC(confidence=2.0)
    with pytest.raises(ValueError, match="expected the same number of points, at least 8, got 5 and 5"):
        RANSAC("fundamental")(torch.rand(5, 2), torch.rand(5, 2))
