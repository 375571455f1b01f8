"""From two images to a homography, on photographs warped by known homographies, compared with OpenCV's SIFT,
matcher and findHomography."""

import cv2
import numpy as np
import pytest
import torch
from photos import FOLDER
from torch import Tensor

from chiasm.pipelines import two_view_homography

SIZE = (320, 240)


def views(name: str, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A photograph, the same photograph rotated, scaled, tilted, darker and noisier, and the homography
    between them."""
    random = np.random.default_rng(seed)
    photo = cv2.resize(
        cv2.imread(str(FOLDER / name), cv2.IMREAD_GRAYSCALE), SIZE, interpolation=cv2.INTER_AREA
    )
    corners = np.array([[0, 0], [SIZE[0], 0], SIZE, [0, SIZE[1]]], np.float64)
    angle, scale, middle = np.deg2rad(random.uniform(-30, 30)), random.uniform(0.8, 1.25), corners.mean(0)
    turn = scale * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    moved = (corners - middle) @ turn.T + middle + random.uniform(-15, 15, (4, 2))
    homography = cv2.getPerspectiveTransform(corners.astype(np.float32), moved.astype(np.float32))
    seen = cv2.warpPerspective(photo, homography, SIZE) * 0.8 + random.normal(0, 2, photo.shape)
    return photo, seen.round().clip(0, 255).astype(np.uint8), homography


def tensor(image: np.ndarray) -> Tensor:
    return torch.from_numpy(image)[None, None].float() / 255.0


def corner_error(estimate: np.ndarray, truth: np.ndarray) -> float:
    corners = np.array([[[0, 0], [SIZE[0], 0], SIZE, [0, SIZE[1]]]], np.float64)
    return float(
        np.linalg.norm(
            cv2.perspectiveTransform(corners, estimate) - cv2.perspectiveTransform(corners, truth), axis=-1
        ).mean()
    )


def by_opencv(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    sift = cv2.SIFT_create(500)
    points1, described1 = sift.detectAndCompute(first, None)
    points2, described2 = sift.detectAndCompute(second, None)
    pairs = [
        a for a, b in cv2.BFMatcher().knnMatch(described1, described2, k=2) if a.distance < 0.8 * b.distance
    ]
    return cv2.findHomography(
        np.float32([points1[m.queryIdx].pt for m in pairs]),
        np.float32([points2[m.trainIdx].pt for m in pairs]),
        cv2.RANSAC,
        3.0,
    )[0]


def test_it_is_as_near_as_opencv() -> None:
    ours, theirs = [], []
    for seed, name in enumerate(("astronaut.png", "coffee.png", "camera.png")):
        first, second, truth = views(name, seed)
        uniforms = torch.rand(1, 500, 4, generator=torch.Generator().manual_seed(seed))
        estimate, points1, points2, matched, inliers = two_view_homography(
            tensor(first), tensor(second), uniforms, 500, num_octaves=3
        )
        ours.append(corner_error(estimate[0].double().numpy(), truth))
        theirs.append(corner_error(by_opencv(first, second), truth))
        mapped = cv2.perspectiveTransform(points1.double().numpy(), truth)[0]
        distance = np.linalg.norm(mapped - points2[0].numpy(), axis=1)
        assert not (inliers & ~matched).any() and int(inliers.sum()) >= 30
        assert np.median(distance[inliers[0].numpy()]) < 0.6
        assert points1[~matched].abs().max() == 0
    assert np.mean(ours) < 1.5 * np.mean(theirs) + 0.2, (ours, theirs)


def test_what_has_nothing_in_common_has_few_inliers() -> None:
    first, second = (tensor(views(name, 0)[0]) for name in ("coffee.png", "camera.png"))
    inliers = two_view_homography(
        first, second, torch.rand(1, 300, 4, generator=torch.Generator().manual_seed(0)), 300, num_octaves=2
    )[4]
    assert int(inliers.sum()) < 10


def test_bad_input_is_named() -> None:
    image, uniforms = torch.rand(1, 1, 64, 64), torch.rand(1, 10, 4)
    with pytest.raises(ValueError, match="image1: expected shape"):
        two_view_homography(image.expand(1, 3, 64, 64), image, uniforms)
    with pytest.raises(ValueError, match="uniforms: expected shape"):
        two_view_homography(image, image, uniforms[..., :3], 50, num_octaves=1)
