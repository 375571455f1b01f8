"""All settings of the example of several processes."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Settings:
    """processes: on this machine. photographs: of scikit-image, each reduced to size, width and height.
    corners: where the homography that is learned takes the images' corners, clockwise from the upper left
    one: how far, in widths and heights. levels, steps, lr: of the optimisation: a pyramid, from coarse to
    fine, and Adam's at each level. tolerance: how far apart, in pixels, what several processes learn and what
    one learns may take the corners.
    """

    processes: int = 2
    photographs: tuple[str, ...] = (
        "astronaut.png",
        "chelsea.png",
        "coffee.png",
        "motorcycle_left.png",
        "rocket.jpg",
        "hubble_deep_field.jpg",
        "brick.png",
    )
    size: tuple[int, int] = (384, 288)
    corners: tuple[tuple[float, float], ...] = ((0.04, 0.03), (-0.02, 0.05), (-0.05, -0.03), (0.03, -0.04))
    levels: int = 4
    steps: int = 100
    lr: float = 0.003
    tolerance: float = 1e-6


#: For tests.
SMALL = Settings(
    photographs=("astronaut.png", "chelsea.png", "coffee.png"), size=(96, 72), levels=2, steps=40
)
