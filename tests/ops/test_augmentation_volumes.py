"""Augmentations of volumes: SciPy's, NumPy's and Pillow's values for the drawn numbers, and the distribution
of these numbers."""

import inspect
import math
from typing import Any

import numpy as np
import pytest
import scipy.ndimage
import torch
from PIL import Image, ImageOps
from scipy import stats
from scipy.spatial.transform import Rotation
from torch import Tensor

from chiasm import augmentation as A
from chiasm.filters import get_motion_kernel3d
from chiasm.primitives.random.draws import uniform

SEEDS = torch.arange(2000) * 1000003
SHAPE = [2000, 1, 20, 30, 40]


def volumes(batch: int = 5, dtype: torch.dtype = torch.float32) -> Tensor:
    made = torch.randint(0, 256, (batch, 2, 6, 9, 11), generator=torch.Generator().manual_seed(1))
    return made.to(dtype) if dtype == torch.uint8 else (made / 255.0).to(dtype)


def augmentations() -> dict[str, Any]:
    return {
        "hflip": A.RandomHorizontalFlip3D(),
        "vflip": A.RandomVerticalFlip3D(),
        "dflip": A.RandomDepthicalFlip3D(),
        "rotation": A.RandomRotation3D((30.0, 20.0, 45.0)),
        "affine": A.RandomAffine3D(20.0, (0.1, 0.2, 0.3), (0.5, 2.0), 8.0),
        "perspective": A.RandomPerspective3D(0.4),
        "crop": A.RandomCrop3D((4, 7, 12), padding=(1, 2, 3), padding_mode="reflect"),
        "center": A.CenterCrop3D((4, 6, 7)),
        "equalize": A.RandomEqualize3D(),
        "motion": A.RandomMotionBlur3D((3, 7), 40.0, 0.5),
    }


NAMES = list(augmentations())
WARPS = ["rotation", "affine", "perspective"]
FLIPS = ["hflip", "vflip", "dflip"]


@pytest.mark.parametrize("name", NAMES)
def test_a_sample_does_not_see_its_batch_and_calls_repeat(name: str) -> None:
    augment, x, seed = augmentations()[name], volumes(), SEEDS[:5]
    whole = augment(x, seed=seed)
    for i in range(5):
        assert torch.equal(augment(x[i : i + 1], seed=seed[i : i + 1]), whole[i : i + 1])
    assert torch.equal(augment(x, seed=seed), whole)
    assert torch.equal(augment(x, params=augment._params), whole)
    assert torch.equal(torch.jit.script(augment)(x, seed), whole)
    assert torch.equal(augment.forward(x, seed), whole)


@pytest.mark.parametrize("name", NAMES)
def test_same_on_batch_one_volume_and_p_of_0(name: str) -> None:
    augment, x = augmentations()[name], volumes()[:1]
    assert augment(x[0]).dim() == 5
    augment.keepdim = True
    assert augment(x[0]).dim() == 4
    augment.same_on_batch = True
    out = augment(x.expand(4, -1, -1, -1, -1), seed=SEEDS[:4])
    assert all(torch.equal(out[0], out[i]) for i in range(1, 4))
    if name not in ("crop", "center"):
        augment.p = 0.0
        assert torch.equal(augment(volumes(), seed=SEEDS[:5]), volumes())


@pytest.mark.parametrize("name", NAMES)
def test_classes_are_their_functions(name: str) -> None:
    x, seed = volumes(), SEEDS[:5]
    degrees = [(-30.0, 30.0), (-20.0, 20.0), (-45.0, 45.0)]
    all_of: Any = lambda size, count: [(-size, size)] * count  # noqa: E731
    expected = {
        "hflip": lambda: A.random_horizontal_flip3d(x, seed),
        "vflip": lambda: A.random_vertical_flip3d(x, seed),
        "dflip": lambda: A.random_depthical_flip3d(x, seed),
        "rotation": lambda: A.random_rotation3d(x, seed, degrees),
        "affine": lambda: A.random_affine3d(
            x, seed, all_of(20.0, 3), (0.1, 0.2, 0.3), [(0.5, 2.0)], all_of(8.0, 6)
        ),
        "perspective": lambda: A.random_perspective3d(x, seed, 0.4),
        "crop": lambda: A.random_crop3d(x, seed, (4, 7, 12), (1, 1, 2, 2, 3, 3), padding_mode="reflect"),
        "center": lambda: x[:, :, 1:5, 1:7, 2:9],
        "equalize": lambda: A.random_equalize3d(x, seed),
        "motion": lambda: A.random_motion_blur3d(x, seed, (3, 7), all_of(40.0, 3), (-0.5, 0.5)),
    }[name]()
    assert torch.equal(augmentations()[name](x, seed=seed), expected)


@pytest.mark.parametrize("name", FLIPS)
@pytest.mark.parametrize("dtype", [torch.float32, torch.uint8])
def test_flips_are_numpy_s(name: str, dtype: torch.dtype) -> None:
    augment, x = augmentations()[name], volumes(20, dtype)
    out = augment(x, seed=SEEDS[:20])
    flipped = augment._params["batch_prob"]
    assert 0 < int(flipped.sum()) < 20
    for i in range(20):
        axis = {"hflip": 3, "vflip": 2, "dflip": 1}[name]
        expected = np.flip(x[i].numpy(), axis) if flipped[i] else x[i].numpy()
        np.testing.assert_array_equal(out[i].numpy(), expected)
    point = torch.tensor([2.0, 3.0, 1.0, 1.0]).double()
    for matrix, is_flipped in zip(augment.transform_matrix, flipped, strict=True):
        moved = [10 - 2, 3, 1] if name == "hflip" else [2, 8 - 3, 1] if name == "vflip" else [2, 3, 5 - 1]
        assert (matrix @ point)[:3].tolist() == (moved if is_flipped else [2, 3, 1])


def by_scipy(volume: Tensor, matrix: Tensor) -> np.ndarray:
    """out(p) = volume(matrix^-1 p), with zeros outside."""
    z, y, x = np.meshgrid(*[np.arange(n) for n in volume.shape[1:]], indexing="ij")
    points = np.stack([x, y, z, np.ones_like(x)]).reshape(4, -1)
    back = np.linalg.inv(matrix.numpy()) @ points
    at = (back[:3] / back[3])[::-1].reshape(3, *volume.shape[1:])
    planes = [
        scipy.ndimage.map_coordinates(plane, at, order=1, mode="grid-constant") for plane in volume.numpy()
    ]
    return np.stack(planes)


@pytest.mark.parametrize("name", WARPS)
def test_warps_are_scipy_s(name: str) -> None:
    augment, x = augmentations()[name], volumes(8, torch.float64)
    out = augment(x, seed=SEEDS[:8])
    assert 0 < int(augment._params["batch_prob"].sum()) < 8
    for volume, warped, matrix in zip(x, out, augment.transform_matrix, strict=True):
        np.testing.assert_allclose(warped.numpy(), by_scipy(volume, matrix), atol=1e-9)


def about(middle: np.ndarray, linear: np.ndarray) -> np.ndarray:
    """The homography of a linear map that keeps the centre fixed."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = linear, middle - linear @ middle
    return matrix


def test_matrices_are_those_of_the_drawn_numbers() -> None:
    x, middle = volumes(8), np.array([5.0, 4.0, 2.5])
    rotation = augmentations()["rotation"]
    rotation(x, seed=SEEDS[:8])
    angles, chosen = rotation._params["angles"].double().numpy(), rotation._params["batch_prob"]
    for i in range(8):
        turn = Rotation.from_rotvec(angles[i], degrees=True).as_matrix()
        expected = about(middle, turn) if chosen[i] else np.eye(4)
        np.testing.assert_allclose(rotation.transform_matrix[i].numpy(), expected, atol=1e-6)
    affine = augmentations()["affine"]
    affine(x, seed=SEEDS[:8])
    params = {k: v.double().numpy() for k, v in affine._params.items() if k != "seed"}
    for i in range(8):
        turn = Rotation.from_rotvec(-params["angles"][i], degrees=True).as_matrix()
        xy, xz, yx, yz, zx, zy = -np.tan(np.radians(params["shears"][i]))
        shear = (
            np.array([[1, 0, 0], [xy, 1, 0], [xz, 0, 1]])
            @ np.array([[1, yx, 0], [0, 1, 0], [0, yz, 1]])
            @ np.array([[1, 0, zx], [0, 1, zy], [0, 0, 1]])
        )
        expected = about(middle, turn * params["scale"][i] @ shear)
        expected[:3, 3] += params["translations"][i]
        found = affine.transform_matrix[i].numpy()
        np.testing.assert_allclose(found, expected if params["batch_prob"][i] else np.eye(4), atol=1e-6)
    perspective: Any = A.RandomPerspective3D(0.4, p=1.0)
    perspective(x, seed=SEEDS[:8])
    start, end = perspective._params["start_points"], perspective._params["end_points"]
    assert start[0, 6].tolist() == [10.0, 8.0, 5.0]
    for i in range(8):
        for corner in (0, 1, 2, 5, 7):
            moved = perspective.transform_matrix[i] @ torch.cat([start[i, corner], torch.ones(1).double()])
            torch.testing.assert_close(moved[:3] / moved[3], end[i, corner], atol=1e-9, rtol=0)


def test_parameters_are_uniform() -> None:
    affine: Any = A.RandomAffine3D(
        [(-10.0, 30.0), (0.0, 5.0), (-3.0, 3.0)],
        (0.1, 0.2, 0.3),
        [(0.5, 2.0), (1.0, 3.0), (0.9, 1.1)],
        [(float(i), 2.0 * i + 1.0) for i in range(6)],
    )
    drawn = affine.draw(SEEDS, SHAPE)
    one = A.RandomAffine3D(10.0, scale=(0.5, 2.0)).draw(SEEDS, SHAPE)["scale"]
    assert torch.equal(one, one[:, :1].expand_as(one))
    moved = A.RandomPerspective3D(0.5).draw(SEEDS, SHAPE)
    moved = (moved["end_points"] - moved["start_points"]).abs()
    for numbers, low, high in (
        (A.RandomRotation3D((5.0, 20.0)).draw(SEEDS, SHAPE)["angles"][:, 2], 5.0, 20.0),
        (drawn["angles"][:, 0], -10.0, 30.0),
        (drawn["angles"][:, 1], 0.0, 5.0),
        (drawn["translations"][:, 0], -4.0, 4.0),
        (drawn["translations"][:, 1], -6.0, 6.0),
        (drawn["translations"][:, 2], -6.0, 6.0),
        (drawn["scale"][:, 1], 1.0, 3.0),
        (one[:, 0], 0.5, 2.0),
        *[(drawn["shears"][:, i], float(i), 2.0 * i + 1.0) for i in range(6)],
        (moved[:, 1, 0], 0.0, 10.0),
        (moved[:, 7, 2], 0.0, 5.0),
    ):
        assert stats.kstest(numbers.numpy(), stats.uniform(low, high - low).cdf).pvalue > 0.005
    for augment in augmentations().values():
        share = augment.draw(SEEDS, SHAPE)["batch_prob"].sum()
        expected = 2000 * augment.p
        assert abs(float(share) - expected) <= 3.5 * math.sqrt(expected * (1 - augment.p))


@pytest.mark.parametrize(
    ("mode", "how"),
    [("constant", "constant"), ("reflect", "reflect"), ("replicate", "edge"), ("circular", "wrap")],
)
@pytest.mark.parametrize("dtype", [torch.float32, torch.uint8])
def test_crops_are_numpy_s(mode: str, how: Any, dtype: torch.dtype) -> None:
    x = volumes(8, dtype)
    crop: Any = A.RandomCrop3D((5, 8, 12), (2, 3, 1, 0, 2, 1), fill=7, padding_mode=mode)
    out = crop(x, seed=SEEDS[:8])
    more: dict[str, Any] = {"constant_values": 7} if mode == "constant" else {}
    padded = np.pad(x.numpy(), ((0, 0), (0, 0), (2, 1), (1, 0), (2, 3)), how, **more)
    for i, (left, top, front) in enumerate((crop._params["corner"] + torch.tensor([2, 1, 2])).tolist()):
        expected = padded[i, :, front : front + 5, top : top + 8, left : left + 12]
        np.testing.assert_array_equal(out[i].numpy(), expected)
    assert torch.equal(crop.transform_matrix[:, :3, 3], -crop._params["corner"].double())


def test_crops_lie_anywhere_and_larger_ones_are_padded() -> None:
    corner = A.RandomCrop3D((17, 30, 36)).draw(SEEDS, SHAPE)["corner"]
    for axis, places in ((0, 5), (1, 1), (2, 4)):
        counts = torch.bincount(corner[:, axis], minlength=places)
        assert len(counts) == places
        assert places == 1 or stats.chisquare(counts.numpy()).pvalue > 0.01
    padded: Any = A.RandomCrop3D((8, 9, 5), pad_if_needed=True)
    out = padded(torch.ones(200, 1, 6, 9, 5), seed=SEEDS[:200])
    first = out[:, 0, :, 0, 0].argmax(1)
    assert set(first.tolist()) == {0, 1, 2}
    for sample, begins in zip(out, first.tolist(), strict=True):
        assert sample.sum() == sample[:, begins : begins + 6].sum() == 6 * 9 * 5
    centred = np.pad(np.ones((1, 1, 3, 3, 3)), ((0, 0), (0, 0), (1, 0), (1, 0), (1, 0)))
    np.testing.assert_array_equal(A.CenterCrop3D(4)(torch.ones(1, 1, 3, 3, 3)).numpy(), centred)


def test_levels_are_pillow_s() -> None:
    x = volumes()
    out = A.RandomEqualize3D(1.0)(x)
    for volume, made in zip(x.flatten(0, 1), out.flatten(0, 1), strict=True):
        levels = (volume * 255).round().byte().reshape(54, 11).numpy()
        expected = np.asarray(ImageOps.equalize(Image.fromarray(levels)))
        np.testing.assert_array_equal((made * 255).round().byte().reshape(54, 11).numpy(), expected)


def test_motion_blur_is_scipy_s() -> None:
    x, u = volumes(8, torch.float64), uniform(SEEDS[:8], 6).double()
    angle = [(-30.0, 30.0), (0.0, 40.0), (-90.0, 10.0)]
    out = A.random_motion_blur3d(x, SEEDS[:8], (3, 7), angle, (-1.0, 0.5), "constant", "bilinear", 0.7)
    sizes = set()
    for b in range(8):
        if u[b, 0] >= 0.7:
            assert torch.equal(out[b], x[b])
            continue
        turn = torch.tensor(
            [[float(u[b, 1 + i]) * (high - low) + low for i, (low, high) in enumerate(angle)]]
        )
        size = 3 + 2 * min(int(u[b, 5] * 3), 2)
        sizes.add(size)
        kernel = get_motion_kernel3d(size, turn.double(), u[b : b + 1, 4] * 1.5 - 1.0, "bilinear")[0].numpy()
        for plane, made in zip(x[b].numpy(), out[b].numpy(), strict=True):
            expected = scipy.ndimage.correlate(plane, kernel, mode="constant")
            np.testing.assert_allclose(made, expected, atol=1e-9)
    assert len(sizes) > 1


@pytest.mark.parametrize("name", [*FLIPS, *WARPS, "crop", "motion"])
def test_gradients(name: str) -> None:
    augment = augmentations()[name]
    augment.p = 1.0
    x = volumes(1, torch.float64)[:, :1].clone().requires_grad_()
    assert torch.autograd.gradcheck(lambda v: augment.forward(v, SEEDS[:1]), x, fast_mode=True)


def test_masks_go_along_in_a_sequence() -> None:
    mask = (volumes(6) > 0.5).float()
    sequence = A.AugmentationSequential(
        A.RandomHorizontalFlip3D(), A.RandomCrop3D((4, 8, 9)), A.RandomDepthicalFlip3D(),
        A.RandomRotation3D(20.0, "nearest"), data_keys=["input", "mask"],
    )  # fmt: skip
    out, moved = sequence(mask, mask, seed=SEEDS[:6])
    assert torch.equal(out, moved) and out.shape == (6, 2, 4, 8, 9)
    assert torch.equal(torch.jit.script(sequence)(mask, SEEDS[:6]), out)
    assert sequence.transform_matrix.shape == (6, 4, 4)
    flips = A.AugmentationSequential(A.RandomVerticalFlip3D(), A.RandomDepthicalFlip3D())
    assert torch.equal(flips.inverse(flips(mask)), mask)


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        *[(f"Random{n}Flip3D", "same_on_batch p keepdim") for n in ("Horizontal", "Vertical", "Depthical")],
        ("RandomRotation3D", "degrees resample same_on_batch align_corners p keepdim"),
        (
            "RandomAffine3D",
            "degrees translate scale shears resample same_on_batch align_corners p keepdim",
        ),
        ("RandomPerspective3D", "distortion_scale resample same_on_batch align_corners p keepdim"),
        (
            "RandomCrop3D",
            "size padding pad_if_needed fill padding_mode resample same_on_batch align_corners p keepdim",
        ),
        ("CenterCrop3D", "size align_corners resample p keepdim"),
        ("RandomEqualize3D", "p same_on_batch keepdim"),
        (
            "RandomMotionBlur3D",
            "kernel_size angle direction border_type resample same_on_batch p keepdim",
        ),
    ],
)
def test_constructors_order(name: str, parameters: str) -> None:
    assert list(inspect.signature(getattr(A, name)).parameters) == parameters.split()


def test_ranges_of_settings() -> None:
    for given, expected in (
        (10.0, [(-10.0, 10.0)] * 3),
        ((5.0, 20.0), [(5.0, 20.0)] * 3),
        ([1.0, 2.0, 3.0], [(-1.0, 1.0), (-2.0, 2.0), (-3.0, 3.0)]),
        (((1, 2), (3, 4), (5, 6)), [(1.0, 2.0), (3.0, 4.0), (5.0, 6.0)]),
        (torch.tensor([1.0, 2.0, 3.0]), [(-1.0, 1.0), (-2.0, 2.0), (-3.0, 3.0)]),
    ):
        assert A.RandomRotation3D(given).degrees == expected


def test_a_perspective_needs_two_voxels_along_each_side() -> None:
    x = torch.rand(1, 1, 2, 2, 2)
    torch.testing.assert_close(A.random_perspective3d(x, SEEDS[:1], 0.0, p=1.0), x)
    for side in (2, 3, 4):
        with pytest.raises(ValueError, match="input: expected at least 2 voxels along each side"):
            A.random_perspective3d(x.narrow(side, 0, 1), SEEDS[:1])
        with pytest.raises(ValueError, match="input: expected at least 2 voxels along each side"):
            A.RandomPerspective3D()(x.narrow(side, 0, 1))


def test_what_is_refused() -> None:
    x = volumes()
    with pytest.raises(TypeError, match="input: expected a floating-point tensor"):
        A.random_rotation3d(volumes(dtype=torch.uint8), SEEDS[:5], [(0.0, 1.0)] * 3)
    with pytest.raises(ValueError, match=r"input: expected shape \(B, C, D, H, W\)"):
        A.random_crop3d(x[0], SEEDS[:2], (1, 1, 1))
    with pytest.raises(ValueError, match=r"degrees: expected \[3\] ranges"):
        A.random_affine3d(x, SEEDS[:5], [(0.0, 1.0)])
    with pytest.raises(ValueError, match=r"scale: expected \[1, 3\] ranges"):
        A.random_affine3d(x, SEEDS[:5], [(0.0, 1.0)] * 3, scale=[(1.0, 1.0)] * 2)
    with pytest.raises(ValueError, match=r"shears: expected \[6\] ranges"):
        A.random_affine3d(x, SEEDS[:5], [(0.0, 1.0)] * 3, shears=[(1.0, 1.0)] * 2)
    with pytest.raises(ValueError, match="translate: expected three numbers"):
        A.RandomAffine3D(1.0, (0.1, 0.2))
    with pytest.raises(ValueError, match="scale: expected a range of positive"):
        A.RandomAffine3D(1.0, scale=(0.0, 0.2))
    with pytest.raises(ValueError, match="resample: expected 'bilinear' or 'nearest'"):
        A.RandomAffine3D(1.0, resample="bicubic")
    with pytest.raises(ValueError, match="distortion_scale: expected 0 to 1"):
        A.RandomPerspective3D(1.5)
    with pytest.raises(ValueError, match="padding: expected 1, 3 or 6 numbers"):
        A.RandomCrop3D(3, (1, 2))
    with pytest.raises(ValueError, match="size: expected at most 6 along an axis of 6"):
        A.RandomCrop3D(7)(x)
    with pytest.raises(ValueError, match="size: expected a positive number"):
        A.CenterCrop3D((3, 2))
    with pytest.raises(ValueError, match="p: expected 1"):
        A.CenterCrop3D(3, p=0.5)
    with pytest.raises(ValueError, match="kernel_size: expected odd"):
        A.random_motion_blur3d(x, SEEDS[:5], (3, 4), [(0.0, 1.0)] * 3, (0.0, 1.0))
    with pytest.raises(ValueError, match="angle: expected three ranges"):
        A.random_motion_blur3d(x, SEEDS[:5], (3, 5), [(0.0, 1.0)], (0.0, 1.0))
