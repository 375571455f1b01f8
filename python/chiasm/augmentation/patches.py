"""Sequences of augmentations for the patches of images."""

from typing import Any, Dict, List, Optional, Sequence, Tuple

import torch
from torch import Tensor, nn

from ..primitives.core.checks import check_choice, check_rank
from ..primitives.random.draws import check_seed, split
from .base import Seeded, draw_seeds
from .container import Some
from .settings import whole
from .video import ImageSequential


class PatchSequential(Seeded):
    """Cut images into a grid of patches, change each patch separately, and put the patches together again.

    S. Lin et al., Patch AutoAugment, 2021. ``forward(input, seed)`` can be scripted and exported; a call
    draws the seeds if none are given, and keeps them in ``_params``.

    Args:
        args: augmentations, sequences of them, and modules that take only an image; all must keep the size.
        grid_size: number of patches (down, across).
        padding: for images that the grid does not divide: "same" adds a black border, which is removed from
            the result; "valid" crops the image at its centre.
        same_on_batch: True draws for the patches of the first image and uses the same changes for all images;
            False draws for each image, whatever the augmentations' settings are; None keeps their settings.
        keepdim: True returns an image without a batch dimension for an image without one.
        patchwise_apply: True: ``args`` has one augmentation for each patch, row by row; False: all of them
            are applied to every patch.
        random_apply: how many of ``args`` are applied to each patch, as in ``AugmentationSequential``; with
            ``patchwise_apply``, False or True, which means one to four.
        random_apply_weights: as in ``AugmentationSequential``.

    Example:
        >>> from chiasm.augmentation import RandomHorizontalFlip, RandomInvert
        >>> augment = PatchSequential(RandomHorizontalFlip(p=1.0), RandomInvert(p=1.0), grid_size=(1, 2))
        >>> augment(torch.tensor([[[[0.5, 0.25, 0.0, 1.0]]]]))
        tensor([[[[0.2500, 0.5000, 1.0000, 0.0000]]]])
    """

    #: The parameters of the last call.
    _params: Dict[str, Tensor]

    def __init__(
        self,
        *args: nn.Module,
        grid_size: Tuple[int, int] = (4, 4),
        padding: str = "same",
        same_on_batch: Optional[bool] = None,
        keepdim: Optional[bool] = None,
        patchwise_apply: bool = True,
        random_apply: Some = False,
        random_apply_weights: Optional[Sequence[float]] = None,
    ) -> None:
        super().__init__()
        check_choice(padding, ["same", "valid"], "padding")
        down, across = whole("grid_size", grid_size)
        if down < 1 or across < 1:
            raise ValueError(f"grid_size: expected positive numbers, got {grid_size}")
        if patchwise_apply and not isinstance(random_apply, bool):
            raise ValueError(f"random_apply: expected True or False for patchwise_apply, got {random_apply}")
        self.by_place = patchwise_apply and not random_apply
        if self.by_place and len(args) != down * across:
            raise ValueError(
                f"args: expected {down * across}, one for each patch, or patchwise_apply=False; got"
                f" {len(args)}"
            )
        some = (1, min(4, len(args))) if patchwise_apply else random_apply
        each = False if same_on_batch is False else None
        self.steps = nn.ModuleList(
            [ImageSequential(a, same_on_batch=each) for a in args]
            if self.by_place
            else [
                ImageSequential(
                    *args,
                    same_on_batch=each,
                    random_apply=some,
                    random_apply_weights=random_apply_weights,
                )
            ]
        )
        self.grid_size, self.padding, self.patchwise_apply = (down, across), padding, patchwise_apply
        self.random_apply, self.random_apply_weights = random_apply, random_apply_weights
        self.same_on_batch, self.keepdim, self._params = same_on_batch is True, bool(keepdim), {}

    def forward(self, input: Tensor, seed: Tensor) -> Tensor:
        """The images, changed according to ``seed`` (B,), int64."""
        check_rank(input, 4, "(B, C, H, W)", "input")
        check_seed(seed, input.size(0))
        if self.same_on_batch:
            seed = seed[:1].expand(input.size(0))
        down, across = self.grid_size
        seeds = split(seed, down * across)
        image, top, left = self.fitted(input)
        high, wide = image.size(2) // down, image.size(3) // across
        patches = image.reshape(-1, image.size(1), down, high, across, wide).permute(0, 2, 4, 1, 3, 5)
        if self.by_place:
            changed: List[Tensor] = []
            for i, step in enumerate(self.steps):
                changed.append(step.forward(patches[:, i // across, i % across], seeds[i]))
            made = torch.stack(changed, 1)
        else:
            made = patches.flatten(0, 2)
            for step in self.steps:  # there is one step, but TorchScript does not know this
                made = step.forward(made, seeds.t().flatten())
        made = made.reshape(-1, down, across, made.size(-3), high, wide).permute(0, 3, 1, 4, 2, 5)
        made = made.reshape(input.size(0), made.size(1), down * high, across * wide)
        if self.padding == "valid":
            return made
        return made[:, :, top : top + input.size(2), left : left + input.size(3)]

    def fitted(self, input: Tensor) -> Tuple[Tensor, int, int]:
        """The images with a size that the grid divides, and the offset (rows, columns) of the visible part in
        them."""
        down, across = self.grid_size
        if self.padding == "valid":
            high, wide = input.size(2) // down * down, input.size(3) // across * across
            if high == 0 or wide == 0:
                raise ValueError(f"input: expected at least {self.grid_size} pixels, got {list(input.shape)}")
            top, left = (input.size(2) - high) // 2, (input.size(3) - wide) // 2
            return input[:, :, top : top + high, left : left + wide], 0, 0
        high, wide = (down - input.size(2) % down) % down, (across - input.size(3) % across) % across
        top, left = high // 2, wide // 2
        around = [left, wide - left, top, high - top]
        return torch.nn.functional.pad(input, around), top, left

    def __call__(
        self,
        input: Tensor,
        seed: Optional[Tensor] = None,
        params: Optional[Dict[str, Tensor]] = None,
        generator: Optional[torch.Generator] = None,
    ) -> Any:
        """The changed images, or one changed image without a batch dimension.

        Args:
            input: (B, C, H, W) or (C, H, W).
            seed: (B,), int64: all random numbers are drawn from it.
            params: the parameters of an earlier call (its ``_params``).
            generator: draws the seeds if none are given; PyTorch's default generator if None.
        """
        batch = input[None] if input.dim() == 3 else input
        if params is not None:
            seed = params["seed"]
        if seed is None:
            seed = draw_seeds(batch.size(0), generator).to(batch.device)
        self._params = {"seed": seed}
        changed = super().__call__(batch, seed)
        return changed[0] if self.keepdim and input.dim() == 3 else changed
