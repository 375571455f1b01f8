"""The registration example at a small size: against known homographies, grid_sample with torch.optim.Adam,
and between engines."""

from __future__ import annotations

import subprocess
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import torch
import torch.nn.functional as F
from PIL import Image
from skimage.transform import ProjectiveTransform
from skimage.transform import warp as skimage_warp

from chiasm import runtime
from chiasm.geometry.registration import ImageRegistrator
from chiasm.image import frames_to_tensor
from studies.registration import bundles as example
from studies.registration.descent import Engine, in_pixels
from studies.registration.figure import WIDTH, figure
from studies.registration.in_cpp import PROGRAM, in_cpp
from studies.registration.pairs import Pair, corner_error, corners_of, pair, pairs
from studies.registration.peers import ecc, ecc_multi_scale
from studies.registration.report import CONTENDERS, Run, page, success_table
from studies.registration.settings import SMALL
from studies.registration.step import registration_step
from studies.registration.trials import Result, trial


@pytest.fixture(scope="module")
def shown() -> Pair:
    return pairs(SMALL)[SMALL.shown]


@pytest.fixture(scope="module")
def eager(shown: Pair) -> list[np.ndarray]:
    return Engine.eager(SMALL).register(shown.src, shown.dst, SMALL)


@pytest.fixture(scope="module")
def bundles(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return example.export_all(SMALL, tmp_path_factory.mktemp("registration") / "bundles", ("onnx",))


def test_pair_is_the_source_seen_by_its_homography(shown: Pair) -> None:
    """scikit-image's warp of the source equals the destination up to resampling, without a shift of a
    fraction of a pixel."""
    back = ProjectiveTransform(np.linalg.inv(shown.homography))
    warped = skimage_warp(shown.src / 255.0, back, order=3, cval=-1.0)
    inside = skimage_warp(np.ones_like(shown.src, float), back, order=1) > 0.999

    def difference(other: np.ndarray) -> float:
        return float((np.abs(warped - other) * inside)[2:-2, 2:-2].mean())

    right = difference(shown.dst / 255.0)
    assert right < 0.02
    for shift in (-1, 1):
        assert right < 0.6 * min(difference(np.roll(shown.dst, shift, axis) / 255.0) for axis in (0, 1))


def test_trials_are_shared_out() -> None:
    settings = replace(SMALL, photographs=("astronaut.png", "coffee.png"), reaches=(0.05, 0.2), trials=8)
    made = pairs(settings)
    assert [(p.photograph, p.reach) for p in made[:4]] == [
        (name, reach) for name in settings.photographs for reach in settings.reaches
    ]
    assert not np.allclose(made[0].homography, made[4].homography) and np.array_equal(
        made[4].dst, pairs(settings)[4].dst
    )
    corners = corners_of(settings.width, settings.height)
    for p in made:
        moved = np.abs(cv2.perspectiveTransform(corners[None], p.homography)[0] - corners)
        assert (moved <= p.reach * np.array([settings.width, settings.height]) + 1e-3).all()


def test_step_is_adam_on_the_covered_difference() -> None:
    """Three steps in float64 against grid_sample, autograd and torch.optim.Adam."""
    generator = torch.Generator().manual_seed(1)
    src, dst = (
        F.avg_pool2d(torch.rand(2, 3, 24, 32, generator=generator, dtype=torch.float64), 5, 1, 2)
        for _ in range(2)
    )
    ours = torch.eye(3, dtype=torch.float64) + 0.05 * torch.randn(
        2, 3, 3, generator=generator, dtype=torch.float64
    )
    theirs = ours.clone().requires_grad_(True)
    mean = square = torch.zeros_like(ours)
    optimizer = torch.optim.Adam([theirs], 1e-2)
    y, x = torch.meshgrid(
        *((torch.arange(n, dtype=torch.float64) + 0.5) * 2 / n - 1 for n in (24, 32)), indexing="ij"
    )
    points = torch.stack([x, y, torch.ones_like(x)], -1)
    for i in range(1, 4):
        optimizer.zero_grad()
        moved = torch.einsum("bij,hwj->bhwi", theirs, points)
        grid = moved[..., :2] / moved[..., 2:]
        inside = F.grid_sample(torch.ones_like(src[:, :1]), grid.detach(), align_corners=False)[:, 0] > 0.999
        assert 0.5 < inside.double().mean() < 0.99
        difference = (F.grid_sample(src, grid, align_corners=False) - dst).abs().mean(1)
        losses = torch.stack([d[i].mean() for d, i in zip(difference, inside)])
        losses.sum().backward()
        optimizer.step()
        step, lr = torch.tensor([i, 1e-2], dtype=torch.float64)
        ours, mean, square, found = registration_step(src, dst, ours, mean, square, step, lr)
        torch.testing.assert_close(found, losses.detach())
        torch.testing.assert_close(ours, theirs.detach(), rtol=0, atol=1e-11)


def test_finds_the_homography(shown: Pair, eager: list[np.ndarray]) -> None:
    errors = [
        corner_error(shown, np.eye(3)),
        *(corner_error(shown, in_pixels(level, SMALL)) for level in eager),
    ]
    assert errors[0] > 5.0 and errors[-1] < 0.05 and errors == sorted(errors, reverse=True), errors


def test_is_the_librarys_registrator(shown: Pair, eager: list[np.ndarray]) -> None:
    registrator = ImageRegistrator(pyramid_levels=SMALL.levels, lr=SMALL.lr, num_iterations=SMALL.iterations)
    found = registrator.register(
        *(frames_to_tensor(torch.from_numpy(frame)) for frame in (shown.src, shown.dst))
    )
    assert np.abs(found[0].numpy() - eager[-1]).max() < SMALL.tolerance


def test_one_exported_step_is_eagers(bundles: Path) -> None:
    """At another size and batch than it was traced at."""
    generator = torch.Generator().manual_seed(2)
    src, dst = (torch.rand(3, 1, 20, 17, generator=generator) for _ in range(2))
    state = [
        torch.eye(3) + 0.1 * torch.rand(3, 3, 3, generator=generator),
        *(0.01 * torch.rand(3, 3, 3, generator=generator) for _ in range(2)),
    ]
    inputs = [src, dst, *state, torch.tensor(7.0), torch.tensor(1e-3)]
    step = runtime.open(bundles / "registration.step.chiasm").method("forward", backend="onnx")
    for found, expected in zip(step(*inputs), registration_step(*inputs)):
        torch.testing.assert_close(found, expected, rtol=1e-5, atol=1e-6)


def test_exported_descent_is_eagers(shown: Pair, eager: list[np.ndarray], bundles: Path) -> None:
    found = Engine.bundles(bundles, "onnx").register(shown.src, shown.dst, SMALL)
    assert len(found) == SMALL.levels and np.abs(found[-1] - eager[-1]).max() < SMALL.tolerance


@pytest.mark.skipif(not PROGRAM.exists(), reason="no release build of study_registration")
def test_cpp_program(shown: Pair, eager: list[np.ndarray], bundles: Path) -> None:
    """From image files to the same homography, without torch; its warped image is the destination where it
    reaches."""
    report = in_cpp(shown, SMALL, bundles, "onnx")
    assert not report.torch and len(report.levels) == SMALL.levels
    assert np.abs(report.levels[-1] - eager[-1]).max() < SMALL.tolerance
    np.testing.assert_allclose(
        report.pixels,
        in_pixels(report.levels[-1], SMALL) / in_pixels(report.levels[-1], SMALL)[2, 2],
        atol=1e-3,
    )
    inside = (
        cv2.warpPerspective(
            np.full(shown.src.shape[:2], 255, np.uint8), shown.homography, (SMALL.width, SMALL.height)
        )
        == 255
    )
    inside = cv2.erode(inside.astype(np.uint8), np.ones((3, 3)), borderValue=0) > 0
    difference = np.abs(report.warped[inside].astype(float) - shown.dst[inside])
    assert inside.mean() > 0.5 and difference.mean() < 4.0, difference.mean()


@pytest.mark.skipif(not PROGRAM.exists(), reason="no release build of study_registration")
def test_cpp_program_names_what_is_wrong(shown: Pair, bundles: Path, tmp_path: Path) -> None:
    done = subprocess.run(
        [PROGRAM, bundles, "onnx", "1", "1", "1e-3", "none.png", "none.png", "out.png"],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1 and done.stderr.endswith("study_registration: cannot read none.png\n")
    assert subprocess.run([PROGRAM], capture_output=True, text=True).stderr.startswith(
        "usage: study_registration BUNDLES"
    )


def test_peers_and_errors(shown: Pair) -> None:
    near = pair(SMALL, "astronaut.png", 0.02, 1)
    for find in (ecc, ecc_multi_scale):
        assert corner_error(near, find(near.src, near.dst)) < 0.1
        assert corner_error(shown, find(np.zeros_like(shown.src), shown.dst)) == np.inf
    assert corner_error(shown, np.linalg.inv(shown.homography)) < 1e-9
    shift = np.array([[1, 0, 3], [0, 1, -4], [0, 0, 1.0]])
    assert corner_error(shown, shift @ np.linalg.inv(shown.homography)) == pytest.approx(5.0)


def test_page(shown: Pair, tmp_path: Path) -> None:
    """The page and the picture from what a run has, and the counts of successes."""
    short = replace(SMALL, iterations=5, trials=2)
    trials = [trial(p, Engine.eager(short), short) for p in pairs(short)]
    trials = [
        replace(t, results={key: Result(error, 1.0) for key in CONTENDERS})
        for t, error in zip(trials, (0.5, np.inf))
    ]
    row = success_table(short, trials, "5")[-2]
    assert row.split(" | ")[1:] == ["1 of 2", "1 of 2", "0.5", "1 |"]
    lines = page(short, trials, [Run("one", trials[0].levels[-1], 1.0)], 60.0, "5")
    assert "| one | 0.0e+00 | 0.0e+00 | 1 |" in lines and len(lines) > 40
    figure(shown, trials[0].levels, short, tmp_path / "figure.png")
    assert Image.open(tmp_path / "figure.png").size[0] == WIDTH


def test_pyramid_of_odd_sides(bundles: Path) -> None:
    pyramid = runtime.open(bundles / "registration.pyramid.chiasm").method("forward", backend="onnx")
    levels = pyramid(torch.randint(0, 256, (72, 97, 3), dtype=torch.uint8))
    assert [list(level.shape) for level in levels] == [[1, 3, 72, 97], [1, 3, 36, 48], [1, 3, 18, 24]]
