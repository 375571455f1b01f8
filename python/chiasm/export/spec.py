"""Specs: what the exporter must know about an op besides its code."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import torch

from .peer import Peer

#: Makes all inputs, from a generator, sizes and the dtype; and one input, in float64.
InputMaker = Callable[[torch.Generator, dict[str, int], torch.dtype], dict[str, torch.Tensor]]
Maker = Callable[[torch.Generator, dict[str, int]], torch.Tensor]

#: Limits of the symbols that most ops share; a spec may narrow them or add its own.
DEFAULT_SYMBOLS = MappingProxyType(
    {"B": (1, 4096), "C": (1, 1024), "H": (1, 32768), "W": (1, 32768), "N": (1, 1 << 20)}
)


@dataclass(frozen=True)
class TensorSpec:
    """One input or output.

    shape: integers and symbols ("B", "H"); empty for outputs, whose shape the exporter derives.
    dtype: "T", the type variable of a generic op, or a concrete one ("uint8"). Derived for outputs.
    layout: the order of an image's dimensions, "NCHW" or "NHWC", or empty. color: the channels,
    such as "RGB", "BGR", "GRAY", or empty. description: what the values are, in a few words. Users see all
    three in `chiasm info`.
    range: nominal values, for test inputs and for users; not enforced.
    sizes: the op gets this tensor's shape instead of the tensor, in these arguments: one for all sizes, or
    one for each. Every runtime can pass tensors, but not every runtime can pass numbers that change from call
    to call (`like`).
    """

    name: str
    shape: tuple[int | str, ...] = ()
    dtype: str = "T"
    layout: str = ""
    color: str = ""
    range: tuple[float, float] | None = None
    description: str = ""
    sizes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Tolerance:
    """|a - b| <= atol + rtol * |b|, for every backend against eager."""

    atol: float
    rtol: float


#: The element types of frames of ops that move or order pixels.
PIXELS = ("uint8", "int16", "uint16")

DEFAULT_TOLERANCES = MappingProxyType(
    {
        "float64": Tolerance(1e-9, 1e-7),
        "float32": Tolerance(2e-5, 1e-4),
        "float16": Tolerance(4e-3, 4e-3),
        "bfloat16": Tolerance(3e-2, 3e-2),
    }
)


@dataclass(frozen=True)
class ErrorInput:
    """A value of an argument that an op rejects: it raises `error`, whose text begins with `message`."""

    argument: str
    value: Any
    message: str
    error: type[Exception] = ValueError


@dataclass(frozen=True)
class Frames:
    """How an op on image batches (B, C, H, W) is deployed for frames, (B, H, W, C), as cameras and files have
    them. The bundle is NAME.frames; the runtime also accepts a single frame, (H, W, C), as a batch of one.

    dtypes: the element types of the frames; the first is the default. config, tolerances, reference: as in
    Spec, if they differ from it: the settings of an op on bytes are in the units of bytes. ranges: those of
    the other inputs, likewise; None omits an input for which the op has a default. peer: as in Spec, for
    frames of the first type. errors: what the op rejects beside those of Spec, if its images are bytes.
    """

    dtypes: tuple[str, ...] = ("uint8",)
    config: dict[str, Any] = field(default_factory=dict)
    ranges: dict[str, tuple[float, float] | None] = field(default_factory=dict)
    tolerances: dict[str, Tolerance] = field(default_factory=dict)
    reference: str = ""
    peer: Peer | None = None
    errors: tuple[ErrorInput, ...] = ()


@dataclass(frozen=True)
class Spec:
    """How an op or pipeline is deployed.

    name: the bundle's name, e.g. "filters.sobel". inputs, outputs: the tensors, in the order of the
    function's arguments and results. config: the function's other arguments, frozen into the artifacts.
    symbols: limits (min, max) of the symbolic dimensions, if they differ from DEFAULT_SYMBOLS. dtypes: the
    values of "T"; the first is the default. gradients: inputs that `vjp` differentiates by; None means every
    floating input, () means no vjp. tolerances: per dtype of an output, if DEFAULT_TOLERANCES do not suit.
    gradient_tolerances: the same for the results of `vjp`, if they differ from `tolerances`. vectorize: False
    compiles native loops without SIMD, for ops whose SIMD loops AOTInductor gets wrong. without_nan: True if
    the op is documented for images without NaN: native minima and maxima then take one instruction, not
    three. special_values: why backends may differ from eager Python on inputs with NaN or infinity; empty if
    they agree (tests/parity/special_values.py). takes_gradients: True for a function that calls
    torch.autograd.grad (an optimisation step); it is traced like a gradient, and has no vjp. make_inputs:
    makes inputs from (generator, sizes, dtype), if independent uniform values do not suit. summary: one line
    for users, by default the first of the docstring. errors: what the op rejects, for tests. version: the
    op's, which the manifest states. reference: what the values are tested against, in words. peer: the same
    op in another library: tests compare values with it, the benchmark times it. also: other settings that
    are tested like `config`, whose entries they replace, but are not deployed. picture: how the gallery
    shows the op, if its tensors' layouts do not tell: a name in PICTURES of gallery/panels/choice.py.
    frames: describes the op's form for frames, if it has one (`as_frames`). interleaved: True for that form:
    the tensors of layout "NHWC" are images (B, C, H, W) to the op.
    """

    name: str
    inputs: Sequence[TensorSpec]
    outputs: Sequence[TensorSpec] = (TensorSpec("output"),)
    config: dict[str, Any] = field(default_factory=dict)
    symbols: dict[str, tuple[int, int]] = field(default_factory=dict)
    dtypes: tuple[str, ...] = ("float32",)
    gradients: tuple[str, ...] | None = None
    tolerances: dict[str, Tolerance] = field(default_factory=dict)
    gradient_tolerances: dict[str, Tolerance] = field(default_factory=dict)
    make_inputs: InputMaker | None = None
    summary: str = ""
    reference: str = ""
    peer: Peer | None = None
    also: tuple[dict[str, Any], ...] = ()
    errors: tuple[ErrorInput, ...] = ()
    version: str = "1.0.0"
    vectorize: bool = True
    without_nan: bool = False
    special_values: str = ""
    takes_gradients: bool = False
    frames: Frames | None = None
    interleaved: bool = False
    picture: str = ""

    def as_frames(self) -> Spec:
        """The spec of the op's form for frames.

        >>> spec = Spec("my.blur", [image()], [TensorSpec("output", layout="NCHW")], frames=Frames())
        >>> spec.as_frames().name, spec.as_frames().inputs[0].shape, spec.as_frames().dtypes
        ('my.blur.frames', ('B', 'H', 'W', 'C'), ('uint8',))
        """
        if self.frames is None:
            raise ValueError(f"spec {self.name!r}: it has no form for frames: set frames=Frames()")
        return replace(
            self,
            name=f"{self.name}.frames",
            inputs=[
                _as_frames(t, self.frames)
                for t in self.inputs
                if self.frames.ranges.get(t.name, ()) is not None
            ],
            outputs=[replace(t, layout="NHWC") if t.layout == "NCHW" else t for t in self.outputs],
            config=self.config | self.frames.config,
            dtypes=self.frames.dtypes,
            gradients=(),
            tolerances=self.frames.tolerances,
            special_values="",
            make_inputs=None if self.make_inputs is None else _for_frames(self.make_inputs, self.inputs),
            reference=self.frames.reference or self.reference,
            peer=self.frames.peer,
            also=(),
            errors=self.errors + self.frames.errors,
            frames=None,
            interleaved=True,
        )

    @property
    def generic(self) -> bool:
        """Whether some input has the type variable T as its dtype."""
        return any(t.dtype == "T" for t in self.inputs)

    def variants(self) -> tuple[str | None, ...]:
        """The values of T to export for; (None,) if there is no T."""
        return self.dtypes if self.generic else (None,)

    def limits(self, symbol: str) -> tuple[int, int]:
        """The least and greatest size of a symbol."""
        found = self.symbols.get(symbol) or DEFAULT_SYMBOLS.get(symbol)
        if found is None:
            raise KeyError(
                f"spec {self.name!r}: symbol {symbol!r} has no limits: add symbols={{{symbol!r}: (min, max)}}"
            )
        return found

    def used_symbols(self) -> dict[str, tuple[int, int]]:
        """The limits of every symbol that an input's shape names, in order of appearance."""
        names = [d for t in self.inputs for d in t.shape if isinstance(d, str)]
        return {name: self.limits(name) for name in dict.fromkeys(names)}

    def differentiated(self) -> list[str]:
        """The inputs that `vjp` differentiates by."""
        floating = [t.name for t in self.inputs if t.dtype == "T" or t.dtype.startswith(("float", "bfloat"))]
        unknown = set(self.gradients or ()) - set(floating)
        if unknown:
            raise ValueError(
                f"spec {self.name!r}: gradients names {sorted(unknown)}, which are not floating inputs"
            )
        if self.takes_gradients:
            return []
        return floating if self.gradients is None else list(self.gradients)

    def tolerance(self, method: str, dtype: str) -> Tolerance | None:
        """The tolerance for a method's outputs of a dtype; None means exact."""
        own = self.gradient_tolerances if method == "vjp" else {}
        return own.get(dtype) or self.tolerances.get(dtype) or DEFAULT_TOLERANCES.get(dtype)


def _is_images(tensor: TensorSpec) -> bool:
    return tensor.layout == "NCHW" and len(tensor.shape) == 4


def _for_frames(make: InputMaker, inputs: Sequence[TensorSpec]) -> InputMaker:
    """As `make`, with images as frames of 0 to 255."""
    images = [t.name for t in inputs if _is_images(t)]

    def frames(
        generator: torch.Generator, sizes: dict[str, int], dtype: torch.dtype
    ) -> dict[str, torch.Tensor]:
        made = make(generator, sizes, torch.float32)
        return made | {
            name: (made[name] * 255.0).round().to(dtype).permute(0, 2, 3, 1).contiguous() for name in images
        }

    return frames


def _as_frames(tensor: TensorSpec, frames: Frames) -> TensorSpec:
    """An image becomes frames; any other tensor of type T becomes float32."""
    if _is_images(tensor):
        batch, channels, height, width = tensor.shape
        shape, range = (batch, height, width, channels), (0.0, 255.0)
        description = tensor.description.replace("image batch", "frames")
        return replace(tensor, shape=shape, layout="NHWC", range=range, description=description)
    range = frames.ranges.get(tensor.name, tensor.range)
    return replace(tensor, dtype="float32" if tensor.dtype == "T" else tensor.dtype, range=range)


def image(
    name: str = "input",
    channels: int | str = "C",
    color: str = "",
    range: tuple[float, float] = (0.0, 1.0),
    description: str = "",
) -> TensorSpec:
    """A float image batch (B, C, H, W)."""
    return TensorSpec(
        name, ("B", channels, "H", "W"), "T", "NCHW", color, range, description or "image batch"
    )


def like(*sizes: str, shape: tuple[str, ...] = ("OH", "OW")) -> TensorSpec:
    """A tensor whose shape is the wanted size, for the op's arguments `sizes`.

    >>> like("dsize").shape, like("height", "width").sizes
    (('OH', 'OW'), ('height', 'width'))
    """
    description = "its shape is the size wanted; its values are not read"
    return TensorSpec("like", shape, "uint8", range=(0, 255), description=description, sizes=sizes)


def frame(name: str = "frame", color: str = "BGR", description: str = "") -> TensorSpec:
    """One uint8 camera frame (H, W, 3), as OpenCV hands it out."""
    return TensorSpec(name, ("H", "W", 3), "uint8", "HWC", color, (0, 255), description or "camera frame")
