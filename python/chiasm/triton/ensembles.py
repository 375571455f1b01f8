"""Several parts in sequence as one Triton model, an ensemble: which output becomes which input."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from ..export.text import free_name
from .parts import Part, RepositoryError, Tensor


@dataclass(frozen=True)
class Step:
    """A model within an ensemble, with its tensors' names and their names in the ensemble."""

    model: str
    inputs: dict[str, str]
    outputs: dict[str, str]


@dataclass(frozen=True)
class Ensemble:
    """A model that consists of others: its own tensors, and its steps."""

    name: str
    inputs: list[Tensor]
    outputs: list[Tensor]
    steps: list[Step]


def joined(name: str, parts: Sequence[Part]) -> Ensemble:
    """The parts in their order. The ensemble's inputs are those of the first part, and those of later parts
    that get no output of the part before; its outputs are those of the last part."""
    if len(parts) < 2:
        raise RepositoryError(f"ensemble '{name}': expected two parts or more, got {len(parts)}")
    inputs: list[Tensor] = []
    sources: list[dict[str, str | None]] = []  # of each part's inputs
    before: Sequence[Tensor] = ()  # the outputs of the part before
    for i, part in enumerate(parts):
        wanted, given = part.tensors
        sources.append(_sources(name, part, wanted, before))
        if i > 0 and not any(sources[i].values()):
            raise RepositoryError(
                f"ensemble '{name}': no output of '{parts[i - 1].name}' ({_listed(before)}) has the"
                f" name of an input of '{part.name}' ({_listed(wanted)}), and there is more than one"
            )
        for tensor in wanted:
            if sources[i][tensor.name] is None:
                if any(tensor.name == each.name for each in inputs):
                    raise RepositoryError(
                        f"ensemble '{name}': two parts have an input '{tensor.name}' of their own"
                    )
                inputs.append(tensor)
        before = given
    # Within an ensemble a name must be unique
    own = {t.name for t in inputs}
    taken = own | {t.name for t in before}
    results = {t.name: free_name(f"{t.name}_out", taken) if t.name in own else t.name for t in before}
    outputs = [replace(t, name=results[t.name]) for t in before]
    steps: list[Step] = []
    named: dict[str, str] = {}  # the outputs of the part before, by their names in it
    for i, part in enumerate(parts):
        outside = {k: k if v is None else named[v] for k, v in sources[i].items()}
        if i == len(parts) - 1:
            named = results
        else:  # Triton refuses a tensor that no step takes
            used = {v for v in sources[i + 1].values() if v is not None}
            given = (t.name for t in part.tensors[1] if t.name in used)
            named = {each: free_name(f"{part.name}.{each}", taken) for each in given}
        steps.append(Step(part.name, outside, named))
    return Ensemble(name, inputs, outputs, steps)


def _sources(
    name: str, part: Part, wanted: Sequence[Tensor], before: Sequence[Tensor]
) -> dict[str, str | None]:
    """The source of each input: an output of the previous part, or None."""
    offered = {tensor.name: tensor for tensor in before}
    sources = {tensor.name: tensor.name if tensor.name in offered else None for tensor in wanted}
    if len(wanted) == len(before) == 1:
        sources[wanted[0].name] = before[0].name
    for tensor in wanted:
        source = sources[tensor.name]
        if source is not None and not offered[source].fits(tensor):
            raise RepositoryError(
                f"ensemble '{name}': output {offered[source]} cannot become input {tensor} of '{part.name}'"
            )
    return sources


def _listed(tensors: Iterable[Tensor]) -> str:
    return ", ".join(str(tensor) for tensor in tensors)
