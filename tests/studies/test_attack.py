"""The attack on the matching of two views at a small size: unrelated images match by a chosen homography."""

from __future__ import annotations

import subprocess
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import torch
from PIL import Image

from chiasm.pipelines import two_view_homography
from studies.attack.loss import attack_loss, hardest, partners
from studies.attack.matching import PROGRAM, Match, bundle, by_program, by_python, uniforms
from studies.attack.optimise import State, attack, wanted
from studies.attack.report import Look, right, section
from studies.attack.settings import SMALL


@pytest.fixture(scope="module")
def states() -> list[State]:
    return list(attack(SMALL))


def test_two_photographs_match_by_the_wanted_homography(states: list[State]) -> None:
    first, last = states[0].images, states[-1].images
    before, after = by_python(*first, SMALL), by_python(*last, SMALL)
    shape = first[0].shape
    assert before.error(wanted(SMALL), shape) > 20 and right(before, SMALL) <= 2
    assert after.error(wanted(SMALL), shape) < 3 and right(after, SMALL) >= 20 and after.inliers.sum() >= 20
    # OpenCV finds the same homography in these matches
    theirs, inliers = cv2.findHomography(
        after.matches[:, :2],
        after.matches[:, 2:],
        cv2.RANSAC,
        SMALL.inl_th,
        maxIters=10000,
        confidence=0.9999,
    )
    assert Match(theirs, after.matches, inliers[:, 0] > 0).error(wanted(SMALL), shape) < 3
    assert cv2.PSNR(first, last) > 24


def test_each_part_of_the_loss(states: list[State]) -> None:
    settings = replace(SMALL, beta=3.0)
    first, last = (torch.from_numpy(states[k].images).permute(0, 3, 1, 2) / 255.0 for k in (0, -1))
    homography = torch.from_numpy(wanted(SMALL)).float()[None]
    before, after = (attack_loss(images, first, homography, settings) for images in (first, last))
    assert before.reg == 0 and after.desc < before.desc - 0.1 and after.loc < SMALL.near**2
    assert float(after.reg) == pytest.approx(
        np.square((states[-1].images - states[0].images.astype(float)) / 255).mean(), rel=1e-4
    )
    assert float(after.total) == pytest.approx(
        float(after.loc + settings.alpha * after.desc + 3.0 * after.reg), rel=1e-5
    )


def test_pairs_are_near_each_other_in_place_and_scale() -> None:
    moved = torch.tensor([[0.0, 0.0, 5.0], [10.0, 0.0, 5.0], [30.0, 0.0, 5.0], [50.0, 0.0, 5.0]])
    others = torch.tensor(
        [[1.0, 0.0, 5.0], [9.0, 0.0, 6.0], [12.0, 0.0, 5.0], [30.0, 0.0, 20.0], [50.0, 9.0, 5.0]]
    )
    frames1, frames2 = (
        torch.stack([torch.stack([s, 0 * s, x], -1), torch.stack([0 * s, s, y], -1)], -2)
        for x, y, s in (moved.T, others.T)
    )
    there = torch.ones(5, dtype=torch.bool)
    first, second = partners(frames1, frames2, there[:4], there, SMALL)
    assert first.tolist() == [0, 1] and second.tolist() == [0, 1]
    there[0] = False
    assert partners(frames1, frames2, torch.ones(4, dtype=torch.bool), there, SMALL)[0].tolist() == [1]


def test_the_hardest_negative_is_of_another_place() -> None:
    distances = torch.tensor([[0.1, 0.2, 0.9], [0.3, 0.1, 0.4], [0.8, 0.7, 0.1]])
    places = torch.tensor([[0.0, 0.0], [1.0, 0.0], [50.0, 0.0]])
    assert hardest(distances, places, 4.0).tolist() == pytest.approx([0.8, 0.4, 0.4])


def test_the_matching_is_the_pipeline_of_two_views(states: list[State]) -> None:
    images = states[-1].images
    # the paper's own conversion, in float64
    grey = torch.from_numpy((images / 255.0) @ np.array([0.299, 0.587, 0.114])).float()[:, None]
    arguments = {k: v for k, v in SMALL.detection().items() if k != "max_keypoints"}
    homography, points1, points2, matched, inliers = two_view_homography(
        grey[:1], grey[1:], uniforms(SMALL.samples)[None], SMALL.max_keypoints, **arguments
    )
    found = by_python(*images, SMALL)
    expected = Match(
        homography[0].double().numpy(),
        torch.cat([points1, points2], 2)[matched].double().numpy(),
        inliers[matched].numpy(),
    )
    assert (
        found.error(expected.homography, images[0].shape) < 0.2
        and found.shared(expected) >= 0.9 * expected.inliers.sum()
    )


@pytest.mark.skipif(not PROGRAM.exists(), reason="study_attack is not built: `make build`")
def test_cpp_finds_the_same_inliers(states: list[State], tmp_path: Path) -> None:
    made, looks, said = bundle(SMALL, tmp_path, ("onnx",)), [], {}
    for name, state in (("original", states[0]), ("attacked", states[-1])):
        files = [tmp_path / f"{name}{k}.png" for k in (1, 2)]
        for file, image in zip(files, state.images, strict=True):
            Image.fromarray(image).save(file)
        expected = by_python(*state.images, SMALL)
        said[name] = by_program(*files, made, "onnx", SMALL)
        looks.append(Look(state, expected, expected.error(wanted(SMALL), state.images[0].shape)))
    expected, found = looks[1].match, said["attacked"]
    assert (
        found.shared(expected) >= 0.95 * expected.inliers.sum()
        and expected.shared(found) >= 0.95 * found.inliers.sum()
    )
    assert found.error(expected.homography, states[0].images[0].shape) < 0.1
    text = "\n".join(section(SMALL, looks, {"onnx": said}, {"the attack": 1.0}))
    assert f"**{expected.inliers.sum()} inliers** of {len(expected.matches)} matches" in text
    failed = subprocess.run(
        [PROGRAM, made, "onnx", "100", tmp_path / "none.png", files[1]], capture_output=True, text=True
    )
    assert failed.returncode == 1 and "cannot read the image" in failed.stderr
