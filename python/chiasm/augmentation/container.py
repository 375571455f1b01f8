"""Sequences of augmentations, for images with their masks, boxes and keypoints."""

from typing import Any, Dict, List, Optional, Sequence, Tuple, Union, cast

import torch
from torch import Tensor, nn

from ..geometry.held import Held
from ..primitives.core.checks import check_rank
from ..primitives.random.draws import check_seed, integers, ranks, split, uniform
from .annotations import as_movable, check_value, is_single, moved_coordinates
from .base import AugmentationBase, ImagesOnly, Seeded, draw_seeds, identity, refusal, select, shape_of
from .crop import RandomResizedCrop
from .cut import Cut
from .cut3d import Cut3D
from .drawn_sizes import Sized
from .iou_crop import RandomIoUCrop
from .keys import keys_of_call, on_dict, on_held, read_keys
from .mixing import MixAugmentationBase, RandomMosaic
from .patch_mix import PatchMix
from .resizing import Resize
from .settings import numbers, whole_numbers

#: The number of steps to apply: a number, (least, greatest), (least,), or False for all.
Some = Union[bool, int, Tuple[int, ...]]

_KEYS = ("input", "mask", "bbox", "bbox_xyxy", "bbox_xywh", "keypoints", "class")


class Fixed(AugmentationBase):
    """A module that draws nothing, as a step of a sequence."""

    def __init__(self, module: nn.Module) -> None:
        super().__init__(1.0)
        self.module = module

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return self.module(input)


class Nested(ImagesOnly):
    """A sequence as a step of another sequence, for images only."""

    def __init__(self, sequence: Seeded) -> None:
        super().__init__(1.0)
        self.sequence, self.rank, self.title = sequence, sequence.rank, type(sequence).__name__

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        return {"batch_prob": torch.ones_like(seed, dtype=torch.bool), "draws": seed}

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return self.sequence.forward(input, params["draws"])


def _steps(module: nn.Module, whole: bool) -> List[AugmentationBase]:
    """A module as a list of steps; with ``whole`` a sequence stays one step, so that it is chosen as a
    whole."""
    if isinstance(module, AugmentationSequential):
        return [Nested(module)] if whole or module.some else module._typed()
    return [_step(module)]


def _step(module: nn.Module) -> AugmentationBase:
    if not isinstance(module, nn.Module):
        raise TypeError(f"args: expected modules, got {type(module).__name__}")
    if isinstance(module, MixAugmentationBase):
        raise ValueError(
            f"args: expected augmentations of images alone; call {type(module).__name__}, which takes"
            f" {list(module.known)}, after the sequence"
        )
    if isinstance(module, Seeded):
        return Nested(module)
    return module if isinstance(module, AugmentationBase) else Fixed(module)


def _share(step: AugmentationBase, same_on_batch: bool) -> None:
    """Set ``same_on_batch`` of a step, and of all that is in a sequence which is a step."""
    if same_on_batch and isinstance(step, RandomIoUCrop):
        raise ValueError("same_on_batch: expected False, for crops depend on an image's boxes, got True")
    step.same_on_batch = same_on_batch
    if isinstance(step, Nested) and not same_on_batch:  # if True, all samples have one seed there
        for inner in step.sequence.modules():
            if hasattr(inner, "same_on_batch"):
                cast("Any", inner).same_on_batch = False


class Chosen(nn.Module):
    """Chooses the steps that are applied to each sample: (steps, B), bool.

    Steps are drawn without replacement; each draw has probabilities proportional to the weights of the
    remaining steps. This is the same as to take the steps with the greatest u^(1/w). P. Efraimidis, P.
    Spirakis, Weighted random sampling with a reservoir, Information Processing Letters 97(5), 2006.
    """

    exponents: List[float]

    def __init__(
        self, least: int, greatest: int, weights: Sequence[float], same_on_batch: bool = False
    ) -> None:
        super().__init__()
        self.least, self.greatest, self.same_on_batch = least, greatest, same_on_batch
        self.exponents = [1.0 / w for w in weights]

    def forward(self, seed: Tensor) -> Tensor:
        if self.same_on_batch:
            seed = seed[:1].expand(seed.size(0))
        count = self.least + integers(seed, self.greatest - self.least + 1, 1, 1)
        drawn = torch.log(1.0 - uniform(seed, len(self.exponents)))
        keys = drawn * torch.tensor(self.exponents, dtype=drawn.dtype, device=seed.device)
        return (ranks(-keys) < count).t()


class AugmentationSequential(Seeded):
    """Apply augmentations one after the other; each has its own seeds, which are computed from the sample's
    seed.

    ``forward(input, seed)`` takes images; it can be scripted, and exported as one bundle of the whole
    pipeline. A call takes the tensors that ``data_keys`` names, draws the seeds, and moves masks, boxes and
    keypoints with their images.

    Args:
        args: augmentations, sequences of them, and modules that take only an image (``enhance.Normalize``).
        data_keys: the arguments of a call: "input" (or "image"), and any number of "mask" (B, C, H, W) of
            any dtype, "bbox" (B, N, 4, 2) with the centres of corner pixels, "bbox_xyxy" and "bbox_xywh" (B,
            N, 4) with the edges of boxes, "keypoints" (B, N, 2), and "class" (or "label"), which stays as it
            is. Boxes and keypoints may be a list of B tensors (N, ...) of different lengths, or ``Boxes`` and
            ``Keypoints`` of ``geometry``; of whole numbers they become float32. A second "input" is changed
            as the first one. A call also takes a dict, whose keys are these words, maybe with "_" or "-" and
            more ("mask_left"); other items stay as they are.
        same_on_batch: True or False overrides the setting of each augmentation; with True, all samples go
            through the same steps of ``random_apply``.
        keepdim: True returns an image without a batch dimension for an image without one.
        random_apply: how many steps are applied to each sample, in their order: a number, (least, greatest),
            or (least,) for at least so many; False for all.
        random_apply_weights: how likely each step is to be chosen, positive numbers; equal by default.

    Example:
        >>> from chiasm.augmentation import RandomHorizontalFlip
        >>> augment = AugmentationSequential(RandomHorizontalFlip(p=1.0), data_keys=["input", "bbox_xyxy"])
        >>> image, boxes = augment(torch.rand(1, 3, 4, 10), torch.tensor([[[0.0, 0.0, 3.0, 4.0]]]))
        >>> boxes
        tensor([[[ 7.,  0., 10.,  4.]]])
    """

    #: The parameters of the last call, for each step.
    _params: List[Dict[str, Tensor]]

    def __init__(
        self,
        *args: nn.Module,
        data_keys: Optional[Sequence[str]] = ("input",),
        same_on_batch: Optional[bool] = None,
        keepdim: bool = False,
        random_apply: Some = False,
        random_apply_weights: Optional[Sequence[float]] = None,
    ) -> None:
        super().__init__()
        steps = [step for module in args for step in _steps(module, random_apply is not False)]
        if same_on_batch is not None:
            for step in steps:
                _share(step, same_on_batch)
        self.rank = max((step.rank for step in steps), default=4)
        self.steps = nn.ModuleList(steps)
        self.some = random_apply is not False
        self.chosen = _chosen(steps, random_apply, random_apply_weights, same_on_batch is True)
        self.data_keys = ["input"] if data_keys is None else read_keys(data_keys, _KEYS)
        self.same_on_batch, self.keepdim = same_on_batch, keepdim
        self.random_apply, self.random_apply_weights = random_apply, random_apply_weights
        self._params = []

    def forward(self, input: Tensor, seed: Tensor) -> Tensor:
        """The images, changed according to ``seed`` (B,), int64."""
        check_seed(seed, input.size(0))
        seeds = split(seed, len(self.steps) + 1)  # the last draws which steps
        chosen = self.chosen(seeds[-1]) if self.some else None
        for i, step in enumerate(self.steps):
            before = input
            input = step.forward(input, seeds[i])
            if chosen is not None:
                input = select({"batch_prob": chosen[i]}, input, before)
        return input

    def __call__(
        self,
        *args: Any,
        params: Optional[List[Dict[str, Tensor]]] = None,
        data_keys: Optional[Sequence[str]] = None,
        seed: Optional[Tensor] = None,
        generator: Optional[torch.Generator] = None,
    ) -> Any:
        """The data that ``data_keys`` names, changed: one tensor, or a list.

        Args:
            args: the data, or a dict of it. An exported or scripted sequence takes images and seeds.
            params: the parameters of an earlier call (its ``_params``).
            data_keys: as in the constructor, for this call; those of a dict are its own.
            seed: (B,), int64: all random numbers are drawn from it.
            generator: draws the seeds if none are given; PyTorch's default generator if None.

        Raises:
            TypeError: if an argument is not a tensor.
            ValueError: if a shape, a key or ``params`` is not as above.
        """
        if len(args) == 1 and isinstance(args[0], dict):
            return on_dict(self.__call__, args[0], _KEYS, params=params, seed=seed, generator=generator)
        if len(args) == 2 and self.data_keys == ["input"] and data_keys is None and seed is None:
            return super().__call__(args[0], args[1])  # forward's own arguments, images and seeds
        keys = keys_of_call(self.data_keys, data_keys, _KEYS, len(args))
        if any(isinstance(arg, Held) for arg in args):
            return on_held(self.__call__, args, keys, params=params, seed=seed, generator=generator)
        data, single = self._batched(keys, args)
        first = keys.index("input")
        if params is not None:
            self._check_params(params)
            if seed is None:  # nothing is drawn from it
                seed = torch.zeros(data[first].size(0), dtype=torch.int64, device=data[first].device)
        elif seed is None:
            seed = draw_seeds(data[first].size(0), generator).to(data[first].device)
        check_seed(seed, data[first].size(0))
        self._params = []
        seeds = split(seed, len(self.steps) + 1)  # the last draws which steps
        chosen = self.chosen(seeds[-1]) if self.some else None
        for i, step in enumerate(self._typed()):
            shape = list(data[first].shape)
            if params is not None:
                given = params[i]
            else:
                given = {**step.draw_beside(seeds[i], shape, keys, data), "seed": seeds[i]}
                if chosen is not None:
                    given["batch_prob"] &= chosen[i]
            image = self._changed(step, data[first], step.change(data[first], given, seeds[i]))
            self._params.append(step._params)
            matrix = _matrix(step, step._params, shape, keys)
            data = [
                image if n == first else self._along(step, key, value, matrix)
                for n, (key, value) in enumerate(zip(keys, data))
            ]
            data = step.settled(keys, data, step._params)
        return self._as_given(keys, args, data, single)

    def inverse(
        self,
        *args: Any,
        params: Optional[List[Dict[str, Tensor]]] = None,
        data_keys: Optional[Sequence[str]] = None,
    ) -> Any:
        """Undo the geometric changes of the last call (or of ``params``); pixel values are not restored.

        Content that was moved out of an image is lost. ``data_keys`` may leave out "input" here.

        Raises:
            TypeError: if an argument is not a tensor.
            ValueError: if a shape or a key is not that of a call, or if there are no parameters.
        """
        if len(args) == 1 and isinstance(args[0], dict):
            return on_dict(self.inverse, args[0], _KEYS, params=params)
        keys = keys_of_call(self.data_keys, data_keys, _KEYS, len(args), with_image=False)
        if any(isinstance(arg, Held) for arg in args):
            return on_held(self.inverse, args, keys, params=params)
        params = self._params if params is None else params
        self._check_params(params)
        data, single = self._batched(keys, args, shape_of(params[0])[0] if params else -1)
        for step, given in list(zip(self._typed(), params))[::-1]:
            shape = shape_of(given)
            matrix = torch.linalg.inv(_matrix(step, given, shape, keys))
            data = [_back(step, key, value, given, shape, matrix) for key, value in zip(keys, data)]
        return self._as_given(keys, args, data, single)

    def __len__(self) -> int:
        return len(self.steps)

    def __getitem__(self, index: int) -> nn.Module:
        """A step, as it was given."""
        step = self._typed()[index]
        if isinstance(step, Fixed):
            return step.module
        return step.sequence if isinstance(step, Nested) else step

    def _check_params(self, params: Any) -> None:
        """Raise unless there are parameters of a call for each step."""
        count = len(self.steps)
        if not isinstance(params, (list, tuple)) or len(params) != count:
            got = len(params) if isinstance(params, (list, tuple)) else type(params).__name__
            raise ValueError(
                f"params: expected those of a call, one dict for each of {count} steps, got {got}"
            )

    def _batched(self, keys: List[str], args: Sequence[Any], batch: int = -1) -> Tuple[List[Any], List[bool]]:
        """The data of a call with the batch's dimension, checked, and what came without it. ``batch`` is the
        number of images of the call before, -1 if there was none."""
        rank = self.rank
        leading = keys.index("input") if "input" in keys else 0
        alone = is_single(keys[leading], args[leading], rank)
        single = [alone and is_single(key, value, rank) for key, value in zip(keys, args)]
        data = [value[None] if one else value for value, one in zip(args, single)]
        spatial: List[int] = []
        if "input" in keys:
            image = data[leading]
            check_rank(image, rank, "(B, C, D, H, W)" if rank == 5 else "(B, C, H, W)", "input")
            check_value("input", image, image.size(0) if batch < 0 else batch, [], rank)
            batch, spatial = image.size(0), list(image.shape[2:])
        for key, value in zip(keys, data):
            check_value(key, value, batch, spatial, rank)
        return [as_movable(key, value) for key, value in zip(keys, data)], single

    def _as_given(self, keys: List[str], args: Sequence[Any], data: List[Any], single: List[bool]) -> Any:
        """The result of a call: masks of their dtype, without the batch's dimension what came without it if
        ``keepdim``; one value, or a list."""
        made = [d.view(a.dtype) if key == "mask" else d for key, a, d in zip(keys, args, data)]
        made = [value[0] if one and self.keepdim else value for value, one in zip(made, single)]
        return made[0] if len(made) == 1 else made

    def _changed(self, step: AugmentationBase, before: Tensor, after: Tensor) -> Tensor:
        """The images after a step; those that are not chosen stay, also if the step draws nothing."""
        return select(step._params, after, before) if self.some else after

    def _along(self, step: AugmentationBase, key: str, value: Any, matrix: Tensor) -> Any:
        """What belongs to images, after the step that has just changed them."""
        if key == "class":
            return value
        if key == "input":
            return self._changed(step, value, step.apply_transform(value, step._params))
        return (
            step.transform_mask(value, step._params)
            if key == "mask"
            else moved_coordinates(key, value, matrix, step.moves_edges)
        )

    @property
    def transform_matrix(self) -> Tensor:
        """The homographies (B, 3, 3), float64, of the last call: they map input pixels (x, y, 1) to output
        pixels."""
        total = None
        for step, given in zip(self._typed(), self._params):
            try:
                matrix = step.compute_transformation(given, shape_of(given))
            except ValueError as error:  # TorchScript asks for every property
                raise AttributeError(f"transform_matrix: {error}") from error
            total = matrix if total is None else matrix @ total
        if total is None:
            raise AttributeError("transform_matrix: expected a call before")
        return total

    __jit_unused_properties__ = ("transform_matrix",)

    def _typed(self) -> List[AugmentationBase]:
        """The steps with their type, which a type checker does not know of a ModuleList."""
        return cast("List[AugmentationBase]", list(self.steps))


def _chosen(
    steps: Sequence[nn.Module],
    random_apply: Some,
    weights: Optional[Sequence[float]],
    same_on_batch: bool,
) -> Chosen:
    total = len(steps)
    if random_apply is False:
        return Chosen(total, total, [1.0] * total)
    if random_apply is True:
        raise ValueError("random_apply: expected a number of steps; their order is fixed, got True")
    if any(_changes_size(step) for step in steps):
        raise ValueError("random_apply: expected False for steps that change the size of images")
    given = whole_numbers("random_apply", random_apply)
    least, greatest = given[0], given[0] if isinstance(random_apply, int) else [*given, total][1]
    if len(given) > 2 or not 0 <= least <= greatest <= total:
        raise ValueError(f"random_apply: expected 0 to {total} steps, got {random_apply}")
    shares = [1.0] * total if weights is None else numbers("random_apply_weights", weights)
    if len(shares) != total or min(shares, default=1.0) <= 0.0:
        raise ValueError(f"random_apply_weights: expected {total} positive numbers, got {weights}")
    return Chosen(least, greatest, shares, same_on_batch)


def _changes_size(step: nn.Module) -> bool:
    if isinstance(step, RandomMosaic):
        return step.output_size is not None
    return isinstance(step, (Cut, Cut3D, RandomIoUCrop, RandomResizedCrop, Resize, Sized))


def _matrix(step: AugmentationBase, params: Dict[str, Tensor], shape: List[int], keys: List[str]) -> Tensor:
    """A step's homographies, if boxes or points need them; not every step can compute them."""
    if isinstance(step, ImagesOnly):
        for key in keys:
            if key not in ("input", "class"):
                raise refusal(step, key)
    if "class" in keys and isinstance(step, (PatchMix, RandomMosaic)):
        raise ValueError(
            f"data_keys: expected no 'class', for {type(step).__name__} mixes images, and with them classes"
        )
    if any(key not in ("input", "mask", "class") for key in keys):
        return step.compute_transformation(params, shape)
    return identity(params["batch_prob"], 3)


def _back(
    step: AugmentationBase,
    key: str,
    value: Any,
    params: Dict[str, Tensor],
    shape: List[int],
    matrix: Tensor,
) -> Any:
    """What a step gave, taken back; ``matrix`` are the inverse homographies (B, 3, 3)."""
    if key == "class":
        return value
    if key == "input":
        return step.inverse_transform(value, params, shape)
    if key == "mask":
        return step.inverse_mask(value, params, shape)
    return moved_coordinates(key, value, matrix, step.moves_edges)
