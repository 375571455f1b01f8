"""Ops that track objects from frame to frame: assignment, Kalman filters, trackers."""

from typing import Any

import numpy as np
import torch
from torch import Generator, Tensor

from ..peer import Peer, opencv
from ..spec import Spec, TensorSpec
from . import add

# --- assignment ---------------------------------------------------------------------------------------------


def _costs(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Costs, some of them of impossible pairs."""
    batch, n, m = sizes["B"], sizes["N"], sizes["M"]
    cost = torch.rand((batch, n, m), generator=generator, dtype=torch.float64)
    cannot = torch.rand((batch, n, m), generator=generator) < 0.2
    return {
        "cost": cost.masked_fill(cannot, float("inf")).to(dtype),
        "rows": torch.rand((batch, n), generator=generator) < 0.9,
        "columns": torch.rand((batch, m), generator=generator) < 0.9,
    }


def _assigned(optimize: Any, cost: np.ndarray, rows: np.ndarray, columns: np.ndarray) -> tuple[Any, ...]:
    """SciPy's, with impossible pairs that cost more than all others together."""
    possible = np.isfinite(cost) & rows[:, None] & columns
    i, j = optimize.linear_sum_assignment(np.where(possible, cost, 1e4))
    has_one, column = np.zeros(len(cost), bool), np.zeros(len(cost), np.int64)
    has_one[i], column[i] = possible[i, j], np.where(possible[i, j], j, 0)
    return column, has_one


add(
    Spec(
        "ops.linear_assignment",
        [
            TensorSpec("cost", ("B", "N", "M"), description="of each pair, infinity where it cannot be"),
            TensorSpec("rows", ("B", "N"), "bool", description="which take part"),
            TensorSpec("columns", ("B", "M"), "bool", description="which take part"),
        ],
        [
            TensorSpec("indices", description="of the column of each row"),
            TensorSpec("assigned", description="which rows have a column"),
        ],
        also=({"max_cost": 0.5},),
        symbols={"B": (1, 64), "N": (1, 1024), "M": (1, 1024)},
        gradients=(),
        make_inputs=_costs,
        peer=Peer("scipy.optimize", _assigned, "samples"),
        reference="scipy.optimize.linear_sum_assignment",
        picture="tensors",
    )
)

# --- Kalman filters -----------------------------------------------------------------------------------------


def _covariances(generator: Generator, *shape: int):
    """Symmetric positive definite matrices."""
    factor = torch.randn((*shape, shape[-1]), generator=generator, dtype=torch.float64)
    return factor @ factor.mT / shape[-1] + 0.5 * torch.eye(shape[-1], dtype=torch.float64)


def _states(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    batch, count = sizes["B"], sizes["N"]

    def normal(*shape: int):
        return torch.randn(shape, generator=generator, dtype=torch.float64)

    made = {
        "mean": normal(batch, count, 7),
        "covariance": _covariances(generator, batch, count, 7),
        "transition": torch.eye(7, dtype=torch.float64) + 0.3 * normal(7, 7),
        "process_noise": _covariances(generator, 7),
        "measurement": normal(batch, count, 4),
        "observation": normal(4, 7),
        "measurement_noise": _covariances(generator, 4),
    }
    return {name: value.to(dtype) for name, value in made.items()}


def _filter(cv2: Any, mean: np.ndarray, covariance: np.ndarray) -> Any:
    kalman = cv2.KalmanFilter(7, 4)
    # it writes into what it gets
    kalman.statePost, kalman.statePre = np.array(mean[:, None]), np.array(mean[:, None])
    kalman.errorCovPost, kalman.errorCovPre = np.array(covariance), np.array(covariance)
    return kalman


def _predicted(cv2: Any, means: Any, covariances: Any, transition: Any, noise: Any) -> tuple[Any, ...]:
    made: list[Any] = []
    for mean, covariance in zip(means, covariances, strict=True):
        kalman = _filter(cv2, mean, covariance)
        kalman.transitionMatrix, kalman.processNoiseCov = transition, noise
        made.append((kalman.predict()[:, 0], kalman.errorCovPre))
    return tuple(np.stack(part) for part in zip(*made, strict=True))


def _updated(
    cv2: Any, means: Any, covariances: Any, measured: Any, observation: Any, noise: Any
) -> tuple[Any, ...]:
    made: list[Any] = []
    for mean, covariance, z in zip(means, covariances, measured, strict=True):
        kalman = _filter(cv2, mean, covariance)
        kalman.measurementMatrix, kalman.measurementNoiseCov = observation, noise
        made.append((kalman.correct(z[:, None])[:, 0], kalman.errorCovPost))
    return tuple(np.stack(part) for part in zip(*made, strict=True))


_STATE = [
    TensorSpec("mean", ("B", "N", 7), description="states"),
    TensorSpec("covariance", ("B", "N", 7, 7), description="of the states"),
]
_NEW_STATE = [
    TensorSpec("new_mean", description="the states after it"),
    TensorSpec("new_covariance", description="their covariances"),
]
for _name, _peer, _others in (
    (
        "kalman_predict",
        opencv(_predicted, "samples", timed=False),
        [
            TensorSpec("transition", (7, 7), description="what a state is multiplied by"),
            TensorSpec("process_noise", (7, 7), description="a covariance"),
        ],
    ),
    (
        "kalman_update",
        opencv(_updated, "samples", timed=False),
        [
            TensorSpec("measurement", ("B", "N", 4), description="one of each state"),
            TensorSpec("observation", (4, 7), description="what is measured of a state"),
            TensorSpec("measurement_noise", (4, 4), description="a covariance"),
        ],
    ),
):
    add(
        Spec(
            f"ops.{_name}",
            [*_STATE, *_others],
            _NEW_STATE,
            symbols={"B": (1, 64), "N": (1, 1 << 14)},
            make_inputs=_states,
            peer=_peer,
            reference="OpenCV KalmanFilter; the equations in NumPy float64",
            picture="tensors",
        )
    )

# --- trackers -----------------------------------------------------------------------------------------------


def _corners(centres: Tensor, sides: Tensor) -> Tensor:
    return torch.cat([centres - sides / 2, centres + sides / 2], -1)


def _followed(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Tracks, most with a detection near them, and detections, some without a track."""
    batch, slots, count = sizes["B"], sizes["K"], sizes["M"]

    def uniform(*shape: int):
        return torch.rand(shape, generator=generator, dtype=torch.float64)

    extent = 60.0 * max(slots, count) ** 0.5
    centres, height = extent * uniform(batch, max(slots, count), 2), 30 + 30 * uniform(batch, slots, 1)
    centres = centres[:, torch.randperm(centres.size(1), generator=generator)]
    ratio = 0.5 + uniform(batch, slots, 1)
    speed = 4 * uniform(batch, slots, 3) - 2
    mean = torch.cat([centres[:, :slots], ratio * height**2, ratio, speed], 2)
    alive = uniform(batch, slots) < 0.7
    since = (3 * uniform(batch, slots)).long()
    identity = torch.arange(1, slots + 1).expand(batch, slots)
    counters = torch.stack([identity, 5 + since, 1 + (4 * uniform(batch, slots)).long(), since], 2)
    near = centres[:, :count] + 8 * uniform(batch, count, 2)
    return {
        "mean": (mean * alive[..., None]).to(dtype),
        "covariance": (4 * _covariances(generator, batch, slots, 7) * alive[..., None, None]).to(dtype),
        "counters": counters * alive[..., None],
        "last_id": torch.full([batch], slots),
        "boxes": _corners(near, 30 + 30 * uniform(batch, count, 2)).to(dtype),
        "scores": uniform(batch, count).to(dtype),
        "found": uniform(batch, count) < 0.8,
    }


_TRACKS = [
    TensorSpec("mean", ("B", "K", 7), description="centre, area, aspect ratio and their speeds"),
    TensorSpec("covariance", ("B", "K", 7, 7), description="of the mean"),
    TensorSpec("counters", ("B", "K", 4), "int64", description="identity, age, hits, frames since the last"),
    TensorSpec("last_id", ("B",), "int64", description="the last identity that was given"),
    TensorSpec("boxes", ("B", "M", 4), description="x1, y1, x2, y2 of detections"),
]
_SCORES = TensorSpec("scores", ("B", "M"), range=(0.0, 1.0), description="of the detections")
_FOUND = TensorSpec("found", ("B", "M"), "bool", description="which slots hold a detection")
for _name, _inputs in (("sort_track", [*_TRACKS, _FOUND]), ("byte_track", [*_TRACKS, _SCORES, _FOUND])):
    add(
        Spec(
            f"ops.{_name}",
            _inputs,
            [
                TensorSpec("new_mean", description="for the next frame"),
                TensorSpec("new_covariance", description="for the next frame"),
                TensorSpec("new_counters", description="for the next frame"),
                TensorSpec("new_last_id", description="for the next frame"),
                TensorSpec("tracked_boxes", description="x1, y1, x2, y2"),
                TensorSpec("indices", description="of the detections that the tracks are in this frame"),
                TensorSpec("shown", description="which tracks have a detection in this frame, and enough"),
            ],
            symbols={"B": (1, 64), "K": (1, 1024), "M": (1, 1024)},
            gradients=(),
            make_inputs=_followed,
            reference="the paper's algorithm in NumPy, with scipy.optimize.linear_sum_assignment",
            picture="tensors",
        )
    )
