"""The classes of mixes, with Kornia's constructors; labels, masks and boxes are mixed with their images."""

from typing import Any, ClassVar, Dict, List, Optional, Sequence, Tuple

import torch
from torch import Tensor, nn

from ..primitives.core.broadcasting import each
from ..primitives.core.checks import check_rank, check_tensor
from ..primitives.core.modules import Module
from ..primitives.random.draws import uniform
from .annotations import check_value, edges_of, of_edges
from .base import AugmentationBase2D, as_size, draw_seeds, shape_of
from .decisions import check_chance
from .keys import keys_of_call, read_keys
from .mix import (
    jigsaw_order,
    put_together,
    random_cut_mix,
    random_mix_up,
    random_transplantation,
    random_transplantation3d,
)
from .mosaic import boxes_of_mosaic, check_mosaic, cut_at_corner, cut_out_of_mosaic, mosaic_parameters
from .settings import fixed, number, one_whole, whole, whole_numbers


class MixAugmentationBase(Module):
    """Random mixes of a batch's images and of their labels or masks. ``forward(input, other, seed)`` can be
    scripted and exported.

    A call takes the tensors that ``data_keys`` names, in that order, and returns one tensor or a list. It
    draws the seeds if none are given, and keeps them: ``mix(other, params=mix._params)`` repeats the same
    mix.
    """

    #: The data keys that a call may take.
    known: ClassVar[Tuple[str, ...]] = ("input", "class")
    #: The parameters of the last call.
    _params: Dict[str, Tensor]

    def __init__(
        self,
        p: float = 1.0,
        same_on_batch: bool = False,
        keepdim: bool = False,
        data_keys: Sequence[Any] = ("input", "class"),
    ) -> None:
        super().__init__()
        self.p, self.same_on_batch, self.keepdim = number("p", p), same_on_batch, keepdim
        check_chance(self.p)
        check_seeds_differ(same_on_batch)
        self.data_keys, self._params = read_keys(data_keys, self.known), {}

    def __call__(
        self,
        *args: Tensor,
        params: Optional[Dict[str, Tensor]] = None,
        data_keys: Optional[Sequence[Any]] = None,
        seed: Optional[Tensor] = None,
        generator: Optional[torch.Generator] = None,
    ) -> Any:
        """The tensors that ``data_keys`` names, mixed.

        Args:
            args: the tensors, or the arguments of ``forward``.
            params: the parameters of an earlier call (its ``_params``).
            data_keys: as in the constructor, for this call.
            seed: (B,), int64, all different: all random numbers are drawn from it.
            generator: draws the seeds if none are given; PyTorch's default generator if None.
        """
        if len(args) == 3 != len(self.data_keys) and data_keys is None and seed is None:
            return super().__call__(*args)
        keys = keys_of_call(self.data_keys, data_keys, self.known, len(args))
        if params is not None:
            seed = params["seed"]
        image = args[keys.index("input")]
        if seed is None:
            seed = draw_seeds(image.size(0), generator).to(image.device)
        self._params = {"seed": seed}
        mixed = self.mixed(keys, list(args), seed)
        return mixed[0] if len(mixed) == 1 else mixed

    def mixed(self, keys: List[str], data: List[Tensor], seed: Tensor) -> List[Tensor]:
        """The results of a call."""
        first = keys.index("input")
        label = data[keys.index("class")] if "class" in keys else torch.zeros_like(seed)
        image, labels = super().__call__(data[first], label, seed)
        made = {"class": labels}
        _check_beside(keys, data, data[first])
        return [
            image if i == first else made[key] if key in made else self.along(value, label, seed)
            for i, (key, value) in enumerate(zip(keys, data))
        ]

    def along(self, value: Tensor, other: Tensor, seed: Tensor) -> Tensor:
        """A label mask (B, C, *) or a further image, mixed in the same way as the images; whole numbers are
        rounded."""
        if value.is_floating_point() or value.dtype == torch.uint8:
            return super().__call__(value, other, seed)[0]
        return super().__call__(value.to(torch.float64), other, seed)[0].round().to(value.dtype)


class RandomMixUpV2(MixAugmentationBase):
    """``random_mix_up`` as a module.

    Args:
        lambda_val: (least, greatest) share of the partner, within [0, 1]; (0, 1) by default.
        same_on_batch: must be False, since the seeds that draw the partners must differ.
        p: the probability of each sample.
        keepdim: for compatibility with Kornia; it has no effect.
        data_keys: the arguments of a call: "input" and, if wanted, "class".

    Example:
        >>> images, labels = RandomMixUpV2()(torch.rand(4, 3, 8, 9), torch.arange(4))
        >>> images.shape, labels.shape
        (torch.Size([4, 3, 8, 9]), torch.Size([4, 3]))
        >>> RandomMixUpV2(data_keys=["input"])(torch.rand(4, 3, 8, 9)).shape
        torch.Size([4, 3, 8, 9])
    """

    def __init__(
        self,
        lambda_val: Optional[Any] = None,
        same_on_batch: bool = False,
        p: float = 1.0,
        keepdim: bool = False,
        data_keys: Sequence[Any] = ("input", "class"),
    ) -> None:
        super().__init__(p, same_on_batch, keepdim, data_keys)
        self.lambda_val = (0.0, 1.0) if lambda_val is None else fixed("lambda_val", lambda_val)

    def forward(self, input: Tensor, label: Tensor, seed: Tensor) -> Tuple[Tensor, Tensor]:
        return random_mix_up(input, label, seed, self.lambda_val, self.p)


class RandomCutMixV2(MixAugmentationBase):
    """``random_cut_mix`` as a module.

    Args:
        num_mix, use_correct_lambda: as in ``random_cut_mix``.
        cut_size: (least, greatest) of l, within [0, 1]; (0, 1) by default.
        beta: the parameter of the distribution of l; 1 by default.
        same_on_batch: must be False, since the seeds that draw the partners must differ.
        p: the probability of each sample.
        keepdim: for compatibility with Kornia; it has no effect.
        data_keys: the arguments of a call: "input" and, if wanted, "class" and "mask" (B, C, H, W), in which
            the same rectangles are pasted.

    Example:
        >>> mix = RandomCutMixV2(data_keys=["input", "mask", "class"])
        >>> image, mask, labels = mix(torch.rand(4, 3, 8, 9), torch.zeros(4, 1, 8, 9).long(), torch.arange(4))
        >>> mask.shape, labels.shape
        (torch.Size([4, 1, 8, 9]), torch.Size([1, 4, 3]))
    """

    known = ("input", "mask", "class")

    def __init__(
        self,
        num_mix: int = 1,
        cut_size: Optional[Any] = None,
        beta: Optional[float] = None,
        same_on_batch: bool = False,
        p: float = 1.0,
        keepdim: bool = False,
        data_keys: Sequence[Any] = ("input", "class"),
        use_correct_lambda: bool = False,
    ) -> None:
        super().__init__(p, same_on_batch, keepdim, data_keys)
        self.num_mix = one_whole("num_mix", num_mix)
        self.beta = 1.0 if beta is None else number("beta", beta)
        self.cut_size = (0.0, 1.0) if cut_size is None else fixed("cut_size", cut_size)
        self.use_correct_lambda = bool(use_correct_lambda)

    def forward(self, input: Tensor, label: Tensor, seed: Tensor) -> Tuple[Tensor, Tensor]:
        correct = self.use_correct_lambda
        return random_cut_mix(input, label, seed, self.num_mix, self.cut_size, self.beta, correct, self.p)


class RandomTransplantation(MixAugmentationBase):
    """``random_transplantation`` as a module: ``forward(input, mask, seed)``.

    Args:
        excluded_labels: labels that are not copied; none by default.
        p: the probability of each sample.
        p_batch: the probability that the batch is changed at all; the first sample's seed decides.
        data_keys: the arguments of a call: at least one "input" and one "mask". The first mask, (B, H, W) or
            (B, 1, H, W), whole numbers, selects the copied region, also for further images and masks.

    Example:
        >>> image, mask = RandomTransplantation([0], p=1.0)(
        ...     torch.rand(2, 3, 8, 9), torch.ones(2, 8, 9).long()
        ... )
        >>> image.shape, mask.shape
        (torch.Size([2, 3, 8, 9]), torch.Size([2, 8, 9]))
    """

    known = ("input", "mask")
    excluded_labels: List[int]

    def __init__(
        self,
        excluded_labels: Optional[Any] = None,
        p: float = 0.5,
        p_batch: float = 1.0,
        data_keys: Optional[Sequence[Any]] = None,
    ) -> None:
        super().__init__(p, data_keys=("input", "mask") if data_keys is None else data_keys)
        none = excluded_labels is None or (isinstance(excluded_labels, (list, tuple)) and not excluded_labels)
        self.excluded_labels = [] if none else whole_numbers("excluded_labels", excluded_labels)
        self.p_batch = number("p_batch", p_batch)
        check_chance(self.p_batch, "p_batch")

    def forward(self, input: Tensor, mask: Tensor, seed: Tensor) -> Tuple[Tensor, Tensor]:
        return self.of_batch(
            random_transplantation(input, mask, seed, self.excluded_labels, self.p), input, mask, seed
        )

    def of_batch(
        self, changed: Tuple[Tensor, Tensor], input: Tensor, mask: Tensor, seed: Tensor
    ) -> Tuple[Tensor, Tensor]:
        """The changed tensors, or the unchanged ones if ``p_batch`` leaves the batch out."""
        if self.p_batch >= 1.0:
            return changed
        chosen = uniform(seed[:1], 1, 1048576)[:, 0] < self.p_batch  # the stream of AugmentationBase
        image, labels = changed
        return torch.where(each(chosen, input), image, input), torch.where(each(chosen, mask), labels, mask)

    @torch.jit.unused
    def mixed(self, keys: List[str], data: List[Tensor], seed: Tensor) -> List[Tensor]:
        if "mask" not in keys:
            raise ValueError(f"data_keys: expected a 'mask', which says what is copied, got {keys}")
        first, leading = keys.index("input"), keys.index("mask")
        rank = data[first].dim() - 1
        mask = data[leading].squeeze(1) if data[leading].dim() > rank else data[leading]
        if mask.is_floating_point():
            raise TypeError(f"mask: expected whole numbers, got dtype {mask.dtype}")
        mask = mask.to(torch.int64)
        image, labels = nn.Module.__call__(self, data[first], mask, seed)
        found: List[Tensor] = []
        for i, value in enumerate(data):
            if i == first:
                found.append(image)
            elif i == leading:
                found.append(labels.to(value.dtype).reshape(value.shape))
            else:
                planes = value if value.dim() > rank else value.unsqueeze(1)
                _check_beside([keys[i]], [planes], data[first])
                found.append(self.along(planes, mask, seed).reshape(value.shape))
        return found


class RandomTransplantation3D(RandomTransplantation):
    """``random_transplantation3d`` as a module, with the arguments of ``RandomTransplantation``.

    Example:
        >>> mask = torch.ones(2, 4, 8, 9).long()
        >>> RandomTransplantation3D([0], p=1.0)(torch.rand(2, 3, 4, 8, 9), mask)[0].shape
        torch.Size([2, 3, 4, 8, 9])
    """

    def forward(self, input: Tensor, mask: Tensor, seed: Tensor) -> Tuple[Tensor, Tensor]:
        return self.of_batch(
            random_transplantation3d(input, mask, seed, self.excluded_labels, self.p), input, mask, seed
        )


class TileAugmentationBase(AugmentationBase2D):
    """Random changes that move parts of images, so that no single matrix can map boxes and points.

    A call takes the tensors that ``data_keys`` names, in that order, and returns one tensor or a list.
    """

    known: ClassVar[Tuple[str, ...]] = ("input", "mask")

    def __init__(
        self, p: float, same_on_batch: bool, keepdim: bool, data_keys: Sequence[Any] = ("input",)
    ) -> None:
        super().__init__(p, 1.0, same_on_batch, keepdim)
        self.data_keys = read_keys(data_keys, self.known)

    def __call__(
        self,
        *args: Tensor,
        params: Optional[Dict[str, Tensor]] = None,
        data_keys: Optional[Sequence[Any]] = None,
        seed: Optional[Tensor] = None,
        generator: Optional[torch.Generator] = None,
    ) -> Any:
        """The tensors that ``data_keys`` names, changed.

        Args:
            args: the tensors; for one sample, each may come without its batch dimension.
            params, seed, generator: as in ``AugmentationBase``.
            data_keys: as in the constructor, for this call.
        """
        keys = keys_of_call(self.data_keys, data_keys, self.known, len(args))
        first = keys.index("input")
        check_tensor(args[first], "input")
        alone = args[first].dim() == self.rank - 1
        data = [value[None] if alone else value for value in args]
        check_rank(data[first], self.rank, "(B, C, H, W) or (C, H, W)", "input")
        _check_beside(keys, data, data[first])
        image = self.change(data[first], params, seed, generator)
        made = [
            image if i == first else self.along(key, value, self._params, shape_of(self._params))
            for i, (key, value) in enumerate(zip(keys, data))
        ]
        made = [value[0] for value in made] if alone and self.keepdim else made
        return made[0] if len(made) == 1 else made

    @torch.jit.unused
    def along(self, key: str, value: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        """A mask or boxes of images of ``shape``, changed in the same way as the images."""
        return self.apply_transform(value, params)

    @torch.jit.unused
    def transform_mask(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return self.apply_transform(input, params)

    @torch.jit.unused
    def compute_transformation(self, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        raise ValueError(
            f"{type(self).__name__}: it moves parts of images, so that no matrix says where boxes and points"
            " go in a sequence: expected data_keys 'input' and 'mask'"
        )


class RandomJigsaw(TileAugmentationBase):
    """``random_jigsaw`` as a module.

    Args:
        grid, ensure_perm: as in ``random_jigsaw``.
        data_keys: the arguments of a call: "input" and, if wanted, "mask" (B, C, H, W).
        p, same_on_batch, keepdim: as in ``AugmentationBase``.

    Example:
        >>> RandomJigsaw((1, 2), p=1.0)(torch.tensor([[[[1.0, 2.0]]]]))
        tensor([[[[2., 1.]]]])
    """

    def __init__(
        self,
        grid: Tuple[int, int] = (4, 4),
        data_keys: Sequence[Any] = ("input",),
        p: float = 0.5,
        same_on_batch: bool = False,
        keepdim: bool = False,
        ensure_perm: bool = True,
    ) -> None:
        super().__init__(p, same_on_batch, keepdim, data_keys)
        self.grid, self.ensure_perm = whole("grid", grid), bool(ensure_perm)

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        is_changed = uniform(seed, 1)[:, 0] < self.p
        every = torch.ones_like(is_changed)
        return {
            "batch_prob": is_changed,
            "permutation": jigsaw_order(seed, self.grid, self.ensure_perm, every),
        }

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return put_together(input, self.order(params), self.grid)

    def order(self, params: Dict[str, Tensor]) -> Tensor:
        """The index of the tile for each place, (B, tiles)."""
        place = torch.arange(self.grid[0] * self.grid[1], device=params["permutation"].device)
        return torch.where(params["batch_prob"][:, None], params["permutation"], place)

    @torch.jit.unused
    def inverse_transform(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return put_together(input, self.order(params).argsort(1), self.grid)


class RandomMosaic(TileAugmentationBase):
    """``random_mosaic`` as a module.

    Args:
        output_size, mosaic_grid, start_ratio_range, padding_mode: as in ``random_mosaic``.
        min_bbox_size: boxes with a smaller visible area, in pixels, become 0.
        data_keys: the arguments of a call: "input" and, if wanted, "mask" (B, C, H, W), "bbox_xyxy",
            "bbox_xywh" (B, N, 4) with the edges of boxes and "bbox" (B, N, 4, 2) with the centres of corner
            pixels. In the result, a sample has the boxes of all tiles, tile by tile, (B, tiles * N, ...),
            clipped to the visible part; boxes that are not visible are 0.
        p, keepdim: as in ``AugmentationBase``.
        resample, align_corners, cropping_mode: for compatibility with Kornia; they have no effect, since a
            box begins at a whole pixel.

    Example:
        >>> mosaic = RandomMosaic((30, 40), data_keys=["input", "bbox_xyxy"])
        >>> image, boxes = mosaic(
        ...     torch.rand(8, 3, 24, 24), torch.tensor([[7.0, 5.0, 15.0, 10.0]]).expand(8, 1, 4)
        ... )
        >>> image.shape, boxes.shape
        (torch.Size([8, 3, 30, 40]), torch.Size([8, 4, 4]))
    """

    known = ("input", "mask", "bbox", "bbox_xyxy", "bbox_xywh")

    def __init__(
        self,
        output_size: Optional[Tuple[int, int]] = None,
        mosaic_grid: Tuple[int, int] = (2, 2),
        start_ratio_range: Tuple[float, float] = (0.3, 0.7),
        min_bbox_size: float = 0.0,
        data_keys: Sequence[Any] = ("input",),
        p: float = 0.7,
        keepdim: bool = False,
        padding_mode: str = "constant",
        resample: Any = "bilinear",
        align_corners: bool = True,
        cropping_mode: str = "slice",
    ) -> None:
        super().__init__(p, False, keepdim, data_keys)
        self.output_size: Optional[Tuple[int, int]] = (
            None if output_size is None else as_size(output_size, "output_size")
        )
        self.mosaic_grid = whole("mosaic_grid", mosaic_grid)
        self.start_ratio_range = fixed("start_ratio_range", start_ratio_range)
        self.min_bbox_size, self.padding_mode = number("min_bbox_size", min_bbox_size), padding_mode
        check_mosaic(self.mosaic_grid, self.start_ratio_range, padding_mode)

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        check_seeds_differ(self.same_on_batch)  # a sequence may have set it
        params = mosaic_parameters(seed, shape[2], shape[3], self.mosaic_grid, self.start_ratio_range)
        params["batch_prob"] = uniform(seed, 1)[:, 0] < self.p
        return params

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        changed = cut_out_of_mosaic(input, params, self.output_size, self.mosaic_grid, self.padding_mode)
        chosen = each(params["batch_prob"], input)
        return torch.where(chosen, changed, cut_at_corner(input, self.output_size))

    @torch.jit.unused
    def along(self, key: str, value: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        if not key.startswith("bbox"):
            return self.apply_transform(value, params)
        size, grid, least = self.output_size, self.mosaic_grid, self.min_bbox_size
        seen = boxes_of_mosaic(edges_of(key, value), params, shape[2], shape[3], size, grid, least)
        return of_edges(key, seen)

    @torch.jit.unused
    def inverse_transform(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        raise ValueError("RandomMosaic: parts of images are lost, so that there is no way back")


def _check_beside(keys: List[str], data: List[Any], image: Tensor) -> None:
    """Raise unless what belongs to images (B, C, ...) is of as many samples, and masks of the same size."""
    for key, value in zip(keys, data):
        check_tensor(value, key)  # mixes take no lists of boxes
        check_value(key, value, image.size(0), list(image.shape[2:]), image.dim())


def check_seeds_differ(same_on_batch: bool) -> None:
    """Raise ValueError if all samples would draw from one seed."""
    if same_on_batch:
        raise ValueError("same_on_batch: expected False, for partners are drawn by seeds that differ")
