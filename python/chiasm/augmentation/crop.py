"""Random crops, resized to one size."""

import math
from typing import Any, Dict, List, Tuple

import torch
from torch import Tensor

from ..primitives.core.broadcasting import each
from ..primitives.random.draws import between, uniform, words
from .base import Size, as_size, check_batch
from .decisions import below, check_bounds, check_positive_bounds
from .drawn_sizes import rectangle
from .settings import symmetric
from .warps import Warp, warped


def _draw(
    seed: Tensor, shape: List[int], scale: Tuple[float, float], ratio: Tuple[float, float], p: float
) -> Dict[str, Tensor]:
    check_bounds(scale, 0.0, math.inf, "scale")
    check_positive_bounds(ratio, "ratio")
    height, width = shape[2], shape[3]
    u = uniform(seed, 22).to(torch.float64)
    area = between(u[:, 2:12], scale[0], scale[1]) * (height * width)
    aspect = torch.exp(between(u[:, 12:22], math.log(ratio[0]), math.log(ratio[1])))
    wide, high = torch.round(torch.sqrt(area * aspect)), torch.round(torch.sqrt(area / aspect))
    # If no box fits: the largest box of an allowed ratio, at the centre.
    one = torch.ones_like(wide[:, 0])
    w = torch.minimum(one * width, torch.clamp(torch.round(one * height * ratio[1]), min=1.0))
    h = torch.minimum(one * height, torch.clamp(torch.round(one * width / ratio[0]), min=1.0))
    fits = (wide >= 1.0) & (wide <= width) & (high >= 1.0) & (high <= height)
    for i in range(9, -1, -1):  # the first that fits is the last to be taken
        w = torch.where(fits[:, i], wide[:, i], w)
        h = torch.where(fits[:, i], high[:, i], h)
    any_fits = fits.any(1)
    place = words(seed, 2, 1).to(torch.float64) * 2.3283064365386963e-10  # in [0, 1)
    left = torch.where(any_fits, torch.floor(place[:, 0] * (width - w + 1.0)), torch.floor((width - w) * 0.5))
    top = torch.where(
        any_fits, torch.floor(place[:, 1] * (height - h + 1.0)), torch.floor((height - h) * 0.5)
    )
    return {"batch_prob": below(u[:, 0], p), "box": torch.stack([left, top, w, h], -1)}


def resized_box(
    params: Dict[str, Tensor], shape: List[int], size: Tuple[int, int], align_corners: bool
) -> Tensor:
    """Maps the box (for unchanged samples, the whole image) to the output: corner pixels to corner pixels, or
    edges to edges."""
    box = params["box"].to(torch.float64)
    zero, one = torch.zeros_like(box[:, 0]), torch.ones_like(box[:, 0])
    whole = torch.stack([zero, zero, one * shape[3], one * shape[2]], -1)
    box = torch.where(params["batch_prob"][:, None], box, whole)
    if align_corners:  # a box of one pixel has no sides to scale
        x = (size[1] - 1) / torch.clamp(box[:, 2] - 1.0, min=1.0)
        y = (size[0] - 1) / torch.clamp(box[:, 3] - 1.0, min=1.0)
        x, y = torch.where(x > 0.0, x, one), torch.where(y > 0.0, y, one)
        rows = [x, zero, -x * box[:, 0], zero, y, -y * box[:, 1], zero, zero, one]
    else:
        x, y = size[1] / box[:, 2], size[0] / box[:, 3]
        rows = [
            x, zero, (0.5 - box[:, 0]) * x - 0.5, zero, y, (0.5 - box[:, 1]) * y - 0.5, zero, zero, one,
        ]  # fmt: skip
    return torch.stack(rows, -1).reshape(-1, 3, 3)


def within_box(image: Tensor, params: Dict[str, Tensor]) -> Tensor:
    """Images (B, C, H, W) with zeros outside the box; unchanged samples as they are."""
    box = params["box"].to(torch.int64)
    inside = rectangle(box[:, [1, 0]], box[:, [3, 2]], (image.size(2), image.size(3)))
    return torch.where(inside | ~each(params["batch_prob"], image), image, torch.zeros_like(image))


def random_resized_crop(
    input: Tensor,
    seed: Tensor,
    size: Tuple[int, int],
    scale: Tuple[float, float] = (0.08, 1.0),
    ratio: Tuple[float, float] = (0.75, 1.3333333333333333),
    resample: str = "bilinear",
    align_corners: bool = True,
    p: float = 1.0,
) -> Tensor:
    """Crop a random box of each image and resize it, as is common in training for classification.

    Of ten boxes of random area and ratio (uniform, and uniform in the logarithm) the first that fits is
    taken, at a random place: C. Szegedy et al., Going deeper with convolutions, CVPR 2015, section 6.

    Args:
        input: (B, C, H, W), floating point or uint8.
        seed: (B,), int64.
        size: (height, width) of the result.
        scale: the range of the box area, as a fraction of the image area.
        ratio: the range of width / height.
        resample: "bilinear", "nearest" or "bicubic".
        align_corners: True maps the box's corner pixels to the result's corner pixels; False maps edges to
            edges; then, pixels of the image outside the box contribute at the box's edges.
        p: the probability that an image is cropped; other images are resized as a whole.

    Returns:
        (B, C, height, width). Differentiable in input.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> x = torch.arange(16.0).reshape(1, 1, 4, 4)
        >>> random_resized_crop(x, torch.tensor([0]), (2, 2), scale=(1.0, 1.0), ratio=(1.0, 1.0))[0, 0]
        tensor([[ 0.,  3.],
                [12., 15.]])
    """
    check_batch(input, seed)
    shape = list(input.shape)
    matrix = resized_box(_draw(seed, shape, scale, ratio, p), shape, size, align_corners)
    return warped(input, matrix, size[0], size[1], resample, "border", align_corners)


class RandomResizedCrop(Warp):
    """``random_resized_crop`` as a module.

    Args:
        size: (height, width) of the result, or a number for both.
        scale, ratio, resample, align_corners: as in ``random_resized_crop``.
        same_on_batch, p, keepdim: as in ``AugmentationBase``.

    Example:
        >>> augment = RandomResizedCrop((4, 6), scale=(0.3, 1.0))
        >>> augment(torch.rand(2, 3, 8, 10)).shape
        torch.Size([2, 3, 4, 6])
        >>> augment.transform_matrix.shape
        torch.Size([2, 3, 3])
    """

    def __init__(
        self,
        size: Size,
        scale: Any = (0.08, 1.0),
        ratio: Any = (0.75, 1.3333333333333333),
        resample: Any = "bilinear",
        same_on_batch: bool = False,
        align_corners: bool = True,
        p: float = 1.0,
        keepdim: bool = False,
    ) -> None:
        super().__init__(resample, "border", align_corners, p, same_on_batch, keepdim)
        self.size = as_size(size, "size")
        self.scale, self.ratio = symmetric("scale", scale), symmetric("ratio", ratio)
        if self.scale[0] <= 0.0 or self.ratio[0] <= 0.0:
            raise ValueError(f"scale, ratio: expected positive ranges, got {scale} and {ratio}")

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        return _draw(seed, shape, self.scale, self.ratio, self.p)

    def compute_transformation(self, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return resized_box(params, shape, self.size, self.align_corners)

    def output_size(self, shape: List[int]) -> List[int]:
        return [self.size[0], self.size[1]]

    @torch.jit.unused
    def inverse_transform(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return within_box(super().inverse_transform(input, params, shape), params)

    @torch.jit.unused
    def inverse_mask(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return within_box(super().inverse_mask(input, params, shape), params)
