"""Decoders of connectionist temporal classification (CTC), which has a class or a blank at each time step."""

from typing import Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_rank, check_tensor
from ..primitives.core.loops import repeated
from ..primitives.numbers.ranking import stable_topk
from ..primitives.numbers.slots import chosen_first


def ctc_greedy_decode(log_probs: Tensor, lengths: Tensor, blank: int = 0) -> Tuple[Tensor, Tensor, Tensor]:
    """Greedy CTC decoding: take the best class of each step, merge repetitions, remove blanks.

    A. Graves et al., Connectionist Temporal Classification, ICML 2006, best path decoding.

    Args:
        log_probs: (B, T, C), floating point: logarithms of the probabilities of C classes at T steps.
        lengths: (B,), int64: the number of valid steps of each sample, clamped to [0, T].
        blank: the class that means no label.

    Returns:
        Labels (B, T), int64, with ``blank`` after the last; the number of labels (B,), int64; and the
        logarithm of the alignment's probability (B,). Of equally likely classes the first one is used.

    Raises:
        TypeError: if log_probs is not floating point, or lengths not int64.
        ValueError: if log_probs is not (B, T, C), lengths not (B,), or blank is none of the classes.

    Example:
        >>> log_probs = torch.tensor([[[0.1, 0.9], [0.2, 0.8], [0.7, 0.3], [0.4, 0.6]]]).log()
        >>> ctc_greedy_decode(log_probs, torch.tensor([4]))
        (tensor([[1, 1, 0, 0]]), tensor([2]), tensor([-1.1960]))
    """
    _check(log_probs, lengths, blank)
    steps = log_probs.size(1)
    values, classes = stable_topk(log_probs, 1)
    best = classes[..., 0]
    time = torch.arange(steps, device=log_probs.device)
    counts = time < lengths[:, None]
    before = best.gather(1, (time - 1).clamp(min=0).expand_as(best))
    begins = (best != before) | (time == 0)
    emitted = counts & begins & (best != blank)
    labels = chosen_first(best, emitted, steps, blank)
    scores = torch.where(counts, values[..., 0], torch.zeros_like(values[..., 0])).sum(1)
    return labels, emitted.to(torch.int64).sum(1), scores


def ctc_beam_decode(
    log_probs: Tensor, lengths: Tensor, beam: int = 10, blank: int = 0
) -> Tuple[Tensor, Tensor, Tensor]:
    """CTC beam search: the most likely label sequences, summed over all their alignments.

    A. Hannun et al., First-Pass Large Vocabulary Continuous Speech Recognition using Bi-Directional Recurrent
    DNNs, arXiv:1408.2873, 2014, algorithm 1 without a language model. This is a prefix beam search: at each
    step the ``beam`` most likely prefixes are kept, and all classes are tried. The probability of a dropped
    prefix is lost, so a score equals the sequence's probability only if the beam is wide enough; otherwise it
    is less. Computed in float64.

    Args:
        log_probs: (B, T, C), floating point: logarithms of the probabilities of C classes at T steps.
        lengths: (B,), int64: the number of valid steps of each sample, clamped to [0, T].
        beam: the number K of prefixes that are kept, and of sequences that are returned.
        blank: the class that means no label.

    Returns:
        Labels (B, K, T), int64, with ``blank`` after the last; the number of labels (B, K), int64; and the
        logarithms of the sequences' probabilities (B, K), in descending order. For equal probabilities,
        prefixes that were already kept come first, in their order, then longer ones by prefix and class. If
        there are fewer than K sequences with a probability above 0, the remaining slots have no labels, and
        -inf.

    Raises:
        TypeError: if log_probs is not floating point, or lengths not int64.
        ValueError: if log_probs is not (B, T, C), lengths not (B,), beam is not positive, or blank is none of
            the classes.

    Example:
        >>> log_probs = torch.tensor([[[0.6, 0.4], [0.6, 0.4]]]).log()
        >>> labels, lengths, scores = ctc_beam_decode(log_probs, torch.tensor([2]), 2)
        >>> labels, lengths, scores.exp()
        (tensor([[[1, 0],
                 [0, 0]]]), tensor([[1, 0]]), tensor([[0.6400, 0.3600]]))
    """
    _check(log_probs, lengths, blank)
    if beam < 1:
        raise ValueError(f"beam: expected a positive number, got {beam}")
    batch, steps = log_probs.size(0), log_probs.size(1)
    # At first there is the empty prefix, which ends with a blank; the other slots are not in use.
    ending = torch.full([batch, beam, 2], -float("inf"), dtype=torch.float64, device=log_probs.device)
    first = torch.arange(2 * beam, device=log_probs.device).reshape(beam, 2) == 0
    ending = torch.where(first, torch.zeros_like(ending), ending)
    labels = torch.full([batch, beam, steps], -1.0, dtype=torch.float64, device=log_probs.device)
    state = _extended(
        torch.cat([ending, labels], 2), steps, log_probs.to(torch.float64), lengths, beam, blank
    )
    scores = _log_sum(state[..., 0], state[..., 1])
    scores, order = stable_topk(scores, beam)
    found = state[..., 2:].gather(1, order[..., None].expand(-1, -1, steps)).to(torch.int64)
    is_label = (found >= 0) & (scores > -float("inf"))[..., None]
    padded = torch.where(is_label, found, torch.full_like(found, blank))
    return padded, is_label.to(torch.int64).sum(2), scores.to(log_probs.dtype)


@repeated
def _extended(state: Tensor, k: Tensor, log_probs: Tensor, lengths: Tensor, beam: int, blank: int) -> Tensor:
    """The prefixes after step k. A prefix consists of the logarithms of its probabilities with a blank and
    with a label at the end, and of its labels, with -1 after the last: (B, beam, 2 + T), float64."""
    now = log_probs.index_select(1, k.reshape(1))[:, 0]
    classes, steps = now.size(1), log_probs.size(1)
    with_blank, with_label, labels = state[..., 0], state[..., 1], state[..., 2:]
    total = _log_sum(with_blank, with_label)
    count = (labels >= 0).to(torch.int64).sum(2)
    position = torch.arange(steps, device=state.device)
    is_last = position == (count - 1)[..., None]
    last = torch.where(is_last, labels, torch.zeros_like(labels)).sum(2).to(torch.int64)
    has_last = count > 0
    nothing = torch.full_like(total, -float("inf"))

    # Longer prefixes (B, beam, classes): a label that repeats the last one needs a blank between.
    index = torch.arange(classes, device=state.device)
    repeats = has_last[..., None] & (index == last[..., None])
    longer = torch.where(repeats, with_blank[..., None], total[..., None]) + now[:, None]
    longer = torch.where(index == blank, torch.full_like(longer, -float("inf")), longer).flatten(1)

    # An extended prefix may equal a prefix that is already kept: parent[b, i, j] says that prefix i plus the
    # last label of j is prefix j. Then its probability is added to j.
    shorter = torch.where(is_last, torch.full_like(labels, -1.0), labels)
    is_used = total > -float("inf")
    parent = (labels[:, :, None] == shorter[:, None]).all(3)
    parent = parent & (is_used[:, :, None] & (is_used & has_last)[:, None])
    number = torch.arange(beam, device=state.device)[:, None].expand(beam, beam)
    has_parent, which = parent.any(1), torch.where(parent, number, torch.zeros_like(number)).sum(1)
    place = which * classes + last
    inherited = torch.where(has_parent, longer.gather(1, place), nothing)
    spare = torch.full_like(place, beam * classes)
    room = torch.cat([longer, nothing[:, :1]], 1)
    longer = room.scatter(1, torch.where(has_parent, place, spare), nothing)[:, : beam * classes]

    same_with_blank = total + now[:, blank : blank + 1]
    same_with_label = torch.where(has_last, with_label + now.gather(1, last), nothing)
    same_with_label = _log_sum(same_with_label, inherited)

    candidates = torch.cat([_log_sum(same_with_blank, same_with_label), longer], 1)
    values, chosen = stable_topk(candidates, beam)
    is_longer = chosen >= beam
    beyond = (chosen - beam).clamp(min=0)
    grown = beyond // classes
    kept = chosen.clamp(max=beam - 1)
    source = torch.where(is_longer, grown, kept)
    added = (beyond - grown * classes).to(torch.float64)
    inherited_labels = labels.gather(1, source[..., None].expand(-1, -1, steps))
    is_next = (position == count.gather(1, source)[..., None]) & is_longer[..., None]
    after = torch.cat(
        [
            torch.where(is_longer, nothing, same_with_blank.gather(1, kept))[..., None],
            torch.where(is_longer, values, same_with_label.gather(1, kept))[..., None],
            torch.where(is_next, added[..., None], inherited_labels),
        ],
        2,
    )
    return torch.where((k < lengths)[:, None, None], after, state)


def _log_sum(a: Tensor, b: Tensor) -> Tensor:
    """log(exp(a) + exp(b)), also where both are -inf."""
    most = torch.maximum(a, b)
    most = torch.where(most > -float("inf"), most, torch.zeros_like(most))
    return most + torch.log(torch.exp(a - most) + torch.exp(b - most))


def _check(log_probs: Tensor, lengths: Tensor, blank: int) -> None:
    check_rank(log_probs, 3, "(B, T, C)", "log_probs")
    check_floating(log_probs, "log_probs")
    check_tensor(lengths, "lengths")
    if lengths.dim() != 1 or lengths.size(0) != log_probs.size(0):
        raise ValueError(
            f"lengths: expected shape (B,) for log_probs {list(log_probs.shape)}, got {list(lengths.shape)}"
        )
    if lengths.dtype != torch.int64:
        raise TypeError(f"lengths: expected dtype int64, got {lengths.dtype}")
    if blank < 0 or blank >= log_probs.size(2):
        raise ValueError(f"blank: expected one of {log_probs.size(2)} classes, got {blank}")
