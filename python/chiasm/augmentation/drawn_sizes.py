"""Results whose size is drawn: one size for the whole batch, or a size for each image on a fixed canvas."""

from typing import Any, Dict, List, Optional, Sequence, Tuple, Union

import torch
from torch import Tensor

from ..geometry.transform.resize import resize
from ..primitives.core.modules import shown
from ..primitives.linalg.matrices import small_matmul
from ..primitives.random.draws import between, integers, uniform
from ..primitives.resampling.taps import cubic_kernel, weight_dtype
from .annotations import moved_mask
from .base import GeometricAugmentationBase2D, Size, as_mode, as_size, identity
from .cut import picked
from .settings import fixed, numbers, one_whole, whole_numbers


class Sized(GeometricAugmentationBase2D):
    """An augmentation that draws the size of its results, "size" (B, 2), int64, (height, width).

    A subclass draws it (``drawn``) and makes the results. Without a canvas, the first seed draws one size for
    the whole batch, as torchvision does: reading it takes eager Python or TorchScript, for no other format
    has sizes that depend on values. With a canvas, each image has its own size, and lies at the upper left
    of a canvas of one size, filled with ``fill``: this exports to every format, and ``valid_mask`` says where
    the images are.

    Args:
        canvas: (height, width) of the results, or a number for both; None: the drawn size.
        fill: the value of added pixels, a number or one for each channel, in the units of the image. Masks
            get 0.
        p, same_on_batch, keepdim: as in ``AugmentationBase``.
    """

    moves_edges = True
    canvas: List[int]
    fill: List[float]

    def __init__(
        self, canvas: Optional[Size], fill: Any, p: float, same_on_batch: bool, keepdim: bool
    ) -> None:
        super().__init__(p, 1.0, same_on_batch, keepdim)
        # A scripted module has one type of canvas, a list.
        self.canvas = [] if canvas is None else list(as_size(canvas, "canvas"))
        self.fill = numbers("fill", fill)

    def drawn(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        """The parameters of each image: "batch_prob", "size" and what else the subclass needs."""
        return {"batch_prob": torch.ones_like(seed, dtype=torch.bool)}

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        if len(self.canvas) == 0:
            if shape[0] == 0:
                raise ValueError("input: expected at least one image, whose seed draws the size; got none")
            seed = seed[:1].expand(seed.size(0))
        return self.drawn(seed, shape)

    def output_size(self, params: Dict[str, Tensor]) -> Tuple[int, int]:
        """Height and width of the results."""
        if len(self.canvas) == 2:
            return self.canvas[0], self.canvas[1]
        return int(params["size"][0, 0]), int(params["size"][0, 1])

    @torch.jit.unused
    def valid_mask(self, params: Optional[Dict[str, Tensor]] = None) -> Tensor:
        """(B, 1, height, width), bool: the pixels of the drawn size, after the last call or for ``params``;
        the other pixels of the canvas are filled."""
        return self.inside(self._params if params is None else params)

    def inside(self, params: Dict[str, Tensor]) -> Tensor:
        """``valid_mask`` for parameters."""
        return rectangle(torch.zeros_like(params["size"]), params["size"], self.output_size(params))

    def filled(self, image: Tensor, inside: Tensor) -> Tensor:
        """The image, and ``fill`` outside (B, 1, H, W), bool."""
        if len(self.fill) != 1 and len(self.fill) != image.size(1):
            raise ValueError(
                f"fill: expected a number, or {image.size(1)}, one a channel, got {len(self.fill)} numbers"
            )
        fill = torch.tensor(self.fill, dtype=torch.float64, device=image.device)
        fill = (fill.clamp(0.0, 255.0) if image.dtype == torch.uint8 else fill).to(image.dtype)
        return torch.where(inside, image, fill[:, None, None])

    def extra_repr(self) -> str:
        return shown(self, canvas=tuple(self.canvas) or None)


class Scaling(Sized):
    """Images resized to the drawn size.

    On a canvas, "bicubic" needs ``antialias``, and bytes differ from those without a canvas by at most a
    level.
    """

    def __init__(
        self,
        interpolation: Any,
        antialias: Optional[bool],
        canvas: Optional[Size],
        fill: Any,
        same_on_batch: bool,
        keepdim: bool,
    ) -> None:
        super().__init__(canvas, fill, 1.0, same_on_batch, keepdim)
        self.interpolation = as_mode(interpolation, "interpolation")
        self.antialias = bool(antialias) and self.interpolation != "nearest"
        if self.canvas and self.interpolation == "bicubic" and not self.antialias:
            raise ValueError("antialias: expected True for 'bicubic' on a canvas, got False")

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        height, width = self.output_size(params)
        if len(self.canvas) == 0:
            return resize(input, (height, width), self.interpolation, False, "short", self.antialias)
        before = size_of_each(input, params)
        out = _scaled(input, before, params["size"], (height, width), self.interpolation, self.antialias)
        return self.filled(out, self.inside(params))

    @torch.jit.unused
    def transform_mask(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        size = self.output_size(params)
        if not self.canvas:
            return moved_mask(input, lambda values, _: resize(values, size, "nearest"))
        out = _scaled(input, size_of_each(input, params), params["size"], size, "nearest", False)
        return torch.where(self.inside(params), out, torch.zeros_like(out))

    @torch.jit.unused
    def inverse_transform(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return self._back(input, params, shape, self.interpolation)

    @torch.jit.unused
    def inverse_mask(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return self._back(input, params, shape, "nearest")

    @torch.jit.unused
    def _back(self, input: Tensor, params: Dict[str, Tensor], shape: List[int], mode: str) -> Tensor:
        whole = torch.tensor(shape[2:], device=input.device).expand(input.size(0), 2)
        return _scaled(input, params["size"], whole, (shape[2], shape[3]), mode, True)

    def compute_transformation(self, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        matrix = identity(params["batch_prob"], 3).clone()
        for axis in range(2):
            factor = params["size"][:, 1 - axis].to(torch.float64) / shape[3 - axis]
            matrix[:, axis, axis] = factor
            matrix[:, axis, 2] = 0.5 * factor - 0.5
        return matrix


class ScaleJitter(Scaling):
    """Resize images by a random factor, relative to the largest size that fits ``target_size``: torchvision's
    transform. Large scale jittering: G. Ghiasi et al., Simple Copy-Paste is a Strong Data Augmentation Method
    for Instance Segmentation, CVPR 2021.

    The ratio of the sides stays. As in torchvision, edges of boxes are multiplied by the ratio of the sizes;
    the centres of keypoints and of the corner pixels of "bbox" move as those of pixels do.

    Args:
        target_size: (width, height) of the base scale, in torchvision's order.
        scale_range: the range of the factor, positive.
        interpolation: "bilinear", "nearest" or "bicubic".
        antialias: True widens the filter by the reduction, as in ``geometry.transform.resize``.
        canvas: (height, width) of the results, where the drawn size lies at the upper left; then each image
            has its own factor, and the augmentation exports. It must hold the largest size. None: results of
            the drawn size, one for the whole batch, as in torchvision; only in eager Python and TorchScript.
        fill: the value of the canvas beside the images, a number or one for each channel; masks get 0.
        same_on_batch: as in ``AugmentationBase``.
        keepdim: False gives an image without a batch dimension one.

    Raises:
        ValueError: if a setting is not as above.

    Example:
        >>> jitter = ScaleJitter((8, 8), (0.5, 2.0), canvas=16)
        >>> jitter(torch.ones(2, 3, 6, 12)).shape
        torch.Size([2, 3, 16, 16])
        >>> mask = jitter.valid_mask()  # jitter._params["size"] has the sizes
        >>> mask.shape, mask.dtype
        (torch.Size([2, 1, 16, 16]), torch.bool)
        >>> ScaleJitter((8, 8), (2.0, 2.0))(torch.ones(3, 6, 12)).shape
        torch.Size([3, 8, 16])
    """

    def __init__(
        self,
        target_size: Tuple[int, int],
        scale_range: Tuple[float, float] = (0.1, 2.0),
        interpolation: Any = "bilinear",
        antialias: Optional[bool] = True,
        canvas: Optional[Size] = None,
        fill: Any = 0.0,
        same_on_batch: bool = False,
        keepdim: bool = True,
    ) -> None:
        super().__init__(interpolation, antialias, canvas, fill, same_on_batch, keepdim)
        self.target_size = as_size(target_size, "target_size")
        self.scale_range = fixed("scale_range", scale_range)
        if not 0.0 < self.scale_range[0] <= self.scale_range[1]:
            raise ValueError(f"scale_range: expected (least, greatest), both positive, got {scale_range}")
        least = [int(self.target_size[i] * self.scale_range[1]) for i in (1, 0)]
        if self.canvas and (self.canvas[0] < least[0] or self.canvas[1] < least[1]):
            raise ValueError(
                f"canvas: expected at least ({least[0]}, {least[1]}), the largest size, got {canvas}"
            )

    def drawn(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        drawn = uniform(seed, 1)[:, 0].to(torch.float64)
        factor = between(drawn, self.scale_range[0], self.scale_range[1])
        one = torch.ones_like(factor)
        fitting = torch.minimum(one * self.target_size[1] / shape[2], one * self.target_size[0] / shape[3])
        return {
            "batch_prob": torch.ones_like(seed, dtype=torch.bool),
            "size": times(shape, fitting * factor),
        }


class RandomShortestSize(Scaling):
    """Resize images so that the shorter side has a length drawn from some: torchvision's transform.

    The ratio of the sides stays. Boxes and keypoints move as those of ``ScaleJitter`` do.

    Args:
        min_size: the lengths of the shorter side, all equally likely; or one number.
        max_size: the greatest length of the longer side; images that would be longer become smaller as a
            whole. None: no limit.
        interpolation, antialias: as in ``ScaleJitter``.
        canvas: (height, width) of the results, as in ``ScaleJitter``; images that would be larger become
            smaller as a whole.
        fill, same_on_batch, keepdim: as in ``ScaleJitter``.

    Raises:
        ValueError: if a setting is not as above.

    Example:
        >>> RandomShortestSize([4, 6], max_size=9, canvas=(9, 9))(torch.ones(2, 3, 8, 10)).shape
        torch.Size([2, 3, 9, 9])
        >>> RandomShortestSize(4)(torch.ones(3, 8, 10)).shape
        torch.Size([3, 4, 5])
    """

    def __init__(
        self,
        min_size: Union[int, Sequence[int]],
        max_size: Optional[int] = None,
        interpolation: Any = "bilinear",
        antialias: Optional[bool] = True,
        canvas: Optional[Size] = None,
        fill: Any = 0.0,
        same_on_batch: bool = False,
        keepdim: bool = True,
    ) -> None:
        super().__init__(interpolation, antialias, canvas, fill, same_on_batch, keepdim)
        self.min_size = whole_numbers("min_size", min_size)
        self.max_size = None if max_size is None else one_whole("max_size", max_size)
        if min(self.min_size) < 1 or (self.max_size is not None and self.max_size < 1):
            raise ValueError(f"min_size, max_size: expected positive numbers, got {min_size} and {max_size}")
        self.limit = 0 if self.max_size is None else self.max_size

    def drawn(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        lengths = torch.tensor(self.min_size, dtype=torch.float64, device=seed.device)
        length = lengths[integers(seed, len(self.min_size), 1)[:, 0]]
        height, width = length * 0.0 + shape[2], length * 0.0 + shape[3]
        ratio = length / torch.minimum(height, width)
        if self.limit > 0:
            ratio = torch.minimum(ratio, self.limit / torch.maximum(height, width))
        if len(self.canvas) == 2:
            ratio = torch.minimum(ratio, torch.minimum(self.canvas[0] / height, self.canvas[1] / width))
        return {"batch_prob": torch.ones_like(seed, dtype=torch.bool), "size": times(shape, ratio)}


def size_of_each(input: Tensor, params: Dict[str, Tensor]) -> Tensor:
    """(B, 2), int64: the height and width of images, which are of one size."""
    return torch.zeros_like(params["size"]) + torch.tensor(
        [input.size(2), input.size(3)], device=input.device
    )


def times(shape: List[int], ratio: Tensor) -> Tensor:
    """Sizes (B, 2), int64: those of images times ratios (B,), rounded down, at least 1."""
    sides = torch.stack([ratio * shape[2], ratio * shape[3]], -1)
    return torch.floor(sides).clamp(min=1.0).to(torch.int64)


def rectangle(corner: Tensor, size: Tensor, out: Tuple[int, int]) -> Tensor:
    """(B, 1, height, width), bool: the pixels of rectangles whose corners and sizes are (B, 2), (row,
    column)."""
    row = torch.arange(out[0], device=size.device) - corner[:, :1]
    column = torch.arange(out[1], device=size.device) - corner[:, 1:]
    rows, columns = (row >= 0) & (row < size[:, :1]), (column >= 0) & (column < size[:, 1:])
    return (rows[:, :, None] & columns[:, None, :])[:, None]


def _scaled(
    input: Tensor, before: Tensor, after: Tensor, out: Tuple[int, int], mode: str, antialias: bool
) -> Tensor:
    """(B, C, height, width): the pixels of the sizes ``before`` (B, 2) at the upper left of images, resized
    to the sizes ``after`` (B, 2); what is beyond these has no meaning."""
    if mode == "nearest":
        row, column = [
            torch.floor((torch.arange(out[i], device=input.device) * before[:, i : i + 1]).to(torch.float64)
                        / after[:, i : i + 1]).to(torch.int64).minimum(before[:, i : i + 1] - 1)
            for i in range(2)
        ]  # fmt: skip
        return picked(input, row, column)
    numbers = input.to(weight_dtype(input))
    across = _weights(before[:, 1], after[:, 1], input.size(3), out[1], mode, antialias, numbers)
    down = _weights(before[:, 0], after[:, 0], input.size(2), out[0], mode, antialias, numbers)
    wide = small_matmul(numbers, across.transpose(2, 3))
    if input.is_floating_point():
        return small_matmul(down, wide).to(input.dtype)
    # Bytes are rounded after each axis, halves up, as in Pillow.
    wide = torch.floor(wide + 0.5).clamp(0.0, 255.0)
    return torch.floor(small_matmul(down, wide) + 0.5).clamp(0.0, 255.0).to(input.dtype)


def _weights(
    before: Tensor, after: Tensor, size: int, out: int, mode: str, antialias: bool, like: Tensor
) -> Tensor:
    """(B, 1, out, size): how much each pixel counts for each pixel of the result, along one axis."""
    extent = before.to(like.dtype)[:, None, None]
    factor = extent / after.to(like.dtype)[:, None, None]
    stretch = factor.clamp(min=1.0) if antialias else torch.ones_like(factor)
    pixel = torch.arange(size, device=like.device).to(like.dtype)
    # A position beyond the result has the last pixel's weights, so that they add up to one.
    centre = torch.minimum(
        (torch.arange(out, device=like.device).to(like.dtype)[:, None] + 0.5) * factor, extent
    )
    distance = (pixel + 0.5 - centre).abs() / stretch
    weight = (1.0 - distance).clamp(min=0.0) if mode == "bilinear" else cubic_kernel(distance, -0.5)
    weight = torch.where(pixel < extent, weight, torch.zeros_like(weight))
    return (weight / weight.sum(2, keepdim=True))[:, None]
