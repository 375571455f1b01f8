"""Sequences of augmentations for images only, and for the frames of videos."""

from typing import Any, Optional, Sequence

import torch
from torch import Tensor, nn

from ..primitives.random.draws import check_seed, split
from .base import Seeded, draw_seeds
from .container import AugmentationSequential, Some


class ImageSequential(AugmentationSequential):
    """``AugmentationSequential`` for images only.

    Args:
        args: augmentations, and modules that take only an image.
        same_on_batch, keepdim, random_apply, random_apply_weights: as in ``AugmentationSequential``.

    Example:
        >>> from chiasm.augmentation import RandomHorizontalFlip
        >>> ImageSequential(RandomHorizontalFlip(p=1.0))(torch.tensor([[[[1.0, 2.0]]]]))
        tensor([[[[2., 1.]]]])
    """

    def __init__(
        self,
        *args: nn.Module,
        same_on_batch: Optional[bool] = None,
        keepdim: bool = False,
        random_apply: Some = False,
        random_apply_weights: Optional[Sequence[float]] = None,
    ) -> None:
        super().__init__(
            *args,
            same_on_batch=same_on_batch,
            keepdim=keepdim,
            random_apply=random_apply,
            random_apply_weights=random_apply_weights,
        )


class VideoSequential(Seeded):
    """A sequence of augmentations for each frame of videos.

    ``forward(input, seed)`` can be scripted and exported; a call draws the seeds if none are given.

    Args:
        args: augmentations, and modules that take only an image.
        data_format: "BTCHW" or "BCTHW", the position of the T frames.
        same_on_frame: True changes all frames of a video in the same way; False draws for each frame.
        random_apply, random_apply_weights: as in ``AugmentationSequential``.

    Example:
        >>> from chiasm.augmentation import RandomHorizontalFlip
        >>> VideoSequential(RandomHorizontalFlip(p=0.5))(torch.rand(2, 5, 3, 8, 9)).shape
        torch.Size([2, 5, 3, 8, 9])
    """

    rank = 5

    def __init__(
        self,
        *args: nn.Module,
        data_format: str = "BTCHW",
        same_on_frame: bool = True,
        random_apply: Some = False,
        random_apply_weights: Optional[Sequence[float]] = None,
    ) -> None:
        super().__init__()
        if data_format not in ("BTCHW", "BCTHW"):
            raise ValueError(f"data_format: expected 'BTCHW' or 'BCTHW', got {data_format!r}")
        self.data_format, self.same_on_frame = data_format, bool(same_on_frame)
        self.random_apply, self.random_apply_weights = random_apply, random_apply_weights
        self.steps = ImageSequential(
            *args, random_apply=random_apply, random_apply_weights=random_apply_weights
        )

    def forward(self, input: Tensor, seed: Tensor) -> Tensor:
        """The videos, changed according to ``seed`` (B,), int64."""
        if input.dim() != 5:
            raise ValueError(f"input: expected 5 dimensions, got {list(input.shape)}")
        check_seed(seed, input.size(0))
        frames_first = self.data_format == "BTCHW"
        video = input if frames_first else input.transpose(1, 2)
        count = video.size(1)
        seeds = seed[None].expand(count, -1) if self.same_on_frame else split(seed, count)
        changed = self.steps.forward(video.flatten(0, 1), seeds.t().flatten())
        changed = changed.unflatten(0, [input.size(0), count])
        return changed if frames_first else changed.transpose(1, 2)

    def __call__(
        self, input: Tensor, seed: Optional[Tensor] = None, generator: Optional[torch.Generator] = None
    ) -> Any:
        """The changed videos.

        Args:
            input: (B, T, C, H, W), or (B, C, T, H, W) if ``data_format`` is "BCTHW".
            seed: (B,), int64: all random numbers are drawn from it.
            generator: draws the seeds if none are given; PyTorch's default generator if None.
        """
        if seed is None:
            seed = draw_seeds(input.size(0), generator).to(input.device)
        return super().__call__(input, seed)
