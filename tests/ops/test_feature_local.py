"""Detectors, descriptors and matchers as modules: each equals its functions, and each can be replaced with
another."""

from typing import Tuple

import numpy as np
import pytest
import torch
import torch.nn.functional as F
from photos import FOLDER
from torch import Tensor, nn

from chiasm import feature
from chiasm.color import rgb_to_grayscale
from chiasm.feature.described import sift_laf_descriptors
from chiasm.geometry.transform import ScalePyramid

SLOTS = 250


def photo(name: str = "astronaut.png") -> Tensor:
    import cv2

    image = cv2.resize(cv2.imread(str(FOLDER / name)), (160, 120), interpolation=cv2.INTER_AREA)
    return torch.from_numpy(np.ascontiguousarray(image[..., ::-1])).permute(2, 0, 1)[None].float() / 255.0


def detector(**others: object) -> feature.ScaleSpaceDetector:
    return feature.ScaleSpaceDetector(SLOTS, 3, response="dog", num_octaves=2, threshold=0.005, **others)


def assert_scripts(module: nn.Module, *inputs: Tensor) -> None:
    scripted = torch.jit.script(module)
    for _ in range(2):
        for actual, expected in zip(scripted(*inputs), module(*inputs), strict=True):
            torch.testing.assert_close(actual, expected)


def test_the_detector_is_its_parts() -> None:
    img = photo()
    lafs, scores, valid = feature.detect_keypoints(
        rgb_to_grayscale(img), SLOTS, "dog", 2, mr_size=3.0, threshold=0.005
    )
    assert 20 < valid.sum() < SLOTS
    for actual, expected in zip(detector()(img), (lafs, scores, valid), strict=True):
        assert actual.equal(expected)
    found, _, _ = detector(aff_module=feature.AdaptLafShape(16), ori_module=feature.OrientLaf(16))(img)
    wanted = feature.orient_laf(feature.adapt_laf_shape(lafs, img, 16), img, 16)
    torch.testing.assert_close(found[valid], wanted[valid])
    assert (found[~valid] == 0).all() and not torch.allclose(wanted, lafs)
    assert_scripts(detector(aff_module=feature.AdaptLafShape(16), ori_module=feature.OrientLaf(16)), img)
    assert_scripts(detector(), rgb_to_grayscale(img))


def test_descriptors_of_empty_slots_are_zeros() -> None:
    img = photo().repeat(2, 1, 1, 1)
    img[1] = 0.5
    module = feature.LocalFeature(
        detector(ori_module=feature.OrientLaf()), feature.LAFDescriptor(feature.SiftDescribe(), 16)
    )
    lafs, scores, valid, descriptors = module(img)
    assert valid[0].sum() > 20 and not valid[1].any()
    assert (descriptors[~valid] == 0).all() and (scores[~valid] == 0).all() and (lafs[~valid] == 0).all()
    patches = feature.extract_patches_from_pyramid(rgb_to_grayscale(img), lafs, 16)
    torch.testing.assert_close(descriptors[valid], feature.sift_describe(patches[valid]))
    assert_scripts(module, img)


def test_the_matcher_is_its_functions() -> None:
    generator = torch.Generator().manual_seed(0)
    first, noise = torch.rand(2, 40, 8, generator=generator), torch.rand(2, 50, 8, generator=generator)
    second = noise.clone()
    second[:, :40] = first + 0.2 * noise[:, :40]
    lafs1 = torch.cat(
        [torch.eye(2).expand(2, 50, 2, 2), 30 * torch.rand(2, 50, 2, 1, generator=generator)], -1
    )
    lafs2 = lafs1 + torch.tensor([[0.0, 0.0, 3.0], [0.0, 0.0, -2.0]])
    lafs1 = lafs1[:, :40]
    mask1, mask2 = torch.arange(40).expand(2, 40) % 5 != 2, torch.arange(50).expand(2, 50) % 7 != 1
    masks = {"mask1": mask1, "mask2": mask2}
    for mode, expected in {
        "nn": feature.match_nn(first, second, **masks),
        "mnn": feature.match_mnn(first, second, **masks),
        "snn": feature.match_snn(first, second, 0.7, **masks),
        "smnn": feature.match_smnn(first, second, 0.7, **masks),
        "fginn": feature.match_fginn(first, second, lafs1, lafs2, 0.7, **masks),
        "adalam": feature.match_adalam(first, second, lafs1, lafs2, **masks),
    }.items():
        module = feature.GeometryAwareDescriptorMatcher(mode, 0.7)
        for actual, wanted in zip(module(first, second, lafs1, lafs2, mask1, mask2), expected, strict=True):
            assert actual.equal(wanted)
    assert_scripts(module, first, second, lafs1, lafs2, mask1, mask2)
    with pytest.raises(ValueError, match="match_mode: expected one of"):
        feature.GeometryAwareDescriptorMatcher("flann")


@pytest.mark.parametrize("mode", ["smnn", "adalam"])
def test_two_views_of_a_photo(mode: str) -> None:
    img = photo("coffee.png")
    first, second = img[..., :, :145], 0.8 * img[..., 8:, 15:]
    module = feature.LocalFeatureMatcher(
        feature.LocalFeature(
            detector(ori_module=feature.OrientLaf()), feature.LAFDescriptor(feature.SiftDescribe(), 32)
        ),
        mode,
    )
    points1, points2, distances, valid, lafs1, lafs2 = module(first, second)
    assert points1.shape == points2.shape == (1, SLOTS, 2) and distances.shape == valid.shape == (1, SLOTS)
    moved = (points1 - points2)[valid] - torch.tensor([15.0, 8.0])
    assert valid.sum() >= 8 and (moved.norm(dim=1) < 1.0).float().mean() > 0.9
    assert points1.equal(feature.get_laf_center(lafs1)) and points2.equal(feature.get_laf_center(lafs2))
    for part in (points1, points2, distances, lafs1, lafs2):
        assert (part[~valid] == 0).all()


def test_a_dictionary_of_images_gives_one_of_matches() -> None:
    img = photo("coffee.png")
    first, second = torch.cat([img, img.flip(3)]), torch.cat([0.8 * img, img.flip(3)])
    described = feature.LocalFeature(detector(), feature.LAFDescriptor(feature.SiftDescribe(), 32))
    module = feature.LocalFeatureMatcher(described, feature.DescriptorMatcher("smnn", 0.9))
    points1, points2, distances, valid, lafs1, lafs2 = module(first, second)
    found = module({"image0": first, "image1": second})
    rows = [(b, k) for b in range(2) for k in range(SLOTS) if valid[b, k]]
    assert len(rows) > 8 and found["batch_indexes"].tolist() == [b for b, _ in rows]
    for name, values in {"keypoints0": points1, "keypoints1": points2, "confidence": 1 - distances}.items():
        assert found[name].equal(torch.stack([values[row] for row in rows]))
    for name, frames in {"lafs0": lafs1, "lafs1": lafs2}.items():
        assert found[name].equal(torch.stack([frames[row] for row in rows])[None])
    by_hand = feature.match_smnn(*(described(i)[3] for i in (first, second)), 0.9)
    assert by_hand[2].sum() >= len(rows)
    torch.jit.script(module)
    with pytest.raises(ValueError, match=r"^data: expected 'image0' and 'image1', got \['image0'\]"):
        module({"image0": first})


class Grid(nn.Module):
    """A detector that returns the same positions for all images."""

    def forward(self, img: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
        place = torch.arange(12, device=img.device).to(img.dtype)
        x, y = 8 * (place % 4) + 10, 8 * torch.floor(place / 4) + 10
        six, zero = torch.full_like(x, 6.0), torch.zeros_like(x)
        lafs = torch.stack([torch.stack([six, zero, x], -1), torch.stack([zero, six, y], -1)], -2)
        return (
            lafs.expand(img.size(0), -1, -1, -1),
            torch.ones_like(x).expand(img.size(0), -1),
            (place < 9).expand(img.size(0), -1),
        )


class Whitened(nn.Module):
    """A descriptor with weights to learn."""

    def __init__(self) -> None:
        super().__init__()
        torch.manual_seed(0)
        self.weight = nn.Linear(64, 16)

    def forward(self, patches: Tensor) -> Tensor:
        return F.normalize(self.weight(patches.flatten(1)), dim=1)


def test_a_users_own_modules_learn_through_it() -> None:
    img = photo()[..., :48, :60]
    module = feature.LocalFeatureMatcher(
        feature.LocalFeature(Grid(), feature.LAFDescriptor(Whitened(), 8)), "nn"
    )
    assert_scripts(module, img, img + 0.02)
    _, _, distances, valid, _, _ = module(img, img.flip(3))
    assert valid.tolist() == [[True] * 9 + [False] * 3]
    distances.sum().backward()
    gradients = [p.grad for p in module.parameters()]
    assert all(g is not None and torch.isfinite(g).all() for g in gradients) and gradients[0].abs().max() > 0


@pytest.mark.parametrize("turned", [False, True])
def test_sift_features_are_where_opencv_s_are_and_match_a_turned_image(turned: bool) -> None:
    import cv2

    gray = cv2.resize(cv2.imread(str(FOLDER / "astronaut.png"), cv2.IMREAD_GRAYSCALE), (200, 200))
    grey = torch.from_numpy(gray)[None, None].float() / 255.0
    module = feature.SIFTFeature(400, descriptor_layout="opencv")
    lafs, scores, valid, descriptors = module(grey)
    assert lafs.shape == (1, 400, 2, 3) and bool((scores[:, 1:] <= scores[:, :-1]).all())
    points = feature.get_laf_center(lafs)[valid].numpy()
    if not turned:
        kinds: list = list(cv2.SIFT.create(contrastThreshold=0.06).detect(gray, None))
        theirs, reach = np.array([kind.pt for kind in kinds]), np.array([3 * kind.size for kind in kinds])
        theirs = theirs[np.minimum(theirs, 199 - theirs).min(1) > reach]  # whose frames are in the image
        apart = np.linalg.norm(theirs[:, None] - points, axis=-1).min(1)
        assert len(theirs) > 200 and (apart < 1.5).mean() > 0.97
        assert_scripts(module, grey)
        return
    around = torch.rot90(grey, 1, (2, 3))
    others, _, seen, described = module(around)
    _, index = feature.only_matches(*feature.match_smnn(descriptors[valid], described[seen], 0.8))
    x, y = points[index[:, 0].numpy()].T
    found = feature.get_laf_center(others)[seen].numpy()[index[:, 1].numpy()]
    apart = np.hypot(found[:, 0] - y, found[:, 1] - (199 - x))
    assert len(apart) > 150 and (apart < 1.0).mean() > 0.95


def test_sift_features_of_kornia_s_layout_are_the_descriptors_of_their_frames() -> None:
    img = photo()
    lafs, _, valid, descriptors = feature.SIFTFeatureScaleSpace(60, upright=True, rootsift=False)(img)
    parts = sift_laf_descriptors(img, lafs, 41, False)
    torch.testing.assert_close(descriptors[valid], parts[valid])
    assert valid.sum() == 60 and (lafs[..., 0, 1] == 0).all()


def test_the_detector_takes_kornia_s_keywords() -> None:
    img = rgb_to_grayscale(photo())
    pyramid = ScalePyramid(4, 1.5, 32, double_image=True)
    blobs = {
        "resp_module": feature.BlobDoG(),
        "scale_pyr_module": pyramid,
        "minima_are_also_good": True,
        "scale_space_response": True,
        "compile_modules": ["resp"],
    }
    for others, settings in (
        (blobs, ("dog", 16, 4, 1.5, 6.0, 0.0, True)),
        ({"resp_module": feature.CornerHarris(0.04)}, ("harris",)),
        ({"resp_module": feature.CornerGFTT()}, ("gftt",)),
        ({"resp_module": feature.BlobHessian(), "minima_are_also_good": False}, ("hessian",)),
    ):
        found = feature.ScaleSpaceDetector(num_features=30, **others)(img)
        for one, expected in zip(found, feature.detect_keypoints(img, 30, *settings), strict=True):
            assert one.equal(expected)
    for message, others in {
        "resp_module: expected CornerHarris": {"resp_module": feature.CornerHarris(0.05)},
        "resp_module: expected": {"resp_module": nn.Identity()},
        "subpix_module: expected None": {"subpix_module": nn.Identity()},
        "minima_are_also_good: expected False for the response 'hessian'": {"minima_are_also_good": True},
        "minima_are_also_good: expected True for the response 'dog'": {
            **blobs,
            "minima_are_also_good": False,
        },
    }.items():
        with pytest.raises(ValueError, match=message):
            feature.ScaleSpaceDetector(**others)


def test_scaling_coef_enlarges_the_described_frames() -> None:
    """Beside Kornia's rule: the descriptor sees frames of `scaling_coef` times the detector's size."""
    image = torch.rand(1, 1, 64, 80, generator=torch.Generator().manual_seed(3))
    detect = feature.ScaleSpaceDetector(12, num_octaves=2, mr_size=3.0)
    describe = feature.LAFDescriptor(torch.nn.Flatten(), 8)
    lafs, _, valid = detect(image)
    enlarged, _, still, descriptors = feature.LocalFeature(detect, describe, 2.0)(image)
    kept = valid[..., None, None]
    assert still.equal(valid) and enlarged[..., 2].equal(lafs[..., 2])
    torch.testing.assert_close(enlarged[..., :2], 2.0 * lafs[..., :2])
    torch.testing.assert_close(descriptors, torch.where(kept[..., 0], describe(image, enlarged), 0.0))
    with pytest.raises(ValueError, match="scaling_coef: expected a positive number, got 0"):
        feature.LocalFeature(detect, describe, 0.0)
