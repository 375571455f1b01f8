"""Several parts in sequence as one Triton model, an ensemble: which output becomes which input."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

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
    steps: list[Step] = []
    before: dict[str, Tensor] = {}  # the outputs of the part before, by their names in the ensemble
    for i, part in enumerate(parts):
        last = i == len(parts) - 1
        wanted, given = part.tensors
        sources = _sources(name, part, wanted, before)
        if i > 0 and not any(sources.values()):
            raise RepositoryError(
                f"ensemble '{name}': no output of '{parts[i - 1].name}' ({_listed(before.values())}) has the"
                f" name of an input of '{part.name}' ({_listed(wanted)}), and there is more than one"
            )
        for tensor in wanted:
            if sources[tensor.name] is None:
                if any(tensor.name == each.name for each in inputs):
                    raise RepositoryError(
                        f"ensemble '{name}': two parts have an input '{tensor.name}' of their own"
                    )
                inputs.append(tensor)
        outside = {t.name: t.name if last else f"{part.name}.{t.name}" for t in given}
        steps.append(Step(part.name, {k: v or k for k, v in sources.items()}, outside))
        before = {outside[t.name]: t for t in given}
    outputs = [replace(tensor, name=called) for called, tensor in before.items()]
    if clash := {t.name for t in inputs} & {t.name for t in outputs}:
        # Within an ensemble a name must be unique
        renamed = {called: f"{called}_out" for called in clash}
        outputs = [replace(t, name=renamed.get(t.name, t.name)) for t in outputs]
        steps[-1] = replace(steps[-1], outputs={k: renamed.get(v, v) for k, v in steps[-1].outputs.items()})
    between = {called for step in steps[:-1] for called in step.outputs.values()}
    if taken := between & {t.name for t in [*inputs, *outputs]}:
        raise RepositoryError(
            f"ensemble '{name}': '{min(taken)}' is a tensor of its own and one between two parts: give the"
            " part another name, NAME=PATH"
        )
    return Ensemble(name, inputs, outputs, steps)


def _sources(
    name: str, part: Part, wanted: Sequence[Tensor], before: dict[str, Tensor]
) -> dict[str, str | None]:
    """The source of each input: an output of the previous part, or None."""
    by_name = {tensor.name: called for called, tensor in before.items()}
    sources: dict[str, str | None] = {tensor.name: by_name.get(tensor.name) for tensor in wanted}
    if len(wanted) == len(before) == 1:
        sources = {wanted[0].name: next(iter(before))}
    for tensor in wanted:
        called = sources[tensor.name]
        if called is not None and not before[called].fits(tensor):
            raise RepositoryError(
                f"ensemble '{name}': output {before[called]} cannot become input {tensor} of '{part.name}'"
            )
    return sources


def _listed(tensors: Iterable[Tensor]) -> str:
    return ", ".join(str(tensor) for tensor in tensors)
