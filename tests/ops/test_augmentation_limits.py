"""Settings, shapes and precisions at the limits of what augmentations take."""

from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

from chiasm import augmentation as A
from chiasm.augmentation.classes import CLASSES

SEEDS = torch.arange(8) * 1000003
HALVES = (torch.float16, torch.bfloat16)


def rand(*shape: int, seed: int = 0) -> Tensor:
    return torch.rand(shape, generator=torch.Generator().manual_seed(seed))


@pytest.mark.parametrize("dtype", HALVES)
def test_constant_images_of_half_precision(dtype: torch.dtype) -> None:
    flat = torch.full((1, 3, 4, 5), 0.5, dtype=dtype)
    assert not CLASSES["RandomAutoContrast"]()(flat).any()  # (x - min) is 0
    pixel = flat[:, :, :1, :1]  # whose plasma is 0
    seed = SEEDS[:1]
    bright = A.random_plasma_brightness(pixel, seed, intensity=(0.25, 0.25), p=1.0)
    assert torch.equal(bright, torch.full_like(pixel, 0.25))
    assert torch.equal(A.random_plasma_contrast(pixel, seed, p=1.0), pixel)


@pytest.mark.parametrize("dtype", HALVES)
def test_labels_beside_images_of_half_precision(dtype: torch.dtype) -> None:
    images, labels = rand(4, 1, 32, 32).to(dtype), torch.tensor([257, 1001, 2049, 65537])
    _, mixed = A.random_mix_up(images, labels, SEEDS[:4], (0.3, 0.3))
    assert mixed.dtype == torch.float32
    assert torch.equal(mixed[:, 0], labels.float())
    assert set(mixed[:, 1].long().tolist()) == set(labels.tolist())
    _, pasted = A.random_cut_mix(images, labels, SEEDS[:4], cut_size=(0.3, 0.3))
    assert pasted.dtype == torch.float32
    assert torch.equal(pasted[0, :, 0], labels.float())
    side = int(np.sqrt(0.7) * 32)
    assert pasted[0, :, 2].tolist() == [side * side / 1024] * 4
    assert A.random_cut_mix(images.double(), labels, SEEDS[:4])[1].dtype == torch.float64


@pytest.mark.parametrize("dtype", HALVES)
def test_masks_of_half_precision_follow_elastic_images(dtype: torch.dtype) -> None:
    images = torch.arange(64.0 * 64).reshape(1, 1, 64, 64) % 250
    deform = A.RandomElasticTransform((9, 9), (4.0, 4.0), p=1.0, resample="nearest")
    augment = A.AugmentationSequential(deform, data_keys=["input", "mask"])
    moved, mask = augment(images, images.to(dtype), seed=SEEDS[:1])
    assert mask.dtype == dtype
    assert torch.equal(mask.float(), moved)
    assert torch.equal(augment(images.to(dtype), images, seed=SEEDS[:1])[0], mask)


@pytest.mark.parametrize("mode", ["bilinear", "nearest"])
def test_the_way_back_of_a_resized_crop_is_black_outside_the_box(mode: str) -> None:
    images, labels = 0.25 + 0.5 * rand(6, 2, 24, 30), torch.ones(6, 1, 24, 30, dtype=torch.uint16)
    for size in ((48, 60), (7, 9)):
        crop = A.RandomResizedCrop(size, scale=(0.2, 0.4), resample=mode, p=0.5)
        overlap = A.RandomIoUCrop(size=size, sampler_options=[0.0, 1.0], resample=mode)
        boxes = torch.tensor([[[4.0, 4.0, 20.0, 20.0]]]).expand(6, 1, 4)
        for step in (crop, overlap):
            augment = A.AugmentationSequential(step, data_keys=["input", "mask", "bbox_xyxy"])
            out, mask, _ = augment(images, labels, boxes, seed=SEEDS[:6])
            back, seen = augment.inverse(out, mask, data_keys=["input", "mask"])
            params = augment._params[0]
            assert set(params["batch_prob"].tolist()) == {True, False}
            for i in range(6):
                x, y, w, h = params["box"][i].long().tolist() if params["batch_prob"][i] else (0, 0, 30, 24)
                inside = torch.zeros(24, 30, dtype=torch.bool)
                inside[y : y + h, x : x + w] = True
                assert torch.equal(back[i] > 0.24, inside.expand(2, 24, 30))
                assert not back[i][:, ~inside].any()
                assert torch.equal(seen[i, 0].long(), inside.long())


def test_the_dimensions_of_images() -> None:
    for augment in (
        A.RandomHorizontalFlip(p=1.0),
        A.RandomErasing(p=1.0),
        A.RandomCrop((2, 2)),
        A.RandomJigsaw((1, 2), p=1.0),
        CLASSES["RandomInvert"](p=1.0),
    ):
        for shape in ((4, 6), (1, 1, 1, 4, 6), (6,)):
            with pytest.raises(ValueError, match=r"input: expected shape \(B, C, H, W\) or \(C, H, W\), got"):
                augment(torch.rand(shape))
    with pytest.raises(ValueError, match=r"input: expected shape \(B, C, D, H, W\) or \(C, D, H, W\), got"):
        A.RandomHorizontalFlip3D()(torch.rand(3, 4, 6))
    with pytest.raises(TypeError, match="input: expected a tensor, got ndarray"):
        A.RandomHorizontalFlip()(np.zeros((1, 2, 3, 4)))  # pyright: ignore


@pytest.mark.parametrize("shape", [(1, 9), (9, 1), (1, 1)])
@pytest.mark.parametrize("method", ["basic", "area_preserving"])
def test_a_perspective_of_one_row_or_column(shape: tuple[int, int], method: str) -> None:
    images = torch.ones(8, 1, *shape)
    still = A.RandomPerspective(0.0, p=1.0, sampling_method=method)
    torch.testing.assert_close(still(images, seed=SEEDS), images)
    augment = A.RandomPerspective(0.5, p=1.0, sampling_method=method)
    out = augment(images, seed=SEEDS)
    assert augment.transform_matrix.isfinite().all()
    assert (torch.linalg.det(augment.transform_matrix).abs() > 1e-3).all()
    assert (out.flatten(1).amax(1) > 0.1).all()
    # The matrix takes the corners of the drawn quadrangle where they were drawn to.
    start, end = augment._params["start_points"], augment._params["end_points"]
    moved = torch.cat([start, torch.ones(8, 4, 1)], -1) @ augment.transform_matrix.mT
    torch.testing.assert_close(moved[..., :2] / moved[..., 2:], end)
    sides = torch.tensor([max(shape[1] - 1, 1), max(shape[0] - 1, 1)]).double().expand(8, 2)
    assert torch.equal(start[:, 2] - start[:, 0], sides)
    middle = torch.tensor([shape[1] - 1, shape[0] - 1]) / 2
    assert torch.equal(start.mean(1), middle.double().expand(8, 2))


def test_fills_of_bytes_are_limited() -> None:
    white = torch.full((1, 3, 4, 4), 7, dtype=torch.uint8)
    for fill, level in ((300.0, 255), (-5.0, 0), (9.0, 9)):
        augments: list[Any] = [
            A.RandomZoomOut(fill, (2.0, 2.0), p=1.0),
            A.ScaleJitter((4, 4), (0.5, 0.5), canvas=4, fill=fill),
            A.RandomShortestSize(2, canvas=(4, 4), fill=fill),
            A.RandomCrop((4, 4), padding=4, fill=fill),
            A.PadTo((5, 5), pad_value=fill),
            A.RandomErasing((0.25, 0.25), (1.0, 1.0), fill, p=1.0),
            CLASSES["RandomChannelDropout"](2, fill, p=1.0),
        ]
        for augment in augments:
            found = set(augment(white, seed=SEEDS[3:4]).unique().tolist())
            assert level in found
            assert found <= {7, level}
    crop = A.RandomCrop3D((4, 4, 4), padding=4, fill=300.0)
    assert crop(torch.zeros(1, 1, 4, 4, 4, dtype=torch.uint8), seed=SEEDS[3:4]).max() == 255
    assert A.random_crop(white / 255, SEEDS[3:4], (4, 4), (4, 4, 4, 4), fill=300.0).max() == 300.0


@pytest.mark.parametrize("dtype, fill", [(torch.uint16, 65535), (torch.uint16, 40000), (torch.uint32, 2**31)])
def test_fills_of_unsigned_masks(dtype: torch.dtype, fill: int) -> None:
    shift = A.RandomAffine(0.0, padding_mode="fill", fill_value=float(fill), p=1.0)
    augment = A.AugmentationSequential(shift, data_keys=["input", "mask"])
    params = shift.draw(SEEDS[:1], [1, 1, 2, 3])
    params["translations"] = torch.tensor([[1.0, 0.0]])
    labels = torch.tensor([[[[1, 2, 3], [4, 5, 60000]]]]).to(dtype)
    _, mask = augment(torch.rand(1, 1, 2, 3), labels, params=[params])
    assert mask.dtype == dtype
    assert mask.long().tolist() == [[[[fill, 1, 2], [fill, 4, 5]]]]


def test_white_of_each_channel() -> None:
    images, white = rand(2, 3, 4, 5), torch.tensor([1.0, 0.5, 2.0])[:, None, None]
    augment = CLASSES["RandomInvert"](white, p=1.0)
    assert torch.equal(augment(images), white - images)
    assert torch.equal(torch.jit.script(augment)(images, SEEDS[:2]), white - images)
    assert dict(augment.named_buffers())["max_val"] is white
    assert CLASSES["RandomInvert"](torch.tensor(1.0)).max_val == 1.0


def test_the_way_back_from_one_row() -> None:
    augment = A.AugmentationSequential(A.Resize((1, 4)), data_keys=["input", "bbox_xyxy"])
    images, boxes = torch.rand(1, 1, 3, 4), torch.tensor([[[0.0, 0.0, 4.0, 1.0]]])
    out, moved = augment(images, boxes)
    back, there = augment.inverse(out, moved)
    assert back.shape == images.shape
    torch.testing.assert_close(there, boxes)


@pytest.mark.parametrize("align_corners", [True, False])
def test_points_stay_inside_one_row(align_corners: bool) -> None:
    resize = A.Resize((1, 4), align_corners=align_corners)
    augment = A.AugmentationSequential(resize, data_keys=["input", "keypoints"])
    _, moved = augment(torch.rand(1, 1, 12, 10), torch.tensor([[[0.0, 0.0], [3.0, 7.0], [9.0, 11.0]]]))
    assert (moved >= -0.5).all() and (moved <= torch.tensor([3.5, 0.5])).all()


IMAGES, NO = torch.ones(1, 1, 4, 4), SEEDS[:1]
VOLUME = torch.ones(1, 1, 4, 4, 4)
STILL = [(0.0, 0.0)] * 3


@pytest.mark.parametrize(
    "call, message",
    [
        (
            lambda: A.RandomAffine(0.0, scale=(0.0, 0.0)),
            "scale: expected .* both positive",
        ),
        (lambda: A.RandomAffine(0.0, scale=(-1.0, 1.0)), "scale: expected .* both positive"),
        (lambda: A.RandomAffine(0.0, scale=1.2), r"scale: expected .* got \(-1.2, 1.2\)"),
        (lambda: A.RandomAffine(0.0, scale=(1.0, 1.0, 0.0, 1.0)), "scale: expected .* both positive"),
        (lambda: A.random_affine(IMAGES, NO, (0.0, 0.0), scale=(0.0, 1.0)), "scale: expected"),
        (lambda: A.random_affine(IMAGES, NO, (0.0, 0.0), scale_y=(-1.0, 1.0)), "scale_y: expected"),
        (lambda: A.random_affine3d(VOLUME, NO, STILL, scale=[(0.0, 1.0)]), "scale: expected"),
        (
            lambda: A.random_affine(IMAGES, NO, (0.0, 0.0), p=1.5),
            "p: expected a probability, 0 to 1",
        ),
        (lambda: A.random_horizontal_flip(IMAGES, NO, p=-0.5), "p: expected a probability"),
        (lambda: A.random_rotation(IMAGES, NO, (0.0, 0.0), p=float("nan")), "p: expected a probability"),
        (lambda: A.random_perspective(IMAGES, NO, 7.0), "distortion_scale: expected 0 to 1, got 7.0"),
        (lambda: A.random_perspective3d(VOLUME, NO, -0.5), "distortion_scale: expected 0 to 1, got -0.5"),
        (lambda: A.random_erasing(IMAGES, NO, ratio=(0.0, 1.0)), "ratio: expected .* both positive"),
        (lambda: A.random_erasing(IMAGES, NO, scale=(-0.5, 0.1)), "scale: expected .* within"),
        (lambda: A.random_resized_crop(IMAGES, NO, (2, 2), scale=(-0.5, 0.1)), "scale: expected .* within"),
        (lambda: A.random_resized_crop(IMAGES, NO, (2, 2), ratio=(0.0, 1.0)), "ratio: expected .* both"),
    ],
)
def test_settings_out_of_range(call: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call()
