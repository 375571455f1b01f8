"""RANSAC as a module that draws its own samples, for eager Python."""

import math
from typing import Optional, Tuple, Union

import torch
from torch import Tensor

from ...primitives.core.checks import check_choice, check_last, check_rank
from ...primitives.core.modules import Module
from .essential import ransac_essential
from .fundamental import ransac_fundamental
from .homography import ransac_homography

#: Points in a sample, and the least number of points.
_SIZES = {"homography": (4, 4), "fundamental": (7, 8), "essential": (5, 6)}


class RANSAC(Module):
    """A model of two views from correspondences with outliers: rounds of ``ransac_homography``,
    ``ransac_fundamental`` or ``ransac_essential`` with random numbers of their own. The round with the most
    inliers wins.

    Args:
        model_type: "homography", "fundamental" (also written "fundamental_7pt", "fundamental_8pt") or
            "essential".
        inl_th: a correspondence is an inlier below this distance: in pixels, or for "essential" in the units
            of its points.
        batch_size: the number of samples of a round; "auto" for 2048.
        max_iter: the most rounds.
        confidence: the rounds end when, by the share of inliers so far, a sample without outliers has been
            drawn with this probability. 1 draws all rounds.
        max_lo_iters: how many times each round fits again to the nearby points.
        seed: draws the same samples in every call; by default they come from PyTorch's generator.

    Shape:
        kp1, kp2: (N, 2), floating point, N at least 4, 8 or 6; for "essential" points of the plane z = 1.
        The result is the model (3, 3), zeros if there is none, and the mask (N,), bool, of its inliers.

    Raises:
        TypeError: if the points are not floating point.
        ValueError: if an argument or a shape is not as above.

    Example:
        >>> points = torch.rand(20, 2, generator=torch.Generator().manual_seed(0)) * 100.0
        >>> moved = points + 5.0
        >>> moved[:4] = 0.0
        >>> H, inliers = RANSAC("homography", seed=0)(points, moved)
        >>> inliers.sum(), H[0, 2].round()
        (tensor(16), tensor(5.))
    """

    def __init__(
        self,
        model_type: str = "homography",
        inl_th: float = 2.0,
        batch_size: Union[int, str] = "auto",
        max_iter: int = 10,
        confidence: float = 0.99,
        max_lo_iters: int = 5,
        seed: Optional[int] = None,
    ) -> None:
        super().__init__()
        kinds = [*_SIZES, "fundamental_7pt", "fundamental_8pt"]
        check_choice(model_type, kinds, "model_type")
        samples = 2048 if batch_size == "auto" else batch_size
        if not (isinstance(samples, int) and samples > 0 and max_iter > 0):
            raise ValueError(
                f"batch_size, max_iter: expected positive numbers, got {batch_size} and {max_iter}"
            )
        if not 0.0 < confidence <= 1.0:
            raise ValueError(f"confidence: expected a number above 0, at most 1, got {confidence}")
        self.model_type, self.inl_th, self.batch_size, self.max_iter = (
            model_type,
            inl_th,
            batch_size,
            max_iter,
        )
        self.confidence, self.max_lo_iters, self.seed = confidence, max_lo_iters, seed

    def forward(self, kp1: Tensor, kp2: Tensor) -> Tuple[Tensor, Tensor]:
        kind = self.model_type.partition("_")[0]
        size, least = _SIZES[kind]
        for points, name in ((kp1, "kp1"), (kp2, "kp2")):
            check_rank(points, 2, "(N, 2)", name)
            check_last(points, 2, name)
        if kp1.shape != kp2.shape or kp1.size(0) < least:
            raise ValueError(
                f"kp1, kp2: expected the same number of points, at least {least}, got {kp1.size(0)} and"
                f" {kp2.size(0)}"
            )
        generator = None if self.seed is None else torch.Generator(kp1.device).manual_seed(self.seed)
        count = 2048 if isinstance(self.batch_size, str) else self.batch_size
        best = kp1.new_zeros(3, 3)
        found: Optional[Tensor] = None
        for done in range(count, count * self.max_iter + 1, count):
            uniforms = torch.rand(1, count, size, generator=generator, device=kp1.device, dtype=kp1.dtype)
            model, mask = self._round(kind, kp1[None], kp2[None], uniforms)
            usable = bool(torch.isfinite(model).all())
            if usable and (found is None or int(mask.sum()) > int(found.sum())):
                best, found = model[0], mask[0]
            share = 0.0 if found is None else float(found.double().mean())
            if self.confidence < 1.0 and done >= _samples(share, size, self.confidence):
                break
        if found is None or not bool(found.any()):
            return torch.zeros_like(best), torch.zeros_like(kp1[:, 0], dtype=torch.bool)
        return best, found

    def _round(self, kind: str, x1: Tensor, x2: Tensor, uniforms: Tensor) -> Tuple[Tensor, Tensor]:
        if kind == "homography":
            return ransac_homography(x1, x2, uniforms, self.inl_th, self.max_lo_iters)
        if kind == "fundamental":
            return ransac_fundamental(x1, x2, uniforms, self.inl_th, self.max_lo_iters)
        camera = torch.eye(3, dtype=x1.dtype, device=x1.device)[None]
        return ransac_essential(x1, x2, camera, camera, uniforms, self.inl_th, self.max_lo_iters)


def _samples(share: float, size: int, confidence: float) -> float:
    """The number of samples of `size` points of which one has no outlier with probability `confidence`."""
    clean = share**size
    if clean <= 0.0:
        return math.inf
    return 1.0 if clean >= 1.0 else math.log(1.0 - confidence) / math.log1p(-clean)
