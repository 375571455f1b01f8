"""Images at random places of larger canvases."""

from typing import Any, Dict, List, Optional, Tuple

import torch
from torch import Tensor

from ..primitives.random.draws import between, uniform
from .base import Size, identity
from .cut import cut
from .decisions import below
from .drawn_sizes import Sized, rectangle, size_of_each, times
from .settings import fixed, number


class RandomZoomOut(Sized):
    """Place images at random on a larger canvas: torchvision's transform, the zoom out of W. Liu et al., SSD:
    Single Shot MultiBox Detector, ECCV 2016, section 3.6.

    The drawn canvas has the image's ratio of sides. Positions in it are uniform and rounded down, so that all
    whole ones are equally likely, except the last, which does not occur, as in torchvision.

    Args:
        fill: the value of added pixels, a number or one for each channel, in the units of the image; masks
            get 0.
        side_range: the range of the ratio of the drawn canvas' side and the image's, at least 1.
        p: the probability of an image, or without ``canvas`` of the batch; others keep their size.
        canvas: (height, width) of the results, where the drawn canvas lies at the upper left; then each image
            has its own ratio, no drawn canvas is larger, and the augmentation exports. None: results of the
            drawn size, one for the whole batch, as in torchvision; only in eager Python and TorchScript.
        same_on_batch, keepdim: as in ``ScaleJitter``.

    Raises:
        ValueError: if a setting is not as above, or an image is larger than ``canvas``.

    Example:
        >>> zoom = RandomZoomOut(fill=0.5, side_range=(2.0, 2.0), p=1.0)
        >>> zoom(torch.ones(3, 4, 5)).shape
        torch.Size([3, 8, 10])
        >>> RandomZoomOut(canvas=(16, 20), p=1.0)(torch.ones(2, 3, 4, 5)).shape
        torch.Size([2, 3, 16, 20])
    """

    def __init__(
        self,
        fill: Any = 0.0,
        side_range: Tuple[float, float] = (1.0, 4.0),
        p: float = 0.5,
        canvas: Optional[Size] = None,
        same_on_batch: bool = False,
        keepdim: bool = True,
    ) -> None:
        super().__init__(canvas, fill, number("p", p), same_on_batch, keepdim)
        self.side_range = fixed("side_range", side_range)
        if not 1.0 <= self.side_range[0] <= self.side_range[1]:
            raise ValueError(f"side_range: expected (least, greatest), at least 1, got {side_range}")

    def drawn(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        u = uniform(seed, 4).to(torch.float64)
        ratio = between(u[:, 1], self.side_range[0], self.side_range[1])
        if len(self.canvas) == 2:
            if shape[2] > self.canvas[0] or shape[3] > self.canvas[1]:
                raise ValueError(
                    f"input: expected at most the canvas {self.canvas}, got [{shape[2]}, {shape[3]}]"
                )
            one = torch.ones_like(ratio)
            room = torch.minimum(one * self.canvas[0] / shape[2], one * self.canvas[1] / shape[3])
            ratio = torch.minimum(ratio, room)
        is_changed = below(u[:, 0].to(torch.float32), self.p)
        size = times(shape, torch.where(is_changed, ratio, torch.ones_like(ratio)))
        free = torch.stack([size[:, 1] - shape[3], size[:, 0] - shape[2]], -1).clamp(min=0)
        return {
            "batch_prob": is_changed,
            "size": size,
            "corner": torch.floor(free.to(torch.float64) * u[:, 2:4]).to(torch.int64),
        }

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        out = self.output_size(params)
        inside = rectangle(params["corner"].flip(1), size_of_each(input, params), out)
        return self.filled(cut(input, -params["corner"], out, "replicate", 0.0), inside)

    @torch.jit.unused
    def transform_mask(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return cut(input, -params["corner"], self.output_size(params), "constant", 0.0)

    @torch.jit.unused
    def inverse_transform(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return cut(input, params["corner"], (shape[2], shape[3]), "replicate", 0.0)

    def compute_transformation(self, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        matrix = identity(params["batch_prob"], 3).clone()
        matrix[:, :2, 2] = params["corner"].to(torch.float64)
        return matrix
