"""Policies: each operation and the tables against torchvision's, and the random choice."""

import math

import pytest
import torch
from scipy import stats
from torch import Tensor
from torchvision.transforms import InterpolationMode, autoaugment
from torchvision.transforms.v2 import functional as tv

from chiasm import augmentation as A
from chiasm.augmentation.distributions import beta, dirichlet, gamma
from chiasm.augmentation.operations import amounts, names, operated
from chiasm.augmentation.policy_tables import policy_table
from chiasm.primitives.random.draws import integers, uniform

NAMES = names()
SEED = torch.arange(20, 28)
RANGES = [0.3, 150.0 / 331.0, 30.0, 0.9, 4.0, 8.0]
#: torchvision's weight of red is 0.2989, BT.601's is 0.299.
GREY = 2e-4


def images(batch: int = 8, height: int = 18, width: int = 23) -> Tensor:
    generator = torch.Generator().manual_seed(3)
    return torch.randint(0, 256, (batch, 3, height, width), generator=generator).double() / 255.0


def by_torchvision(x: Tensor, name: str, amount: float) -> Tensor:
    """One sample, as torchvision's policies call its functions."""
    still = {"angle": 0.0, "scale": 1.0, "interpolation": InterpolationMode.BILINEAR}
    plain = {**still, "translate": [0, 0], "shear": [0.0, 0.0]}
    levels = (x * 255.0).round().to(torch.uint8)
    if name == "ShearX":
        shear = [math.degrees(math.atan(amount)), 0.0]
        return tv.affine(x, **{**plain, "shear": shear}, center=[0, 0])
    if name == "ShearY":
        shear = [0.0, math.degrees(math.atan(amount))]
        return tv.affine(x, **{**plain, "shear": shear}, center=[0, 0])
    if name == "TranslateX":
        return tv.affine(x, **{**plain, "translate": [int(amount), 0]})
    if name == "TranslateY":
        return tv.affine(x, **{**plain, "translate": [0, int(amount)]})
    if name == "Rotate":
        return tv.rotate(x, amount, InterpolationMode.BILINEAR)
    return {
        "Identity": lambda: x,
        "Brightness": lambda: tv.adjust_brightness(x, amount),
        "Color": lambda: tv.adjust_saturation(x, amount),
        "Contrast": lambda: tv.adjust_contrast(x, amount),
        "Sharpness": lambda: tv.adjust_sharpness(x, amount),
        "Posterize": lambda: tv.posterize(levels, int(amount)).double() / 255.0,
        "Solarize": lambda: tv.solarize(x, amount),
        "AutoContrast": lambda: tv.autocontrast(x),
        "Equalize": lambda: tv.equalize(levels).double() / 255.0,
        "Invert": lambda: tv.invert(x),
    }[name]()


@pytest.mark.parametrize("level", [-0.7, 0.4, 1.0])
@pytest.mark.parametrize("name", NAMES)
def test_an_operation(name: str, level: float) -> None:
    operation = torch.tensor([NAMES.index(name), 0])
    strength = torch.tensor([abs(level), abs(level)])
    amount = amounts(operation, strength, torch.full([2], math.copysign(1.0, level)), RANGES, 18, 23, True)
    x = images(2)
    y = operated(x, operation, amount, "bilinear")
    assert y[1].equal(x[1])
    torch.testing.assert_close(y[0], by_torchvision(x[0], name, float(amount[0])), rtol=0, atol=GREY)


def space(made: object, *sizes: object) -> dict:
    return made._augmentation_space(*sizes)


@pytest.mark.parametrize(
    ("made", "ranges", "relative", "bins", "known"),
    [
        (lambda: space(autoaugment.RandAugment(), 31, (18, 23)), RANGES, True, 31, 14),
        (
            lambda: space(autoaugment.TrivialAugmentWide(), 31),
            [0.99, 32.0, 135.0, 0.99, 6.0, 8.0],
            False,
            31,
            14,
        ),
        (lambda: space(autoaugment.AutoAugment(), 10, (18, 23)), RANGES, True, 10, 14),
        (lambda: space(autoaugment.AugMix(), 10, (18, 23)), [0.3, 1 / 3, 30.0, 0.9, 4.0, 4.0], True, 10, 13),
    ],
    ids=["rand", "trivial", "auto", "mix"],
)
def test_strengths_are_torchvisions(made, ranges: list[float], relative: bool, bins: int, known: int) -> None:
    table = made()
    assert len(table) == known
    for name, (magnitudes, signed) in table.items():
        for k in range(bins):
            for sign in (1.0, -1.0):
                number = torch.tensor([NAMES.index(name)])
                found = amounts(
                    number, torch.tensor([k / (bins - 1)]), torch.tensor([sign]), ranges, 18, 23, relative
                )
                if magnitudes.dim() == 0:
                    continue  # no strength
                expected = float(magnitudes[k]) * (sign if signed else 1.0)
                if name in ("Brightness", "Color", "Contrast", "Sharpness"):
                    expected += 1.0
                if name == "Solarize":
                    expected /= 255.0  # for bytes
                if name.startswith("Translate"):
                    # A number within rounding of an integer may be truncated to either neighbour.
                    assert float(found) in (int(expected - 1e-4), int(expected + 1e-4))
                    continue
                assert float(found) == pytest.approx(expected, abs=1e-5), name


@pytest.mark.parametrize("policy", ["imagenet", "cifar10", "svhn"])
def test_tables(policy: str) -> None:
    table = torch.tensor(policy_table(policy)).reshape(25, 2, 3)
    expected = autoaugment.AutoAugment(autoaugment.AutoAugmentPolicy(policy)).policies
    for line, pair in zip(table, expected, strict=True):
        for (operation, chance, strength), (name, p, magnitude) in zip(line.tolist(), pair, strict=True):
            assert (NAMES[int(operation)], strength) == (name, magnitude or 0)
            assert chance == pytest.approx(p)


def test_rand_augment_as_drawn() -> None:
    x, sign, operation = images(), uniform(SEED, 2), integers(SEED, 14, 2, 1)
    y = A.rand_augment(x, SEED, 2, 12)
    for b in range(8):
        expected = x[b]
        for i in range(2):
            one = operation[b, i].reshape(1)
            turned = torch.where(sign[b, i] < 0.5, -1.0, 1.0).reshape(1)
            amount = amounts(one, torch.tensor([12 / 30]), turned, RANGES, 18, 23, True)
            expected = by_torchvision(expected, NAMES[int(one)], float(amount))
        # Rounding may move a level across a step of Equalize or Posterize.
        assert ((y[b] - expected).abs() > 3 * GREY).double().mean() < 0.01


def test_aug_mix_is_the_blend() -> None:
    x, alpha = images(), 0.7
    y = A.aug_mix(x, SEED, 4, 2, 1, alpha, mode="nearest")
    known = torch.tensor([1, 2, 3, 4, 5, 10, 11, 12, 13, 6, 7, 8, 9])
    operation = known[integers(SEED, 13, 2, 1)]
    level, sign = integers(SEED, 4, 2, 2).float() / 9, torch.where(uniform(SEED, 2) < 0.5, -1.0, 1.0)
    weight = gamma(SEED, alpha, 2, 4)
    weight = weight / weight.sum(1, keepdim=True)
    own = beta(SEED, alpha, 1, 7)
    for b in range(8):
        expected = float(own[b]) * x[b]
        for i in range(2):
            one = slice(i, i + 1)
            amount = amounts(
                operation[b, one],
                level[b, one],
                sign[b, one],
                [0.3, 1 / 3, 30.0, 0.9, 4.0, 4.0],
                18,
                23,
                True,
            )
            chain = operated(x[b : b + 1], operation[b, one], amount, "nearest")[0]
            expected = expected + (1 - float(own[b])) * float(weight[b, i]) * chain
        torch.testing.assert_close(y[b], expected, rtol=0, atol=1e-6)


def test_a_small_alpha_chooses_one_chain() -> None:
    """exp(log(u) / alpha) is 0 for nearly every draw of each chain."""
    weight = dirichlet(torch.arange(3000), 0.001, 3, 4)
    torch.testing.assert_close(weight.sum(1), torch.ones(3000))
    assert (weight.amax(1) > 0.999).double().mean() > 0.98
    assert stats.chisquare(weight.argmax(1).bincount(minlength=3).numpy()).pvalue > 0.01
    for call in (A.aug_mix, torch.jit.script(A.aug_mix)):
        assert call(images(), SEED, alpha=0.001).isfinite().all()


def test_every_operation_is_equally_likely() -> None:
    counts = integers(torch.arange(4000), 14, 1, 1).flatten().bincount(minlength=14)
    assert stats.chisquare(counts.numpy()).pvalue > 0.01


@pytest.mark.parametrize("name", ["rand_augment", "trivial_augment", "auto_augment", "aug_mix"])
def test_a_sample_hangs_on_its_own_seed_alone(name: str) -> None:
    op, x = getattr(A, name), images().float()
    together = op(x, SEED)
    assert op(x, SEED.clone()).equal(together)
    alone = torch.cat([op(x[b : b + 1], SEED[b : b + 1]) for b in range(8)])
    torch.testing.assert_close(together, alone, rtol=0, atol=1e-6)
    assert not op(x, SEED + 100).equal(together)
    with pytest.raises(TypeError, match="seed: expected an int64 tensor"):
        op(x, SEED.float())
    with pytest.raises(ValueError, match="mode: expected one of"):
        op(x, SEED, mode="cubic")


@pytest.mark.parametrize("name", ["rand_augment", "trivial_augment", "auto_augment", "aug_mix"])
def test_bytes_are_rounded_once(name: str) -> None:
    x = torch.randint(0, 256, (8, 3, 18, 23), generator=torch.Generator().manual_seed(3))
    numbers, made = getattr(A, name)(x / 255.0, SEED), getattr(A, name)(x.byte(), SEED)
    assert made.dtype == torch.uint8
    # float32 and float64 sometimes round to different levels; Equalize amplifies the difference.
    off = (made.int() - (numbers * 255).round().int()).abs()
    assert (off > 0).double().mean() < 0.01


def test_settings_that_are_refused() -> None:
    x = images()
    for op, settings, message in (
        (A.rand_augment, {"n": 0}, "n: expected at least 1, got 0"),
        (A.rand_augment, {"m": 31}, "m: expected 0 to 30, got 31"),
        (A.auto_augment, {"policy": "mnist"}, "policy: expected one of"),
        (A.aug_mix, {"severity": 11}, "severity: expected 1 to 10"),
        (A.aug_mix, {"mixture_width": 0}, "mixture_width: expected at least 1"),
        (A.aug_mix, {"chain_depth": 0}, "chain_depth: expected -1 or at least 1"),
        (A.aug_mix, {"alpha": 0.0}, "alpha: expected a positive number"),
    ):
        with pytest.raises(ValueError, match=message):
            op(x, SEED, **settings)
