"""Classes of mixes and their data keys; mosaics against NumPy with the drawn numbers."""

import inspect
from typing import Any

import numpy as np
import pytest
import torch
from scipy import stats
from torch import Tensor

from chiasm import augmentation as A
from chiasm.primitives.random.draws import uniform

SEED = torch.arange(20, 28)
LABEL = torch.tensor([3, 1, 4, 1, 5, 9, 2, 6])
P = 0.6
MODES = {"constant": "constant", "replicate": "edge", "reflect": "reflect", "circular": "wrap"}


def images(dtype: torch.dtype = torch.float32, height: int = 12, width: int = 15) -> Tensor:
    made = torch.randint(0, 256, (8, 3, height, width), generator=torch.Generator().manual_seed(3))
    return made.to(dtype)


def masks() -> Tensor:
    return torch.randint(0, 5, (8, 1, 12, 15), generator=torch.Generator().manual_seed(1))


def permutation(keys: Tensor) -> list[int]:
    """Sample b gets the sample whose index is the rank of b's key."""
    return [sorted(keys.tolist()).index(key) for key in keys.tolist()]


def mosaics(x: np.ndarray, grid: tuple[int, int], mode: str, size: tuple[int, int]) -> list[np.ndarray]:
    """The expected samples, by numpy.block, numpy.pad and slices."""
    u, count = uniform(SEED, 2 + grid[0] * grid[1]), grid[0] * grid[1]
    height, width = x.shape[2:]
    partner = [list(range(8))] + [permutation(u[:, 3 + i]) for i in range(count - 1)]
    found = []
    for b in range(8):
        tiles = [[x[partner[i * grid[1] + j][b]] for j in range(grid[1])] for i in range(grid[0])]
        big = np.concatenate([np.concatenate(row, 2) for row in tiles], 1)
        left = int((float(u[b, 1]) * 0.4 + 0.3) * width)
        top = int((float(u[b, 2]) * 0.4 + 0.3) * height)
        if u[b, 0] >= P:
            big, left, top = x[b], 0, 0
        how: Any = MODES[mode] if u[b, 0] < P else "constant"
        padded = np.pad(big, ((0, 0), (0, 40), (0, 40)), how)
        found.append(padded[:, top : top + size[0], left : left + size[1]])
    return found


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize(("grid", "size"), [((2, 2), (12, 15)), ((2, 3), (20, 17)), ((1, 2), (9, 40))])
@pytest.mark.parametrize("dtype", [torch.float32, torch.uint8])
def test_mosaics_are_numpys(
    dtype: torch.dtype, grid: tuple[int, int], size: tuple[int, int], mode: str
) -> None:
    x = images(dtype)
    assert 0 < int((uniform(SEED, 1) < P).sum()) < 8
    settings: dict[str, Any] = {"mosaic_grid": grid, "p": P, "padding_mode": mode}
    made = A.random_mosaic(x, SEED, size, **settings)
    for b, expected in enumerate(mosaics(x.numpy(), grid, mode, size)):
        np.testing.assert_array_equal(made[b].numpy(), expected)
    module = A.RandomMosaic(size, **settings)
    assert module(x, seed=SEED).equal(made)
    assert module(x, params=module._params).equal(made)
    assert torch.jit.script(module)(x, SEED).equal(made)


def test_a_mosaic_s_box_begins_anywhere_and_has_every_partner_alike() -> None:
    seed = torch.arange(3000)
    x = torch.arange(3000.0)[:, None, None, None].expand(-1, 1, 10, 10)
    module = A.RandomMosaic(start_ratio_range=(0.0, 1.0), p=1.0)
    module(x, seed=seed)
    corner = module._params["corner"]
    for axis in range(2):
        counts = torch.bincount(corner[:, axis], minlength=10)
        assert len(counts) == 10 and stats.chisquare(counts.numpy()).pvalue > 0.01
    partner = module._params["permutation"]
    assert partner[:, 0].equal(seed)
    for i in range(1, 4):
        assert partner[:, i].sort().values.equal(seed)


@pytest.mark.parametrize("key", ["bbox_xyxy", "bbox_xywh", "bbox"])
@pytest.mark.parametrize("size", [None, (20, 17)])
def test_boxes_of_a_mosaic_are_those_of_what_is_seen(key: str, size: tuple[int, int] | None) -> None:
    """Two rectangles are painted into each image: their boxes must end where the paint ends."""
    generator = torch.Generator().manual_seed(5)
    low = torch.randint(0, 9, (8, 2, 2), generator=generator)
    side = torch.randint(1, 4, (8, 2, 2), generator=generator)
    high = low + side  # (x, y)
    paint = torch.zeros(8, 16, 12, 15)  # a channel for each rectangle
    for b in range(8):
        for n in range(2):
            paint[b, 2 * b + n, low[b, n, 1] : high[b, n, 1], low[b, n, 0] : high[b, n, 0]] = 1.0
    given = {
        "bbox_xyxy": torch.cat([low, high], -1).float(),
        "bbox_xywh": torch.cat([low, side], -1).float(),
        "bbox": torch.stack(
            [low, torch.stack([high[..., 0] - 1, low[..., 1]], -1), high - 1]
            + [torch.stack([low[..., 0], high[..., 1] - 1], -1)],
            2,
        ).float(),
    }[key]
    module = A.RandomMosaic(size, (2, 2), min_bbox_size=3.0, data_keys=["input", key], p=P)
    out, boxes = module(paint, given, seed=SEED)
    assert boxes.shape[:2] == (8, 8)
    partner = module._params["permutation"]
    shown = 0
    for b in range(8):
        if not module._params["batch_prob"][b]:
            assert not boxes[b, 2:].any()
        for t in range(4 if module._params["batch_prob"][b] else 1):
            sources = [(u, n) for u in range(4) for n in range(2) if partner[b, u] == partner[b, t]]
            for n in range(2):
                box = boxes[b, 2 * t + n].reshape(-1)
                if not box.any():
                    continue
                shown += 1
                edges = {
                    "bbox_xyxy": lambda v: v,
                    "bbox_xywh": lambda v: torch.cat([v[:2], v[:2] + v[2:]]),
                    "bbox": lambda v: torch.cat([v[:2], v[4:6] + 1]),
                }[key](box).long()
                plane = out[b, 2 * int(partner[b, t]) + n]
                inside = plane[edges[1] : edges[3], edges[0] : edges[2]]
                assert inside.numel() >= 3 and inside.all()
                if len(sources) == 2:  # painted once: the surroundings are not painted
                    assert plane.sum() == inside.sum()
    assert shown > 10


def test_masks_are_mixed_as_their_images() -> None:
    mask = masks()
    for name, settings in (
        ("RandomJigsaw", {"grid": (3, 5)}),
        ("RandomMosaic", {"output_size": (14, 13)}),
        ("RandomCutMixV2", {"num_mix": 2}),
    ):
        mix = getattr(A, name)(**settings, p=P)
        image, moved = mix(mask.double().expand(-1, 3, -1, -1), mask, data_keys=["input", "mask"], seed=SEED)
        assert moved.dtype == torch.int64 and not torch.equal(moved, mask)
        assert moved.double().expand_as(image).equal(image)


def test_boxes_as_a_list_are_refused_by_name() -> None:
    mosaic = A.RandomMosaic(data_keys=["input", "bbox_xyxy"], p=1.0)
    with pytest.raises(TypeError, match="bbox_xyxy: expected a tensor, got list"):
        mosaic(torch.rand(2, 3, 8, 8), [torch.zeros(1, 4), torch.zeros(2, 4)])


def test_what_a_call_takes_and_gives() -> None:
    x, mask = images(), masks()
    mix_up = A.random_mix_up(x, LABEL, SEED, (0.0, 1.0), P)
    for keys, given in ((["input", "class"], (x, LABEL)), (["label", "image"], (LABEL, x))):
        made = A.RandomMixUpV2(p=P, data_keys=keys)(*given, seed=SEED)
        assert isinstance(made, list)
        order = made if keys[0] == "input" else made[::-1]
        assert order[0].equal(mix_up[0]) and order[1].equal(mix_up[1])
    alone = A.RandomMixUpV2(p=P, data_keys=["input"])
    assert alone(x, seed=SEED).equal(mix_up[0])
    assert alone(x, params=alone._params).equal(mix_up[0])
    cut = A.random_cut_mix(x, LABEL, SEED, 2, p=P)
    made = A.RandomCutMixV2(2, p=P, data_keys=["mask", "input", "class"])(mask, x, LABEL, seed=SEED)
    assert made[1].equal(cut[0]) and made[2].equal(cut[1]) and made[0].shape == mask.shape
    torch.manual_seed(3)
    drawn = A.RandomCutMixV2(p=P)(x, LABEL)
    torch.manual_seed(3)
    assert drawn[0].equal(A.RandomCutMixV2(p=P)(x, LABEL)[0])


def test_a_second_image_is_mixed_as_the_first() -> None:
    x = images(torch.uint8)
    for name in ("RandomMixUpV2", "RandomCutMixV2"):
        first, second, third = getattr(A, name)(p=1.0, data_keys=["input"] * 3)(x, x, x.int(), seed=SEED)
        assert second.dtype == torch.uint8 and second.equal(first)
        # Numbers that are not bytes are blended in float64, where bytes are in float32.
        assert third.dtype == torch.int32 and (third - first.int()).abs().max() <= 1
        assert (third != first).float().mean() < 1e-3


@pytest.mark.parametrize("name", ["RandomMixUpV2", "RandomCutMixV2"])
def test_labelled_mixes_script(name: str) -> None:
    mix, x = getattr(A, name)(p=P), images()
    for made in (torch.jit.script(mix)(x, LABEL, SEED), mix(x, LABEL, SEED)):
        for a, b in zip(made, mix(x, LABEL, seed=SEED), strict=True):
            torch.testing.assert_close(a, b, rtol=0, atol=1e-6)


@pytest.mark.parametrize("deep", [False, True])
def test_transplantation_by_keys(deep: bool) -> None:
    shape = (8, 4, 12, 15) if deep else (8, 12, 15)
    mask = torch.randint(0, 5, shape, generator=torch.Generator().manual_seed(1))
    x = torch.rand(8, 3, *shape[1:], generator=torch.Generator().manual_seed(2))
    function = A.random_transplantation3d if deep else A.random_transplantation
    kind = A.RandomTransplantation3D if deep else A.RandomTransplantation
    image, labels = function(x, mask, SEED, [2], P)
    assert not image.equal(x)
    transplant = kind([2], P)
    for made in (transplant(x, mask, seed=SEED), transplant(x, mask[:, None].short(), seed=SEED)):
        assert made[0].equal(image) and made[1].reshape(shape).equal(labels.to(made[1].dtype))
    script = torch.jit.script(transplant)(x, mask, SEED)
    assert script[0].equal(image) and script[1].equal(labels)
    further = kind([2], P, data_keys=["mask", "input", "mask", "input"])(mask, x, 2 * mask, -x, seed=SEED)
    assert further[0].equal(labels) and further[1].equal(image)
    assert further[2].equal(2 * labels) and further[3].equal(-image)
    never = kind(torch.tensor([2]), P, p_batch=0.0)(x, mask, seed=SEED)
    assert never[0].equal(x) and never[1].equal(mask)
    whole = [
        kind(p=1.0, p_batch=0.5)(x[:2], mask[:2], seed=SEED[:2] + 9 * i)[0].equal(x[:2]) for i in range(60)
    ]
    assert stats.binomtest(sum(whole), 60, 0.5 + 0.5 * 0.5).pvalue > 0.01  # half of the pairs are one sample


def test_a_label_of_volumes_is_copied_where_its_partner_has_it() -> None:
    mask = torch.randint(0, 4, (8, 3, 5, 6), generator=torch.Generator().manual_seed(1))
    x = torch.rand(8, 2, 3, 5, 6, generator=torch.Generator().manual_seed(2))
    mixed, labels = A.random_transplantation3d(x, mask, SEED, [0], P)
    u = uniform(SEED, 2)
    partner = permutation(u[:, 1])
    for b in range(8):
        if u[b, 0] >= P or partner[b] == b:
            assert mixed[b].equal(x[b]) and labels[b].equal(mask[b])
            continue
        fits = []
        for label in (1, 2, 3):
            there = (mask[partner[b]] == label).numpy()
            expected = np.where(there, x[partner[b]].numpy(), x[b].numpy())
            fits.append(np.array_equal(expected, mixed[b].numpy()))
            if fits[-1]:
                np.testing.assert_array_equal(labels[b], np.where(there, label, mask[b].numpy()))
        assert sum(fits) == 1


def test_bytes() -> None:
    x, u = images(torch.uint8), uniform(SEED, 3)
    mixed, labels = A.random_mix_up(x, LABEL, SEED, p=P)
    assert mixed.dtype == torch.uint8 and labels.dtype == torch.float32
    for b, partner in enumerate(permutation(u[:, 2])):
        share = float(u[b, 1]) if u[b, 0] < P else 0.0
        exact = x[b].numpy() * (1 - share) + x[partner].numpy() * share
        assert np.abs(mixed[b].numpy() - exact).max() <= 0.5 + 1e-4
    for op, more in (
        (A.random_cut_mix, [LABEL, SEED]),
        (A.random_jigsaw, [SEED, (3, 5)]),
        (A.random_transplantation, [masks()[:, 0], SEED, [0]]),
    ):
        of_bytes, of_numbers = op(x, *more), op(x.float(), *more)
        if isinstance(of_bytes, tuple):
            assert of_bytes[1].equal(of_numbers[1])
            of_bytes, of_numbers = of_bytes[0], of_numbers[0]
        assert of_bytes.dtype == torch.uint8 and of_bytes.float().equal(of_numbers)


def test_tiles_in_a_sequence() -> None:
    mask, x = masks(), images()
    sequence = A.AugmentationSequential(
        A.RandomHorizontalFlip(), A.RandomJigsaw((3, 5), p=P), data_keys=["input", "mask"]
    )
    out, moved = sequence(mask.float(), mask.float(), seed=SEED)
    assert moved.equal(out) and not out.equal(mask.float())
    assert sequence.inverse(out, moved)[0].equal(mask.float())
    assert torch.jit.script(sequence)(x, SEED).equal(sequence.forward(x, SEED))
    mosaic = A.AugmentationSequential(A.RandomMosaic(p=1.0))
    assert mosaic(x, seed=SEED).shape == x.shape
    points = torch.zeros(8, 1, 2)
    with pytest.raises(ValueError, match="RandomJigsaw: it moves parts of images"):
        sequence(x, points, data_keys=["input", "keypoints"])
    with pytest.raises(ValueError, match="RandomMosaic: parts of images are lost"):
        mosaic.inverse(x)
    with pytest.raises(ValueError, match="call RandomMixUpV2, which takes"):
        A.AugmentationSequential(A.RandomMixUpV2())


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("RandomMixUpV2", "lambda_val same_on_batch p keepdim data_keys"),
        (
            "RandomCutMixV2",
            "num_mix cut_size beta same_on_batch p keepdim data_keys use_correct_lambda",
        ),
        ("RandomJigsaw", "grid data_keys p same_on_batch keepdim ensure_perm"),
        (
            "RandomMosaic",
            "output_size mosaic_grid start_ratio_range min_bbox_size data_keys p keepdim padding_mode"
            " resample align_corners cropping_mode",
        ),
        ("RandomTransplantation", "excluded_labels p p_batch data_keys"),
        ("RandomTransplantation3D", "excluded_labels p p_batch data_keys"),
    ],
)
def test_constructors_order(name: str, parameters: str) -> None:
    assert list(inspect.signature(getattr(A, name)).parameters) == parameters.split()
    assert repr(getattr(A, name)()).startswith(f"{name}(")


def test_what_is_refused() -> None:
    x = images()
    with pytest.raises(ValueError, match=r"data_keys: expected some of \['input', 'class'\], got 'mask'"):
        A.RandomMixUpV2(data_keys=["input", "mask"])
    with pytest.raises(ValueError, match="data_keys: expected 'input' among them"):
        A.RandomMixUpV2(data_keys=["class"])
    with pytest.raises(ValueError, match="args: expected 2 tensors"):
        A.RandomMixUpV2()(x)
    with pytest.raises(ValueError, match="same_on_batch: expected False"):
        A.RandomMixUpV2(same_on_batch=True)
    with pytest.raises(ValueError, match="same_on_batch: expected False"):
        A.AugmentationSequential(A.RandomMosaic(), same_on_batch=True)(x)
    with pytest.raises(ValueError, match="mosaic_grid: expected positive numbers"):
        A.random_mosaic(x, SEED, mosaic_grid=(0, 2))
    with pytest.raises(ValueError, match="start_ratio_range: expected"):
        A.RandomMosaic(start_ratio_range=(0.5, 1.5))
    with pytest.raises(ValueError, match="padding_mode: expected one of"):
        A.random_mosaic(x, SEED, padding_mode="zeros")
    with pytest.raises(TypeError, match="mask: expected whole numbers"):
        A.RandomTransplantation()(x, x[:, 0])
    with pytest.raises(ValueError, match="data_keys: expected a 'mask'"):
        A.RandomTransplantation(data_keys=["input"])(x)
    with pytest.raises(ValueError, match=r"mask: expected shape \(B, D, H, W\)"):
        A.random_transplantation3d(x[:, :, None], torch.zeros(8, 3, 3, 3, dtype=torch.int64), SEED, [])


@pytest.mark.parametrize("dtype", [torch.float32, torch.uint8])
def test_a_patch_mix_copies_a_square_of_the_partner(dtype: torch.dtype) -> None:
    x, module = images(dtype), A.PatchMix(patch_size=5, data_keys=["input", "mask"])
    made, mask = module(x, masks(), seed=SEED)
    partner = permutation(uniform(SEED, 1)[:, 0])
    assert module._params["partner"].tolist() == partner
    for b, (left, top) in enumerate(module._params["corner"].tolist()):
        assert 0 <= left <= 10 and 0 <= top <= 7
        square = (slice(None), slice(top, top + 5), slice(left, left + 5))
        for found, given in ((made, x), (mask, masks())):
            expected = given[b].clone()
            expected[square] = given[partner[b]][square]
            assert found[b].equal(expected)
    assert module(x, masks(), params=module._params)[0].equal(made)
    assert torch.jit.script(module)(x, SEED).equal(made)
    assert A.PatchMix(patch_size=5, p=0.0)(x).equal(x)
    corner = module.draw(torch.arange(4000), [4000, 3, 12, 15])["corner"]
    assert stats.chisquare(torch.bincount(corner[:, 0], minlength=11).numpy()).pvalue > 0.001
    assert stats.chisquare(torch.bincount(corner[:, 1], minlength=8).numpy()).pvalue > 0.001


def test_what_a_patch_mix_refuses() -> None:
    for message, call in {
        r"patch_size: expected at most the image's sides \(12, 15\), got 16": lambda: A.PatchMix()(images()),
        "alpha, patch_size: expected positive": lambda: A.PatchMix(0.0),
        "same_on_batch: expected False": lambda: A.PatchMix(same_on_batch=True),
        "expected no 'class', for PatchMix": lambda: A.AugmentationSequential(
            A.PatchMix(patch_size=3), data_keys=["input", "class"]
        )(images(), LABEL),
        "PatchMix: parts of images are lost": lambda: A.PatchMix(patch_size=3).inverse_transform(
            images(), {}, []
        ),
    }.items():
        with pytest.raises(ValueError, match=message):
            call()


def test_masks_of_another_size_are_refused() -> None:
    images, small = torch.rand(2, 3, 8, 8), torch.zeros(2, 1, 4, 8, dtype=torch.int64)
    mixes: list[Any] = [
        A.RandomCutMixV2(data_keys=["input", "mask"]),
        A.RandomJigsaw((2, 2), data_keys=["input", "mask"]),
        A.RandomMosaic(data_keys=["input", "mask"]),
        A.PatchMix(patch_size=2, data_keys=["input", "mask"]),
    ]
    for mix in mixes:
        for mask in (small, small[:1].expand(1, 1, 4, 8), small[:, 0]):
            with pytest.raises(ValueError, match=r"mask: expected shape \(2, C, 8, 8\), got"):
                mix(images, mask)
        assert mix(images, torch.zeros(2, 1, 8, 8))[1].shape == (2, 1, 8, 8)
    copy = A.RandomTransplantation(data_keys=["input", "mask", "mask"])
    whole = torch.zeros(2, 8, 8, dtype=torch.int64)
    with pytest.raises(ValueError, match=r"mask: expected shape \(2, C, 8, 8\), got"):
        copy(images, whole, whole[:, :4])
    with pytest.raises(ValueError, match=r"bbox_xyxy: expected shape \(2, N, 4\), got"):
        A.RandomMosaic(data_keys=["input", "bbox_xyxy"])(images, torch.zeros(1, 1, 4))
