"""The matching that is attacked: a bundle from two camera frames to the homography between them, run by eager
Python and by C++."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Tuple

import numpy as np
import torch
from torch import Tensor

from bench.machine import said
from bench.matching.score import corner_error
from chiasm.color import bgr_to_rgb, rgb_to_grayscale
from chiasm.export import Spec, TensorSpec, export
from chiasm.export.catalog.feature_detection import blobs
from chiasm.export.spec import Tolerance, frame
from chiasm.feature import detect_keypoints, get_laf_center, match_mnn, orient_laf
from chiasm.feature.described import sift_laf_descriptors
from chiasm.geometry.ransac import ransac_homography
from gallery.cases import BUILD

from .settings import Settings

PROGRAM = BUILD / "release" / "bin" / "study_attack"
NAME = "studies.match_frames"
SEED = 1


def match_frames(
    frame1: Tensor,
    frame2: Tensor,
    uniforms: Tensor,
    max_keypoints: int,
    response: str,
    num_octaves: int,
    mr_size: float,
    threshold: float,
    double_image: bool,
    inl_th: float,
) -> Tuple[Tensor, Tensor, Tensor, Tensor, Tensor]:
    """``chiasm.pipelines.two_view_homography`` for two camera frames of one size: they form one batch, so
    that the graph has half as many nodes.

    Args:
        frame1, frame2: (H, W, 3), uint8, BGR, as OpenCV reads them.
        uniforms: (S, 4), see ``ransac_homography``.
        max_keypoints, response, num_octaves, mr_size, threshold, double_image: see ``detect_keypoints``.
        inl_th: see ``ransac_homography``.

    Returns:
        homography (3, 3) from the first to the second; points1 and points2 (K, 2), key points and their
        matches; matched and inliers (K,), bool.
    """
    # Convert to float32 first: AOTInductor needs libtorch to stack bytes.
    frames = torch.stack([frame1.to(torch.float32), frame2.to(torch.float32)]).permute(0, 3, 1, 2)
    grey = rgb_to_grayscale(bgr_to_rgb(frames / 255.0))
    lafs, _, valid = detect_keypoints(
        grey,
        max_keypoints,
        response,
        num_octaves,
        mr_size=mr_size,
        threshold=threshold,
        double_image=double_image,
    )
    described = sift_laf_descriptors(grey, orient_laf(lafs, grey))
    _, indices, matched = match_mnn(described[0], described[1], None, valid[0], valid[1])
    places = get_laf_center(lafs)
    points1, points2 = places[0], places[1].index_select(0, indices[:, 1].clamp(min=0))
    homography, inliers = ransac_homography(
        points1[None], points2[None], uniforms[None], inl_th, mask=matched[None]
    )
    return homography[0], points1, points2, matched, inliers[0]


def config(settings: Settings) -> dict:
    return settings.detection() | {"inl_th": settings.inl_th}


def bundle(settings: Settings, folder: Path, formats: tuple[str, ...]) -> Path:
    """Export the matching as a bundle."""
    # in the last octave, 27 taps must fit twice
    least = 2 ** (settings.num_octaves - 1)
    symbols = {"H": (26 * least + 2, 8192), "W": (27 * least + 2, 8192), "S": (1, 1 << 16)}
    inputs = [frame("frame1"), frame("frame2"), TensorSpec("uniforms", ("S", 4), "float32", range=(0.0, 1.0))]
    outputs = [TensorSpec(name) for name in ("homography", "points1", "points2", "matched", "inliers")]
    tolerances = {"float32": Tolerance(2e-2, 1e-3)}  # points, in pixels
    spec = Spec(
        NAME,
        inputs,
        outputs,
        config(settings),
        symbols,
        gradients=(),
        tolerances=tolerances,
        make_inputs=_sample,
    )
    return export(match_frames, spec, folder, formats, methods=("forward",))


def _sample(generator: torch.Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    views = blobs(generator, 1, [(sizes["H"], sizes["W"], 0), (sizes["H"], sizes["W"], 5)], torch.float32)
    # Not clamped: in flat areas, the fit of a key point would have no solution, and rounding would decide.
    frames = [
        (view[0] * 127 + 64).clamp(0, 255).round().to(torch.uint8).permute(1, 2, 0).repeat(1, 1, 3)
        for view in views
    ]
    return {
        "frame1": frames[0],
        "frame2": frames[1],
        "uniforms": torch.rand((sizes["S"], 4), generator=generator),
    }


def uniforms(samples: int) -> Tensor:
    """The random numbers for RANSAC: the upper 24 bits of a Mersenne twister, as in the C++ program."""
    bits = np.random.RandomState(SEED).randint(0, 2**32, (samples, 4), np.uint32)
    return torch.from_numpy((bits >> 8).astype(np.float32) * np.float32(2.0**-24))


@dataclass(frozen=True)
class Match:
    """The result of matching two images.

    homography: (3, 3), from the first to the second.
    matches: (M, 4), x and y in the first, x and y in the second.
    inliers: (M,), bool.
    """

    homography: np.ndarray
    matches: np.ndarray
    inliers: np.ndarray

    def error(self, wanted: np.ndarray, shape: tuple[int, ...]) -> float:
        """The mean distance, in pixels, between the corners of an image of shape (H, W, ...) as mapped by
        both homographies."""
        return corner_error(self.homography.flatten().tolist(), wanted, shape[:2])

    def shared(self, other: Match) -> int:
        """The number of inliers that are the other's inliers too, within 0.05 pixels."""
        mine, theirs = self.matches[self.inliers], other.matches[other.inliers]
        return (
            int((np.abs(mine[:, None] - theirs).max(-1) < 0.05).any(1).sum())
            if len(mine) and len(theirs)
            else 0
        )


def by_python(first: np.ndarray, second: np.ndarray, settings: Settings) -> Match:
    """The match of two images (H, W, 3), uint8, RGB, by eager Python."""
    frames = [torch.from_numpy(np.ascontiguousarray(image[..., ::-1])) for image in (first, second)]
    with torch.no_grad():
        homography, points1, points2, matched, inliers = match_frames(
            *frames, uniforms(settings.samples), **config(settings)
        )
    return Match(
        homography.double().numpy(),
        torch.cat([points1, points2], 1)[matched].double().numpy(),
        inliers[matched].numpy(),
    )


def by_program(first: Path, second: Path, made: Path, backend: str, settings: Settings) -> Match:
    """The match of two image files, by the C++ program and a bundle."""
    found = said(PROGRAM, made, backend, settings.samples, first, second)
    return Match(
        np.array(found["homography"]).reshape(3, 3),
        np.array(found["matches"]).reshape(-1, 4),
        np.array(found["inliers"], bool),
    )
