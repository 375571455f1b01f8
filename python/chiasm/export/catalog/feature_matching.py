"""Features: matching of descriptors."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import torch
from torch import Generator, Tensor

from ..peer import Peer, opencv
from ..spec import InputMaker, Spec, TensorSpec
from . import add
from .feature_frames import frames

_SIZES = {"M": (2, 1 << 20), "D": (2, 4096)}
_FIRST = TensorSpec("desc1", ("B", "N", "D"), description="descriptors of the first image")
_SECOND = TensorSpec("desc2", ("B", "M", "D"), description="descriptors of the second image")
_MASKS = [
    TensorSpec("mask1", ("B", "N"), "bool", description="which are there"),
    TensorSpec("mask2", ("B", "M"), "bool", description="which are there"),
]
_FRAMES = [
    TensorSpec("lafs1", ("B", "N", 2, 3), description="their frames"),
    TensorSpec("lafs2", ("B", "M", 2, 3), description="their frames"),
]


def _made(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """The second set has some of the first, with noise."""
    batch, count, others, channels = (sizes[k] for k in ("B", "N", "M", "D"))
    first = torch.rand((batch, count, channels), generator=generator, dtype=torch.float64)
    noise = 0.3 * torch.rand((batch, others, channels), generator=generator, dtype=torch.float64)
    second = first[:, torch.arange(others) * 3 % count] + noise
    there = torch.rand((batch, count + others), generator=generator) < 0.8
    made = {
        "desc1": first,
        "desc2": second,
        "lafs1": frames(generator, sizes),
        "lafs2": frames(generator, {**sizes, "N": others}),
    }
    return {
        **{name: value.to(dtype) for name, value in made.items()},
        "mask1": there[:, :count].clone(),
        "mask2": there[:, count:].clone(),
    }


def _make_moved(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """A common similarity maps all frames except every fifth; descriptors are nearly the same."""
    batch, count, others = (sizes[k] for k in ("B", "N", "M"))
    shared = min(count, others)
    made = _made(generator, sizes, dtype)
    first, noise = (
        torch.rand((batch, count, sizes["D"]), generator=generator, dtype=torch.float64),
        torch.rand((batch, others, sizes["D"]), generator=generator, dtype=torch.float64),
    )
    lafs1, lafs2 = frames(generator, sizes), frames(generator, {**sizes, "N": others})
    moved = torch.tensor([[0.9, -0.4], [0.4, 0.9]], dtype=torch.float64) @ lafs1[:, :shared]
    jitter = torch.rand((batch, shared, 2), generator=generator, dtype=torch.float64)
    moved[..., 2] += torch.tensor([40.0, 3.0], dtype=torch.float64) + jitter
    kept = torch.arange(shared) % 5 != 3
    lafs2[:, :shared][:, kept] = moved[:, kept]
    second = noise.clone()
    second[:, :shared] = first[:, :shared] + 0.1 * noise[:, :shared]
    size = torch.full((batch, 2), 100.0, dtype=torch.float64)
    float_inputs = {
        "desc1": first,
        "desc2": second,
        "lafs1": lafs1,
        "lafs2": lafs2,
        "hw1": size,
        "hw2": 1.3 * size,
    }
    return {**made, **{name: value.to(dtype) for name, value in float_inputs.items()}}


def _add(
    name: str,
    inputs: Sequence[TensorSpec],
    measure: str,
    reference: str,
    make_inputs: InputMaker = _made,
    **rest: Any,
):
    add(
        Spec(
            f"feature.{name}",
            inputs,
            [
                TensorSpec("distances", description=f"{measure}, 0 where not valid"),
                TensorSpec("indices", description="into both sets, -1 where not valid"),
                TensorSpec("valid", description="which descriptors of the first image have a match"),
            ],
            symbols=_SIZES,
            gradients=("desc1", "desc2"),
            make_inputs=make_inputs,
            reference=reference,
            picture="matches",
            **rest,
        ),
        fn=f"feature.{name.partition('.')[0]}",
    )


def _in_rows(count: int, found: Mapping[int, tuple[int, float]]) -> tuple[np.ndarray, ...]:
    """Distances, indices and validity, of {row: (index, distance)}."""
    distances, indices = np.zeros((count, 1)), np.full((count, 2), -1)
    for i, (j, distance) in found.items():
        distances[i], indices[i] = distance, (i, j)
    return distances, indices, indices[:, 0] >= 0


def _nearest(mutual: bool) -> Peer:
    """OpenCV's brute-force matcher, of the descriptors that are there."""

    def call(cv2: Any, first: Any, second: Any, *which: Any) -> Any:
        matches = cv2.BFMatcher(cv2.NORM_L2, crossCheck=mutual).match(first, second)
        return which or len(first), matches

    def before(first: Any, second: Any, *masks: Any) -> tuple[Any, ...]:
        if not masks:
            return first, second
        return first[masks[0]], second[masks[1]], *masks

    def after(made: Any) -> tuple[np.ndarray, ...]:
        which, matches = made
        if isinstance(which, int):
            return _in_rows(which, {m.queryIdx: (m.trainIdx, m.distance) for m in matches})
        rows, columns = (np.flatnonzero(mask).tolist() for mask in which)
        found = {rows[m.queryIdx]: (columns[m.trainIdx], m.distance) for m in matches}
        return _in_rows(len(which[0]), found)

    return opencv(call, "samples", before=before, after=after, timed=False)


def _ratios(cv2: Any, first: Any, second: Any, most: float) -> dict[int, tuple[int, float]]:
    both = cv2.BFMatcher(cv2.NORM_L2).knnMatch(first, second, k=2)
    return {
        m.queryIdx: (m.trainIdx, m.distance / n.distance) for m, n in both if m.distance <= most * n.distance
    }


def _one_way(cv2: Any, first: Any, second: Any) -> tuple[np.ndarray, ...]:
    return _in_rows(len(first), _ratios(cv2, first, second, 0.9))


def _both_ways(cv2: Any, first: Any, second: Any) -> tuple[np.ndarray, ...]:
    there, back = _ratios(cv2, first, second, 0.95), _ratios(cv2, second, first, 0.95)
    mutual = {i: (j, max(r, back[j][1])) for i, (j, r) in there.items() if back.get(j, (-1, 0.0))[0] == i}
    return _in_rows(len(first), mutual)


_NEAREST = ("Euclidean distances", "OpenCV BFMatcher")
_MUTUAL = ("Euclidean distances", "OpenCV BFMatcher with crossCheck")
_add("match_nn.plain", [_FIRST, _SECOND], *_NEAREST, peer=_nearest(False))
_add("match_nn.masked", [_FIRST, _SECOND, *_MASKS], *_NEAREST, peer=_nearest(False))
_add("match_mnn.plain", [_FIRST, _SECOND], *_MUTUAL, peer=_nearest(True))
_add("match_mnn.masked", [_FIRST, _SECOND, *_MASKS], *_MUTUAL, peer=_nearest(True))
_add(
    "match_snn",
    [_FIRST, _SECOND],
    "ratios of distances",
    "OpenCV BFMatcher knnMatch",
    peer=opencv(_one_way, "samples", timed=False),
    config={"th": 0.9},
)
_add(
    "match_smnn",
    [_FIRST, _SECOND],
    "larger ratios of distances",
    "OpenCV BFMatcher knnMatch both ways",
    peer=opencv(_both_ways, "samples", timed=False),
    config={"th": 0.95},
)
_add(
    "match_smnn_batched",
    [_FIRST, _SECOND, *_MASKS],
    "larger ratios of distances",
    "OpenCV BFMatcher knnMatch both ways",
    config={"th": 0.95},
)
_add(
    "match_fginn.plain",
    [_FIRST, _SECOND, *_FRAMES],
    "ratios of distances",
    "a loop in NumPy",
    config={"th": 0.9},
)
_add(
    "match_fginn.mutual",
    [_FIRST, _SECOND, *_FRAMES, *_MASKS],
    "ratios of distances",
    "a loop in NumPy",
    config={"th": 0.95, "spatial_th": 20.0, "mutual": True},
)

_ADALAM = {"area_ratio": 5.0, "ransac_iters": 40, "min_inliers": 3, "num_seeds": 16, "num_neighbors": 24}
_IMAGES = [
    TensorSpec("hw1", ("B", 2), description="the first image's height and width"),
    TensorSpec("hw2", ("B", 2), description="those of the second"),
]
_TRUTH = "scenes with known matches; a loop in NumPy"
_NO_RANK = "what is near NaN has no rank, and engines order NaN differently"
_add(
    "match_adalam.plain",
    [_FIRST, _SECOND, *_FRAMES],
    "Euclidean distances",
    _TRUTH,
    _make_moved,
    config=_ADALAM,
    special_values=_NO_RANK,
)
_add(
    "match_adalam.masked",
    [_FIRST, _SECOND, *_FRAMES, *_IMAGES, *_MASKS],
    "Euclidean distances",
    _TRUTH,
    _make_moved,
    config=_ADALAM,
    special_values=_NO_RANK,
)
