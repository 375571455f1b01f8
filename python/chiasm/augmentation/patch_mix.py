"""A square of each image from another one of the batch."""

from typing import Any, Dict, List, Sequence

import torch
from torch import Tensor

from ..primitives.core.broadcasting import each
from ..primitives.random.draws import ranks, uniform, words
from .cut import beginning
from .decisions import check_chance
from .mixing import TileAugmentationBase, check_seeds_differ
from .settings import number, one_whole


class PatchMix(TileAugmentationBase):
    """Replace a square of each image by the same square of another image of the batch.

    The partners are a permutation of the batch, in which an image may be its own; all positions of the square
    within the image are equally likely. As CutMix (S. Yun et al., ICCV 2019), with rectangles of one size.

    Args:
        alpha: for compatibility with Kornia, which draws a number from Beta(alpha, alpha) and does not use
            it; positive.
        patch_size: the side of the square in pixels, at most the image's sides.
        p: the probability that the batch is changed; the first sample's seed decides.
        same_on_batch: must be False, since the seeds that draw the partners must differ.
        keepdim: as in ``AugmentationBase``.
        data_keys: the arguments of a call: "input" and, if wanted, "mask" (B, C, H, W).

    Raises:
        ValueError: if a setting is not as above, or an image is smaller than the square.

    Example:
        >>> mix = PatchMix(patch_size=2)
        >>> mixed = mix(torch.arange(2.0)[:, None, None, None].expand(2, 1, 4, 4), seed=torch.tensor([1, 2]))
        >>> mixed.sum((1, 2, 3)), mix._params["partner"]
        (tensor([ 4., 12.]), tensor([1, 0]))
    """

    def __init__(
        self,
        alpha: float = 1.0,
        patch_size: int = 16,
        p: float = 1.0,
        same_on_batch: bool = False,
        keepdim: bool = False,
        data_keys: Sequence[Any] = ("input",),
    ) -> None:
        check_seeds_differ(same_on_batch)
        super().__init__(1.0, False, keepdim, data_keys)
        self.alpha, self.patch_size = number("alpha", alpha), one_whole("patch_size", patch_size)
        if self.alpha <= 0.0 or self.patch_size < 1:
            raise ValueError(f"alpha, patch_size: expected positive numbers, got {alpha} and {patch_size}")
        self.p_batch = number("p", p)
        check_chance(self.p_batch)

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        check_seeds_differ(self.same_on_batch)  # a sequence may have set it
        if self.patch_size > shape[2] or self.patch_size > shape[3]:
            raise ValueError(
                f"patch_size: expected at most the image's sides ({shape[2]}, {shape[3]}), got"
                f" {self.patch_size}"
            )
        drawn = words(seed, 2, 1)
        x = beginning(drawn[:, 0], shape[3], self.patch_size, 0, 0, False)
        y = beginning(drawn[:, 1], shape[2], self.patch_size, 0, 0, False)
        return {
            "batch_prob": torch.ones_like(seed, dtype=torch.bool),
            "partner": ranks(uniform(seed, 1)[:, 0]),
            "corner": torch.stack([x, y], -1),
        }

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        column = torch.arange(input.size(3), device=input.device) - params["corner"][:, :1]
        row = torch.arange(input.size(2), device=input.device) - params["corner"][:, 1:]
        columns, rows = (column >= 0) & (column < self.patch_size), (row >= 0) & (row < self.patch_size)
        inside = (rows[:, :, None] & columns[:, None, :])[:, None] & each(params["batch_prob"], input)
        return torch.where(inside, input.index_select(0, params["partner"]), input)

    @torch.jit.unused
    def inverse_transform(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        raise ValueError("PatchMix: parts of images are lost, so that there is no way back")
