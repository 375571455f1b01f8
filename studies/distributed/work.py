"""The work itself, independent of processes: a pipeline on a batch of photographs, and an optimisation."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
import torch
from torch import Tensor, nn

from chiasm.color import RgbToGrayscale
from chiasm.enhance import EqualizeClahe
from chiasm.filters import MedianBlur, Sobel, UnsharpMask
from chiasm.geometry.conversions import denormalize_homography
from chiasm.geometry.transform import HomographyWarper, build_pyramid, warp_perspective
from gallery.photographs import View

from .settings import Settings


def pipeline() -> nn.Sequential:
    """From photographs to their edges: denoise, sharpen, equalise, and detect edges."""
    return nn.Sequential(
        MedianBlur((3, 3)), UnsharpMask((9, 9), (1.5, 1.5)), EqualizeClahe(), RgbToGrayscale(), Sobel()
    )


def batch(settings: Settings) -> Tensor:
    """The photographs (B, 3, H, W), RGB in [0, 1]."""
    pixels = np.stack([View(name, size=settings.size).pixels() for name in settings.photographs])
    return torch.from_numpy(pixels).permute(0, 3, 1, 2).contiguous() / 255.0


def truth(settings: Settings) -> np.ndarray:
    """The homography (3, 3) from the photographs' pixels to those of the moved ones."""
    before = corners(settings)
    return cv2.getPerspectiveTransform(
        before.astype(np.float32), (before + np.array(settings.corners) * settings.size).astype(np.float32)
    )


def moved(photographs: Tensor, settings: Settings) -> Tensor:
    """The photographs, warped by the true homography."""
    homography = torch.from_numpy(truth(settings)).to(photographs)[None].expand(len(photographs), -1, -1)
    return warp_perspective(photographs, homography, photographs.shape[2:])


def learn(
    model: nn.Module,
    photographs: Tensor,
    share: float,
    settings: Settings,
    done: Callable[[], None] = lambda: None,
) -> None:
    """Learn the one homography that moved all photographs, like registration by gradient descent, but with
    squared differences.

    Absolute differences have kinks, at which the rounding errors of sums, which depend on how photographs are
    shared, grow to tenths of a pixel within a few hundred steps.

    Args:
        model: returns (1, 3, 3), from the moved photographs to the others, in normalised coordinates:
            ``Homography()``, or a wrapper of it.
        photographs: (B, 3, H, W), those of this process.
        share: the factor of their mean loss. DistributedDataParallel averages the processes' gradients, so
            this is the number of processes times this process's share of all photographs, and 1 in a single
            process.
        done: called after each step.
    """
    optimiser = torch.optim.Adam(model.parameters(), settings.lr)
    levels = zip(
        build_pyramid(photographs, settings.levels),
        build_pyramid(moved(photographs, settings), settings.levels),
        strict=True,
    )
    for source, target in reversed(list(levels)):
        warp = HomographyWarper(target.size(2), target.size(3))
        for _ in range(settings.steps):
            homography = model().expand(len(source), -1, -1)
            covered = (warp(torch.ones_like(source[:, :1]), homography.detach()) > 0.999).to(source.dtype)
            off = ((warp(source, homography) - target).square() * covered).sum((1, 2, 3)) / covered.sum(
                (1, 2, 3)
            )
            loss = share * off.mean()
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
            done()


def corners_taken(homography: Tensor, settings: Settings) -> np.ndarray:
    """The photographs' corners (4, 2), in pixels, mapped by the learned homography (1, 3, 3)."""
    size = settings.size[::-1]
    back = denormalize_homography(homography.double(), size, size, align_corners=False)[0].numpy()
    return cv2.perspectiveTransform(corners(settings)[None], np.linalg.inv(back))[0]


def corners_truly(settings: Settings) -> np.ndarray:
    return cv2.perspectiveTransform(corners(settings)[None], truth(settings))[0]


def corners(settings: Settings) -> np.ndarray:
    """The corner pixels' centres (4, 2)."""
    width, height = settings.size
    return np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * (width - 1.0, height - 1.0)
