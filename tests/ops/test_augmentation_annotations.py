"""What belongs to images: masks of labels, boxes, keypoints and classes; and the way back."""

import math
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor
from torchvision.transforms.v2 import functional as vision

from chiasm import augmentation as A
from chiasm import constants
from chiasm.geometry.boxes import Boxes
from chiasm.geometry.keypoints import Keypoints

SEEDS = torch.arange(2000) * 1000003
WHOLE = [
    torch.bool,
    torch.uint8,
    torch.int8,
    torch.int16,
    torch.uint16,
    torch.int32,
    torch.uint32,
    torch.int64,
    torch.uint64,
]


def photos(batch: int = 2, height: int = 12, width: int = 16) -> Tensor:
    return torch.rand(batch, 3, height, width, generator=torch.Generator().manual_seed(1))


def turned(points: Any, degrees: float, height: int = 12, width: int = 16) -> np.ndarray:
    """Points (..., 2), rotated clockwise as seen about an image's centre."""
    angle, centre = np.deg2rad(degrees), np.array([(width - 1) / 2, (height - 1) / 2])
    matrix = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return (np.asarray(points, np.float64) - centre) @ matrix.T + centre


def turn(degrees: float = 30.0, **settings: Any) -> Any:
    return A.AugmentationSequential(A.RandomAffine((degrees, degrees), p=1.0), **settings)


def nearest(labels: np.ndarray, matrix: np.ndarray, size: tuple[int, int]) -> list[np.ndarray]:
    """A plane of labels, read at the nearest pixel by the inverse of a homography, 0 outside; of the four
    sides of a point between two pixels."""
    y, x = np.mgrid[: size[0], : size[1]]
    at = np.linalg.inv(matrix) @ np.stack([x, y, np.ones_like(x)]).reshape(3, -1)
    made = []
    for side in np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * 1e-4:
        column, row = np.rint(at[:2] / at[2] + side[:, None]).astype(int).reshape(2, *size)
        inside = (column >= 0) & (row >= 0) & (column < labels.shape[1]) & (row < labels.shape[0])
        found = np.zeros(size, labels.dtype)
        found[inside] = labels[row[inside], column[inside]]
        made.append(found)
    return made


def labels_of(dtype: torch.dtype, *shape: int) -> Tensor:
    """Labels up to the greatest of a dtype, which no float holds."""
    if dtype == torch.bool:
        return torch.rand(*shape, generator=torch.Generator().manual_seed(2)) < 0.5
    last = torch.iinfo(dtype).max
    numbers = last - np.arange(np.prod(shape), dtype=np.uint64) % min(last, 2**40)
    name = str(dtype).rpartition(".")[2]
    return torch.from_numpy(numbers.astype(getattr(np, name))).reshape(shape)


WARPS: dict[str, Any] = {
    "affine": lambda: A.RandomAffine(40.0, (0.1, 0.2), (0.7, 1.3), 10.0, p=1.0),
    "rotation": lambda: A.RandomRotation(50.0, p=1.0),
    "shear": lambda: A.RandomShear(20.0, p=1.0),
    "translate": lambda: A.RandomTranslate((-0.3, 0.3), (-0.3, 0.3), p=1.0),
    "perspective": lambda: A.RandomPerspective(0.4, p=1.0),
    "rotation90": lambda: A.RandomRotation90((1, 3), p=1.0),
    "resized_crop": lambda: A.RandomResizedCrop((9, 11)),
    "flip": lambda: A.RandomHorizontalFlip(p=1.0),
    "crop": lambda: A.RandomCrop((7, 9)),
    "pad": lambda: A.PadTo((15, 18)),
}


@pytest.mark.parametrize("name", WARPS)
@pytest.mark.parametrize("dtype", WHOLE)
def test_labels_arrive_as_they_are(name: str, dtype: torch.dtype) -> None:
    images, mask = photos(3, 13, 17), labels_of(dtype, 3, 2, 13, 17)
    augment: Any = A.AugmentationSequential(WARPS[name](), data_keys=["input", "mask"])
    out, moved = augment(images, mask, seed=SEEDS[:3])
    assert moved.dtype == dtype
    assert moved.shape == (3, 2, *out.shape[2:])
    size = (out.size(2), out.size(3))
    for i, matrix in enumerate(augment.transform_matrix.numpy()):
        for channel in range(2):
            sides = nearest(mask[i, channel].numpy(), matrix, size)
            assert np.any([moved[i, channel].numpy() == side for side in sides], 0).all()
    back = augment.inverse(out, moved)[1]
    assert back.dtype == dtype
    assert back.shape == mask.shape
    assert set(back.flatten().tolist()) <= {0, *mask.flatten().tolist()}


@pytest.mark.parametrize("dtype", [torch.uint8, torch.int64, torch.bool])
def test_labels_of_elastic_transforms_and_sizes(dtype: torch.dtype) -> None:
    images, mask = photos(3, 21, 30), labels_of(dtype, 3, 1, 21, 30)
    bent: Any = A.RandomElasticTransform((5, 7), (1.5, 2.0), (0.2, 0.3), p=1.0)
    moved = A.AugmentationSequential(bent, data_keys=["input", "mask"])(images, mask, seed=SEEDS[:3])[1]
    assert moved.dtype == dtype
    read = torch.arange(1.0, 631.0).double().reshape(1, 1, 21, 30).expand(3, 1, 21, 30)
    numbers = bent.transform_mask(read, bent._params).long().flatten(1)
    with_zero = torch.cat([torch.zeros(3, 1, dtype=dtype), mask.flatten(1)], 1)
    assert torch.equal(moved.flatten(1), with_zero.gather(1, numbers))
    for size in ((10, 15), (42, 60)):
        resized = A.AugmentationSequential(A.Resize(size), data_keys=["input", "mask"])(images, mask)[1]
        expected = vision.resize(
            torch.arange(630.0).reshape(1, 21, 30), list(size), vision.InterpolationMode.NEAREST
        )
        assert torch.equal(resized.flatten(1), mask.flatten(1)[:, expected.long().flatten()])


def test_labels_of_volumes() -> None:
    volume = torch.rand(2, 1, 5, 6, 7, generator=torch.Generator().manual_seed(1))
    mask = labels_of(torch.int64, 2, 1, 5, 6, 7)
    square, labels = volume[..., :6], mask[..., :6]
    quarter = A.RandomRotation3D(((0.0, 0.0), (0.0, 0.0), (90.0, 90.0)), p=1.0)  # from x to y
    augment: Any = A.AugmentationSequential(quarter, data_keys=["input", "mask"])
    out, moved = augment(square, labels)
    assert torch.equal(moved, torch.rot90(labels, -1, (3, 4)))
    assert torch.equal(augment.inverse(out, moved)[1], labels)


def test_the_way_back_needs_only_the_parameters() -> None:
    images = photos()
    one, other = turn(), turn()
    out = one(images)
    assert torch.equal(other.inverse(out, params=one._params), one.inverse(out))
    assert not torch.equal(one.inverse(out), out)
    resize: Any = A.AugmentationSequential(A.Resize((20, 30)))
    larger = resize(images)
    params = resize._params
    resize(photos(2, 8, 9))
    assert resize.inverse(larger, params=params).shape == images.shape
    with pytest.raises(
        ValueError, match="params: expected those of a call, one dict for each of 1 steps, got 0"
    ):
        other.inverse(out)
    with pytest.raises(ValueError, match="params: expected those of a call"):
        A.AugmentationSequential(*one.steps, *other.steps)(images, params=one._params)
    with pytest.raises(ValueError, match="'forward_input_shape'"):
        other.inverse(out, params=[{"batch_prob": torch.ones(2).bool()}])


def test_every_input_moves_as_the_first() -> None:
    images = photos()
    first, second, mask = turn(data_keys=["image", "input", "mask"])(images, images[:, :1], images)
    assert torch.equal(second, first[:, :1])
    moved, image = turn(data_keys=["mask", "input"])(images, images)
    assert torch.equal(image, first)
    assert torch.equal(moved, mask)
    some: Any = A.AugmentationSequential(
        A.RandomHorizontalFlip(p=1.0),
        A.RandomVerticalFlip(p=1.0),
        random_apply=1,
        data_keys=["input", "input"],
    )
    many = photos(20)
    first, second = some(many, many)
    assert torch.equal(first, second)
    assert not torch.equal(first, many.flip(2))


@pytest.mark.parametrize("dtype", [torch.int32, torch.int64, torch.float64])
def test_coordinates_between_pixels(dtype: torch.dtype) -> None:
    box, point = torch.tensor([[[2, 3, 8, 9]]], dtype=dtype), torch.tensor([[[2, 3]]], dtype=dtype)
    corners = turned([[2, 3], [7, 3], [7, 8], [2, 8]], 10.0)
    low, high = corners.min(0), corners.max(0) + 1.0
    keys = ["input", "bbox_xyxy", "bbox_xywh", "keypoints", "bbox"]
    xywh = torch.tensor([[[2, 3, 6, 6]]], dtype=dtype)
    square = torch.tensor([[[[2, 3], [7, 3], [7, 8], [2, 8]]]], dtype=dtype)
    _, xyxy, sizes, points, quad = turn(10.0, data_keys=keys)(photos(1), box, xywh, point, square)
    for moved, expected in (
        (xyxy, [*low, *high]),
        (sizes, [*low, *(high - low)]),
        (points, turned([2, 3], 10.0)),
        (quad, corners),
    ):
        assert moved.dtype == (dtype if dtype.is_floating_point else torch.float32)
        np.testing.assert_allclose(moved[0, 0].numpy(), expected, atol=1e-5)


def test_lists_dicts_and_classes() -> None:
    images = photos()
    boxes = [torch.tensor([[1.0, 2.0, 5.0, 7.0]]), torch.zeros(0, 4)]
    points = [torch.tensor([[1, 2], [3, 4]]), torch.tensor([[0, 0]])]
    flip: Any = A.AugmentationSequential(A.RandomHorizontalFlip(p=1.0), data_keys=None)
    data = {
        "Image": images,
        "name": "a.png",
        "label": [3, 4],
        "bbox_xyxy-left": boxes,
        "keypoints": points,
        "mask_a": images[:, :1] > 0.5,
    }
    out = flip(data)
    assert list(out) == list(data)
    assert torch.equal(out["Image"], images.flip(3))
    assert torch.equal(out["mask_a"], (images[:, :1] > 0.5).flip(3))
    assert out["name"] == "a.png"
    assert out["label"] == [3, 4]
    assert out["bbox_xyxy-left"][0].tolist() == [[11.0, 2.0, 15.0, 7.0]]
    assert out["bbox_xyxy-left"][1].shape == (0, 4)
    assert [p.tolist() for p in out["keypoints"]] == [[[14.0, 2.0], [12.0, 4.0]], [[15.0, 0.0]]]
    back = flip.inverse(out)
    assert torch.equal(back["Image"], images)
    assert torch.equal(back["bbox_xyxy-left"][0], boxes[0])
    label = torch.arange(2)
    assert flip(images, label, data_keys=["input", "class"])[1] is label
    with pytest.raises(ValueError, match="args: expected a dict with some of the keys"):
        flip({"photo": images})
    mosaic: Any = A.AugmentationSequential(A.RandomMosaic(), data_keys=["input", "class"])
    with pytest.raises(ValueError, match="data_keys: expected no 'class', for RandomMosaic"):
        mosaic(images, label)


def test_one_image_there_and_back() -> None:
    image, box = photos(1)[0], torch.tensor([[2.0, 3.0, 8.0, 9.0]])
    for keepdim in (True, False):
        augment = turn(keepdim=keepdim, data_keys=["input", "mask", "bbox_xyxy"])
        out, mask, moved = augment(image, image[:1], box)
        assert [t.dim() for t in (out, mask, moved)] == ([3, 3, 2] if keepdim else [4, 4, 3])
        back = augment.inverse(out, mask, moved)
        assert [t.dim() for t in back] == ([3, 3, 2] if keepdim else [4, 4, 3])
        assert augment(image, image[:1], box[None])[2].shape == (1, 1, 4)
        alone = augment.inverse(mask, data_keys=["mask"])
        assert torch.equal(alone, back[1])
    crop: Any = A.AugmentationSequential(A.RandomCrop((4, 5)), keepdim=True)
    assert crop.inverse(crop(image)).shape == image.shape
    deep: Any = A.AugmentationSequential(A.RandomHorizontalFlip3D(p=1.0), keepdim=True)
    volume = torch.rand(1, 3, 4, 5)
    assert torch.equal(deep(volume), volume.flip(3))


@pytest.mark.parametrize("deep", [False, True])
def test_a_mask_comes_back_without_the_fill_of_its_image(deep: bool) -> None:
    sides = (4, 5, 6) if deep else (5, 6)
    size = tuple(n - 2 for n in sides)
    crop = A.RandomCrop3D(size, fill=0.5) if deep else A.RandomCrop(size, fill=0.5)
    augment: Any = A.AugmentationSequential(crop, data_keys=["input", "mask"])
    image, mask = torch.ones(3, 1, *sides), torch.full((3, 1, *sides), 7.0)
    back, labels = augment.inverse(*augment(image, mask, seed=torch.arange(3)))
    inside = labels > 0
    assert inside.flatten(1).sum(1).tolist() == [math.prod(size)] * 3
    assert labels.unique().tolist() == [0.0, 7.0]
    assert torch.equal(back, torch.where(inside, 1.0, 0.5))


@pytest.mark.parametrize(
    ("key", "value", "error", "message"),
    [
        (
            "bbox_xyxy",
            torch.rand(2, 1, 5),
            ValueError,
            r"bbox_xyxy: expected shape \(2, N, 4\), got \[2, 1, 5\]",
        ),
        ("bbox_xywh", torch.rand(3, 1, 4), ValueError, r"bbox_xywh: expected shape \(2, N, 4\)"),
        ("bbox", torch.rand(2, 1, 4), ValueError, r"bbox: expected shape \(2, N, 4, 2\), got \[2, 1, 4\]"),
        ("keypoints", torch.rand(2, 3), ValueError, r"keypoints: expected shape \(2, N, 2\), got \[2, 3\]"),
        (
            "mask",
            torch.rand(2, 1, 6, 6),
            ValueError,
            r"mask: expected shape \(2, C, 12, 16\), got \[2, 1, 6, 6\]",
        ),
        ("mask", torch.rand(3, 1, 12, 16), ValueError, r"mask: expected shape \(2, C, 12, 16\)"),
        ("input", torch.rand(2, 3, 5, 4), ValueError, r"input: expected shape \(2, C, 12, 16\)"),
        ("mask", np.zeros((2, 1, 12, 16)), TypeError, "mask: expected a tensor, got ndarray"),
        (
            "bbox",
            [torch.rand(1, 4, 2)],
            ValueError,
            "bbox: expected a list of 2 tensors, one for each image, got 1",
        ),
        ("keypoints", [[1.0, 2.0], [3.0, 4.0]], TypeError, "keypoints: expected a tensor, got list"),
        (
            "bbox_xyxy",
            [torch.rand(1, 5), torch.rand(1, 4)],
            ValueError,
            r"bbox_xyxy: expected shape \(1, N, 4\)",
        ),
    ],
)
def test_shapes_are_checked(key: str, value: Any, error: type[Exception], message: str) -> None:
    augment = turn(data_keys=["input", key])
    with pytest.raises(error, match=message):
        augment(photos(), value)
    augment(photos(), data_keys=["input"])
    with pytest.raises(error, match=message):
        augment.inverse(photos(), value)


def test_steps_of_a_sequence() -> None:
    flip, identity = A.RandomHorizontalFlip(), torch.nn.Identity()
    augment: Any = A.AugmentationSequential(flip, identity)
    assert len(augment) == 2
    assert augment[0] is flip
    assert augment[-1] is identity
    assert list(augment) == [flip, identity]


def test_boxes_narrower_than_a_pixel_keep_their_width() -> None:
    flip = A.AugmentationSequential(A.RandomHorizontalFlip(p=1.0), data_keys=["input", "bbox_xyxy"])
    boxes = torch.tensor([[[0.0, 0.0, 0.0, 0.0], [3.0, 2.0, 3.25, 8.0], [3.0, 2.0, 9.0, 8.0]]])
    expected = torch.stack([16 - boxes[..., 2], boxes[..., 1], 16 - boxes[..., 0], boxes[..., 3]], -1)
    assert flip(photos(1), boxes)[1].equal(expected)


def test_boxes_and_keypoints_as_objects() -> None:
    images, corners = photos(), torch.tensor([[[2.0, 3.0, 9.0, 8.0], [0.0, 1.0, 5.0, 5.0]]] * 2)
    points = torch.tensor([[[2.0, 3.0], [9.0, 8.0]]] * 2)
    for boxes in (Boxes.from_tensor(corners, "xyxy"), Boxes.from_tensor(corners, "xyxy_plus")):
        augment = turn(data_keys=["input", "bbox_xyxy", "keypoints"])
        _, moved, kept = augment(images, boxes, Keypoints(points))
        assert isinstance(moved, Boxes) and isinstance(kept, Keypoints) and moved.mode == boxes.mode
        np.testing.assert_allclose(moved.data, turned(boxes.data, 30.0), atol=1e-5)
        np.testing.assert_allclose(kept.data, turned(points, 30.0), atol=1e-5)
        _, back, again = augment.inverse(images, moved, kept)
        np.testing.assert_allclose(back.to_tensor(), corners, atol=1e-4)
        np.testing.assert_allclose(again.data, points, atol=1e-4)
    alone = turn(data_keys=["input", "bbox"])(images[0], Boxes.from_tensor(corners[0]))[1]
    np.testing.assert_allclose(alone.data, turned(Boxes.from_tensor(corners[:1]).data, 30.0), atol=1e-5)
    named = turn(data_keys=None)({"image": images, "bbox": Boxes.from_tensor(corners), "id": 3})
    assert isinstance(named["bbox"], Boxes)


def test_policies_have_kornias_path() -> None:
    from chiasm.augmentation.auto import AutoAugment, RandAugment, TrivialAugment

    assert (AutoAugment, RandAugment, TrivialAugment) == (A.AutoAugment, A.RandAugment, A.TrivialAugment)
    assert A.auto.RandAugment(n=2, m=10)(photos()).shape == photos().shape


def test_settings_are_members_of_kornias_enumerations() -> None:
    images = photos()
    assert constants.Resample.get("Bicubic") is constants.Resample.get(2) is constants.Resample.BICUBIC
    assert constants.DataKey.IMAGE is constants.DataKey.INPUT
    with pytest.raises(ValueError, match=r"^value: expected one of \['constant', .*\], got 'wrap'"):
        constants.BorderType.get("wrap")
    for member in constants.Resample:
        made = A.RandomRotation(50.0, resample=member, p=1.0)  # pyright: ignore[reportArgumentType]
        same = A.RandomRotation(50.0, resample=member.name.lower(), p=1.0)
        assert made(images, seed=SEEDS[:2]).equal(same(images, seed=SEEDS[:2]))
    for name in ("ZEROS", "BORDER", "REFLECTION"):
        for kind in (
            lambda mode: A.RandomShear(20.0, padding_mode=mode, p=1.0),
            lambda mode: A.RandomThinPlateSpline(padding_mode=mode, p=1.0),
            lambda mode: A.RandomElasticTransform((5, 5), (2.0, 2.0), padding_mode=mode, p=1.0),
        ):
            made, same = kind(constants.SamplePadding[name]), kind(name.lower())
            assert made(images, seed=SEEDS[:2]).equal(same(images, seed=SEEDS[:2]))
    keys = constants.DataKey
    flip = A.AugmentationSequential(
        A.RandomHorizontalFlip(p=1.0), data_keys=[keys.INPUT, keys.KEYPOINTS, keys.CLASS]
    )
    assert flip(images, torch.zeros(2, 1, 2), torch.arange(2))[1].tolist() == [[[15.0, 0.0]]] * 2
