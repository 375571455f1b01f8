"""Inputs for export, golden vectors and parity: generated from the spec, reproducible, at difficult
shapes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, cast

import torch

from .errors import ExportError
from .spec import Spec, TensorSpec
from .text import one_line

#: The sizes that ops are exported at. All differ, also from constants in signatures (2, 3, 4, 9), because
#: symbolic tracing gives equal sizes the same symbol.
EXAMPLE = {"B": 7, "C": 6, "H": 24, "W": 31, "N": 11, "OD": 10, "OH": 14, "OW": 19}
#: The sizes that they are tested at: none of EXAMPLE's, odd and even, batch 1 and 3, 1, 3 and 5 channels,
#: non-square.
TESTS = (
    {"B": 1, "C": 1, "H": 37, "W": 53, "N": 4, "OH": 50, "OW": 33},
    {"B": 3, "C": 3, "H": 64, "W": 20, "N": 17, "OH": 9, "OW": 41},
    {"B": 1, "C": 5, "H": 19, "W": 121, "N": 100, "OH": 77, "OW": 78},
    {"B": 3, "C": 1, "H": 96, "W": 33, "N": 6, "OH": 12, "OW": 10},
)
#: The sizes of the golden vectors: small, because bundles contain them.
GOLDEN = {"B": 1, "C": 3, "H": 17, "W": 22, "N": 8, "OH": 11, "OW": 13}


def example(spec: Spec, tensors: Sequence[TensorSpec] = ()) -> dict[str, int]:
    """The sizes that an op is exported at: those of EXAMPLE, changed if the op's settings or the shapes of
    its inputs and of `tensors` contain the same number, such as an `output_size` of (7, 7): a trace would
    confuse the two."""
    sizes = fit(spec, EXAMPLE)
    taken = {2, 3, 4, 9} | _whole_numbers(spec.config)
    taken |= {d for t in (*spec.inputs, *tensors) for d in t.shape if isinstance(d, int)}
    for symbol, (low, high) in spec.used_symbols().items():
        others = taken | {size for name, size in sizes.items() if name != symbol}
        if sizes[symbol] in taken:
            free = (size for size in range(max(low, sizes[symbol]), high + 1) if size not in others)
            sizes[symbol] = next(free, sizes[symbol])
    return sizes


def _whole_numbers(value: object) -> set[int]:
    if isinstance(value, Mapping):
        return _whole_numbers(list(cast("Mapping[Any, object]", value).values()))
    if isinstance(value, (list, tuple)):
        return {number for part in cast("Sequence[object]", value) for number in _whole_numbers(part)}
    return {value} if isinstance(value, int) else set()


def fit(spec: Spec, sizes: dict[str, int]) -> dict[str, int]:
    """`sizes` for the spec's symbols, moved into their limits; unknown symbols get a size of their own."""
    result: dict[str, int] = {}
    for index, (symbol, (low, high)) in enumerate(spec.used_symbols().items()):
        wanted = sizes.get(symbol, sizes["N"] + 3 + index)
        result[symbol] = min(max(wanted, low), high)
    return result


def dtype_of(name: str, variant: str | None) -> torch.dtype:
    """The torch dtype of a spec's dtype, T standing for `variant`."""
    return getattr(torch, str(variant) if name == "T" else name)


def make(spec: Spec, sizes: dict[str, int], variant: str | None, seed: int = 0) -> dict[str, torch.Tensor]:
    """Named inputs of the given sizes."""
    generator = torch.Generator().manual_seed(seed)
    dtype = dtype_of("T", variant) if variant else torch.float32
    if spec.make_inputs is not None:
        return _made(spec, generator, sizes, dtype)
    result: dict[str, torch.Tensor] = {}
    for t in spec.inputs:
        try:
            result[t.name] = uniform(generator, t, sizes, variant)
        except (RuntimeError, MemoryError) as error:  # torch's, of a size that no memory has
            shape = tuple(sizes[d] if isinstance(d, str) else d for d in t.shape)
            why = str(error).partition("\n")[0] or "out of memory"
            raise ExportError(
                f"{spec.name}: input {t.name!r}: an example of shape {shape} cannot be made: {why}; the op is"
                " tried with the smallest sizes that the spec allows"
            ) from error
    return result


def _made(
    spec: Spec, generator: torch.Generator, sizes: dict[str, int], dtype: torch.dtype
) -> dict[str, torch.Tensor]:
    """What the spec's own function makes."""
    assert spec.make_inputs is not None
    try:
        made: Any = spec.make_inputs(generator, sizes, dtype)
    except Exception as error:
        raise ExportError(
            f"{spec.name}: make_inputs fails for the sizes {sizes}: {type(error).__name__}: {one_line(error)}"
        ) from error
    result: dict[str, torch.Tensor] = {}
    for t in spec.inputs:
        try:
            found: object = made[t.name]
        except (TypeError, KeyError, IndexError):  # of other objects
            found = None
        if not isinstance(found, torch.Tensor):
            raise ExportError(
                f"{spec.name}: make_inputs: expected a dictionary with a tensor {t.name!r}, got"
                f" {one_line(made, 99)}"
            )
        # Native code is compiled for the strides of the example inputs, and at run time gets dense tensors.
        result[t.name] = found.contiguous()
    return result


def uniform(
    generator: torch.Generator, tensor: TensorSpec, sizes: dict[str, int], variant: str | None
) -> torch.Tensor:
    """Independent uniform values in the tensor's range (0 to 1 if it states none)."""
    shape = [sizes[d] if isinstance(d, str) else d for d in tensor.shape]
    dtype = dtype_of(tensor.dtype, variant)
    low, high = tensor.range or (0.0, 1.0)
    if dtype.is_floating_point:
        # drawn in float64, so that every dtype gets the same values
        return (torch.rand(shape, generator=generator, dtype=torch.float64) * (high - low) + low).to(dtype)
    if dtype == torch.bool:
        return torch.rand(shape, generator=generator) < 0.5
    return torch.randint(int(low), int(high) + 1, shape, generator=generator).to(dtype)
