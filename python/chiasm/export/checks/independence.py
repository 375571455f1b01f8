"""Whether the samples of a batch are independent, so that a runtime may run a large batch in parts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import torch

from ..spec import TensorSpec, Tolerance

Tensors = dict[str, torch.Tensor]

#: The symbol that counts the samples of a batch.
SYMBOL = "B"


def has_samples(inputs: Sequence[TensorSpec], outputs: Sequence[TensorSpec]) -> bool:
    """Whether the first dimension of every output and of some input is the batch, and no other dimension
    is."""
    inside = any(SYMBOL in str(d) for t in (*inputs, *outputs) for d in t.shape[1:])
    leading = [t.shape[:1] == (SYMBOL,) for t in inputs]
    return not inside and any(leading) and all(t.shape[:1] == (SYMBOL,) for t in outputs)


def independent(
    run: Callable[[Tensors], Sequence[torch.Tensor]],
    inputs: Sequence[TensorSpec],
    made: Tensors,
    tolerances: Sequence[Tolerance | None],
) -> bool:
    """Whether each sample gives the same results alone as in its batch, whatever the other samples are.

    This is tested on one batch: with each sample alone; and with values in the first sample that would change
    a sum, an extremum or a comparison over the batch. With these, the results of the other samples must stay
    the same bit for bit.

    Args:
        run: the method, from named inputs to outputs, eager.
        inputs: the tensors that it takes.
        made: a batch of two samples or more.
        tolerances: per output, because a vector's last elements may be rounded differently; None means exact.
    """
    batched = [t.name for t in inputs if t.shape[:1] == (SYMBOL,)]
    whole = run(made)
    for i in range(made[batched[0]].size(0)):
        alone = run({name: t[i : i + 1] if name in batched else t for name, t in made.items()})
        if not all(_close(a[0], w[i], t) for a, w, t in zip(alone, whole, tolerances, strict=True)):
            return False
    for other in _disturbed(made, batched):
        try:
            changed = run(other)
        except Exception:  # values that the op rejects
            continue
        if not all(
            torch.equal(c[1:].nan_to_num(), w[1:].nan_to_num()) for c, w in zip(changed, whole, strict=True)
        ):
            return False
    return True


def _disturbed(made: Tensors, batched: Sequence[str]) -> Iterator[Tensors]:
    changes: tuple[Callable[[torch.Tensor], torch.Tensor], ...] = (
        lambda first: first * 1e4,
        lambda first: first * -1e4,
        lambda first: first * 0,
        lambda first: first + float("nan"),
    )
    for change in changes:
        other = dict(made)
        for name in batched:
            if made[name].is_floating_point():
                other[name] = torch.cat([change(made[name][:1]).to(made[name].dtype), made[name][1:]])
        yield other
    integers = [name for name in batched if not made[name].is_floating_point()]
    yield made | {name: torch.cat([made[name][1:2], made[name][1:]]) for name in integers}


def _close(a: torch.Tensor, b: torch.Tensor, tolerance: Tolerance | None) -> bool:
    if a.shape != b.shape:
        return False
    if tolerance is None or not a.is_floating_point():
        return a.equal(b)
    return torch.allclose(a, b, rtol=tolerance.rtol, atol=tolerance.atol, equal_nan=True)
