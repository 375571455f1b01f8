"""Drawn sizes, zooms, crops by overlap and the removal of boxes: torchvision's results for the drawn
numbers, and their distributions."""

from typing import Any

import numpy as np
import pytest
import torch
from PIL import Image
from scipy import stats
from torch import Tensor, nn
from torchvision import tv_tensors
from torchvision.transforms import v2
from torchvision.transforms.v2 import functional as vision

from chiasm import augmentation as A

SEEDS = torch.arange(2000) * 1000003
MODES = {name: vision.InterpolationMode(name) for name in ("bilinear", "bicubic", "nearest")}


def photos(batch: int = 4, height: int = 23, width: int = 34, dtype: torch.dtype = torch.float32) -> Tensor:
    made = torch.rand(batch, 3, height, width, generator=torch.Generator().manual_seed(1))
    return made if dtype.is_floating_point else (made * 255).round().to(dtype)


def boxes(count: int = 4) -> Tensor:
    """(B, 5, 4), x1, y1, x2, y2 within 23 x 34 pixels."""
    corners = torch.rand(count, 5, 2, 2, generator=torch.Generator().manual_seed(2))
    return (corners.sort(2).values * torch.tensor([34.0, 23.0])).flatten(2)


def in_vision(values: Tensor, height: int, width: int) -> Any:
    made: Any = tv_tensors.BoundingBoxes  # whose declared types are a Tensor's
    return made(values, format="XYXY", canvas_size=(height, width))


def are_alike(a: Any, b: Any) -> bool:
    """Whether two samples may be of one distribution."""
    found: Any = stats.ks_2samp(a, b)
    return found.pvalue > 0.001


SCALINGS: dict[str, Any] = {
    "jitter": lambda **how: A.ScaleJitter((30, 26), (0.3, 2.0), **how),
    "shortest": lambda **how: A.RandomShortestSize([9, 14, 31], 40, **how),
}


@pytest.mark.parametrize("antialias", [True, False])
@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", SCALINGS)
def test_scaled_images_are_torchvisions(name: str, mode: str, antialias: bool) -> None:
    images, seed = photos(), torch.tensor([3, 5, 8, 13])
    masks = torch.arange(4 * 23 * 34).reshape(4, 1, 23, 34)
    keys = ["input", "mask", "bbox_xyxy", "bbox_xywh"]
    xywh = torch.cat([boxes()[..., :2], boxes()[..., 2:] - boxes()[..., :2]], -1)
    canvas = (60, 64) if mode != "bicubic" or antialias else None
    augment = SCALINGS[name](interpolation=mode, antialias=antialias, canvas=canvas, fill=0.5)
    step = A.AugmentationSequential(augment, data_keys=keys)
    out, mask, moved, other = step(images, masks, boxes(), xywh, seed=seed)
    sizes = augment._params["size"].tolist()
    assert canvas is None or len({tuple(size) for size in sizes}) > 1
    for i, (height, width) in enumerate(sizes):
        expected = vision.resize(images[i], [height, width], MODES[mode], antialias=antialias)
        torch.testing.assert_close(out[i, :, :height, :width], expected, atol=5e-6, rtol=0)
        nearest = vision.resize(masks[i], [height, width], MODES["nearest"])
        assert mask[i, :, :height, :width].equal(nearest)
        scaled = vision.resize(in_vision(boxes()[i], 23, 34), [height, width]).as_subclass(Tensor)
        torch.testing.assert_close(moved[i], scaled, atol=1e-4, rtol=0)
        torch.testing.assert_close(other[i, :, :2] + other[i, :, 2:], scaled[:, 2:], atol=1e-4, rtol=0)
        valid = augment.valid_mask()[i, 0]
        assert valid[:height, :width].all() and int(valid.sum()) == height * width
        outside = ~valid
        assert (out[i][:, outside] == 0.5).all() and (mask[i][:, outside] == 0).all()


@pytest.mark.parametrize("mode", ["bilinear", "bicubic"])
def test_scaled_bytes_are_torchvisions_up_to_rounding(mode: str) -> None:
    images = photos(dtype=torch.uint8)
    augment = A.ScaleJitter((30, 26), (0.3, 2.0), mode, canvas=64)
    out = augment(images, seed=torch.arange(4))
    assert out.dtype == torch.uint8
    for i, (height, width) in enumerate(augment._params["size"].tolist()):
        pillow = Image.fromarray(images[i].permute(1, 2, 0).numpy())
        expected = pillow.resize((width, height), getattr(Image.Resampling, mode.upper()))
        off = out[i, :, :height, :width].permute(1, 2, 0).int() - torch.tensor(np.asarray(expected)).int()
        assert off.abs().max() <= 1 and (off != 0).float().mean() < 0.04
    eager = A.ScaleJitter((30, 26), (0.3, 2.0), mode)
    alone = eager(images[0], seed=torch.tensor([9]))
    size = eager._params["size"][0].tolist()
    off = alone.int() - vision.resize(images[0], size, MODES[mode], antialias=True).int()
    assert list(alone.shape) == [3, *size] and off.abs().max() <= 2  # its weights have fewer bits


def test_sizes_are_drawn_as_torchvision_s() -> None:
    jitter = A.ScaleJitter((30, 26), (0.3, 2.0), canvas=64).draw(SEEDS, [2000, 3, 230, 340])["size"]
    reference = v2.ScaleJitter((30, 26), (0.3, 2.0))
    image = torch.zeros(3, 230, 340)
    drawn = torch.tensor([reference.make_params([image])["size"] for _ in range(2000)])
    assert (jitter[:, 0] <= 52).all() and (jitter[:, 1] <= 60).all()
    for axis in range(2):
        assert are_alike(jitter[:, axis].numpy(), drawn[:, axis].numpy())
    for given in ((230, 340), (340, 230), (50, 60)):
        found = A.RandomShortestSize([90, 140, 310], 400, canvas=400).draw(SEEDS, [2000, 3, *given])["size"]
        chosen = v2.RandomShortestSize([90, 140, 310], 400)
        pairs = {tuple(chosen.make_params([torch.zeros(3, *given)])["size"]) for _ in range(100)}
        assert {tuple(size) for size in found.tolist()} == pairs
        _, counts = found[:, 0].unique(return_counts=True)
        assert stats.chisquare(counts.numpy()).pvalue > 0.001
    limited = A.RandomShortestSize(100, canvas=(90, 80)).draw(SEEDS[:1], [1, 3, 50, 100])["size"]
    assert limited.tolist() == [[40, 80]]  # the largest of the ratio that fits


@pytest.mark.parametrize("fill", [0.25, [0.1, 0.2, 0.3]])
def test_zooms_are_torchvisions_pads(fill: Any) -> None:
    images, masks = photos(), torch.ones(4, 1, 23, 34, dtype=torch.int64)
    zoom = A.RandomZoomOut(fill, (1.0, 2.5), p=0.6, canvas=(57, 85))
    step = A.AugmentationSequential(zoom, data_keys=["input", "mask", "bbox_xyxy", "keypoints"])
    points = boxes()[..., :2]
    out, mask, moved, at = step(images, masks, boxes(), points, seed=torch.tensor([2, 3, 4, 9]))
    params = zoom._params
    assert 0 < int(params["batch_prob"].sum()) < 4
    for i in range(4):
        (height, width), (left, top) = params["size"][i].tolist(), params["corner"][i].tolist()
        pad = [left, top, width - 34 - left, height - 23 - top]
        assert min(pad) >= 0 and (params["batch_prob"][i] or pad == [0, 0, 0, 0])
        assert out[i, :, :height, :width].equal(vision.pad(images[i], pad, fill=fill))
        assert mask[i, :, :height, :width].equal(vision.pad(masks[i], pad))
        torch.testing.assert_close(
            moved[i], vision.pad(in_vision(boxes()[i], 23, 34), pad).as_subclass(Tensor)
        )
        torch.testing.assert_close(at[i], points[i] + torch.tensor([left, top]))
        beyond = ~zoom.valid_mask()[i, 0]
        expected = torch.as_tensor(fill, dtype=torch.float32).expand(3)[:, None]
        assert out[i][:, beyond].equal(expected.expand(3, int(beyond.sum())))
    assert torch.equal(zoom.inverse(out), images)
    alone = A.RandomZoomOut(fill, (1.5, 1.5), p=1.0)(images[0])
    assert alone.shape == (3, 34, 51)


def test_zooms_are_drawn_as_torchvision_s() -> None:
    drawn = A.RandomZoomOut(p=1.0, canvas=(400, 800)).draw(SEEDS, [2000, 3, 100, 200])
    reference = v2.RandomZoomOut(p=1.0)
    pads = torch.tensor([reference.make_params([torch.zeros(3, 100, 200)])["padding"] for _ in range(2000)])
    pairs = [
        (drawn["size"][:, 0], pads[:, 1] + pads[:, 3] + 100),
        (drawn["corner"][:, 0], pads[:, 0]),
        (drawn["corner"][:, 1], pads[:, 1]),
    ]
    for found, expected in pairs:
        assert are_alike(found.numpy(), expected.numpy())
    limited = A.RandomZoomOut(p=1.0, canvas=(150, 800)).draw(SEEDS, [2000, 3, 100, 200])["size"]
    assert limited.amax(0).tolist() == [150, 300]


def cropped(values: Tensor, box: Tensor) -> Tensor:
    """Boxes as torchvision's RandomIoUCrop leaves them."""
    left, top, width, height = [int(n) for n in box]
    made = vision.crop(in_vision(values, 23, 34), top, left, height, width).as_subclass(Tensor)
    x, y = (values[:, 0] + values[:, 2]) / 2, (values[:, 1] + values[:, 3]) / 2
    within = (left < x) & (x < left + width) & (top < y) & (y < top + height)
    return torch.where(within[:, None], made, torch.zeros_like(made))


@pytest.mark.parametrize("as_list", [True, False])
def test_crops_by_overlap_are_torchvisions(as_list: bool) -> None:
    step = A.RandomIoUCrop()
    keys = ["input", "mask", "bbox_xyxy", "bbox_xywh", "keypoints"]
    augment = A.AugmentationSequential(step, data_keys=keys)
    images, values = photos(1), boxes(1)
    masks = torch.arange(23 * 34, dtype=torch.int64).reshape(1, 1, 23, 34)
    xywh = torch.cat([values[..., :2], values[..., 2:] - values[..., :2]], -1)
    stayed = 0
    for seed in SEEDS[:40]:
        given = [values[0]] if as_list else values
        out, mask, moved, other, points = augment(
            images, masks, given, xywh, values[..., :2], seed=seed[None]
        )
        box = step._params["box"][0]
        left, top, width, height = [int(n) for n in box]
        assert out.equal(vision.crop(images, top, left, height, width))
        assert mask.equal(vision.crop(masks, top, left, height, width))
        if not step._params["batch_prob"].all():
            assert [left, top, width, height] == [0, 0, 34, 23]
            torch.testing.assert_close(moved[0], values[0])
            stayed += 1
            continue
        expected = cropped(values[0], box)
        torch.testing.assert_close(moved[0], expected)
        torch.testing.assert_close(
            torch.cat([other[0][:, :2], other[0][:, :2] + other[0][:, 2:]], -1), expected
        )
        torch.testing.assert_close(points[0], values[0, :, :2] - box[:2].float())
    assert 0 < stayed < 20


def test_crops_by_overlap_keep_enough_of_a_box() -> None:
    values = boxes(1).expand(2000, -1, -1)
    for least in (0.0, 0.3, 0.7):
        step = A.RandomIoUCrop(sampler_options=[least], min_scale=0.4, trials=60)
        params = step.draw_among(values, SEEDS, [2000, 3, 23, 34])
        assert params["batch_prob"].float().mean() > (0.99 if least < 0.5 else 0.5)
        box = params["box"][params["batch_prob"]].numpy()
        assert (box[:, 2] >= int(0.4 * 34)).all() and (box[:, 3] >= int(0.4 * 23)).all()
        assert (box[:, 2] / box[:, 3] >= 0.5).all() and (box[:, 2] / box[:, 3] <= 2.0).all()
        a, crop = (
            boxes(1)[0].numpy().astype(np.float64),
            np.concatenate([box[:, :2], box[:, :2] + box[:, 2:]], 1),
        )
        sides = np.minimum(a[None, :, 2:], crop[:, None, 2:]) - np.maximum(a[None, :, :2], crop[:, None, :2])
        common = sides.clip(0).prod(-1)
        overlap = common / ((a[:, 2:] - a[:, :2]).prod(-1) + (box[:, 2:].prod(-1))[:, None] - common)
        centre = (a[:, :2] + a[:, 2:]) / 2
        inside = ((centre > crop[:, None, :2]) & (centre < crop[:, None, 2:])).all(-1)
        assert (np.where(inside, overlap, -1.0).max(1) >= least - 1e-9).all()


def test_the_distribution_of_crops_by_overlap_is_torchvision_s() -> None:
    values = boxes(1)
    found = A.RandomIoUCrop().draw_among(values.expand(1500, -1, -1), SEEDS[:1500], [1500, 3, 23, 34])
    reference, sample = v2.RandomIoUCrop(), [tv_tensors.Image(photos(1)[0]), in_vision(values[0], 23, 34)]
    drawn = [reference.make_params(sample) for _ in range(1500)]
    share = sum(not params for params in drawn) / 1500
    assert abs(share - 1 + float(found["batch_prob"].float().mean())) < 0.05
    for i, key in enumerate(("left", "top", "width", "height")):
        theirs = [params[key] for params in drawn if params]
        ours = found["box"][found["batch_prob"]][:, i].numpy()
        assert are_alike(ours, theirs)


def test_crops_by_overlap_of_a_batch_have_one_size() -> None:
    step = A.RandomIoUCrop(size=(20, 24))
    augment = A.AugmentationSequential(step, data_keys=["input", "bbox_xyxy"])
    images, values = photos(), boxes()
    out, moved = augment(images, values, seed=torch.tensor([1, 2, 3, 5]))
    assert out.shape == (4, 3, 20, 24) and step._params["batch_prob"].any()
    for i in range(4):
        left, top, width, height = [int(n) for n in step._params["box"][i]]
        resized = vision.resized_crop(images[i], top, left, height, width, [20, 24], antialias=False)
        inner = (slice(None), slice(2, -2), slice(2, -2))  # at the border the image beyond the crop is read
        torch.testing.assert_close(out[i][inner], resized[inner], atol=1e-5, rtol=1e-5)
        if step._params["batch_prob"][i]:
            by = torch.tensor([24 / width, 20 / height] * 2)
            torch.testing.assert_close(moved[i], cropped(values[i], step._params["box"][i]) * by)
    again = augment(images, values, params=augment._params)
    assert again[0].equal(out) and again[1].equal(moved)


def test_sanitized_boxes_are_torchvisions() -> None:
    values = torch.tensor(
        [[0, 0, 4, 4], [0, 0, 1, 9], [5, 5, 5, 8], [1, 1, 35, 9], [-1, 0, 4, 4], [2, 2, 34, 23], [3, 3, 5, 5]]
    ).float()
    labels = torch.arange(7)
    for least, area in ((1.0, 1.0), (2.0, 1.0), (1.0, 10.0)):
        sanitize = A.SanitizeBoundingBoxes(least, area)
        expected, valid = vision.sanitize_bounding_boxes(
            values,
            format=tv_tensors.BoundingBoxFormat.XYXY,
            canvas_size=(23, 34),
            min_size=least,
            min_area=area,
        )
        assert sanitize.valid(values, 23, 34).equal(valid) and 0 < int(valid.sum()) < 7
        step = A.AugmentationSequential(sanitize, data_keys=["input", "bbox_xyxy", "class"])
        _, kept, classes = step(photos(2), [values, values[:2]], [labels, labels[:2]])
        assert kept[0].equal(expected) and classes[0].equal(labels[valid])
        assert kept[1].equal(values[:2][valid[:2]]) and classes[1].equal(labels[:2][valid[:2]])
        _, whole, same = step(photos(1), values[None], labels[None])
        assert whole[0].equal(torch.where(valid[:, None], values, 0.0)) and same.equal(labels[None])


@pytest.mark.parametrize(
    "augment",
    [
        A.ScaleJitter((30, 26), (0.3, 2.0), canvas=64),
        A.ScaleJitter((30, 26), (0.3, 2.0), "bicubic"),
        A.RandomShortestSize([9, 14], 40, canvas=(30, 40), fill=[0.1, 0.2, 0.3]),
        A.RandomShortestSize([9, 14]),
        A.RandomZoomOut(canvas=(57, 85)),
        A.RandomZoomOut(p=1.0),
    ],
)
def test_replay_script_and_the_way_back(augment: Any) -> None:
    images = photos()
    first = augment(images, generator=torch.Generator().manual_seed(3))
    assert augment(images, params=augment._params).equal(first)
    torch.testing.assert_close(torch.jit.script(augment)(images, augment._params["seed"]), first)
    sequence = A.AugmentationSequential(augment, A.RandomHorizontalFlip())
    torch.testing.assert_close(
        torch.jit.script(sequence)(images, SEEDS[:4]), sequence.forward(images, SEEDS[:4])
    )
    ramp = torch.arange(34.0).expand(4, 3, 23, 34) / 34.0
    back = augment.inverse(augment(ramp))
    assert back.shape == ramp.shape
    assert (back - ramp)[..., 4:-4].abs().max() < 0.02


def test_a_crop_of_parameters_scripts() -> None:
    class Cropped(nn.Module):
        def __init__(self) -> None:
            super().__init__()
            self.crop = A.RandomIoUCrop(size=(20, 24))

        def forward(self, input: Tensor, boxes: Tensor, seed: Tensor) -> Tensor:
            params = self.crop.draw_among(boxes, seed, list(input.shape))
            return self.crop.forward(input, seed, params)

    module, seed = Cropped(), torch.arange(4)
    expected = module(photos(), boxes(), seed)
    assert torch.jit.script(module)(photos(), boxes(), seed).equal(expected)


def test_what_is_refused() -> None:
    images = photos()
    refused: dict[str, Any] = {
        r"canvas: expected at least \(52, 60\)": lambda: A.ScaleJitter((30, 26), canvas=(50, 60)),
        "scale_range: expected": lambda: A.ScaleJitter((30, 26), (0.0, 1.0)),
        "antialias: expected True": lambda: A.ScaleJitter((30, 26), (1, 1), "bicubic", False, canvas=40),
        "min_size, max_size: expected positive": lambda: A.RandomShortestSize([4, 0]),
        "side_range: expected": lambda: A.RandomZoomOut(side_range=(0.5, 2.0)),
        "input: expected at most the canvas": lambda: A.RandomZoomOut(canvas=20)(images),
        "fill: expected a number, or 3": lambda: A.RandomZoomOut([1, 2], canvas=40)(images),
        "input: expected at least one image": lambda: A.ScaleJitter((30, 26))(images[:0]),
        "min_scale, max_scale: expected": lambda: A.RandomIoUCrop(0.0),
        "min_aspect_ratio, max_aspect_ratio: expected": lambda: A.RandomIoUCrop(min_aspect_ratio=3.0),
        "trials: expected a positive number": lambda: A.RandomIoUCrop(trials=0),
        "same_on_batch: expected False": lambda: A.RandomIoUCrop(same_on_batch=True),
        "data_keys: expected 'bbox_xyxy'": lambda: A.RandomIoUCrop()(images),
        "data_keys: expected 'bbox_xyxy' or": lambda: A.AugmentationSequential(A.RandomIoUCrop())(images),
        "input: expected one image": lambda: A.AugmentationSequential(
            A.RandomIoUCrop(), data_keys=["input", "bbox_xyxy"]
        )(images, boxes()),
        "expected 'bbox_xyxy' or 'bbox_xywh' beside a step that empties boxes": lambda: (
            A.AugmentationSequential(A.RandomIoUCrop(size=8), data_keys=["input", "bbox"])(
                images, torch.zeros(4, 1, 4, 2)
            )
        ),
        "min_size, min_area: expected": lambda: A.SanitizeBoundingBoxes(0.5),
        r"class: expected as many entries as boxes, \[5\], got \[4\]": lambda: A.AugmentationSequential(
            A.SanitizeBoundingBoxes(), data_keys=["input", "bbox_xyxy", "class"]
        )(images[:1], [boxes()[0]], [torch.arange(4)]),
        "random_apply: expected False": lambda: A.AugmentationSequential(
            A.RandomZoomOut(canvas=90), random_apply=1
        ),
    }
    for message, call in refused.items():
        with pytest.raises(ValueError, match=message):
            call()
