"""The attack: gradient descent on the pixels of both images."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import cv2
import numpy as np
import torch
from torch import Tensor

from .loss import Loss, attack_loss
from .settings import Settings


class State(NamedTuple):
    """Both images (2, H, W, 3), uint8, RGB, after ``step`` steps, and the loss before the last step (None at
    first)."""

    step: int
    images: np.ndarray
    loss: Loss | None


def attack(settings: Settings) -> Iterator[State]:
    """The photographs, then the images after each step."""
    photographs = np.stack([settings.first.pixels(), settings.second.pixels()])
    homography = torch.from_numpy(wanted(settings)).float()[None]
    originals = torch.from_numpy(photographs).permute(0, 3, 1, 2) / 255.0
    images = originals.clone().requires_grad_(True)
    optimiser = torch.optim.Adam([images], settings.lr)
    yield State(0, photographs, None)
    for step in range(1, settings.steps + 1):
        loss = attack_loss(images, originals, homography, settings)
        optimiser.zero_grad()
        loss.total.backward()
        optimiser.step()
        with torch.no_grad():
            images.clamp_(0, 1)
        yield State(step, as_bytes(images.detach()), loss)


def wanted(settings: Settings) -> np.ndarray:
    """The homography (3, 3) by which the images should match, in pixels, from the first to the second."""
    height, width = settings.first.pixels().shape[:2]
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * (width - 1, height - 1)
    there = corners + np.array(settings.corners) * (width, height)
    return cv2.getPerspectiveTransform(corners.astype(np.float32), there.astype(np.float32))


def as_bytes(images: Tensor) -> np.ndarray:
    """(B, H, W, 3), uint8, rounded to the nearest of 256 levels."""
    return (images.permute(0, 2, 3, 1) * 255).round().to(torch.uint8).numpy()
