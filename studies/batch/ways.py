"""The parts of every contender: images in its form, a call that processes a whole batch, and its results in
chiasm's form."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bench.images.data import PHOTOGRAPHS, photograph
from bench.images.ops import Agreement

from .settings import Settings


class Setup(NamedTuple):
    """The folder of bundles, and the number of threads that a contender may use."""

    settings: Settings
    bundles: Path
    threads: int


def photographs(batch: int, size: tuple[int, int]) -> np.ndarray:
    """scikit-image's colour photographs, cyclically: (B, 3, H, W), RGB, uint8."""
    some = photograph(len(PHOTOGRAPHS), *size)
    return some[np.arange(batch) % len(some)]


class Images:
    """A batch of photographs (B, 3, H, W), RGB, uint8, in the forms that contenders take, each made at its
    first use."""

    def __init__(self, pixels: np.ndarray) -> None:
        self.pixels = pixels

    def __len__(self) -> int:
        return len(self.pixels)

    def bytes(self) -> int:
        """The bytes of all forms made so far."""
        # Planes are views of floats
        made = [v for k, v in vars(self).items() if k not in ("pixels", "planes")]
        return sum(a.nbytes for form in made for a in (form if isinstance(form, list) else [form]))

    @cached_property
    def floats(self) -> np.ndarray:
        """(B, 3, H, W), float32 in [0, 1]."""
        return self.pixels / np.float32(255)

    @cached_property
    def planes(self) -> list[np.ndarray]:
        """Each channel of each image (H, W), as views of `floats`."""
        return list(self.floats.reshape(-1, *self.floats.shape[2:]))

    @cached_property
    def matrices(self) -> list[np.ndarray]:
        """Each image (H, W, 3), RGB, float32 in [0, 1]."""
        return [np.ascontiguousarray(i.transpose(1, 2, 0)) for i in self.floats]

    @cached_property
    def rgb(self) -> list[np.ndarray]:
        """Each image (H, W, 3), RGB, uint8."""
        return [np.ascontiguousarray(i.transpose(1, 2, 0)) for i in self.pixels]

    @cached_property
    def frames(self) -> list[np.ndarray]:
        """Each image as a camera frame (H, W, 3), BGR, uint8."""
        return [np.ascontiguousarray(i[::-1].transpose(1, 2, 0)) for i in self.pixels]

    @cached_property
    def stacked_frames(self) -> np.ndarray:
        """(B, H, W, 3), BGR, uint8."""
        return np.ascontiguousarray(self.pixels[:, ::-1].transpose(0, 2, 3, 1))


class Ready(NamedTuple):
    """A contender with its prepared inputs.

    call: does the work on the whole batch once, and returns the results.
    planes: converts these to (B, C, H, W) in chiasm's scale.
    """

    call: Callable[[], Any]
    planes: Callable[[Any], np.ndarray]


@dataclass(frozen=True)
class Way:
    """A contender for one work, and the allowed difference of its results from chiasm's."""

    make: Callable[[Images, Setup], Ready]
    agrees: Agreement


@dataclass(frozen=True)
class Work:
    """The work of all contenders in a race.

    bundle: the bundle that chiasm's contenders run.
    ways: the contenders by name; the first is chiasm's eager function, whose results are the reference.
    """

    title: str
    #: the description of the work, for the page
    said: str
    bundle: str
    ways: Mapping[str, Way]
    #: the allowed difference of Debian's OpenCV, if its version computes differently from the wheel's
    debian: Agreement | None = None


def over_images(one: Callable[[int, dict], Any], count: int, threads: int) -> Callable[[], list]:
    """A call that does `one(i, scratch)` for each of `count` images; `scratch` belongs to the thread and
    keeps objects that it reuses."""
    shares = min(threads, count)
    scratch: list[dict] = [{} for _ in range(shares)]

    def share(k: int) -> list:
        return [one(i, scratch[k]) for i in range(count * k // shares, count * (k + 1) // shares)]

    if shares == 1:
        return lambda: share(0)
    pool = ThreadPoolExecutor(shares)
    return lambda: [made for part in pool.map(share, range(shares)) for made in part]


def into(
    scratch: dict, key: str, function: Callable, *arguments: Any, dst: str = "dst", **options: Any
) -> Any:
    """A call of an OpenCV function into the matrix that `scratch` keeps under the key."""
    made = function(*arguments, **{dst: scratch.get(key)}, **options)
    scratch[key] = made[1] if isinstance(made, tuple) else made
    return scratch[key]


def from_matrices(matrices: list[np.ndarray]) -> np.ndarray:
    """Matrices (H, W, C), one per image, as (B, C, H, W)."""
    return np.stack(matrices).transpose(0, 3, 1, 2)
