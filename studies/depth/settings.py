"""All settings of the study. Nothing is random, so there is no seed."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Settings:
    """Scales, iterations and the size of the rendered views are the paper's.

    scales: each half as large as the next. iterations: steps at a scale. rate: learning rate at a scale's
    first step; it falls to 0 in equal steps. inertia: factor of the momentum. window: taps of SSIM's window.
    ssim_weight, l1_weight: weights of the photometric differences, from C. Godard et al. (CVPR 2017).
    smoothness: weight of the edge-aware smoothness. room_size, motorcycle_size: width and height of the
    views, pixels. depths: the smallest and the greatest depth of the search, in metres; the search starts at
    the mean of their inverses.
    """

    scales: int = 7
    iterations: int = 500
    rate: float = 0.5
    inertia: float = 0.9
    window: int = 5
    ssim_weight: float = 0.85
    l1_weight: float = 0.15
    smoothness: float = 0.05
    room_size: tuple[int, int] = (320, 240)
    motorcycle_size: tuple[int, int] = (370, 250)
    depths: tuple[float, float] = (1.5, 10.0)

    def rate_at(self, iteration: int) -> float:
        """The learning rate of a step, counted from 0."""
        return self.rate * (1 - iteration / self.iterations)


SMALL = Settings(scales=4, iterations=40, room_size=(80, 60), motorcycle_size=(92, 62))
