"""The two steps of a Kalman filter: the prediction and the measurement update.

R. E. Kalman, A New Approach to Linear Filtering and Prediction Problems, Journal of Basic Engineering 82,
1960; in the notation of Y. Bar-Shalom et al., Estimation with Applications to Tracking and Navigation, 2001.
"""

from typing import Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import (
    check_broadcastable,
    check_floating,
    check_matrix,
)
from ..primitives.linalg.matrices import small_matmul, solve


def kalman_predict(
    mean: Tensor, covariance: Tensor, transition: Tensor, process_noise: Tensor
) -> Tuple[Tensor, Tensor]:
    """Predict a state after one time step: F x, with the covariance F P F' + Q. Computed in float64.

    Args:
        mean: (*, D), floating point, x: any number of states, for example (B, N, D).
        covariance: (*, D, D), P, symmetric.
        transition: (D, D) for all, or (*, D, D) for each, F: the state is multiplied by it.
        process_noise: (D, D) or (*, D, D), Q, symmetric: the covariance of the process noise.

    Returns:
        The state (*, D) and its covariance (*, D, D), symmetric.

    Raises:
        TypeError: if an argument is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> position_and_speed, covariance = torch.tensor([[3.0, 2.0]]), torch.eye(2)[None]
        >>> transition = torch.tensor([[1.0, 1.0], [0.0, 1.0]])
        >>> kalman_predict(position_and_speed, covariance, transition, 0.5 * torch.eye(2))
        (tensor([[5., 2.]]), tensor([[[2.5000, 1.0000],
                 [1.0000, 1.5000]]]))
    """
    size = _check_state(mean, covariance)
    _check_for_states(transition, size, size, mean, "transition")
    _check_for_states(process_noise, size, size, mean, "process_noise")
    f, p = transition.to(torch.float64), covariance.to(torch.float64)
    x = small_matmul(f, mean.to(torch.float64)[..., None])[..., 0]
    spread = _symmetric(_spread(f, p) + process_noise.to(torch.float64))
    return x.to(mean.dtype), spread.to(mean.dtype)


def kalman_update(
    mean: Tensor, covariance: Tensor, measurement: Tensor, observation: Tensor, measurement_noise: Tensor
) -> Tuple[Tensor, Tensor]:
    """Update a state by a measurement z of H x: x + K (z - H x), with the gain K = P H' (H P H' + R)^-1.

    The covariance is computed in Joseph's form, (I - K H) P (I - K H)' + K R K', which stays positive
    definite despite rounding. Computed in float64.

    Args:
        mean: (*, D), floating point, x: any number of states, for example (B, N, D).
        covariance: (*, D, D), P, symmetric.
        measurement: (*, E), floating point, z: one for each state.
        observation: (E, D) for all, or (*, E, D) for each, H: the matrix from a state to its measurement.
        measurement_noise: (E, E) for all, or (*, E, E) for each, R, symmetric and positive definite: the
            covariance of a measurement's error.

    Returns:
        The state (*, D) and its covariance (*, D, D), symmetric.

    Raises:
        TypeError: if an argument is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> mean, covariance = torch.tensor([[5.0, 2.0]]), torch.diag(torch.tensor([3.0, 1.0]))[None]
        >>> position = torch.tensor([[1.0, 0.0]])
        >>> kalman_update(mean, covariance, torch.tensor([[9.0]]), position, torch.ones(1, 1))
        (tensor([[8., 2.]]), tensor([[[0.7500, 0.0000],
                 [0.0000, 1.0000]]]))
    """
    size = _check_state(mean, covariance)
    check_floating(measurement, "measurement")
    if measurement.dim() != mean.dim() or measurement.shape[:-1] != mean.shape[:-1]:
        raise ValueError(
            f"measurement: expected shape (*, E) for mean {list(mean.shape)}, got {list(measurement.shape)}"
        )
    measured = measurement.size(-1)
    _check_for_states(observation, measured, size, mean, "observation")
    _check_for_states(measurement_noise, measured, measured, mean, "measurement_noise")
    x, p = mean.to(torch.float64), covariance.to(torch.float64)
    h, r = observation.to(torch.float64), measurement_noise.to(torch.float64)
    # H P, and K' as the solution of (H P H' + R) K' = H P
    seen = small_matmul(h, p)
    of_measurement = small_matmul(seen, h.transpose(-1, -2)) + r
    gain = solve(of_measurement, seen).transpose(-1, -2)
    surprise = measurement.to(torch.float64)[..., None] - small_matmul(h, x[..., None])
    x = x + small_matmul(gain, surprise)[..., 0]
    left = torch.eye(size, dtype=torch.float64, device=mean.device) - small_matmul(gain, h)
    spread = _symmetric(_spread(left, p) + _spread(gain, r))
    return x.to(mean.dtype), spread.to(mean.dtype)


def _spread(a: Tensor, covariance: Tensor) -> Tensor:
    """The covariance of a x."""
    return small_matmul(small_matmul(a, covariance), a.transpose(-1, -2))


def _symmetric(m: Tensor) -> Tensor:
    return 0.5 * (m + m.transpose(-1, -2))


def _check_state(mean: Tensor, covariance: Tensor) -> int:
    """Raise unless the covariance fits the states; returns their size D."""
    check_floating(mean, "mean")
    if mean.dim() < 1:
        raise ValueError(f"mean: expected shape (*, D), got {list(mean.shape)}")
    size = mean.size(-1)
    check_matrix(covariance, size, size, "covariance")
    if covariance.shape[:-1] != mean.shape:
        raise ValueError(
            f"covariance: expected shape (*, D, D) for mean {list(mean.shape)}, got {list(covariance.shape)}"
        )
    return size


def _check_for_states(matrix: Tensor, rows: int, columns: int, mean: Tensor, name: str) -> None:
    check_matrix(matrix, rows, columns, name)
    check_broadcastable(matrix, mean, name, "mean", 2, 1)
    if matrix.dim() > mean.dim() + 1:
        raise ValueError(f"{name}: expected no more dimensions than covariance, got {list(matrix.shape)}")
