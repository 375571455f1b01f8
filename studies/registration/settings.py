"""All settings of the example."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Settings:
    """The learning rate and the number of iterations are the paper's.

    photographs: from scikit-image. height, width: of the images to register. margin: the part of a photograph
    around the source image, relative to the image's sides. levels: of the pyramid. iterations: at each level.
    reaches: the largest movements of corners along each axis, relative to the sides. Beyond a quarter, the
    corners may no longer form a convex quadrilateral. trials: the number of pairs, distributed evenly over
    the reaches and then over the photographs. shown: the pair of the picture and of the comparison between
    Python and C++. success: the largest mean error of the corners, in pixels, that counts as success.
    tolerance: the largest difference of any entry of the homographies between normalised coordinates, on
    every engine.
    """

    photographs: tuple[str, ...] = (
        "astronaut.png",
        "camera.png",
        "coffee.png",
        "motorcycle_left.png",
        "rocket.jpg",
    )
    height: int = 288
    width: int = 384
    margin: float = 0.15
    levels: int = 5
    iterations: int = 200
    lr: float = 1e-3
    reaches: tuple[float, ...] = (0.05, 0.1, 0.15, 0.2, 0.25)
    trials: int = 50
    shown: int = 4
    success: float = 1.0
    tolerance: float = 2e-4
    seed: int = 1
    threads: int = 1


SMALL = Settings(
    photographs=("astronaut.png",),
    height=72,
    width=96,
    levels=3,
    iterations=80,
    reaches=(0.1,),
    trials=1,
    shown=0,
)
