"""The loop: from coarse to fine, with a fixed number of steps at each level. It runs with eager Python or
with exported bundles; registration.cpp is the same in C++."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from chiasm import runtime
from chiasm.geometry.conversions import denormalize_homography

from .settings import Settings
from .step import pyramid, registration_step

Step = Callable[..., tuple[Tensor, Tensor, Tensor, Tensor]]


@dataclass(frozen=True)
class Engine:
    """The functions that compute a frame's pyramid and a step."""

    pyramid: Callable[[Tensor], list[Tensor]]
    step: Step

    @staticmethod
    def eager(settings: Settings) -> Engine:
        return Engine(lambda frame: pyramid(frame, settings.levels), registration_step)

    @staticmethod
    def bundles(folder: Path, backend: str) -> Engine:
        """From bundles. ONNX Runtime ("onnx") uses standard operators: native code is another engine."""
        opened = (runtime.open(folder / f"registration.{name}.chiasm") for name in ("pyramid", "step"))
        return Engine(*(bundle.method("forward", backend=backend, fused=False) for bundle in opened))

    def register(self, src: np.ndarray, dst: np.ndarray, settings: Settings) -> list[np.ndarray]:
        """Register frames (H, W, 3), uint8. Returns the homography (3, 3), from dst to src in normalised
        coordinates, after each level, the coarsest first."""
        sources, targets = (self.pyramid(torch.from_numpy(frame)) for frame in (src, dst))
        homography, lr, found = torch.eye(3)[None], torch.tensor(settings.lr), []
        for source, target in zip(sources[::-1], targets[::-1], strict=True):
            mean = square = torch.zeros_like(homography)
            for i in range(1, settings.iterations + 1):
                homography, mean, square, _ = self.step(
                    source, target, homography, mean, square, torch.tensor(float(i)), lr
                )
            found.append((homography / homography[:, 2:, 2:])[0].numpy())
        return found


def in_pixels(homography: np.ndarray, settings: Settings) -> np.ndarray:
    """A homography (3, 3) between normalised coordinates, converted to pixels of the full size, in
    float64."""
    size = (settings.height, settings.width)
    return denormalize_homography(
        torch.from_numpy(homography.astype(np.float64))[None], size, size, align_corners=False
    )[0].numpy()
