"""One step of an optimiser as a function of tensors: parameters, gradients and state in, parameters and state
out.

The same arithmetic as torch.optim's, in a form that can be exported with the loss and its gradient as one
graph.
"""

from typing import Tuple

import torch
from torch import Tensor


def adam(
    parameter: Tensor, gradient: Tensor, mean: Tensor, square: Tensor, step: Tensor, lr: Tensor
) -> Tuple[Tensor, Tensor, Tensor]:
    """D. Kingma, J. Ba, Adam: A Method for Stochastic Optimization, ICLR 2015, with its constants 0.9, 0.999
    and 1e-8.

    Args:
        parameter, gradient: of one shape.
        mean, square: of the same shape, the moving averages of the gradient and of its square; zeros at
        first. step: (), the number of the step, from 1. lr: (), the learning rate.

    Returns:
        parameter, mean and square after the step.

    Example:
        >>> adam(
        ...     torch.ones(1),
        ...     torch.full((1,), 3.0),
        ...     torch.zeros(1),
        ...     torch.zeros(1),
        ...     torch.tensor(1.0),
        ...     torch.tensor(0.5),
        ... )[0]
        tensor([0.5000])
    """
    mean = 0.9 * mean + 0.1 * gradient
    square = 0.999 * square + 0.001 * gradient * gradient
    unbiased_mean = mean / (1.0 - torch.pow(0.9, step))
    unbiased_square = square / (1.0 - torch.pow(0.999, step))
    return parameter - lr * unbiased_mean / (torch.sqrt(unbiased_square) + 1e-8), mean, square


def momentum(
    parameter: Tensor, gradient: Tensor, velocity: Tensor, lr: Tensor, factor: float = 0.9
) -> Tuple[Tensor, Tensor]:
    """Stochastic gradient descent with momentum, like torch.optim.SGD.

    Args:
        parameter, gradient: of one shape.
        velocity: of the same shape; zeros at first.
        lr: (), the learning rate.
        factor: the part of the velocity that is kept.

    Returns:
        parameter and velocity after the step.

    Example:
        >>> momentum(torch.ones(1), torch.ones(1), torch.ones(1), torch.tensor(0.5))
        (tensor([0.0500]), tensor([1.9000]))
    """
    velocity = factor * velocity + gradient
    return parameter - lr * velocity, velocity
