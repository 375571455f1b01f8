"""Local affine frames against NumPy, OpenCV's key points and derivatives by autograd."""

import math

import cv2
import numpy as np
import pytest
import torch
from torch import Tensor

from chiasm import feature
from chiasm.export.catalog.feature_frames import frames
from chiasm.geometry.linalg import transform_points


def some(batch: int = 3, count: int = 7, seed: int = 0) -> Tensor:
    return frames(torch.Generator().manual_seed(seed), {"B": batch, "N": count, "H": 61, "W": 83})


def close(actual: Tensor, expected: object, atol: float = 1e-12) -> None:
    np.testing.assert_allclose(actual, expected, rtol=1e-10, atol=atol)


@pytest.mark.parametrize("batch", [1, 3])
def test_parts(batch: int) -> None:
    laf = some(batch)
    a = laf[..., :2].numpy()
    close(feature.get_laf_center(laf), laf[..., 2])
    close(feature.get_laf_scale(laf)[..., 0, 0], np.sqrt(np.abs(np.linalg.det(a))))
    close(feature.get_laf_orientation(laf)[..., 0], np.degrees(np.arctan2(a[..., 0, 1], a[..., 0, 0])))


def test_scale_of_thin_frames_in_float32() -> None:
    """The two products in the determinant agree in six digits."""
    laf = torch.tensor([[[[1000.0, 1001.0, 0.0], [1001.0, 1002.003, 0.0]]]])
    close(
        feature.get_laf_scale(laf).double().flatten(),
        [math.sqrt(abs(np.linalg.det(laf[0, 0, :, :2].double().numpy())))],
        1e-6,
    )


def test_angles_are_those_of_opencv_key_points() -> None:
    """cv2 rotates key points clockwise on the screen, but its rotation matrices counter-clockwise."""
    angle = torch.tensor([[[30.0], [-75.0], [160.0]]], dtype=torch.float64)
    laf = feature.laf_from_center_scale_ori(
        torch.zeros(1, 3, 2, dtype=torch.float64), torch.full([1, 3, 1, 1], 4.0), angle
    )
    for k in range(3):
        close(laf[0, k, :, :2], cv2.getRotationMatrix2D((0, 0), float(angle[0, k]), 4.0)[:, :2])
    close(feature.get_laf_orientation(laf), angle)


def test_turning_keeps_ellipses() -> None:
    laf, angle = some(), torch.linspace(-179, 179, 21, dtype=torch.float64).reshape(3, 7, 1)
    turned = feature.set_laf_orientation(laf, angle)
    close(feature.get_laf_orientation(turned), angle, 1e-9)
    for changed in (turned, feature.rotate_laf(laf, angle), feature.make_upright(laf)):
        close(changed[..., :2] @ changed[..., :2].mT, laf[..., :2] @ laf[..., :2].mT, 1e-10)
        close(changed[..., 2], laf[..., 2])
    close(
        feature.get_laf_orientation(feature.rotate_laf(laf, -feature.get_laf_orientation(laf))),
        torch.zeros(3, 7, 1),
        1e-9,
    )


def test_upright_is_the_triangular_factor() -> None:
    laf = some()
    laf[0, 0, 0, :2] *= -1.0  # mirrored
    q, r = np.linalg.qr(laf[..., :2].mT.numpy())
    sign = np.sign(r[..., 0, 0])[..., None, None]
    rotation = np.where(
        np.linalg.det(q)[..., None] < 0, np.stack([sign[..., 0, 0], -sign[..., 0, 0]], -1), sign[..., 0]
    )
    close(feature.make_upright(laf)[..., :2], np.swapaxes(r, -1, -2) * rotation[..., None, :], 1e-10)


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16, torch.float32])
def test_upright_of_large_frames_and_empty_slots(dtype: torch.dtype) -> None:
    laf = torch.zeros(1, 2, 2, 3, dtype=dtype)
    laf[0, 0] = torch.tensor([[0.0, 300.0, 7.0], [-300.0, 0.0, 5.0]])
    expected = torch.zeros_like(laf)
    expected[0, 0] = torch.tensor([[300.0, 0.0, 7.0], [0.0, 300.0, 5.0]])
    assert torch.equal(feature.make_upright(laf), expected)


def test_scaling() -> None:
    laf = some()
    factor = torch.linspace(0.5, 2.0, 21, dtype=torch.float64).reshape(3, 7, 1, 1)
    close(feature.get_laf_scale(feature.scale_laf(laf, factor)), feature.get_laf_scale(laf) * factor)
    close(feature.scale_laf(laf, 2.0), torch.cat([2.0 * laf[..., :2], laf[..., 2:]], -1))
    scripted = torch.jit.script(feature.scale_laf)
    close(scripted(laf, factor), feature.scale_laf(laf, factor))
    close(scripted(laf, 2.0), feature.scale_laf(laf, 2.0))


def test_defaults_of_building() -> None:
    xy = torch.tensor([[[3.0, 4.0]]])
    close(feature.laf_from_center_scale_ori(xy), [[[[1, 0, 3], [0, 1, 4]]]])


@pytest.mark.parametrize("size", [(61, 83), (40, 21), (1, 9)])
def test_normalised_frames(size: tuple[int, int]) -> None:
    laf, images = some(), torch.zeros(3, 1, *size)
    height, width = max(size[0] - 1, 1), max(size[1] - 1, 1)
    normal = feature.normalize_laf(laf, images)
    close(normal[..., 2], laf[..., 2].numpy() / [width, height])
    close(normal[..., :2], laf[..., :2].numpy() / min(width, height))
    close(feature.denormalize_laf(normal, images), laf)


def test_points() -> None:
    laf = some()
    three = feature.laf_to_three_points(laf)
    close(three[..., 0], laf[..., 0] + laf[..., 2])
    close(three[..., 2], laf[..., 2])
    close(feature.laf_from_three_points(three), laf)
    points = feature.laf_to_boundary_points(laf, 20).numpy()
    assert points.shape == (3, 7, 20, 2)
    angle = np.linspace(0, 2 * np.pi, 19)
    disk = np.concatenate([np.zeros((2, 1)), np.stack([np.sin(angle), np.cos(angle)])], 1)
    close(points, np.swapaxes(laf[..., :2].numpy() @ disk + laf[..., 2:].numpy(), -1, -2), 1e-12)


def test_ellipses() -> None:
    laf = some()
    a = laf[..., :2].numpy()
    form = np.linalg.inv(a @ np.swapaxes(a, -1, -2))
    ells = np.stack([laf[..., 0, 2], laf[..., 1, 2], form[..., 0, 0], form[..., 0, 1], form[..., 1, 1]], -1)
    found = feature.ellipse_to_laf(torch.from_numpy(ells))
    close(found[..., :2], np.linalg.cholesky(np.linalg.inv(form)), 1e-10)
    close(found[..., 2], laf[..., 2])
    around = feature.laf_to_boundary_points(found)[..., 1:, :].numpy() - laf[..., None, :, 2].numpy()
    close(np.einsum("bnpi,bnij,bnpj->bnp", around, form, around), np.ones((3, 7, 49)), 1e-10)


def test_forms_that_are_no_ellipses() -> None:
    ells = torch.tensor(
        [[[1.0, 2.0, 1.0, 2.0, 1.0], [1.0, 2.0, -1.0, 0.0, -1.0], [1.0, 2.0, 1.0, 0.5, 1.0]]],
        requires_grad=True,
    )
    laf = feature.ellipse_to_laf(ells)
    assert feature.laf_is_filled(laf).tolist() == [[False, False, True]]
    laf.sum().backward()
    assert ells.grad is not None and torch.isfinite(ells.grad).all()


def test_masks() -> None:
    good = torch.tensor([[2.0, 0.0, 1.0], [0.0, 3.0, 2.0]])
    singular = torch.tensor([[1.0, 2.0, 1.0], [2.0, 4.0, 2.0]])
    broken = good.clone()
    broken[0, 2] = math.nan
    laf = torch.stack([good, torch.zeros(2, 3), singular, broken, 1e200 * good.double().float()])[None]
    assert feature.laf_is_filled(laf).tolist() == [[True, False, True, True, True]]
    assert feature.laf_is_valid(laf).tolist() == [[True, False, False, False, False]]


def test_inside() -> None:
    images, laf = torch.zeros(3, 1, 61, 83), some(count=40)
    points = feature.laf_to_boundary_points(laf, 12).numpy()
    for border in (0, 5):
        expected = ((points >= border) & (points <= np.array([83, 61]) - border)).all((-1, -2))
        np.testing.assert_array_equal(feature.laf_is_inside_image(laf, images, border), expected)
        assert 0 < expected.sum() < expected.size


# --- homographies -------------------------------------------------------------------------------------------

H = torch.tensor([[1.1, 0.1, -3.0], [-0.05, 0.9, 5.0], [1e-3, -2e-3, 1.0]], dtype=torch.float64)


def test_perspective_is_the_jacobian() -> None:
    laf = some()
    homographies = torch.stack([H, H.mT, torch.eye(3, dtype=torch.float64)])
    mapped = feature.perspective_transform_lafs(homographies, laf)
    for b in range(3):
        for n in range(7):
            centre = laf[b, n, :, 2]
            at = torch.autograd.functional.jacobian(
                lambda p, m=homographies[b]: transform_points(m[None], p[None, None])[0, 0], centre
            )
            close(mapped[b, n, :, :2], at @ laf[b, n, :, :2])
            close(mapped[b, n, :, 2], transform_points(homographies[b][None], centre[None, None])[0, 0])


def test_perspective_of_affine_maps_takes_every_point_along() -> None:
    m = torch.cat([H[:2], torch.tensor([[0.0, 0.0, 1.0]], dtype=torch.float64)])[None]
    laf = some(1)
    moved = feature.laf_to_boundary_points(feature.perspective_transform_lafs(m, laf))
    close(moved, transform_points(m, feature.laf_to_boundary_points(laf)), 1e-10)


def test_singular_frames_have_gradients() -> None:
    laf = torch.zeros(1, 2, 2, 3, requires_grad=True)
    total = (
        feature.get_laf_scale(laf).sum()
        + feature.get_laf_orientation(laf).sum()
        + feature.make_upright(laf).sum()
    )
    total.backward()
    assert laf.grad is not None and torch.isfinite(laf.grad).all()


FRAME, IMAGE = torch.zeros(1, 2, 2, 3), torch.zeros(1, 1, 8, 8)
WRONG = [
    (
        lambda: feature.get_laf_center(FRAME[0]),
        ValueError,
        r"LAF: expected shape \(B, N, 2, 3\), got \[2, 2, 3\]",
    ),
    (lambda: feature.get_laf_scale(FRAME.int()), TypeError, "LAF: expected a floating-point tensor"),
    (
        lambda: feature.rotate_laf(FRAME, torch.zeros(1, 1, 2)),
        ValueError,
        r"angles_degrees: expected shape \(B, N, 1\), got \[1, 1, 2\]",
    ),
    (
        lambda: feature.set_laf_orientation(FRAME, torch.zeros(1)),
        ValueError,
        "angles_degrees: expected shape",
    ),
    (lambda: feature.scale_laf(FRAME[..., :2], 1.0), ValueError, "laf: expected shape"),
    (
        lambda: feature.laf_from_center_scale_ori(torch.zeros(1, 3)),
        ValueError,
        r"xy: expected shape \(B, N, 2\)",
    ),
    (
        lambda: feature.laf_from_center_scale_ori(FRAME[..., 0], torch.zeros(1, 2)),
        ValueError,
        r"scale: expected shape \(B, N, 1, 1\)",
    ),
    (
        lambda: feature.laf_from_center_scale_ori(FRAME[..., 0], None, torch.zeros(1, 2)),
        ValueError,
        r"ori: expected shape \(B, N, 1\)",
    ),
    (lambda: feature.normalize_laf(FRAME, IMAGE[0]), ValueError, r"images: expected shape \(B, C, H, W\)"),
    (lambda: feature.laf_from_three_points(FRAME[0]), ValueError, "threepts: expected shape"),
    (lambda: feature.laf_to_boundary_points(FRAME, 1), ValueError, "n_pts: expected at least 2, got 1"),
    (lambda: feature.ellipse_to_laf(FRAME), ValueError, r"ells: expected shape \(B, N, 5\)"),
    (lambda: feature.laf_is_inside_image(FRAME, IMAGE[0]), ValueError, "images: expected shape"),
    (
        lambda: feature.perspective_transform_lafs(H, FRAME),
        ValueError,
        r"trans_01: expected shape \(B, 3, 3\)",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
