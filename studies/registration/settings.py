"""What the example does, and how much of it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Settings:
    """The learning rate and the number of iterations are the paper's.

    photographs: of scikit-image. height, width: of the images that are registered. margin: what a photograph
    shows around the source image, as a share of its sides. levels: of the pyramid. iterations: at each level.
    reaches: by how much of the sides corners move at most along either axis. Beyond a quarter they may no
    longer be a convex quadrilateral's. trials: how many pairs, shared out evenly to the reaches and then to
    the photographs. shown: which pair the picture and the comparison of Python with C++ are of. success: the
    mean error of the corners, in pixels, that counts as one. tolerance: the largest difference of any entry
    of the homographies between normalised coordinates, wherever they are computed.
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
