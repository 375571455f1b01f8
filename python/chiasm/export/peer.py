"""Peers: the same op in another library. Tests compare an op's values with its peer, the benchmark its
speed."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias

import numpy as np
import torch

if TYPE_CHECKING:
    from .spec import Spec

#: A call of one to six arguments. For `Callable[..., Any]` a lambda's arguments would have no types.
Call: TypeAlias = (
    Callable[[Any], Any]
    | Callable[[Any, Any], Any]
    | Callable[[Any, Any, Any], Any]
    | Callable[[Any, Any, Any, Any], Any]
    | Callable[[Any, Any, Any, Any, Any], Any]
    | Callable[[Any, Any, Any, Any, Any, Any], Any]
)
Form = Literal["images", "planes", "samples", "batch", "tensors"]


@dataclass(frozen=True)
class Peer:
    """The same op in another library.

    library: the module that `call` gets first, e.g. "cv2"; it is imported when the peer runs. call: one call
    of it. form: the arguments of the call.

    * "images": each image of a batch as NumPy (H, W, C), or (H, W) of one channel, and its other inputs;
    * "planes": each channel of each image as (H, W);
    * "samples": each sample of every input, as it is;
    * "batch": all inputs as NumPy arrays, as they are;
    * "tensors": all inputs as PyTorch tensors.

    Every call gets inputs without a batch as a whole; if no input has a B, the first one's first dimension is
    the batch. atol, rtol: the tolerance, if the spec's is too small.
    edge: rows and columns along the border that are not compared, if the libraries treat the border
    differently. share: the share of values that may be further apart, if rounding decides. before: converts
    an op's inputs to the arguments of a call; after: converts a call's result to the op's output, if
    conventions differ; neither counts as the peer's time. sizes: symbols with the only size that the peer
    takes, such as {"C": 3}. timed: False if the benchmark does not compare times: a call is a loop in Python,
    does another amount of work, or needs too much memory at the benchmark's sizes.
    """

    library: str
    call: Call
    form: Form = "images"
    atol: float | None = None
    rtol: float = 0.0
    edge: int = 0
    share: float = 0.0
    before: Call | None = None
    after: Callable[[Any], Any] | None = None
    sizes: Mapping[str, int] = field(default_factory=dict[str, int])
    timed: bool = True


def opencv(
    call: Call,
    form: Form = "images",
    *,
    before: Call | None = None,
    after: Callable[[Any], Any] | None = None,
    **options: Any,
) -> Peer:
    """A peer in OpenCV."""
    return Peer("cv2", call, form, before=before, after=after, **options)


#: OpenCV's names of border modes.
BORDERS = {"zeros": "BORDER_CONSTANT", "border": "BORDER_REPLICATE", "reflection": "BORDER_REFLECT_101"}
#: OpenCV's names of interpolations.
WAYS = {"nearest": "INTER_NEAREST", "bilinear": "INTER_LINEAR", "bicubic": "INTER_CUBIC"}

#: The largest difference of two bytes of noise whose positions differ by 1/64 pixel along both axes.
NEAR_BYTES = 2 * 255 / 64 + 1


def warped(function: str, mode: str, padding: str, of_bytes: bool = False) -> Peer:
    """OpenCV's warpAffine or warpPerspective by a matrix, to the size of a tensor. The images are so large
    that positions are mirrored at most once, because OpenCV does no more. For bytes chiasm rounds positions
    to 1/32 pixel, which shows in noise of 255 levels."""

    def call(cv2: Any, x: np.ndarray, matrix: np.ndarray, size: tuple[int, int]) -> np.ndarray:
        options = {"flags": getattr(cv2, WAYS[mode]), "borderMode": getattr(cv2, BORDERS[padding])}
        return getattr(cv2, function)(x, matrix, size, **options)

    def arguments(x: np.ndarray, matrix: np.ndarray, like: np.ndarray) -> tuple[Any, ...]:
        return x, matrix, like.shape[::-1]

    return opencv(
        call,
        before=arguments,
        atol=NEAR_BYTES if of_bytes else 1e-3,
        share=2e-3 if of_bytes else 1e-3,
        sizes={"C": 3, "H": 80, "W": 80},
    )


def cvt_color(
    code: str, *, before: Call | None = None, after: Callable[[Any], Any] | None = None, **options: Any
) -> Peer:
    """OpenCV's cvtColor."""

    def call(cv2: Any, x: np.ndarray) -> np.ndarray:
        return cv2.cvtColor(x, getattr(cv2, code))

    return opencv(call, before=before, after=after, **options)


@dataclass
class Work:
    """A peer's calls on some inputs. The inputs are already in the peer's own form, so that the conversion
    does not count as the calls' time."""

    peer: Peer
    arguments: list[list[Any]]
    interleaved: bool

    def run(self) -> list[Any]:
        """The result of each call."""
        return [self.peer.call(*a) for a in self.arguments]

    def outputs(self, like: Sequence[np.ndarray]) -> list[np.ndarray]:
        """The results of the calls in the form of the op's outputs; ValueError if the shapes differ."""
        made = self.run()
        if self.peer.after is not None:
            made = [self.peer.after(m) for m in made]
        tuples: list[tuple[Any, ...]] = [m if isinstance(m, tuple) else (m,) for m in made]
        parts = zip(*tuples, strict=True)
        return [self._output(list(p), o) for p, o in zip(parts, like, strict=True)]

    def _output(self, parts: list[Any], like: np.ndarray) -> np.ndarray:
        form = self.peer.form
        result = np.asarray(parts[0]) if form in ("batch", "tensors") else np.stack(parts)
        if form == "images" and like.ndim == 4:
            result = result[..., None] if result.ndim == 3 else result
            result = result if self.interleaved else np.transpose(result, (0, 3, 1, 2))
        elif form == "planes" and like.ndim > 1:
            samples = like.shape[0]
            result = np.reshape(result, (samples, len(result) // samples, *result.shape[1:]))
            result = np.moveaxis(result, 1, -1) if self.interleaved and like.ndim == 4 else result
        if result.shape != like.shape:
            raise ValueError(f"the peer gives {result.shape}, the op {like.shape}")
        return result


def work(spec: Spec, inputs: Sequence[torch.Tensor]) -> Work:
    """The calls of the spec's peer on its inputs."""
    peer, interleaved = spec.peer, spec.interleaved
    assert peer is not None
    shapes = [t.shape for t in spec.inputs]
    batch = "B" if any("B" in shape[:1] for shape in shapes) else shapes[0][0]
    batched = [shape[:1] == (batch,) for shape in shapes]
    library = importlib.import_module(peer.library)
    arrays = [t.numpy() for t in inputs]
    if peer.form in ("batch", "tensors"):
        whole: Sequence[Any] = arrays if peer.form == "batch" else inputs
        return Work(peer, [[library, *(peer.before(*whole) if peer.before else whole)]], interleaved)
    samples = next(len(a) for a, has in zip(arrays, batched, strict=True) if has)
    channels = arrays[0].shape[-1 if interleaved else 1] if peer.form == "planes" else 1
    calls: list[list[Any]] = []
    for b in range(samples):
        for c in range(channels):
            parts = [
                _part(peer.form, a, b, c, interleaved) if has else a
                for a, has in zip(arrays, batched, strict=True)
            ]
            calls.append([library, *(peer.before(*parts) if peer.before else parts)])
    return Work(peer, calls, interleaved)


def _part(form: Form, array: np.ndarray, sample: int, channel: int, interleaved: bool) -> Any:
    """The argument of a call for one input: a number if a sample is one number."""
    part = array[sample]
    if part.ndim == 0:
        return part.item()
    if form == "samples" or part.ndim != 3:
        return part
    image = part if interleaved else part.transpose(1, 2, 0)
    only = channel if form == "planes" else 0 if image.shape[-1] == 1 else slice(None)
    return np.ascontiguousarray(image[..., only])


class Apart(NamedTuple):
    """The difference of an op's values from its peer's: the largest difference of the compared values, the
    share of values outside of the tolerance, and the share of those that are not equal."""

    most: float
    share: float
    differing: float


def compared(spec: Spec, actual: np.ndarray, expected: np.ndarray, layout: str) -> Apart:
    """Compares the values of one output with those of the spec's peer."""
    peer = spec.peer
    assert peer is not None
    allowed = spec.tolerance("forward", str(actual.dtype))
    atol, rtol = (allowed.atol, allowed.rtol) if allowed else (0.0, 0.0)
    if peer.atol is not None:
        atol, rtol = peer.atol, peer.rtol
    if peer.edge:
        inside = slice(peer.edge, -peer.edge)
        where = (slice(None), inside, inside) if layout == "NHWC" else (..., inside, inside)
        actual, expected = actual[where], expected[where]
    actual, expected = actual.astype(np.float64), expected.astype(np.float64)
    apart = np.abs(actual - expected)
    same = (actual == expected) | (np.isnan(actual) & np.isnan(expected))
    wrong = ~same & ~(apart <= atol + rtol * np.abs(expected))
    return Apart(float(apart.max(initial=0.0, where=~same)), float(wrong.mean()), float((~same).mean()))
