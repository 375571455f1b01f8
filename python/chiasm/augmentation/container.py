"""Sequences of augmentations, for images with their masks, boxes and keypoints."""

from typing import Any, Dict, List, Optional, Sequence, Tuple, Union, cast

import torch
from torch import Tensor, nn

from ..geometry.linalg import transform_points
from ..primitives.random.draws import check_seed, integers, ranks, split, uniform
from .base import AugmentationBase, draw_seeds, identity, select
from .crop import RandomResizedCrop
from .cut import Cut
from .cut3d import Cut3D
from .keys import keys_of_call, read_keys
from .mixing import MixAugmentationBase, RandomMosaic
from .resizing import Resize

#: The number of steps to apply: a number, (least, greatest), (least,), or False for all.
Some = Union[bool, int, Tuple[int, ...]]

_KEYS = ("input", "mask", "bbox", "bbox_xyxy", "bbox_xywh", "keypoints")


class Fixed(AugmentationBase):
    """A module that draws nothing, as a step of a sequence."""

    def __init__(self, module: nn.Module) -> None:
        super().__init__(1.0)
        self.module = module

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return self.module(input)


class Nested(AugmentationBase):
    """A sequence as a step of another sequence, for images only."""

    def __init__(self, sequence: nn.Module) -> None:
        super().__init__(1.0)
        self.sequence = sequence

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        return {"batch_prob": torch.ones_like(seed, dtype=torch.bool), "draws": seed}

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        return self.sequence.forward(input, params["draws"])

    @torch.jit.unused
    def transform_mask(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        raise ValueError("data_keys: expected 'input' alone, for a step is a sequence that chooses its steps")

    @torch.jit.unused
    def inverse_transform(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return self.transform_mask(input, params)

    @torch.jit.unused
    def compute_transformation(self, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return self.transform_mask(params["draws"], params)


def _steps(module: nn.Module, whole: bool) -> List[AugmentationBase]:
    """A module as a list of steps; with ``whole`` a sequence stays one step, so that it is chosen as a
    whole."""
    if isinstance(module, AugmentationSequential):
        return [Nested(module)] if whole or module.some else module._typed()
    return [_step(module)]


def _step(module: nn.Module) -> AugmentationBase:
    if isinstance(module, MixAugmentationBase):
        raise ValueError(
            f"args: expected augmentations of images alone; call {type(module).__name__}, which takes"
            f" {list(module.known)}, after the sequence"
        )
    return module if isinstance(module, AugmentationBase) else Fixed(module)


class Chosen(nn.Module):
    """Chooses the steps that are applied to each sample: (steps, B), bool.

    Steps are drawn without replacement; each draw has probabilities proportional to the weights of the
    remaining steps. This is the same as to take the steps with the greatest u^(1/w). P. Efraimidis, P.
    Spirakis, Weighted random sampling with a reservoir, Information Processing Letters 97(5), 2006.
    """

    exponents: List[float]

    def __init__(self, least: int, greatest: int, weights: Sequence[float]) -> None:
        super().__init__()
        self.least, self.greatest = least, greatest
        self.exponents = [1.0 / w for w in weights]

    def forward(self, seed: Tensor) -> Tensor:
        count = self.least + integers(seed, self.greatest - self.least + 1, 1, 1)
        drawn = torch.log(1.0 - uniform(seed, len(self.exponents)))
        keys = drawn * torch.tensor(self.exponents, dtype=drawn.dtype, device=seed.device)
        return (ranks(-keys) < count).t()


class AugmentationSequential(nn.Module):
    """Apply augmentations one after the other; each has its own seeds, which are computed from the sample's
    seed.

    ``forward(input, seed)`` takes images; it can be scripted, and exported as one bundle of the whole
    pipeline. A call takes the tensors that ``data_keys`` names, draws the seeds, and moves masks, boxes and
    keypoints with their images.

    Args:
        args: augmentations, sequences of them, and modules that take only an image (``enhance.Normalize``).
        data_keys: the arguments of a call: first "input" (or "image"), then any number of "mask" (B, C, H,
            W), "bbox" (B, N, 4, 2) with the centres of corner pixels, "bbox_xyxy" and "bbox_xywh" (B, N, 4)
            with the edges of boxes, and "keypoints" (B, N, 2).
        same_on_batch: True or False overrides the setting of each augmentation.
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
    _shapes: List[List[int]]

    def __init__(
        self,
        *args: nn.Module,
        data_keys: Sequence[str] = ("input",),
        same_on_batch: Optional[bool] = None,
        keepdim: bool = False,
        random_apply: Some = False,
        random_apply_weights: Optional[Sequence[float]] = None,
    ) -> None:
        super().__init__()
        steps = [step for module in args for step in _steps(module, random_apply is not False)]
        if same_on_batch is not None:
            for step in steps:
                step.same_on_batch = same_on_batch
        self.steps = nn.ModuleList(steps)
        self.some = random_apply is not False
        self.chosen = _chosen(steps, random_apply, random_apply_weights)
        self.data_keys, self.keepdim = read_keys(data_keys, _KEYS), keepdim
        self._params, self._shapes = [], []

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
        *args: Tensor,
        params: Optional[List[Dict[str, Tensor]]] = None,
        data_keys: Optional[Sequence[str]] = None,
        seed: Optional[Tensor] = None,
        generator: Optional[torch.Generator] = None,
    ) -> Any:
        """The tensors that ``data_keys`` names, changed: one tensor, or a list.

        Args:
            args: the tensors. An exported or scripted sequence takes images and seeds.
            params: the parameters of an earlier call (its ``_params``).
            data_keys: as in the constructor, for this call.
            seed: (B,), int64: all random numbers are drawn from it.
            generator: draws the seeds if none are given; PyTorch's default generator if None.
        """
        if len(args) == 2 and self.data_keys == ["input"] and data_keys is None and seed is None:
            return super().__call__(args[0], args[1])  # forward's own arguments, images and seeds
        keys = keys_of_call(self.data_keys, data_keys, _KEYS, len(args))
        alone = args[0].dim() == 3
        data = [a[None] if alone else a for a in args]
        if seed is None:
            seed = draw_seeds(data[0].size(0), generator).to(data[0].device)
        self._params, self._shapes = [], []
        seeds = split(seed, len(self.steps) + 1)  # the last draws which steps
        chosen = self.chosen(seeds[-1]) if self.some else None
        for i, step in enumerate(self._typed()):
            self._shapes.append(list(data[0].shape))
            given = None if params is None else params[i]
            if given is None and chosen is not None:
                given = {**step.draw(seeds[i], self._shapes[i]), "seed": seeds[i]}
                given["batch_prob"] &= chosen[i]
            image = step.change(data[0], given, seeds[i])
            if self.some:
                image = select(step._params, image, data[0])
            self._params.append(step._params)
            matrix = _matrix(step, step._params, self._shapes[i], keys)
            data = [image] + [
                step.transform_mask(d, step._params) if key == "mask" else _moved(key, d, matrix)
                for key, d in zip(keys[1:], data[1:])
            ]
        data = [d[0] for d in data] if alone and self.keepdim else data
        return data[0] if len(data) == 1 else data

    def inverse(
        self,
        *args: Tensor,
        params: Optional[List[Dict[str, Tensor]]] = None,
        data_keys: Optional[Sequence[str]] = None,
    ) -> Any:
        """Undo the geometric changes of the last call (or of ``params``); pixel values are not restored.

        Content that was moved out of an image is lost.
        """
        keys = keys_of_call(self.data_keys, data_keys, _KEYS, len(args))
        params = self._params if params is None else params
        data = list(args)
        for step, given, shape in list(zip(self._typed(), params, self._shapes))[::-1]:
            matrix = torch.linalg.inv(_matrix(step, given, shape, keys))
            data = [
                step.inverse_transform(d, given, shape) if k in ("input", "mask") else _moved(k, d, matrix)
                for k, d in zip(keys, data)
            ]
        return data[0] if len(data) == 1 else data

    @property
    def transform_matrix(self) -> Tensor:
        """The homographies (B, 3, 3), float64, of the last call: they map input pixels (x, y, 1) to output
        pixels."""
        total = None
        for step, given, shape in zip(self._typed(), self._params, self._shapes):
            try:
                matrix = step.compute_transformation(given, shape)
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
) -> Chosen:
    total = len(steps)
    if random_apply is False:
        return Chosen(total, total, [1.0] * total)
    if random_apply is True:
        raise ValueError("random_apply: expected a number of steps; their order is fixed, got True")
    if any(_changes_size(step) for step in steps):
        raise ValueError("random_apply: expected False for steps that change the size of images")
    given = (random_apply, random_apply) if isinstance(random_apply, int) else (*random_apply, total)
    least, greatest = int(given[0]), int(given[1])
    if not 0 <= least <= greatest <= total:
        raise ValueError(f"random_apply: expected 0 to {total} steps, got {random_apply}")
    shares = [1.0] * total if weights is None else [float(w) for w in weights]
    if len(shares) != total or min(shares, default=1.0) <= 0.0:
        raise ValueError(f"random_apply_weights: expected {total} positive numbers, got {weights}")
    return Chosen(least, greatest, shares)


def _changes_size(step: nn.Module) -> bool:
    if isinstance(step, RandomMosaic):
        return step.output_size is not None
    return isinstance(step, (Cut, Cut3D, Resize, RandomResizedCrop))


def _matrix(step: AugmentationBase, params: Dict[str, Tensor], shape: List[int], keys: List[str]) -> Tensor:
    """A step's homographies, if boxes or points need them; not every step can compute them."""
    if any(key not in ("input", "mask") for key in keys):
        return step.compute_transformation(params, shape)
    return identity(params["batch_prob"], 3)


def _moved(key: str, data: Tensor, matrix: Tensor) -> Tensor:
    """Boxes or points, mapped by homographies (B, 3, 3)."""
    if key in ("keypoints", "bbox"):
        flat = data.reshape(data.size(0), -1, 2)
        return transform_points(matrix, flat.to(torch.float64)).reshape(data.shape).to(data.dtype)
    first, second = data[..., :2].to(torch.float64), data[..., 2:].to(torch.float64)
    # From edges to centres of corner pixels: the last pixel's coordinate is one less.
    last = (second if key == "bbox_xyxy" else first + second) - 1.0
    x, y = torch.stack([first[..., 0], last[..., 0]], -1), torch.stack([first[..., 1], last[..., 1]], -1)
    corners = torch.stack([x[..., [0, 1, 1, 0]], y[..., [0, 0, 1, 1]]], -1)
    moved = transform_points(matrix, corners.reshape(data.size(0), -1, 2)).reshape(corners.shape)
    low, high = moved.amin(-2), moved.amax(-2) + 1.0
    return torch.cat([low, high if key == "bbox_xyxy" else high - low], -1).to(data.dtype)
