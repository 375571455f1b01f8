"""The section of docs/use_cases.md on a run of the attack."""

from __future__ import annotations

from textwrap import wrap
from typing import NamedTuple

import cv2
import numpy as np
import torch

from chiasm.metrics import psnr
from studies.use_cases import settings_table

from .matching import Match
from .optimise import State, wanted
from .settings import Settings

#: the factor of the change in its picture
GAIN = 10
#: the C++ program's matches, by backend, then by "original" and "attacked"
Said = dict[str, dict[str, Match]]


class Look(NamedTuple):
    """Eager Python's match after some steps, and the distance of its homography from the chosen one, in
    pixels."""

    state: State
    match: Match
    error: float

    def __str__(self) -> str:
        return (
            f"{len(self.match.matches)} matches, {self.match.inliers.sum()} inliers, corners {self.error:.2f}"
            " px off"
        )


def section(settings: Settings, looks: list[Look], said: Said, seconds: dict[str, float]) -> list[str]:
    first, last = looks[0], looks[-1]
    size = "{2} x {1}".format(*first.state.images.shape)
    level = np.abs(last.state.images.astype(int) - first.state.images).max()
    summary = (
        f"Parts of two photographs, {settings.first.file} and {settings.second.file} of scikit-image, {size}"
        " pixels each, show different scenes. Gradient descent changes both until their key points match by"
        f" a homography that was chosen beforehand. After {settings.steps} steps, RANSAC finds it with"
        f" **{last.match.inliers.sum()} inliers** of {len(last.match.matches)} matches and an error of"
        f" {last.error:.2f} pixels at the corners; before, it found {first.match.inliers.sum()} of"
        f" {len(first.match.matches)}, with an error of {first.error:.0f} pixels. The images then have a PSNR"
        f" of **{change(first, last, 0):.1f} and {change(first, last, 1):.1f} dB** relative to the"
        f" photographs, and no value differs by more than {level} of 255 levels. These numbers are for 8-bit"
        " PNG files: the attack survives their rounding."
    )
    return [
        *wrap(summary, 160),
        "",
        "![matches before and after](use_cases/attack.png)",
        "",
        "![the attacked images and their change](use_cases/attack_change.png)",
        "",
        (
            f"Below the attacked images is their change, amplified {GAIN} times, around grey: each image"
            " takes on structures of the other."
        ),
        "",
        (
            "The matching is that of `chiasm.pipelines.two_view_homography`: Hessian key points in scale"
            " space, orientations, RootSIFT, mutual nearest neighbours, RANSAC. It is"
        ),
        (
            "exported as one bundle, from the bytes of two frames to the homography. C++ runs it on the PNG"
            " files, without Python:"
        ),
        "",
        *_matchings(settings, first, last, said),
        "",
        *_shared(last, said),
        "",
        ("*Right*: a match that fits the chosen homography within RANSAC's threshold."),
        "",
        "During the attack, in eager Python:",
        "",
        *_history(looks),
        "",
        (
            "The loss has the paper's three parts: the squared distances of paired key points, L_loc; a loss"
            " that makes the descriptors of pairs nearer than the hardest negative in the batch, L_desc;"
        ),
        (
            "and the mean square of the change, L_reg. The total is L_loc + alpha L_desc + beta L_reg."
            " `studies/attack/loss.py` has the formulas, and the additions to the paper: which key points"
        ),
        "form pairs, and that both descriptors of a pair use one orientation.",
        "",
        *settings_table(settings),
        (
            "The paper's result is a picture of inliers: it states neither their number nor the PSNR, weights"
            " or steps, and its photographs are not available. So we cannot tell"
        ),
        (
            "whether this attack is as strong as the paper's. The paper calls its change not quite"
            " imperceptible."
        ),
        "",
        f"Seconds, with {torch.get_num_threads()} of torch's threads: "
        + ", ".join(f"{what} {time:.0f}" for what, time in seconds.items())
        + ".",
    ]


def change(first: Look, last: Look, which: int) -> float:
    """PSNR in decibels of an attacked image."""
    before, after = (torch.from_numpy(look.state.images[which].astype(np.float64)) for look in (first, last))
    return float(psnr(after, before, 255.0))


def _matchings(settings: Settings, first: Look, last: Look, said: Said) -> list[str]:
    names = {"native": "C++, native code", "onnx": "C++, ONNX Runtime"}
    rows = [
        ("eager Python", first.match, last.match),
        *((names[b], of["original"], of["attacked"]) for b, of in said.items()),
    ]
    rows.append(
        (
            f"OpenCV {cv2.__version__}'s SIFT, not the target of the attack",
            *(_by_opencv(*look.state.images, settings) for look in (first, last)),
        )
    )
    lines = [
        (
            "| by | before: matches | inliers | corners off, px | after: matches | right | inliers | corners"
            " off, px |"
        ),
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, *pair in rows:
        before, after = (
            _cells(match, settings, look.state.images[0].shape)
            for match, look in zip(pair, (first, last), strict=True)
        )
        lines.append(f"| {name} | {before[0]} | {before[2]} | {before[3]} | {' | '.join(after)} |")
    return lines


def _cells(match: Match, settings: Settings, shape: tuple[int, ...]) -> list[str]:
    return [
        str(len(match.matches)),
        str(right(match, settings)),
        str(match.inliers.sum()),
        f"{match.error(wanted(settings), shape):.2f}",
    ]


def right(match: Match, settings: Settings) -> int:
    """The number of matches that fit the chosen homography, computed by OpenCV."""
    moved = cv2.perspectiveTransform(match.matches[None, :, :2], wanted(settings))[0]
    return int((np.linalg.norm(moved - match.matches[:, 2:], axis=1) < settings.inl_th).sum())


def _by_opencv(first: np.ndarray, second: np.ndarray, settings: Settings) -> Match:
    """OpenCV's match: differences of Gaussians instead of the Hessian, a different SIFT, the same mutual
    nearest neighbours."""
    sift = cv2.SIFT_create(settings.max_keypoints)
    (points1, described1), (points2, described2) = (
        sift.detectAndCompute(cv2.cvtColor(i, cv2.COLOR_RGB2GRAY), None) for i in (first, second)
    )
    pairs = cv2.BFMatcher(crossCheck=True).match(described1, described2)
    matches = np.array([[*points1[m.queryIdx].pt, *points2[m.trainIdx].pt] for m in pairs])
    homography, inliers = cv2.findHomography(
        matches[:, :2], matches[:, 2:], cv2.RANSAC, settings.inl_th, maxIters=settings.samples
    )
    return Match(homography, matches, inliers[:, 0].astype(bool))


def _shared(last: Look, said: Said) -> list[str]:
    count = last.match.inliers.sum()
    found = [f"{last.match.shared(of['attacked'])} of {count} by {backend}" for backend, of in said.items()]
    return [f"Of eager Python's inliers on the attacked images, C++ finds {' and '.join(found)}."]


def _history(looks: list[Look]) -> list[str]:
    lines = [
        "| step | pairs | L_loc, px^2 | L_desc | PSNR, dB | matches | inliers | corners off, px |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for look in looks:
        loss = look.state.loss
        losses = f"{loss.pairs} | {loss.loc:.2f} | {loss.desc:.3f}" if loss else "| |"
        noise = " ".join(f"{change(looks[0], look, which):.1f}" for which in (0, 1)) if loss else ""
        lines.append(
            f"| {look.state.step} | {losses} | {noise} | {len(look.match.matches)} |"
            f" {look.match.inliers.sum()} | {look.error:.2f} |"
        )
    return lines
