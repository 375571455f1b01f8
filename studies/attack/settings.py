"""All settings of the attack."""

from __future__ import annotations

from dataclasses import dataclass, replace

from gallery.photographs import View

PARTS = (View("astronaut.png", (64, 0, 464, 300)), View("coffee.png", (100, 60, 500, 360)))


@dataclass(frozen=True)
class Settings:
    """The paper's: Hessian, 2500 key points, Adam with 0.003. The paper does not give the other settings.

    first, second: parts of two photographs, of one size. corners: the displacements, in widths and heights,
    from the second image's corners to the first image's corners as mapped by the chosen homography, clockwise
    from the upper left one. max_keypoints, response, num_octaves, mr_size, threshold, double_image: see
    ``chiasm.feature.detect_keypoints``. near, octaves: key points are a pair if, after mapping by the
    homography, their distance is less than ``near`` pixels and ``octaves`` octaves. alpha, beta: weights of
    the losses of descriptors and of the change. lr, steps: for Adam. samples, inl_th: for RANSAC. look_every:
    steps between two runs of the matching.
    """

    first: View = PARTS[0]
    second: View = PARTS[1]
    corners: tuple[tuple[float, float], ...] = ((0.08, 0.05), (-0.03, 0.08), (-0.06, -0.07), (0.06, -0.03))
    max_keypoints: int = 2500
    response: str = "hessian"
    num_octaves: int = 4
    mr_size: float = 6.0
    threshold: float = 0.0
    double_image: bool = True
    near: float = 4.0
    octaves: float = 0.5
    alpha: float = 20.0
    beta: float = 10000.0
    lr: float = 0.003
    steps: int = 150
    samples: int = 10000
    inl_th: float = 3.0
    look_every: int = 25

    def detection(self) -> dict:
        """The arguments of the detector, which the matching has too."""
        return {
            name: getattr(self, name)
            for name in ("max_keypoints", "response", "num_octaves", "mr_size", "threshold", "double_image")
        }


#: For tests: takes seconds, and the change is clearly visible.
SMALL = Settings(
    replace(PARTS[0], size=(160, 120)),
    replace(PARTS[1], size=(160, 120)),
    max_keypoints=1000,
    num_octaves=2,
    alpha=200.0,
    beta=0.0,
    lr=0.006,
    steps=24,
    samples=2000,
    look_every=24,
)
