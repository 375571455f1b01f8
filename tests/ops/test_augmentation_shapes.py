"""Crops, sizes, quarter turns and deformations: other libraries' values for given parameters."""

from typing import Any

import cv2
import numpy as np
import pytest
import torch
from scipy import ndimage, stats
from torch import Tensor, nn
from torchvision.transforms.v2 import functional as vision

from chiasm import augmentation

SEEDS = torch.arange(2000) * 1000003
NUMPY_MODES = {"constant": "constant", "reflect": "reflect", "replicate": "edge", "circular": "wrap"}


def photos(batch: int = 5, height: int = 21, width: int = 30, dtype: torch.dtype = torch.float32) -> Tensor:
    return torch.rand(batch, 3, height, width, generator=torch.Generator().manual_seed(1)).to(dtype)


def augmentations() -> dict[str, Any]:
    return {
        "crop": augmentation.RandomCrop((9, 11)),
        "padded_crop": augmentation.RandomCrop((23, 31), (2, 1, 3, 4), fill=0.5),
        "center_crop": augmentation.CenterCrop((8, 11)),
        "pad": augmentation.PadTo((25, 28), pad_value=0.25),
        "resize": augmentation.Resize((10, 40), align_corners=False),
        "longest": augmentation.LongestMaxSize(12),
        "smallest": augmentation.SmallestMaxSize(12, align_corners=False),
        "turn": augmentation.RandomRotation90((0, 3)),
        "elastic": augmentation.RandomElasticTransform((5, 7), (1.5, 2.0)),
        "spline": augmentation.RandomThinPlateSpline(),
        "fisheye": augmentation.RandomFisheye((-0.3, 0.3), (-0.2, 0.2), torch.tensor([0.9, 1.1])),
    }


NAMES = list(augmentations())


@pytest.mark.parametrize("name", NAMES)
def test_a_sample_does_not_see_its_batch(name: str) -> None:
    augment, images, seed = augmentations()[name], photos(), SEEDS[:5]
    whole = augment(images, seed=seed)
    for i in range(5):
        torch.testing.assert_close(augment(images[i : i + 1], seed=seed[i : i + 1]), whole[i : i + 1])


@pytest.mark.parametrize("name", NAMES)
def test_replay_and_script(name: str) -> None:
    augment, images = augmentations()[name], photos()
    first = augment(images, generator=torch.Generator().manual_seed(3))
    params = augment._params
    assert torch.equal(augment(images, params=params), first)
    torch.testing.assert_close(torch.jit.script(augment)(images, params["seed"]), first)
    sequence = augmentation.AugmentationSequential(augment, augmentation.RandomHorizontalFlip())
    torch.testing.assert_close(
        torch.jit.script(sequence)(images, SEEDS[:5]), sequence.forward(images, SEEDS[:5])
    )


@pytest.mark.parametrize("padding_mode", list(NUMPY_MODES))
@pytest.mark.parametrize("dtype", [torch.float32, torch.uint8])
def test_a_crop_is_cut_out_of_what_numpy_pads(padding_mode: str, dtype: torch.dtype) -> None:
    images = (photos(20) * 255).to(dtype)
    augment = augmentation.RandomCrop((9, 26), (8, 3, 5, 4), fill=7, padding_mode=padding_mode)
    out = augment(images, seed=SEEDS[:20])
    margins = ((0, 0), (3, 4), (8, 5))
    values = {"constant_values": 7} if padding_mode == "constant" else {}
    for image, cropped, corner in zip(images, out, augment._params["corner"].tolist(), strict=True):
        big = np.pad(image.numpy(), margins, NUMPY_MODES[padding_mode], **values)  # pyright: ignore
        x, y = corner[0] + 8, corner[1] + 3
        assert np.array_equal(cropped.numpy(), big[:, y : y + 9, x : x + 26])


def test_places_of_crops_are_equally_likely() -> None:
    augment = augmentation.RandomCrop((3, 5), (1, 0), pad_if_needed=True)
    x, y = augment.draw(SEEDS, [2000, 3, 8, 4])["corner"].T
    for drawn, low, high in ((x, -1, 0), (y, 0, 5)):
        counts = torch.bincount(drawn - low, minlength=high - low + 1)
        assert len(counts) == high - low + 1
        assert stats.chisquare(counts.numpy()).pvalue > 0.005
    missing = augmentation.RandomCrop((6, 9), pad_if_needed=True).draw(SEEDS, [2000, 3, 4, 9])["corner"]
    assert missing[:, 0].unique().tolist() == [0]
    assert missing[:, 1].unique().tolist() == [-2, -1, 0]


@pytest.mark.parametrize("size", [(8, 10), (7, 9), (21, 30), (25, 34)])
def test_the_middle_is_torchvision_s(size: tuple[int, int]) -> None:
    images = photos()
    out = augmentation.CenterCrop(size)(images)
    # If the centre lies between pixels, torchvision rounds half to even.
    even = tuple(s + (s - n) % 2 for s, n in zip(size, images.shape[2:], strict=True))
    expected = vision.center_crop(images, list(even))[..., : size[0], : size[1]]
    assert torch.equal(out, expected)


def test_padding_to_a_size_is_torch_s() -> None:
    images = photos()
    out = augmentation.PadTo((25, 28), pad_value=0.25)(images)
    assert torch.equal(out, nn.functional.pad(images, (0, -2, 0, 4), value=0.25))
    with pytest.raises(ValueError, match=r"input: expected at most \(25, 28\), crop_if_exceeds is False"):
        augmentation.PadTo((25, 28), crop_if_exceeds=False)(images)


@pytest.mark.parametrize("align_corners", [True, False])
def test_sizes_are_torch_s(align_corners: bool) -> None:
    images = photos(dtype=torch.float64)
    for augment, size in (
        (augmentation.Resize((10, 40), align_corners=align_corners), (10, 40)),
        (augmentation.Resize(14, align_corners=align_corners), (14, 20)),
        (augmentation.LongestMaxSize(20, align_corners=align_corners), (14, 20)),
        (augmentation.SmallestMaxSize(7, align_corners=align_corners), (7, 10)),
    ):
        out = augment(images)
        expected = nn.functional.interpolate(images, size, mode="bilinear", align_corners=align_corners)
        torch.testing.assert_close(out, expected, atol=1e-6, rtol=0)
        corners = torch.tensor([[[0.0, 0.0, 1.0], [29.0, 20.0, 1.0]]]).double()
        moved = (corners @ augment.transform_matrix.mT)[..., :2]
        # edges, half a pixel from the corner pixels' centres, map to edges
        ends = torch.tensor([[0.0, 0.0], [size[1] - 1.0, size[0] - 1.0]]).double()
        if not align_corners:
            scale = torch.tensor([size[1] / 30, size[0] / 21]).double()
            ends = torch.stack([scale * 0.5 - 0.5, ends[1] + 0.5 - scale * 0.5])
        torch.testing.assert_close(moved[0], ends)


def test_what_belongs_to_a_crop_moves_with_it() -> None:
    augment: Any = augmentation.AugmentationSequential(
        augmentation.RandomCrop((30, 30), 6),
        augmentation.PadTo((40, 36)),
        augmentation.RandomRotation90((1, 3), p=1.0),
        data_keys=["input", "mask", "keypoints"],
    )
    image = torch.zeros(6, 1, 32, 32)
    image[:, :, 15, 17] = 1.0
    out, mask, points = augment(image, image, torch.tensor([[[17.0, 15.0]]]).expand(6, 1, 2), seed=SEEDS[:6])
    assert torch.equal(out, mask)
    for i in range(6):
        x, y = points[i, 0].round().long().tolist()
        assert out[i, 0, y, x] == 1.0
    back = augment.inverse(out, mask, points)
    assert torch.equal(back[0][:, :, 12:20, 12:20], image[:, :, 12:20, 12:20])
    torch.testing.assert_close(back[2], torch.tensor([[[17.0, 15.0]]]).expand(6, 1, 2))


@pytest.mark.parametrize("dtype", [torch.float32, torch.uint8])
def test_turns_are_torch_s(dtype: torch.dtype) -> None:
    images = (photos(40, 12, 12) * 255).to(dtype)
    augment = augmentation.RandomRotation90((-1, 2), p=0.8)
    out = augment(images, seed=SEEDS[:40])
    params = augment._params
    for i in range(40):
        turns = int(params["times"][i]) if params["batch_prob"][i] else 0
        assert torch.equal(out[i], torch.rot90(images[i], turns, (1, 2)))
    counts = torch.bincount(augment.draw(SEEDS, [2000, 3, 4, 4])["times"] + 1)
    assert stats.chisquare(counts.numpy()).pvalue > 0.005


def test_an_elastic_transform_is_torchvision_s() -> None:
    images = photos()
    augment = augmentation.RandomElasticTransform((5, 7), (1.5, 2.0), (0.2, 0.3), p=1.0)
    out = augment(images, seed=SEEDS[:5])
    noise = augment._params["noise"].double()
    assert stats.kstest(noise.flatten().numpy(), stats.uniform(-1, 2).cdf).pvalue > 0.005
    # a Gaussian that is cut off after 2 and 3 pixels
    smooth = ndimage.gaussian_filter(noise.numpy(), (0, 0, 1.5, 2.0), radius=(0, 0, 2, 3), mode="constant")
    moved = torch.from_numpy(smooth).permute(0, 2, 3, 1) * torch.tensor([0.2, 0.3])
    for i in range(5):
        expected = vision.elastic(images[i].double(), moved[i : i + 1])
        inside = vision.elastic(torch.ones(3, 21, 30).double(), moved[i : i + 1]) > 0.999
        torch.testing.assert_close(out[i].double()[inside], expected[inside], atol=1e-4, rtol=0)


def test_a_spline_moves_what_is_at_its_points() -> None:
    """The planes are the pixels' coordinates, so the result shows where each of its pixels was read."""
    y, x = (torch.linspace(-1, 1, n).double() for n in (151, 201))
    image = torch.stack([x.expand(151, 201), y[:, None].expand(151, 201)])[None]
    augment = augmentation.RandomThinPlateSpline(0.3, True, "border", p=1.0)
    out = augment(image.expand(9, -1, -1, -1), seed=SEEDS[:9])
    source, target = augment._params["src"].double(), augment._params["dst"].double()
    moved = (target - source).flatten().numpy()
    assert stats.kstest(moved / 0.3, stats.uniform(-1, 2).cdf).pvalue > 0.005
    for i in range(9):
        inside = (target[i].abs() < 0.99).all(-1)
        assert inside[4]
        at = (target[i][inside] + 1) * torch.tensor([100.0, 75.0])
        read = [ndimage.map_coordinates(plane, at.numpy().T[::-1], order=1) for plane in out[i].numpy()]
        # at most half a pixel
        np.testing.assert_allclose(np.stack(read, -1), source[i][inside].numpy(), atol=5e-3)


def test_a_fisheye_is_opencv_s() -> None:
    image = photos(1)
    augment = augmentations()["fisheye"]
    augment.p = 1.0
    out = augment(image, seed=SEEDS[:1])
    center_x, center_y, gamma = augment._params["lens"][0].double().tolist()
    y, x = np.mgrid[-1:1:21j, -1:1:30j]
    stretch = 1 + np.hypot(x - center_x, y - center_y) ** gamma
    map_x, map_y = ((x * stretch + 1) * 14.5).astype(np.float32), ((y * stretch + 1) * 10).astype(np.float32)
    expected = cv2.remap(image[0].permute(1, 2, 0).numpy(), map_x, map_y, cv2.INTER_LINEAR)
    # OpenCV rounds positions to 1/32 pixel.
    np.testing.assert_allclose(out[0].permute(1, 2, 0).numpy(), expected, atol=0.07)
    lens = augment.draw(SEEDS, [2000, 3, 8, 8])["lens"]
    for drawn, low, high in zip(lens.T, (-0.3, -0.2, 0.9), (0.3, 0.2, 1.1), strict=True):
        assert stats.kstest(drawn.numpy(), stats.uniform(low, high - low).cdf).pvalue > 0.005


@pytest.mark.parametrize("name", ["padded_crop", "turn", "elastic", "spline", "fisheye", "resize"])
def test_gradients(name: str) -> None:
    augment = augmentations()[name]
    images = photos(2, 21, 30, torch.float64)[:, :1].clone().requires_grad_()
    assert torch.autograd.gradcheck(lambda x: augment.forward(x, SEEDS[:2]), images, fast_mode=True)


def test_what_is_refused() -> None:
    with pytest.raises(
        ValueError, match=r"size: expected at most 21 along an axis of 21, with padding; got 22"
    ):
        augmentation.RandomCrop((22, 5))(photos())
    with pytest.raises(ValueError, match="p: expected 1, for the size"):
        augmentation.CenterCrop(4, p=0.5)
    with pytest.raises(ValueError, match="padding: expected 1, 2 or 4 numbers"):
        augmentation.RandomCrop(4, (1, 2, 3))
    with pytest.raises(ValueError, match="padding_mode: expected"):
        augmentation.RandomCrop(4, padding_mode="edge")
    with pytest.raises(ValueError, match="times: expected"):
        augmentation.RandomRotation90((3, 1))
    with pytest.raises(ValueError, match="gamma: expected a positive range"):
        augmentation.RandomFisheye(0.0, 0.0, (-1.0, 1.0))
    with pytest.raises(TypeError, match="input: expected a floating-point tensor"):
        augmentation.random_elastic_transform((photos() * 255).to(torch.uint8), SEEDS[:5])
