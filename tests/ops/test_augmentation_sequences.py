"""Sequences of which each sample goes through some steps."""

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


def test_what_is_refused() -> None:
    with pytest.raises(ValueError, match="random_apply: expected 0 to 4 steps, got 5"):
        sequence(random_apply=5)
    with pytest.raises(ValueError, match="their order is fixed, got True"):
        sequence(random_apply=True)
    with pytest.raises(ValueError, match="random_apply_weights: expected 4 positive numbers"):
        sequence(random_apply=2, random_apply_weights=[1.0, 2.0])
    with pytest.raises(ValueError, match="steps that change the size"):
        augmentation.AugmentationSequential(augmentation.CenterCrop(4), random_apply=1)
