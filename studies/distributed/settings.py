"""All settings of the example with several processes."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Settings:
    """processes: the number on this machine. photographs: from scikit-image, each reduced to size, width and
    height. corners: the displacements of the images' corners by the homography to learn, clockwise from the
    upper left one, in widths and heights. levels, steps, lr: for the optimisation: the pyramid's levels, from
    coarse to fine, and Adam's steps and rate at each. tolerance: the largest distance, in pixels, between the
    corners mapped by the results of several processes and of one.
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
