"""The base classes of augmentations: one step draws parameters from seeds, another one applies them to
images."""

from typing import Any, ClassVar, Dict, List, Optional, Tuple, Union

import torch
from torch import Tensor

from ..primitives.core.broadcasting import where_chosen
from ..primitives.core.checks import check_pixels, check_rank, check_tensor
from ..primitives.core.modules import Module
from ..primitives.random.draws import check_seed, uniform
from .decisions import below, check_chance
from .settings import number, whole_numbers

Range = Union[float, Tuple[float, float], List[float], Tensor]
Size = Union[int, Tuple[int, int]]


class AugmentationBase(Module):
    """Random changes of a batch, with one 64-bit seed for each sample.

    ``forward(input, seed)`` depends on its arguments only: it can be scripted and exported. A call of the
    module, ``augmentation(input)``, draws the seeds from PyTorch's generator and stores the parameters that
    it computes from them. ``augmentation(other, params=augmentation._params)`` then repeats the same change.

    A subclass computes the parameters from seeds (``generate_parameters``) and applies them to images
    (``apply_transform``).

    Args:
        p: the probability that a sample is changed; samples are independent.
        p_batch: the probability that the batch is changed at all; the first sample's seed decides.
        same_on_batch: True draws the parameters of all samples from the first sample's seed.
        keepdim: True returns an image without a batch dimension for an image without one.
    """

    __jit_unused_properties__: ClassVar[List[str]] = ["transform_matrix"]
    #: The number of dimensions of a batch.
    rank = 4
    #: Whether a change moves the edges of boxes, not the centres of their corner pixels.
    moves_edges = False
    #: The parameters of the last call.
    _params: Dict[str, Tensor]

    def __init__(
        self, p: float = 0.5, p_batch: float = 1.0, same_on_batch: bool = False, keepdim: bool = False
    ) -> None:
        super().__init__()
        self.p, self.p_batch = number("p", p), number("p_batch", p_batch)
        check_chance(self.p)
        check_chance(self.p_batch, "p_batch")
        self.same_on_batch, self.keepdim = same_on_batch, keepdim
        self._params = {}

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        """The parameters of each sample, and "batch_prob", (B,), which says whether the sample is changed."""
        return {"batch_prob": below(uniform(seed, 1)[:, 0], self.p)}

    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        """The batch changed by the parameters; samples that "batch_prob" leaves out stay unchanged."""
        return input

    @torch.jit.unused
    def transform_mask(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        """Label masks (B, C, H, W), moved with their images; the result has no new label values."""
        return input

    @torch.jit.unused
    def inverse_transform(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        """The inverse of the geometric change, applied to a result; ``shape`` is the shape of the original
        images."""
        return input

    @torch.jit.unused
    def inverse_mask(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        """``inverse_transform`` for label masks; the result has no new label values."""
        return self.inverse_transform(input, params, shape)

    def draw(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        """``generate_parameters``, with the constructor's options for whole batches applied."""
        if self.same_on_batch:
            seed = seed[:1].expand(seed.size(0))
        params = self.generate_parameters(seed, shape)
        if self.p_batch < 1.0:
            # A stream that no augmentation draws from.
            drawn = uniform(seed[:1], 1, 1048576)[:, 0] < self.p_batch
            params["batch_prob"] = params["batch_prob"] & drawn
        return params

    @torch.jit.unused
    def draw_beside(
        self, seed: Tensor, shape: List[int], keys: List[str], data: List[Any]
    ) -> Dict[str, Tensor]:
        """``draw`` within a sequence, where the parameters may depend on what belongs to the images."""
        return self.draw(seed, shape)

    @torch.jit.unused
    def settled(self, keys: List[str], data: List[Any], params: Dict[str, Tensor]) -> List[Any]:
        """What a sequence returns after this step, of the moved ``data``."""
        return data

    def forward(self, input: Tensor, seed: Tensor, params: Optional[Dict[str, Tensor]] = None) -> Tensor:
        """The batch, changed according to ``seed`` (B,), int64, or according to ``params`` if they are
        given."""
        if params is None:
            check_seed(seed, input.size(0))
            params = self.draw(seed, list(input.shape))
        return self.apply_transform(input, params)

    def __call__(
        self,
        input: Tensor,
        params: Optional[Dict[str, Tensor]] = None,
        seed: Optional[Tensor] = None,
        generator: Optional[torch.Generator] = None,
    ) -> Tensor:
        """The changed batch, or the changed image without a batch dimension; ``_params`` keeps the
        parameters.

        Args:
            input: a batch, or one sample of it.
            params: the parameters of an earlier call, or your own; then none are drawn.
            seed: (B,), int64: the parameters are drawn from it.
            generator: draws the seeds if none are given; PyTorch's default generator if None.

        Raises:
            TypeError: if input is not a tensor.
            ValueError: if it has another number of dimensions.
        """
        check_tensor(input, "input")
        batch = input[None] if input.dim() == self.rank - 1 else input
        layout = "(B, C, H, W) or (C, H, W)" if self.rank == 4 else "(B, C, D, H, W) or (C, D, H, W)"
        check_rank(batch, self.rank, layout, "input")
        out = self.change(batch, params, seed, generator)
        return out[0] if self.keepdim and input.dim() < batch.dim() else out

    def change(
        self,
        batch: Tensor,
        params: Optional[Dict[str, Tensor]] = None,
        seed: Optional[Tensor] = None,
        generator: Optional[torch.Generator] = None,
    ) -> Tensor:
        """The work of a call, for a batch."""
        if params is None:
            if seed is None:
                seed = draw_seeds(batch.size(0), generator).to(batch.device)
            check_seed(seed, batch.size(0))
            params = self.draw(seed, list(batch.shape))
            params["seed"] = seed
        else:  # nothing is drawn
            if seed is not None:
                check_seed(seed, batch.size(0))
            seed = torch.zeros(batch.size(0), dtype=torch.int64, device=batch.device)
            params = {"batch_prob": torch.ones_like(seed, dtype=torch.bool), **params}
        self._params = {**params, "forward_input_shape": torch.tensor(batch.shape)}
        return super().__call__(batch, seed, self._params)

    def compute_transformation(self, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        """The homographies (B, 3, 3), float64, that map input pixels to output pixels; the identity for
        unchanged samples."""
        return identity(params["batch_prob"], len(shape) - 1)

    @property
    def transform_matrix(self) -> Tensor:
        """The homographies (B, 3, 3), float64, of the last call: they map input pixels (x, y, 1) to output
        pixels."""
        if not self._params:
            raise AttributeError("transform_matrix: expected a call before")
        try:
            return self.compute_transformation(self._params, shape_of(self._params))
        except ValueError as error:  # TorchScript asks for every property
            raise AttributeError(f"transform_matrix: {error}") from error


class AugmentationBase2D(AugmentationBase):
    """Random changes of images (B, C, H, W).

    Example:
        >>> AugmentationBase2D(p=1.0)(torch.rand(2, 3, 4, 4)).shape  # a base, which changes nothing
        torch.Size([2, 3, 4, 4])
    """


class Seeded(Module):
    """A module whose ``forward(input, seed)`` draws all random numbers from seeds (B,), int64."""

    #: The number of dimensions of a batch.
    rank = 4


class IntensityAugmentationBase2D(AugmentationBase2D):
    """Random changes of pixel values; the content of the image does not move.

    Example:
        >>> class Darker(IntensityAugmentationBase2D):
        ...     def apply_transform(self, input, params):
        ...         return select(params, input / 2, input)
        >>> Darker(p=1.0)(torch.ones(1, 1, 1, 2))
        tensor([[[[0.5000, 0.5000]]]])
    """


class ImagesOnly(IntensityAugmentationBase2D):
    """Random changes that may move images, without parameters that tell how: nothing can follow them, and
    there is no way back."""

    #: The name in messages.
    title = ""

    @torch.jit.unused
    def transform_mask(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:
        raise refusal(self, "mask")

    @torch.jit.unused
    def inverse_transform(self, input: Tensor, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        name = _title(self)
        raise ValueError(f"inverse: there is no way back, for {name} does not tell how it moves images")

    @torch.jit.unused
    def compute_transformation(self, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        raise ValueError(f"{_title(self)}: it does not tell how it moves images, so it has no matrix")


def refusal(step: ImagesOnly, key: str) -> ValueError:
    """The error of a step that only images can go through."""
    name = _title(step)
    return ValueError(
        f"data_keys: expected 'input' alone, for {name} does not tell how it moves images; got {key!r}"
    )


def _title(step: ImagesOnly) -> str:
    return step.title or type(step).__name__


class GeometricAugmentationBase2D(AugmentationBase2D):
    """Random geometric changes. A subclass implements ``compute_transformation``.

    Example:
        >>> GeometricAugmentationBase2D().compute_transformation(
        ...     {"batch_prob": torch.ones(2)}, [2, 3, 4, 4]
        ... ).shape
        torch.Size([2, 3, 3])
    """

    @torch.jit.unused
    def inverse(self, input: Tensor, params: Optional[Dict[str, Tensor]] = None) -> Tensor:
        """Undo the change of the last call (or of ``params``). Content that was moved out of an image is
        lost."""
        given = self._params if params is None else params
        shape = shape_of(given)
        batch = input[None] if input.dim() == self.rank - 1 else input
        check_rank(batch, self.rank, "(B, C, H, W)", "input")
        if batch.size(0) != shape[0]:
            raise ValueError(
                f"input: expected {shape[0]} images, as many as in the call, got {batch.size(0)}"
            )
        out = self.inverse_transform(batch, given, shape)
        return out[0] if self.keepdim and input.dim() < batch.dim() else out


class AugmentationBase3D(AugmentationBase):
    """Random changes of volumes (B, C, D, H, W).

    Example:
        >>> AugmentationBase3D(keepdim=True)(torch.rand(3, 4, 4, 4)).shape  # a base, which changes nothing
        torch.Size([3, 4, 4, 4])
    """

    rank = 5


def shape_of(params: Dict[str, Tensor]) -> List[int]:
    """The shape of the images that a call changed by ``params``, which it keeps among them."""
    if "forward_input_shape" not in params:
        raise ValueError("params: expected the parameters of a call, its _params, with 'forward_input_shape'")
    return [int(n) for n in params["forward_input_shape"]]


def draw_seeds(count: int, generator: Optional[torch.Generator] = None) -> Tensor:
    """Seeds (count,), int64, from PyTorch's generator."""
    return torch.randint(-(2**63), 2**63 - 1, (count,), generator=generator, dtype=torch.int64)


def check_batch(input: Tensor, seed: Tensor) -> None:
    """Raise unless ``input`` is (B, C, H, W), floating point or uint8, and ``seed`` has B elements."""
    check_pixels(input, "input")
    check_seed(seed, input.size(0))


def identity(like: Tensor, size: int) -> Tensor:
    """Identity matrices (B, size, size), float64, where B is the batch size of ``like``."""
    eye = torch.eye(size, dtype=torch.float64, device=like.device)
    return eye.expand(like.size(0), size, size)


def select(params: Dict[str, Tensor], changed: Tensor, input: Tensor) -> Tensor:
    """The changed sample where "batch_prob" chooses it, otherwise the unchanged one."""
    return where_chosen(params["batch_prob"], changed, input)


def pair(value: Any) -> List[Any]:
    """A number, or a sequence of them, as a list."""
    return list(value) if isinstance(value, (tuple, list)) else [value]


def as_size(value: Size, name: str) -> Tuple[int, int]:
    """(height, width); one number stands for both."""
    sides = whole_numbers(name, value)
    sides = sides * 2 if len(sides) == 1 else sides
    if len(sides) != 2 or min(sides) < 1:
        raise ValueError(f"{name}: expected a positive number, or (height, width), got {value}")
    return sides[0], sides[1]


def as_mode(value: Any, name: str = "resample") -> str:
    """The name of an interpolation: "bilinear", "nearest" or "bicubic"; an enum member is read by its
    name."""
    names = {0: "nearest", 1: "bilinear", 2: "bicubic"}
    found = names.get(value, "") if isinstance(value, int) else str(getattr(value, "name", value)).lower()
    if found not in names.values():
        raise ValueError(f"{name}: expected 'bilinear', 'nearest' or 'bicubic', got {value!r}")
    return found
