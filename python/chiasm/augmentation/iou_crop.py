"""Crops that keep enough of a box, and the removal of boxes that are no use any more."""

from typing import Any, Dict, List, Optional, Sequence

import torch
from torch import Tensor

from ..primitives.core.modules import shown
from ..primitives.geometry.boxes import box_areas, intersections_and_unions
from ..primitives.random.draws import between, integers, uniform
from .annotations import edges_of, of_edges
from .base import AugmentationBase, Size, as_size, identity
from .crop import resized_box, within_box
from .cut import cut
from .settings import number, numbers, one_whole
from .warps import Warp


class RandomIoUCrop(Warp):
    """Crop images so that a box keeps a drawn overlap with the crop: torchvision's transform, the patch
    sampling of W. Liu et al., SSD: Single Shot MultiBox Detector, ECCV 2016, section 2.2.

    For each image an overlap is drawn from ``sampler_options``: of 1 or more, the image stays. Otherwise the
    first of ``trials`` random crops is taken that has a box whose centre is within it and whose intersection
    over union with it is at least this overlap; if there is none, another option is drawn, 8 times at most
    (torchvision tries without end), then the image stays.

    Boxes are needed, so it is a step of an ``AugmentationSequential`` whose ``data_keys`` have some. Their
    edges are clipped to the crop; boxes whose centre is outside become zeros, which ``SanitizeBoundingBoxes``
    removes.

    Without ``size``, as in torchvision, the result has the crop's size, which only eager Python and
    TorchScript can have: a call takes one image. With ``size``, crops are resized to one size, by the same
    rule as those of ``RandomResizedCrop(align_corners=False)``, whatever the batch; this exports to every
    format: ``forward(input, seed, draw_among(boxes, seed, shape))``.

    Args:
        min_scale, max_scale: the range of a crop's sides, relative to the image's.
        min_aspect_ratio, max_aspect_ratio: the range of its width / height.
        sampler_options: the overlaps, all equally likely; 0, 0.1, 0.3, 0.5, 0.7, 0.9 and 1 by default.
        trials: how many crops are tried for an overlap.
        size: (height, width) of the results, or a number for both; None: that of the crop.
        resample: of ``size``: "bilinear", "nearest" or "bicubic".
        same_on_batch: must be False, since crops depend on an image's boxes.
        keepdim: False gives an image without a batch dimension one.

    Raises:
        ValueError: if a setting is not as above, there are no boxes, or without ``size`` several images.

    Example:
        >>> from chiasm.augmentation import AugmentationSequential, SanitizeBoundingBoxes
        >>> augment = AugmentationSequential(
        ...     RandomIoUCrop(size=(8, 8)), SanitizeBoundingBoxes(), data_keys=["input", "bbox_xyxy", "class"]
        ... )
        >>> boxes, labels = [torch.tensor([[2.0, 3.0, 9.0, 9.0]])], [torch.tensor([7])]
        >>> image, boxes, labels = augment(torch.rand(1, 3, 20, 24), boxes, labels)
        >>> image.shape, len(boxes[0]) == len(labels[0])
        (torch.Size([1, 3, 8, 8]), True)
    """

    moves_edges = True
    size: List[int]

    def __init__(
        self,
        min_scale: float = 0.3,
        max_scale: float = 1.0,
        min_aspect_ratio: float = 0.5,
        max_aspect_ratio: float = 2.0,
        sampler_options: Optional[Sequence[float]] = None,
        trials: int = 40,
        size: Optional[Size] = None,
        resample: Any = "bilinear",
        same_on_batch: bool = False,
        keepdim: bool = True,
    ) -> None:
        super().__init__(resample, "border", False, 1.0, False, keepdim)
        if same_on_batch:
            raise ValueError("same_on_batch: expected False, for crops depend on an image's boxes, got True")
        self.min_scale, self.max_scale = number("min_scale", min_scale), number("max_scale", max_scale)
        self.min_aspect_ratio = number("min_aspect_ratio", min_aspect_ratio)
        self.max_aspect_ratio = number("max_aspect_ratio", max_aspect_ratio)
        if not 0.0 < self.min_scale <= self.max_scale <= 1.0:
            raise ValueError(
                f"min_scale, max_scale: expected least and greatest within (0, 1], got {min_scale} and"
                f" {max_scale}"
            )
        if not 0.0 < self.min_aspect_ratio <= self.max_aspect_ratio:
            raise ValueError(
                "min_aspect_ratio, max_aspect_ratio: expected least and greatest, both positive, got"
                f" {min_aspect_ratio} and {max_aspect_ratio}"
            )
        options = [0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0] if sampler_options is None else sampler_options
        self.options, self.trials = numbers("sampler_options", options), one_whole("trials", trials)
        if self.trials < 1:
            raise ValueError(f"trials: expected a positive number, got {trials}")
        self.rounds = 8  # how often an option is drawn before an image stays as it is
        self.size = [] if size is None else list(as_size(size, "size"))

    def draw_among(self, boxes: Tensor, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        """The crops "box" (B, 4), (left, top, width, height), of images of ``shape``, and "batch_prob" (B,).

        Args:
            boxes: (B, N, 4), floating point, the edges x1, y1, x2, y2. Boxes without an area do not count.
            seed: (B,), int64.
            shape: of the images, (B, C, H, W).
        """
        height, width, count = shape[2], shape[3], self.rounds * self.trials
        chosen = integers(seed, len(self.options), self.rounds)
        option = torch.tensor(self.options, dtype=torch.float64, device=seed.device)[chosen]  # (B, rounds)
        u = uniform(seed, 4 * count, 1).to(torch.float64).reshape(-1, self.rounds, self.trials, 4)
        sides = torch.tensor([width, height], dtype=torch.float64, device=seed.device)
        extent = torch.floor(between(u[..., :2], self.min_scale, self.max_scale) * sides)
        corner = torch.floor((sides - extent) * u[..., 2:])
        ratio = extent[..., 0] / extent[..., 1].clamp(min=1.0)
        fits = (extent >= 1.0).all(-1) & (ratio >= self.min_aspect_ratio) & (ratio <= self.max_aspect_ratio)
        crop = torch.cat([corner, corner + extent], -1)[..., None, :]
        given = boxes.to(torch.float64)[:, None, None]  # (B, rounds, trials, N, 4)
        inside = _centred_within(given, crop) & (box_areas(given) > 0.0)
        intersection, union = intersections_and_unions(given, crop)
        overlap = torch.where(inside, intersection / union.clamp(min=1e-12), -torch.ones_like(union))
        fits = fits & (overlap >= option[..., None, None]).any(-1)
        # The first round that leaves the image as it is, or has a crop that fits.
        ends = (option >= 1.0) | fits.any(-1)
        round_ = ends.to(torch.int64).argmax(1, keepdim=True)
        stays = (option >= 1.0).gather(1, round_)[:, 0] | ~ends.any(1)
        trial = fits.to(torch.int64).argmax(2).gather(1, round_)
        found = torch.cat([corner, extent], -1).flatten(1, 2)
        index = (round_ * self.trials + trial)[:, :, None].expand(-1, 1, 4)
        whole = torch.tensor([0, 0, width, height], dtype=torch.float64, device=seed.device)
        box = torch.where(stays[:, None], whole, found.gather(1, index)[:, 0])
        return {"batch_prob": ~stays, "box": box}

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        raise ValueError(
            "data_keys: expected 'bbox_xyxy' or 'bbox_xywh' in a sequence, for RandomIoUCrop needs boxes"
        )

    @torch.jit.unused
    def draw_beside(
        self, seed: Tensor, shape: List[int], keys: List[str], data: List[Any]
    ) -> Dict[str, Tensor]:
        place = next((i for i, key in enumerate(keys) if key.startswith("bbox")), -1)
        if place < 0:
            return self.draw(seed, shape)  # which raises
        given, key = data[place], keys[place]
        if isinstance(given, list):
            edges = [_edges(key, one) for one in given]
            return self.draw_among(torch.nn.utils.rnn.pad_sequence(edges, True), seed, shape)
        return self.draw_among(_edges(key, given), seed, shape)

    @torch.jit.unused
    def settled(self, keys: List[str], data: List[Any], params: Dict[str, Tensor]) -> List[Any]:
        height, width = self.cropped_size(params)
        frame = torch.tensor([0.0, 0.0, width, height])

        def clipped(key: str, boxes: Tensor, is_cropped: Tensor) -> Tensor:
            edges, whole = _edges(key, boxes), frame.to(boxes)
            inside = _centred_within(edges, whole)[..., None]
            kept = torch.minimum(edges.clamp(min=0.0), whole[[2, 3, 2, 3]])
            made = of_edges(key, torch.where(inside, kept, torch.zeros_like(edges)))
            return torch.where(is_cropped.reshape([-1] + [1] * (boxes.dim() - 1)), made, boxes)

        return [
            value
            if not key.startswith("bbox")
            else [clipped(key, one[None], params["batch_prob"][i : i + 1])[0] for i, one in enumerate(value)]
            if isinstance(value, list)
            else clipped(key, value, params["batch_prob"])
            for key, value in zip(keys, data)
        ]

    def cropped_size(self, params: Dict[str, Tensor]) -> List[int]:
        """Height and width of the result."""
        if len(self.size) == 2:
            return self.size
        if params["box"].size(0) != 1:
            raise ValueError(
                f"input: expected one image, for crops have different sizes without size; got"
                f" {params['box'].size(0)}"
            )
        return [int(params["box"][0, 3]), int(params["box"][0, 2])]

    def output_size(self, shape: List[int]) -> List[int]:
        return self.size

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        if len(self.size) == 2:
            return self.sampled(input, params, self.resample, self.fill_value)
        height, width = self.cropped_size(params)
        return cut(input, params["box"][:, :2].to(torch.int64), (height, width), "replicate", 0.0)

    @torch.jit.unused
    def transform_mask(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return super().transform_mask(input, params) if self.size else self.apply_transform(input, params)

    @torch.jit.unused
    def inverse_transform(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        if self.size:
            return within_box(super().inverse_transform(input, params, shape), params)
        corner = -params["box"][:, :2].to(torch.int64)
        return cut(input, corner, (shape[2], shape[3]), "constant", 0.0)

    @torch.jit.unused
    def inverse_mask(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return (
            within_box(super().inverse_mask(input, params, shape), params)
            if self.size
            else self.inverse_transform(input, params, shape)
        )

    def compute_transformation(self, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        if len(self.size) == 2:
            return resized_box(params, shape, (self.size[0], self.size[1]), False)
        matrix = identity(params["batch_prob"], 3).clone()
        matrix[:, :2, 2] = -params["box"][:, :2]
        return matrix

    def extra_repr(self) -> str:
        return shown(self, sampler_options=self.options, size=tuple(self.size) or None)


class SanitizeBoundingBoxes(AugmentationBase):
    """Remove boxes that are too small or reach beyond the image: torchvision's transform, a step of an
    ``AugmentationSequential`` after those that move boxes. Images stay as they are.

    Boxes in a list, a tensor for each image, are removed, with their entries of "class", if this is a list
    too, one tensor (N, ...) for each image. Of a tensor of boxes (B, N, ...) the number stays, as an exported
    graph needs it: boxes that do not pass become zeros. ``valid`` says which boxes pass.

    Args:
        min_size: the least width and height of a box, at least 1.
        min_area: the least area, at least 1.

    Raises:
        ValueError: if a setting is below 1, or "class" has other lengths than the boxes.

    Example:
        >>> from chiasm.augmentation import AugmentationSequential
        >>> sanitize = AugmentationSequential(SanitizeBoundingBoxes(2.0), data_keys=["input", "bbox_xyxy"])
        >>> sanitize(torch.rand(1, 3, 8, 8), [torch.tensor([[0.0, 0.0, 4.0, 1.0], [0.0, 0.0, 4.0, 2.0]])])[1]
        [tensor([[0., 0., 4., 2.]])]
    """

    moves_edges = True

    def __init__(self, min_size: float = 1.0, min_area: float = 1.0) -> None:
        super().__init__(1.0)
        self.min_size, self.min_area = number("min_size", min_size), number("min_area", min_area)
        if self.min_size < 1.0 or self.min_area < 1.0:
            raise ValueError(f"min_size, min_area: expected at least 1, got {min_size} and {min_area}")

    def valid(self, boxes: Tensor, height: int, width: int) -> Tensor:
        """(*, N), bool: whether boxes pass.

        Args:
            boxes: (*, N, 4), floating point, the edges x1, y1, x2, y2.
            height, width: of the images.
        """
        x1, y1, x2, y2 = boxes[..., 0], boxes[..., 1], boxes[..., 2], boxes[..., 3]
        large = (x2 - x1 >= self.min_size) & (y2 - y1 >= self.min_size)
        large = large & (box_areas(boxes) >= self.min_area)
        return large & (x1 >= 0.0) & (y1 >= 0.0) & (x2 <= width) & (y2 <= height)

    @torch.jit.unused
    def settled(self, keys: List[str], data: List[Any], params: Dict[str, Tensor]) -> List[Any]:
        height, width = [int(n) for n in params["forward_input_shape"][-2:]]
        made, kept, stays = list(data), None, ~params["batch_prob"]
        for i, (key, value) in enumerate(zip(keys, data)):
            if not key.startswith("bbox"):
                continue
            if isinstance(value, list):
                kept = [self.valid(_edges(key, one), height, width) | stay for one, stay in zip(value, stays)]
                made[i] = [one[valid] for one, valid in zip(value, kept)]
            else:
                valid = self.valid(_edges(key, value), height, width) | stays[:, None]
                valid = valid.reshape(list(valid.shape) + [1] * (value.dim() - valid.dim()))
                made[i] = torch.where(valid, value, torch.zeros_like(value))
        for i, (key, value) in enumerate(zip(keys, data)):
            if key == "class" and kept is not None and isinstance(value, (list, tuple)):
                lengths = [len(one) for one in value]
                if lengths != [len(valid) for valid in kept]:
                    raise ValueError(
                        f"class: expected as many entries as boxes, {[len(v) for v in kept]}, got {lengths}"
                    )
                made[i] = [one[valid] for one, valid in zip(value, kept)]
        return made


def _centred_within(boxes: Tensor, frame: Tensor) -> Tensor:
    """(*, N), bool: whether the centres of boxes (*, N, 4) lie strictly within frames that broadcast."""
    centre = 0.5 * (boxes[..., :2] + boxes[..., 2:])
    return ((centre > frame[..., :2]) & (centre < frame[..., 2:])).all(-1)


def _edges(key: str, boxes: Tensor) -> Tensor:
    """``edges_of`` boxes that may become empty, which those of "bbox", whole pixels, can't."""
    if key == "bbox":
        raise ValueError(
            "data_keys: expected 'bbox_xyxy' or 'bbox_xywh' beside a step that empties boxes, got 'bbox'"
        )
    return edges_of(key, boxes)
