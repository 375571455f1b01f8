"""Geometric augmentations: other libraries' values for given parameters, and the distribution of the
parameters."""

import doctest
import math
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import torch
from scipy import stats
from torch import Tensor, nn
from torchvision.transforms.v2 import functional as vision

from chiasm import augmentation

SEEDS = torch.arange(2000) * 1000003


def photos(batch: int = 5, height: int = 21, width: int = 30, dtype: torch.dtype = torch.float32) -> Tensor:
    return torch.rand(batch, 3, height, width, generator=torch.Generator().manual_seed(1)).to(dtype)


def augmentations() -> dict[str, Any]:
    return {
        "hflip": augmentation.RandomHorizontalFlip(),
        "vflip": augmentation.RandomVerticalFlip(),
        "rotation": augmentation.RandomRotation(30.0),
        "affine": augmentation.RandomAffine(20.0, (0.1, 0.2), (0.5, 2.0), (-5.0, 5.0, -3.0, 3.0)),
        "shear": augmentation.RandomShear(10.0),
        "translate": augmentation.RandomTranslate((-0.1, 0.2), (0.0, 0.3)),
        "perspective": augmentation.RandomPerspective(0.6),
        "area_preserving": augmentation.RandomPerspective(0.6, sampling_method="area_preserving"),
        "erasing": augmentation.RandomErasing(value=0.25),
        "resized_crop": augmentation.RandomResizedCrop((9, 11), p=0.5),
    }


NAMES = list(augmentations())


def from_opencv(image: Tensor, matrix: Tensor, size: tuple[int, int]) -> Tensor:
    planes = image.permute(1, 2, 0).double().numpy()
    warped = cv2.warpPerspective(planes, matrix.numpy(), size[::-1], flags=cv2.INTER_LINEAR)
    return torch.from_numpy(warped).permute(2, 0, 1)


@pytest.mark.parametrize("name", NAMES)
def test_a_sample_does_not_see_its_batch(name: str) -> None:
    augment, images, seed = augmentations()[name], photos(), SEEDS[:5]
    whole = augment(images, seed=seed)
    for i in range(5):
        assert torch.equal(augment(images[i : i + 1], seed=seed[i : i + 1]), whole[i : i + 1])


@pytest.mark.parametrize("name", NAMES)
def test_replay_script_and_the_calls_without_seeds(name: str) -> None:
    augment, images = augmentations()[name], photos()
    first = augment(images, generator=torch.Generator().manual_seed(3))
    params = augment._params
    assert torch.equal(augment(images, generator=torch.Generator().manual_seed(3)), first)
    assert torch.equal(augment(images, params=params), first)
    assert torch.equal(torch.jit.script(augment)(images, params["seed"]), first)
    torch.manual_seed(5)
    drawn = augment(images)
    torch.manual_seed(5)
    assert torch.equal(augment(images), drawn)


@pytest.mark.parametrize("name", NAMES)
def test_same_on_batch_and_one_image(name: str) -> None:
    augment, image = augmentations()[name], photos()[:1]
    augment.same_on_batch = True
    out = augment(image.expand(4, -1, -1, -1), seed=SEEDS[:4])
    assert all(torch.equal(out[0], out[i]) for i in range(1, 4))
    augment.keepdim = True
    assert augment(image[0]).dim() == 3
    augment.keepdim = False
    assert augment(image[0]).dim() == 4


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("dtype", [torch.float32, torch.float64, torch.uint8])
def test_p_of_0_leaves_images_alone(name: str, dtype: torch.dtype) -> None:
    augment = augmentations()[name]
    images = (photos() * 255).to(dtype)
    augment.p = 0.0
    out = augment(images, seed=SEEDS[:5])
    if name == "resized_crop":
        # For bytes, positions are rounded to 1/32 pixel.
        resized = nn.functional.interpolate(images.double(), (9, 11), mode="bilinear", align_corners=True)
        torch.testing.assert_close(out.double(), resized, atol=8.5 if dtype == torch.uint8 else 1e-3, rtol=0)
    else:
        assert torch.equal(out, images)
    torch.testing.assert_close(
        augment.transform_matrix[:, 2], torch.tensor([0.0, 0.0, 1.0]).double().expand(5, 3)
    )


@pytest.mark.parametrize("p", [0.0, 0.3, 1.0])
def test_the_share_of_samples(p: float) -> None:
    for augment in augmentations().values():
        augment.p = p
        share = augment.draw(SEEDS, [2000, 3, 20, 30])["batch_prob"].sum()
        assert abs(float(share) - 2000 * p) <= 3.5 * math.sqrt(2000 * p * (1 - p))


def test_a_batch_as_a_whole() -> None:
    augment: Any = augmentation.RandomHorizontalFlip(p=1.0, p_batch=0.5)
    drawn = [augment.draw(SEEDS[i : i + 3], [3, 1, 2, 2])["batch_prob"] for i in range(90)]
    assert all(bool(d.all()) or not bool(d.any()) for d in drawn)
    assert stats.binomtest(int(sum(d[0] for d in drawn)), 90, 0.5).pvalue > 0.01


def test_flips_are_numpy_s() -> None:
    images = photos()
    pairs: list[tuple[Any, int]] = [
        (augmentation.RandomHorizontalFlip(), 3),
        (augmentation.RandomVerticalFlip(), 2),
    ]
    for augment, axis in pairs:
        out = augment(images, seed=SEEDS[:5])
        for i, flipped in enumerate(augment._params["batch_prob"]):
            expected = np.flip(images.numpy(), axis)[i] if flipped else images[i].numpy()
            assert np.array_equal(out[i].numpy(), expected)


@pytest.mark.parametrize(
    "name", ["rotation", "affine", "shear", "translate", "perspective", "area_preserving"]
)
def test_warps_are_opencv_s(name: str) -> None:
    augment, images = augmentations()[name], photos(dtype=torch.float64)
    augment.p = 1.0
    out = augment(images, seed=SEEDS[:5])
    for image, warped, matrix in zip(images, out, augment.transform_matrix, strict=True):
        # OpenCV rounds positions to 1/32 pixel.
        torch.testing.assert_close(warped, from_opencv(image, matrix, (21, 30)), atol=0.07, rtol=0)


def test_a_rotation_is_torchvision_s() -> None:
    image = photos(1)
    augment: Any = augmentation.RandomRotation(180.0, p=1.0)
    out = augment(image, params={"degrees": torch.tensor([33.0])})
    expected = vision.rotate(image, 33.0, vision.InterpolationMode.BILINEAR)
    inside = vision.rotate(torch.ones_like(image), 33.0, vision.InterpolationMode.BILINEAR) > 0.999
    torch.testing.assert_close(out[inside], expected[inside], atol=1e-4, rtol=0)


def test_an_affine_map_is_torchvision_s() -> None:
    image = photos(1)
    augment: Any = augmentation.RandomAffine(180.0)
    params = {
        "angle": torch.tensor([20.0]),
        "translations": torch.tensor([[3.0, -2.0]]),
        "scale": torch.tensor([[1.3, 1.3]]),
        "shear_x": torch.zeros(1),
        "shear_y": torch.zeros(1),
        "center": torch.tensor([[14.5, 10.0]]),
    }
    out = augment(image, params=params)
    args = (20.0, [3.0, -2.0], 1.3, [0.0, 0.0], vision.InterpolationMode.BILINEAR)
    inside = vision.affine(torch.ones_like(image), *args) > 0.999
    torch.testing.assert_close(out[inside], vision.affine(image, *args)[inside], atol=1e-4, rtol=0)


@pytest.mark.parametrize("align_corners", [True, False])
def test_a_resized_crop_is_a_crop_resized(align_corners: bool) -> None:
    augment: Any = augmentation.RandomResizedCrop((24, 33), (0.2, 0.9), align_corners=align_corners)
    images = photos(20, dtype=torch.float64)
    out = augment(images, seed=SEEDS[:20])
    for image, cropped, box in zip(images, out, augment._params["box"].int().tolist(), strict=True):
        x, y, w, h = box
        part = vision.crop(image, y, x, h, w)[None]
        expected = nn.functional.interpolate(part, (24, 33), mode="bilinear", align_corners=align_corners)[0]
        cut = slice(None) if align_corners else slice(4, -4)  # at its edges, pixels beyond the box count
        torch.testing.assert_close(cropped[:, cut, cut], expected[:, cut, cut], atol=1e-9, rtol=0)


def test_erasing_is_torchvision_s() -> None:
    augment: Any = augmentation.RandomErasing((0.1, 0.3), value=0.25, p=1.0)
    images = photos()
    out = augment(images, seed=SEEDS[:5])
    names = ("ys", "xs", "heights", "widths")
    for i in range(5):
        box = [int(augment._params[name][i]) for name in names]
        assert torch.equal(
            out[i], vision.erase(images[i], box[0], box[1], box[2], box[3], torch.tensor(0.25))
        )
    drawn = augment.draw(SEEDS, [2000, 3, 1000, 1000])
    area = drawn["widths"] * drawn["heights"] / 1e6
    assert stats.kstest(area.numpy(), stats.uniform(0.1, 0.2).cdf).pvalue > 0.005
    assert stats.kstest((drawn["ys"] / (1001 - drawn["heights"])).numpy(), "uniform").pvalue > 0.005


def test_parameters_are_uniform() -> None:
    shape = [2000, 3, 40, 50]
    affine = augmentation.RandomAffine((-10.0, 30.0), (0.1, 0.2), (0.5, 2.0), (-5.0, 5.0, -3.0, 9.0)).draw(
        SEEDS, shape
    )
    perspective = augmentation.RandomPerspective(0.5).draw(SEEDS, shape)
    moved = (perspective["end_points"] - perspective["start_points"]).abs()
    for drawn, low, high in (
        (augmentation.RandomRotation(45.0).draw(SEEDS, shape)["degrees"], -45.0, 45.0),
        (affine["angle"], -10.0, 30.0),
        (affine["translations"][:, 0], -5.0, 5.0),
        (affine["translations"][:, 1], -8.0, 8.0),
        (affine["scale"][:, 0], 0.5, 2.0),
        (affine["shear_x"], -5.0, 5.0),
        (affine["shear_y"], -3.0, 9.0),
        (moved[:, 1, 0], 0.0, 12.5),
        (moved[:, 2, 1], 0.0, 10.0),
    ):
        assert stats.kstest(drawn.numpy(), stats.uniform(low, high - low).cdf).pvalue > 0.005


def test_boxes_of_resized_crops() -> None:
    box = augmentation.RandomResizedCrop((8, 8), (0.05, 0.3)).draw(SEEDS, [2000, 3, 1000, 1000])["box"]
    x, y, w, h = box.T
    assert stats.kstest((w * h / 1e6).numpy(), stats.uniform(0.05, 0.25).cdf).pvalue > 0.005
    ratio = torch.log(w / h).numpy()
    assert stats.kstest(ratio, stats.uniform(math.log(0.75), math.log(16 / 9)).cdf).pvalue > 0.005
    assert stats.kstest((x / (1001 - w)).numpy(), "uniform").pvalue > 0.005
    assert stats.kstest((y / (1001 - h)).numpy(), "uniform").pvalue > 0.005


@pytest.mark.parametrize("shape", [(4, 400), (400, 4), (1, 1)])
def test_a_resized_crop_where_no_box_fits(shape: tuple[int, int]) -> None:
    box = augmentation.RandomResizedCrop((8, 8), (0.9, 1.0)).draw(SEEDS[:9], [9, 3, *shape])["box"]
    x, y, w, h = box.T
    assert bool(((x >= 0) & (y >= 0) & (w >= 1) & (h >= 1) & (x + w <= shape[1]) & (y + h <= shape[0])).all())


def test_what_belongs_to_an_image_moves_with_it() -> None:
    """A white rectangle: its mask, box and corners end where the rectangle does."""
    image = torch.zeros(8, 1, 60, 80)
    image[:, :, 20:40, 30:60] = 1.0
    corners = torch.tensor([[30.0, 20.0], [59.0, 20.0], [59.0, 39.0], [30.0, 39.0]]).expand(8, 4, 2)
    augment: Any = augmentation.AugmentationSequential(
        augmentation.RandomHorizontalFlip(),
        augmentation.RandomAffine(0.0, (0.1, 0.1), (0.8, 1.2)),
        augmentation.RandomVerticalFlip(),
        data_keys=["input", "mask", "bbox", "bbox_xyxy", "bbox_xywh", "keypoints"],
    )
    xyxy = torch.tensor([30.0, 20.0, 60.0, 40.0]).expand(8, 1, 4)
    xywh = torch.tensor([30.0, 20.0, 30.0, 20.0]).expand(8, 1, 4)
    out, mask, box, moved_xyxy, moved_xywh, points = augment(
        image, image, corners[:, None], xyxy, xywh, corners, seed=SEEDS[:8]
    )
    assert set(mask.unique().tolist()) == {0.0, 1.0}
    assert (mask - out).abs().max() <= 0.75 + 1e-5  # at a corner, half a pixel away along both axes
    for i in range(8):
        row, column = torch.nonzero(out[i, 0] > 0.5, as_tuple=True)
        found = torch.stack([column.min(), row.min(), column.max(), row.max()]).float()
        expected = torch.cat([points[i].amin(0), points[i].amax(0)])
        torch.testing.assert_close(found, expected, atol=0.51, rtol=0)
    torch.testing.assert_close(box[:, 0], points)
    torch.testing.assert_close(moved_xyxy[:, 0, :2], points.amin(1))
    torch.testing.assert_close(moved_xyxy[:, 0, 2:], points.amax(1) + 1.0)
    torch.testing.assert_close(moved_xywh[:, 0, 2:], moved_xyxy[:, 0, 2:] - moved_xyxy[:, 0, :2])
    back = augment.inverse(out, mask, box, moved_xyxy, moved_xywh, points)
    for moved, first in zip(back[2:], (corners[:, None], xyxy, xywh, corners), strict=True):
        torch.testing.assert_close(moved, first, atol=1e-4, rtol=0)
    assert (back[1] != image).float().mean() < 0.02


@pytest.mark.parametrize("dtype", [torch.float64, torch.uint8])
@pytest.mark.parametrize("fill", [7.0, (10.0, 20.0, 30.0)])
def test_the_colour_outside_is_opencv_s(fill: Any, dtype: torch.dtype) -> None:
    images = (photos(2) * 255).to(dtype)
    value = torch.tensor(fill) if isinstance(fill, tuple) else fill
    # in Kornia's position, before p
    half: Any = augmentation.RandomAffine(
        0.0, None, (0.5, 0.5), None, "bilinear", False, False, "fill", value, 1.0
    )
    out = half(images, seed=SEEDS[:2])
    assert torch.equal(torch.jit.script(half)(images, SEEDS[:2]), out)
    colour = fill if isinstance(fill, tuple) else (fill,) * 3
    for image, warped in zip(images, out, strict=True):
        matrix = half.transform_matrix[0].numpy()
        expected = cv2.warpPerspective(
            image.permute(1, 2, 0).double().numpy(), matrix, (30, 21), borderValue=colour
        )
        if dtype == torch.uint8:
            expected = np.floor(expected + 0.5)
        np.testing.assert_allclose(warped.permute(1, 2, 0).numpy(), expected, atol=1e-9)
    labels = torch.ones(2, 1, 21, 30, dtype=torch.int64)
    sequence: Any = augmentation.AugmentationSequential(half, data_keys=["input", "mask"])
    for mask in (labels, labels.double()):
        moved = sequence(images, mask)[1]
        outside = 7 if fill == 7.0 else 0
        assert moved[:, :, :4].unique().tolist() == [outside]
        assert moved[:, :, 10, 14].unique().tolist() == [1]
    with pytest.raises(ValueError, match="fill_value: expected a number, or 3, one a channel, got"):
        augmentation.RandomAffine(1.0, padding_mode="fill", fill_value=(1, 2), p=1.0)(images)
    with pytest.raises(ValueError, match="padding_mode: expected one of"):
        augmentation.RandomShear(1.0, padding_mode="reflect")


def test_the_way_back_of_one_augmentation() -> None:
    images = photos(3)
    flip: Any = augmentation.RandomHorizontalFlip()
    assert torch.equal(flip.inverse(flip(images)), images)
    crop: Any = augmentation.RandomCrop((9, 11), keepdim=True)
    out, (x, y) = crop(images[0]), crop._params["corner"][0].tolist()
    expected = torch.zeros_like(images[0])
    expected[:, y : y + 9, x : x + 11] = out
    assert torch.equal(crop.inverse(out), expected)
    turn: Any = augmentation.RandomRotation90((1, 1), p=1.0)
    turned = turn(photos(3, 20, 20))
    params = turn._params
    turn(images[:2])
    assert torch.equal(turn.inverse(turned, params=params), turned.rot90(-1, (2, 3)))
    with pytest.raises(ValueError, match="input: expected 2 images, as many as in the call, got 3"):
        turn.inverse(turned)
    with pytest.raises(ValueError, match="params: expected the parameters of a call"):
        augmentation.RandomVerticalFlip().inverse(images)


def test_a_sequence_draws_for_each_step() -> None:
    augment: Any = augmentation.AugmentationSequential(
        *[augmentation.RandomHorizontalFlip() for _ in range(2)]
    )
    images, seed = photos(40), SEEDS[:40]
    out = augment(images, seed=seed)
    first, second = (p["batch_prob"] for p in augment._params)
    assert not torch.equal(first, second)
    assert torch.equal(out, torch.where((first ^ second)[:, None, None, None], images.flip(3), images))
    assert torch.equal(augment.forward(images, seed), out)
    assert torch.equal(augment(images, params=augment._params), out)
    assert torch.equal(torch.jit.script(augment)(images, seed), out)


@pytest.mark.parametrize("name", ["hflip", "rotation", "affine", "perspective", "resized_crop"])
def test_gradients(name: str) -> None:
    augment = augmentations()[name]
    images = photos(2, 5, 6, torch.float64)[:, :1].clone().requires_grad_()
    assert torch.autograd.gradcheck(lambda x: augment.forward(x, SEEDS[:2]), images, fast_mode=True)


def test_what_is_refused() -> None:
    flip = augmentation.random_horizontal_flip
    with pytest.raises(TypeError, match="seed: expected an int64 tensor"):
        flip(photos(), torch.zeros(5))
    with pytest.raises(ValueError, match=r"seed: expected shape \(5,\), one seed a sample, got \[4\]"):
        flip(photos(), SEEDS[:4])
    with pytest.raises(ValueError, match="p: expected a probability, 0 to 1, got 2"):
        augmentation.RandomVerticalFlip(p=2)
    with pytest.raises(ValueError, match="degrees: expected a number"):
        augmentation.RandomRotation((3.0, 1.0))
    with pytest.raises(ValueError, match="resample: expected"):
        augmentation.RandomRotation(3.0, "lanczos")
    with pytest.raises(ValueError, match="data_keys: expected some of"):
        augmentation.AugmentationSequential(data_keys=["boxes"])
    with pytest.raises(ValueError, match="args: expected 1 tensors"):
        augmentation.AugmentationSequential()(photos(), SEEDS[:5], SEEDS[:5])


def test_the_page() -> None:
    page = Path(__file__).resolve().parents[2] / "docs" / "augmentation.md"
    tested = doctest.testfile(str(page), module_relative=False)
    assert tested.attempted > 8
    assert tested.failed == 0
