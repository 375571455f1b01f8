"""Sequences in which each sample goes through some of the steps."""

import itertools
from typing import Any

import numpy as np
import pytest
import torch
from scipy import stats

from chiasm import augmentation
from chiasm.augmentation.classes import CLASSES
from chiasm.augmentation.container import Chosen

SEEDS = torch.arange(4000) * 1000003


def shares(weights: tuple[float, ...], count: int) -> dict[tuple[int, ...], float]:
    """The probability of each set of steps, drawn one after the other without replacement."""
    found: dict[tuple[int, ...], float] = {}
    for order in itertools.permutations(range(len(weights)), count):
        left, chance = sum(weights), 1.0
        for step in order:
            chance *= weights[step] / left
            left -= weights[step]
        found[tuple(sorted(order))] = found.get(tuple(sorted(order)), 0.0) + chance
    return found


@pytest.mark.parametrize("weights", [(1.0, 1.0, 1.0, 1.0), (1.0, 2.0, 4.0, 0.5)])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_steps_are_drawn_by_their_weights(weights: tuple[float, ...], count: int) -> None:
    drawn = Chosen(count, count, weights)(SEEDS)
    assert drawn.shape == (4, 4000)
    assert torch.equal(drawn.sum(0), torch.full((4000,), count))
    sets = [tuple(np.flatnonzero(column).tolist()) for column in drawn.T.numpy()]
    expected = shares(weights, count)
    counts = [sets.count(each) for each in expected]
    assert sum(counts) == 4000
    assert stats.chisquare(counts, [4000 * p for p in expected.values()]).pvalue > 0.005


def test_numbers_of_steps_are_equally_likely() -> None:
    counts = torch.bincount(Chosen(1, 4, (1.0,) * 4)(SEEDS).sum(0), minlength=5)
    assert counts[0] == 0
    assert stats.chisquare(counts[1:].numpy()).pvalue > 0.005


def sequence(**settings: Any) -> Any:
    return augmentation.AugmentationSequential(
        augmentation.RandomHorizontalFlip(p=1.0),
        CLASSES["RandomInvert"](p=1.0),
        augmentation.RandomVerticalFlip(p=1.0),
        torch.nn.Hardtanh(0.0, 0.8),
        **settings,
    )


@pytest.mark.parametrize("random_apply", [1, 3, (0, 2), (2,)])
def test_each_sample_goes_through_its_steps(random_apply: Any) -> None:
    augment = sequence(random_apply=random_apply)
    images, seed = torch.rand(30, 3, 5, 6, generator=torch.Generator().manual_seed(1)), SEEDS[:30]
    out = augment(images, seed=seed)
    steps = (lambda x: x.flip(2), lambda x: 1 - x, lambda x: x.flip(1), lambda x: x.clamp(0, 0.8))
    numbers = set()
    for i in range(30):
        chosen = [bool(p["batch_prob"][i]) for p in augment._params]
        numbers.add(sum(chosen))
        expected = images[i]
        for step, taken in zip(steps, chosen, strict=True):
            expected = step(expected) if taken else expected
        assert torch.equal(out[i], expected)
    least, greatest = {1: (1, 1), 3: (3, 3), (0, 2): (0, 2), (2,): (2, 4)}[random_apply]
    assert numbers == set(range(least, greatest + 1))
    assert torch.equal(augment.forward(images, seed), out)
    assert torch.equal(torch.jit.script(augment)(images, seed), out)
    assert torch.equal(augment(images, params=augment._params), out)
    assert torch.equal(augment(images[7:8], seed=seed[7:8]), out[7:8])


def test_a_batch_goes_through_the_same_steps() -> None:
    images = torch.rand(1, 3, 5, 6, generator=torch.Generator().manual_seed(1)).expand(8, -1, -1, -1)
    augment, each = sequence(random_apply=2, same_on_batch=True), sequence(random_apply=2)
    drawn = set()
    for start in range(0, 160, 8):
        seed = SEEDS[start : start + 8]
        out = augment(images, seed=seed)
        assert torch.equal(out, out[:1].expand_as(out))
        assert torch.equal(out[:1], each(images[:1], seed=seed[:1]))
        assert torch.equal(augment.forward(images, seed), out)
        chosen = tuple(bool(p["batch_prob"][0]) for p in augment._params)
        assert sum(chosen) == 2
        drawn.add(chosen)
    assert len(drawn) > 3  # of the six pairs of steps
    assert torch.equal(torch.jit.script(augment)(images, SEEDS[:8]), augment(images, seed=SEEDS[:8]))


def test_what_belongs_to_an_image_goes_through_the_same_steps() -> None:
    augment = sequence(random_apply=2, data_keys=["input", "keypoints"])
    image = torch.zeros(20, 1, 5, 6)
    image[:, :, 1, 2] = 0.25
    out, points = augment(image, torch.tensor([[[2.0, 1.0]]]).expand(20, 1, 2), seed=SEEDS[:20])
    for i in range(20):
        x, y = points[i, 0].long().tolist()
        value = out[i, 0, y, x]
        assert (out[i] == value).sum() == 1
        assert float(value) in (0.25, 0.75)


@pytest.mark.parametrize("data_format", ["BTCHW", "BCTHW"])
@pytest.mark.parametrize("same_on_frame", [True, False])
def test_frames_of_videos(data_format: str, same_on_frame: bool) -> None:
    step = augmentation.RandomCrop((4, 5))
    augment = augmentation.VideoSequential(step, data_format=data_format, same_on_frame=same_on_frame)
    first = torch.arange(3 * 7.0 * 8).reshape(1, 1, 3, 7, 8)
    videos = first.expand(6, 9, 3, 7, 8)  # every frame shows its crop
    given = videos if data_format == "BTCHW" else videos.transpose(1, 2)
    out = augment(given, seed=SEEDS[:6])
    assert torch.equal(torch.jit.script(augment)(given, SEEDS[:6]), out)
    assert torch.equal(augment(given[4:5], seed=SEEDS[4:5]), out[4:5])
    frames = out if data_format == "BTCHW" else out.transpose(1, 2)
    assert frames.shape == (6, 9, 3, 4, 5)
    corners = frames[:, :, 0, 0, 0].long()
    for video, row in zip(frames, corners, strict=True):
        for frame, corner in zip(video, row.tolist(), strict=True):
            y, x = divmod(corner, 8)
            assert torch.equal(frame, first[0, 0, :, y : y + 4, x : x + 5])
    numbers = [len(row.unique()) for row in corners]
    assert numbers == [1] * 6 if same_on_frame else min(numbers) > 1
    assert len(corners[:, 0].unique()) > 1


def test_images_alone() -> None:
    augment = augmentation.ImageSequential(augmentation.RandomVerticalFlip(p=1.0), random_apply=1)
    images = torch.rand(2, 3, 5, 6, generator=torch.Generator().manual_seed(1))
    assert torch.equal(augment(images), images.flip(2))
    with pytest.raises(ValueError, match="data_format: expected"):
        augmentation.VideoSequential(data_format="TBCHW")
    with pytest.raises(ValueError, match="input: expected 5 dimensions"):
        augmentation.VideoSequential(augmentation.RandomVerticalFlip())(images)


def pieces(x: np.ndarray, down: int, across: int) -> list[list[np.ndarray]]:
    return [np.split(row, across, 3) for row in np.split(x, down, 2)]


def joined(rows: list[list[np.ndarray]]) -> np.ndarray:
    return np.concatenate([np.concatenate(row, 3) for row in rows], 2)


def test_each_patch_by_its_own_step() -> None:
    images = torch.rand(3, 2, 8, 15, generator=torch.Generator().manual_seed(1))
    flip, turn, invert = (
        augmentation.RandomHorizontalFlip(p=1.0),
        augmentation.RandomVerticalFlip(p=1.0),
        CLASSES["RandomInvert"](p=1.0),
    )
    steps = [flip, turn, invert, augmentation.ImageSequential(flip, turn, invert), torch.nn.Identity(), flip]
    augment = augmentation.PatchSequential(*steps, grid_size=(2, 3))
    by_hand = [
        [lambda x: x[..., ::-1], lambda x: x[:, :, ::-1], lambda x: 1 - x],
        [lambda x: 1 - x[:, :, ::-1, ::-1], lambda x: x, lambda x: x[..., ::-1]],
    ]
    parts = pieces(images.numpy(), 2, 3)
    expected = joined([[f(x) for f, x in zip(*row, strict=True)] for row in zip(by_hand, parts, strict=True)])
    np.testing.assert_array_equal(augment(images).numpy(), expected)
    assert torch.equal(torch.jit.script(augment)(images, SEEDS[:3]), augment(images, SEEDS[:3]))


@pytest.mark.parametrize(
    ("random_apply", "numbers"), [(False, (3, 3)), (True, (1, 3)), (1, (1, 1)), ((0, 2), (0, 2))]
)
def test_patches_draw_for_themselves(random_apply: Any, numbers: tuple[int, int]) -> None:
    """In a picture of constant patches, the value of each patch shows its own draws."""
    value = torch.tensor([0.25, 0.5])
    images = value.repeat(6)[None, None, None].expand(30, 1, 8, 12)
    steps = [CLASSES["RandomInvert"](0.75), augmentation.RandomHorizontalFlip(), torch.nn.Hardtanh(0.0, 0.4)]
    augment = augmentation.PatchSequential(
        *steps, grid_size=(4, 6), patchwise_apply=random_apply is True, random_apply=random_apply
    )
    out = augment(images, SEEDS[:30])
    assert torch.equal(augment(images, params=augment._params), out)
    assert torch.equal(torch.jit.script(augment)(images, SEEDS[:30]), out)
    assert torch.equal(augment(images[7:8], SEEDS[7:8]), out[7:8])
    shown = {tuple(p.flatten().tolist()) for row in pieces(out.numpy(), 4, 6) for q in row for p in q}
    possible = set()
    for chosen in itertools.product([False, True], repeat=3):
        if numbers[0] <= sum(chosen) <= numbers[1]:
            for inverts, flips in itertools.product([False, True], repeat=2):
                x = 0.75 - value if chosen[0] and inverts else value
                x = x.flip(0) if chosen[1] and flips else x
                possible.add(tuple((x.clamp(0, 0.4) if chosen[2] else x).repeat(2).tolist()))
    assert shown == possible
    assert len({tuple(o.flatten().tolist()) for o in out}) == 30
    same = augmentation.PatchSequential(
        *steps, grid_size=(4, 6), patchwise_apply=False, same_on_batch=True, random_apply=2
    )(images)
    assert torch.equal(same, same[:1].expand_as(same))
    assert len({tuple(p.flatten().tolist()) for row in pieces(same[:1].numpy(), 4, 6) for p in row}) > 1


def test_grids_that_do_not_divide() -> None:
    images = torch.rand(2, 3, 9, 14, generator=torch.Generator().manual_seed(1))
    flip = augmentation.RandomHorizontalFlip(p=1.0)
    settings: Any = {"grid_size": (2, 4), "patchwise_apply": False}
    padded = np.pad(images.numpy(), ((0, 0), (0, 0), (0, 1), (1, 1)))
    flipped = joined([[x[..., ::-1] for x in row] for row in pieces(padded, 2, 4)])
    same = augmentation.PatchSequential(flip, **settings)
    np.testing.assert_array_equal(same(images).numpy(), flipped[:, :, :9, 1:15])
    flipped = joined([[x[..., ::-1] for x in row] for row in pieces(images[:, :, :8, 1:13].numpy(), 2, 4)])
    valid = augmentation.PatchSequential(flip, padding="valid", keepdim=True, **settings)
    np.testing.assert_array_equal(valid(images).numpy(), flipped)
    assert torch.equal(valid(images[0]), valid(images)[0])
    with pytest.raises(ValueError, match="input: expected at least"):
        valid(images[:, :, :1])
    for wrong, message in (
        ({}, "args: expected 16, one for each patch"),
        ({"random_apply": 2}, "random_apply: expected True or False"),
        ({"padding": "reflect"}, "padding: expected one of"),
        ({"grid_size": (0, 2)}, "grid_size: expected positive numbers"),
    ):
        with pytest.raises(ValueError, match=message):
            augmentation.PatchSequential(flip, **wrong)


def test_sequences_in_sequences() -> None:
    images = torch.rand(20, 1, 5, 6, generator=torch.Generator().manual_seed(1))
    flips = augmentation.ImageSequential(
        augmentation.RandomHorizontalFlip(p=1.0), augmentation.RandomVerticalFlip(p=1.0)
    )
    points = torch.tensor([[[2.0, 1.0]]]).expand(20, 1, 2)
    both = augmentation.AugmentationSequential(flips, torch.nn.Hardtanh(0.0, 0.8))
    out, moved = both(images, points, data_keys=["input", "keypoints"])
    assert torch.equal(out, images.flip(2, 3).clamp(0, 0.8))
    assert torch.equal(moved[:, 0], torch.tensor([3.0, 3.0]).expand(20, 2))
    chosen = augmentation.ImageSequential(flips, CLASSES["RandomInvert"](p=1.0), random_apply=1)
    out = chosen(images, seed=SEEDS[:20])
    assert torch.equal(torch.jit.script(chosen)(images, SEEDS[:20]), out)
    whole, inverted = images.flip(2, 3), 1 - images
    kinds = [torch.equal(o, w) + 2 * torch.equal(o, i) for o, w, i in zip(out, whole, inverted, strict=True)]
    assert set(kinds) == {1, 2}
    with pytest.raises(ValueError, match="data_keys: expected 'input' alone"):
        chosen(images, points, data_keys=["input", "keypoints"])


def test_what_is_refused() -> None:
    with pytest.raises(ValueError, match="random_apply: expected 0 to 4 steps, got 5"):
        sequence(random_apply=5)
    with pytest.raises(ValueError, match="their order is fixed, got True"):
        sequence(random_apply=True)
    with pytest.raises(ValueError, match="random_apply_weights: expected 4 positive numbers"):
        sequence(random_apply=2, random_apply_weights=[1.0, 2.0])
    with pytest.raises(ValueError, match="random_apply_weights: expected finite numbers"):
        sequence(random_apply=2, random_apply_weights=[1.0, float("nan"), 1.0, 1.0])
    with pytest.raises(ValueError, match="random_apply: expected whole numbers"):
        sequence(random_apply=(0.5, 2))
    with pytest.raises(TypeError, match="args: expected modules, got str"):
        augmentation.AugmentationSequential("flip")  # pyright: ignore
    with pytest.raises(ValueError, match=r"input: expected shape \(B, C, H, W\), got 0 dimensions"):
        sequence()(torch.tensor(1.0))
    for step in (augmentation.CenterCrop(4), augmentation.CenterCrop3D(4), augmentation.RandomMosaic((4, 4))):
        with pytest.raises(ValueError, match="steps that change the size"):
            augmentation.AugmentationSequential(step, random_apply=1)


@pytest.mark.parametrize(
    "name, settings", [("AutoAugment", ()), ("RandAugment", (2, 9)), ("TrivialAugment", ()), ("AugMix", ())]
)
def test_nothing_follows_the_images_of_a_policy(name: str, settings: tuple[int, ...]) -> None:
    images = torch.rand(2, 3, 16, 16, generator=torch.Generator().manual_seed(1))
    data = {
        "mask": torch.zeros(2, 1, 16, 16),
        "bbox_xyxy": torch.zeros(2, 1, 4),
        "keypoints": torch.zeros(2, 1, 2),
    }
    augment = augmentation.AugmentationSequential(CLASSES[name](*settings))
    out = augment(images)
    for key, value in data.items():
        message = f"data_keys: expected 'input' alone, for {name} .*; got '{key}'"
        with pytest.raises(ValueError, match=message):
            augment(images, value, data_keys=["input", key])
        with pytest.raises(ValueError, match=message):
            augment.inverse(value, data_keys=[key])
    with pytest.raises(ValueError, match=f"inverse: there is no way back, for {name} "):
        augment.inverse(out)
    label = torch.arange(2)
    assert augment(images, label, data_keys=["input", "class"])[1] is label


def test_patches_within_a_sequence() -> None:
    images = torch.rand(6, 3, 8, 8, generator=torch.Generator().manual_seed(1))
    patches = augmentation.PatchSequential(
        augmentation.RandomHorizontalFlip(),
        CLASSES["RandomInvert"](),
        grid_size=(2, 2),
        patchwise_apply=False,
    )
    augment = augmentation.AugmentationSequential(patches, augmentation.RandomVerticalFlip(p=1.0))
    assert augment[0] is patches
    out = augment(images, seed=SEEDS[:6])
    draws = augment._params[0]["draws"]
    assert torch.equal(out, patches.forward(images, draws).flip(2))  # its own seeds
    assert not torch.equal(out, images.flip(2))
    assert torch.equal(augment(images, seed=SEEDS[:6]), out)
    assert torch.equal(augment(images, params=augment._params), out)
    assert torch.equal(augment.forward(images, SEEDS[:6]), out)
    assert torch.equal(torch.jit.script(augment)(images, SEEDS[:6]), out)
    assert torch.equal(augment(images[4:5], seed=SEEDS[4:5]), out[4:5])
    with pytest.raises(ValueError, match=r"expected 'input' alone, for PatchSequential .*; got 'mask'"):
        augment(images, images, data_keys=["input", "mask"])
    frames = augmentation.VideoSequential(augmentation.RandomHorizontalFlip())
    videos = images.reshape(2, 3, 3, 8, 8)
    sequence = augmentation.AugmentationSequential(frames)
    out = sequence(videos, seed=SEEDS[:2])
    assert torch.equal(out, frames.forward(videos, sequence._params[0]["draws"]))


def test_repeating_a_call_draws_no_numbers() -> None:
    images, flips = torch.rand(3, 3, 8, 8), [augmentation.RandomHorizontalFlip() for _ in range(2)]
    augments: list[Any] = [flips[0], augmentation.AugmentationSequential(*flips, random_apply=1)]
    for augment in augments:
        out = augment(images)
        before = torch.get_rng_state()
        assert torch.equal(augment(images, params=augment._params), out)
        assert torch.equal(torch.get_rng_state(), before)


def test_same_on_batch_of_a_sequence_within_a_sequence() -> None:
    images = torch.rand(64, 3, 4, 4, generator=torch.Generator().manual_seed(1))

    def flips(same_on_batch: bool | None) -> Any:
        flip = augmentation.RandomHorizontalFlip(same_on_batch=True)
        inner = augmentation.ImageSequential(flip, torch.nn.Identity(), random_apply=(2,), same_on_batch=True)
        return augmentation.AugmentationSequential(inner, same_on_batch=same_on_batch)(
            images, seed=SEEDS[:64]
        )

    for same_on_batch, kinds in ((None, {1}), (True, {1}), (False, {2})):
        flipped = (flips(same_on_batch) == images.flip(3)).flatten(1).all(1)
        assert {len(set(flipped.tolist()))} == kinds
    with pytest.raises(
        ValueError, match="same_on_batch: expected False, for crops depend on an image's boxes"
    ):
        augmentation.AugmentationSequential(augmentation.RandomIoUCrop(), same_on_batch=True)


def test_boxes_that_are_not_chosen_stay() -> None:
    count = 30
    boxes = torch.tensor([[0.0, 0.0, 4.0, 0.5], [1.0, 1.0, 5.0, 5.0]])
    augment = augmentation.AugmentationSequential(
        augmentation.SanitizeBoundingBoxes(),
        torch.nn.Identity(),
        data_keys=["input", "bbox_xyxy", "class"],
        random_apply=1,
    )
    images, labels = torch.rand(count, 1, 8, 8), [torch.arange(2)] * count
    _, kept, classes = augment(images, [boxes] * count, labels)
    chosen = augment._params[0]["batch_prob"]
    assert 0 < chosen.sum() < count
    _, padded = augment(
        images, boxes.expand(count, 2, 4), data_keys=["input", "bbox_xyxy"], params=augment._params
    )
    for i, taken in enumerate(chosen.tolist()):
        assert torch.equal(kept[i], boxes[1:] if taken else boxes)
        assert classes[i].tolist() == ([1] if taken else [0, 1])
        assert torch.equal(padded[i], boxes * torch.tensor([[0.0], [1.0]]) if taken else boxes)


def test_no_samples_and_no_frames() -> None:
    flip = augmentation.RandomHorizontalFlip()
    patches = augmentation.PatchSequential(flip, grid_size=(2, 2), patchwise_apply=False)
    by_place = augmentation.PatchSequential(flip, flip, grid_size=(1, 2), padding="valid")
    for augment in (patches, by_place):
        assert augment(torch.rand(0, 3, 5, 6)).shape[:2] == (0, 3)
    for same_on_frame in (True, False):
        video = augmentation.VideoSequential(flip, same_on_frame=same_on_frame)
        assert video(torch.rand(2, 0, 3, 5, 6)).shape == (2, 0, 3, 5, 6)
        assert video(torch.rand(0, 4, 3, 5, 6)).shape == (0, 4, 3, 5, 6)
    videos = augmentation.VideoSequential(flip, data_format="BCTHW")
    assert videos(torch.rand(2, 3, 0, 5, 6)).shape == (2, 3, 0, 5, 6)
