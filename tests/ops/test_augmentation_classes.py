"""Classes of the augmentations: Kornia's constructors, seeds, TorchScript."""

import inspect
import math
from typing import Any

import numpy as np
import pytest
import scipy.ndimage
import torch
from torch import Tensor

from chiasm import augmentation as A
from chiasm.augmentation.classes import CLASSES
from chiasm.export import example_inputs
from chiasm.export.catalog import Entry, catalog
from chiasm.export.tracing.module import bind_spec

SEED = torch.arange(20, 25)
GIVEN = {
    "Normalize": ([0.5, 0.4, 0.3], 0.25),
    "Denormalize": (0.5, (0.2, 0.3, 0.4)),
    "RandomGaussianBlur": (3, (0.1, 2.0)),
    "RandomMotionBlur": ((3, 5), 35.0, 0.5),
    "RandAugment": (2, 9),
    "ColorJitter": (0.2, 0.2, 0.2, 0.1),
    "ColorJiggle": (0.2, 0.2, 0.2, 0.1),
    "RandomRain": ((5, 9), (3, 5), (-2, 2)),
}
#: What the classes that move pixels need.
MOVING: dict[str, Any] = {
    "CenterCrop": (8,),
    "CenterCrop3D": (4,),
    "LongestMaxSize": (8,),
    "PadTo": ((20, 20),),
    "RandomAffine": (10.0,),
    "RandomAffine3D": (10.0,),
    "RandomCrop": (8,),
    "RandomCrop3D": (4,),
    "RandomFisheye": ((-0.3, 0.3), (-0.3, 0.3), (0.9, 1.0)),
    "RandomMotionBlur3D": (3, 10.0, 0.5),
    "RandomResizedCrop": (8,),
    "RandomRotation": (10.0,),
    "RandomRotation3D": (10.0,),
    "RandomRotation90": ((0, 3),),
    "RandomShear": (10.0,),
    "RandomShortestSize": (8,),
    "Resize": (8,),
    "ScaleJitter": ((8, 8),),
    "SmallestMaxSize": (8,),
}
MADE = [
    name
    for name in A.__all__
    if inspect.isclass(getattr(A, name)) and "Base" not in name and not name.endswith("Sequential")
]
FUNCTIONS = {name: entry for name, entry in catalog().items() if name.startswith("augmentation.")}
every_class = pytest.mark.parametrize("name", CLASSES)


def images() -> Tensor:
    return torch.rand(5, 3, 24, 28, generator=torch.Generator().manual_seed(1))


def call(module: torch.nn.Module, x: Tensor, *seed: Tensor) -> Tensor:
    return module(x, seed=seed[0]) if seed else module(x)


@every_class
def test_scripts_and_replays(name: str) -> None:
    made, x = CLASSES[name](*GIVEN.get(name, ())), images()
    first = call(made, x, SEED)
    for again in (call(made, x, SEED), call(torch.jit.script(made), x, SEED)):
        torch.testing.assert_close(first, again, rtol=0, atol=1e-6)
    torch.manual_seed(3)
    drawn = call(made, x)
    torch.manual_seed(3)
    assert drawn.equal(call(made, x))
    assert repr(made).startswith(f"{name}(")
    made(x, seed=SEED)
    assert made(x, params=made._params).equal(first)
    with pytest.raises(ValueError, match="seed: "):
        made(x, params=made._params, seed=SEED[1:])


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("RandomBrightness", {"brightness": (1.0, 1.0)}),
        ("ColorJitter", {"brightness": (0.8, 1.2), "hue": (-0.1, 0.1)}),
        ("RandomSolarize", {"thresholds": (0.4, 0.6), "additions": (-0.1, 0.1)}),
        ("RandomSharpness", {"sharpness": (0.0, 0.5)}),
        ("RandomPosterize", {"bits": (3, 8)}),
        ("RandomJPEG", {"jpeg_quality": (1.0, 100.0)}),
        ("RandomRGBShift", {"r_shift_limit": (-0.5, 0.5)}),
        ("RandomMotionBlur", {"angle": (-35.0, 35.0), "direction": (-0.5, 0.5)}),
        ("RandomGaussianBlur", {"kernel_size": (3, 3)}),
    ],
)
def test_numbers_become_bounds(name: str, settings: dict) -> None:
    made = CLASSES[name](*GIVEN.get(name, ()))
    for key, bounds in settings.items():
        assert getattr(made, key) == pytest.approx(bounds), key


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("ColorJitter", "brightness contrast saturation hue same_on_batch p keepdim order"),
        ("Normalize", "mean std p keepdim"),
        ("RandomBoxBlur", "kernel_size border_type normalized same_on_batch p keepdim"),
        ("RandomGaussianIllumination", "gain center sigma sign p same_on_batch keepdim"),
        ("RandomMotionBlur", "kernel_size angle direction border_type resample same_on_batch p keepdim"),
        ("RandomSaltAndPepperNoise", "amount salt_vs_pepper p same_on_batch keepdim"),
    ],
)
def test_constructors_order(name: str, parameters: str) -> None:
    assert list(inspect.signature(CLASSES[name]).parameters) == parameters.split()


def test_same_on_batch_and_dimensions() -> None:
    x = images()[:1].expand(5, -1, -1, -1)
    y = A.RandomBrightness((0.5, 1.5), same_on_batch=True)(x, seed=SEED)
    assert y.equal(y[:1].expand_as(y))
    assert not A.RandomBrightness((0.5, 1.5))(x, seed=SEED).equal(y)
    assert A.RandomInvert(p=1.0)(x[0], seed=SEED[:1]).shape == (1, 3, 24, 28)
    assert A.RandomInvert(p=1.0, keepdim=True)(x[0], seed=SEED[:1]).equal(1 - x[0])


@pytest.mark.parametrize("entry", FUNCTIONS.values(), ids=FUNCTIONS)
def test_a_batch_of_no_images(entry: Entry) -> None:
    op, spec = bind_spec(entry.function(), entry.spec), entry.spec
    made = example_inputs.make(
        spec, example_inputs.fit(spec, {"B": 13, "C": 3, "H": 16, "W": 18, "N": 5}), "float32"
    )
    first, *rest = made.values()
    none = op(
        first[:0],
        *[t[:0] if each.shape[0] == "B" else t for each, t in zip(spec.inputs[1:], rest, strict=True)],
    )
    for some, empty in zip(outputs(op(first, *rest)), outputs(none), strict=True):
        assert empty.dtype == some.dtype
        assert empty.shape == torch.Size([0 if n == 13 else n for n in some.shape])


def outputs(result: Any) -> tuple[Tensor, ...]:
    return (result,) if isinstance(result, Tensor) else tuple(result)


@every_class
def test_a_batch_of_no_images_by_a_class(name: str) -> None:
    made = CLASSES[name](*GIVEN.get(name, ()))
    assert made(images()[:0]).shape == (0, 3, 24, 28)
    assert A.AugmentationSequential(made)(images()[:0]).shape == (0, 3, 24, 28)


def test_what_is_refused() -> None:
    with pytest.raises(ValueError, match=r"brightness: expected a number that is not negative, got -0\.5"):
        A.ColorJitter(-0.5)
    with pytest.raises(ValueError, match="same_on_batch: expected False"):
        A.RandomMixUpV2(same_on_batch=True)
    with pytest.raises(ValueError, match="normalized: expected True"):
        A.RandomBoxBlur(normalized=False)
    with pytest.raises(ValueError, match="kernel_size: expected whole numbers"):
        A.RandomMedianBlur((3.5, 3.0))
    with pytest.raises(ValueError, match="m: expected finite numbers, got nan"):
        A.RandAugment(2, math.nan)
    with pytest.raises(ValueError, match="m: expected 0 to 30, got nan"):
        A.rand_augment(images(), SEED, 2, math.nan)
    with pytest.raises(ValueError, match="pad_mode: expected one of"):
        A.PadTo((4, 5), "wrap")
    with pytest.raises(ValueError, match="max_size: expected a positive number"):
        A.LongestMaxSize(0)
    with pytest.raises(ValueError, match=r"size: expected whole numbers, got 2\.5"):
        A.Resize(2.5)


@pytest.mark.parametrize("name", MADE)
def test_a_wrong_setting_is_named(name: str) -> None:
    made = getattr(A, name)
    signature, refused = inspect.signature(made), 0
    for argument in signature.parameters:
        for wrong in (None, "x", -1, [], ("x",), (1, "y"), [[]], {}, math.inf, math.nan, 2.5, range(9)):
            bound = signature.bind_partial(*GIVEN.get(name, MOVING.get(name, ())))
            bound.arguments[argument] = wrong
            try:
                made(*bound.args, **bound.kwargs)
            except (TypeError, ValueError) as error:
                before, _, after = str(error).partition(":")
                assert argument in before, (argument, wrong, error)
                assert "expected" in after
                refused += 1
    assert refused > 0 or not signature.parameters or name in ("AutoAugment", "TrivialAugment")


def test_whole_numbers_may_be_floats() -> None:
    x = images()
    for made, other in (
        (A.RandAugment(2.0, 9.0), A.RandAugment(2, 9)),
        (A.AugMix(2.0, 2.0, 2.0), A.AugMix(2, 2, 2)),
        (A.Resize((8.0, 9.0)), A.Resize((8, 9))),
    ):
        assert made(x, seed=SEED).equal(other(x, seed=SEED))
    labels = torch.arange(5)
    one, other = A.RandomCutMixV2(2.0), A.RandomCutMixV2(2)
    assert one(x, labels, seed=SEED)[0].equal(other(x, labels, seed=SEED)[0])


def test_medians_reflect_at_the_border() -> None:
    x = torch.rand(2, 3, 9, 12, generator=torch.Generator().manual_seed(0))
    expected = scipy.ndimage.median_filter(x.numpy(), (1, 1, 3, 5), mode="mirror")
    np.testing.assert_array_equal(A.RandomMedianBlur((3, 5), p=1.0)(x), expected)
