"""Skeletons of binary images."""

from torch import Tensor

from ..primitives.core.checks import check_image
from ..primitives.features.thinning import thinned


def skeletonize(input: Tensor, num_iters: int = 10000) -> Tensor:
    """Thin shapes to lines one pixel wide, by peeling their outlines until nothing changes.

    Not in Kornia. T. Y. Zhang, C. Y. Suen, A fast parallel algorithm for thinning digital patterns, CACM
    27(3), 1984, exactly as published: squares of 2 x 2 pixels vanish, and scikit-image's
    ``skeletonize(method="zhang")``, whose table also removes some corners, differs by single pixels. A round
    removes a pixel from every side, so the number of rounds is about half the width of a shape.

    Args:
        input: (B, C, H, W), floating point; pixels above 0 are set. Pixels outside the image are not set.
        num_iters: the maximum number of rounds.

    Returns:
        (B, C, H, W), 0 or 1.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D or num_iters is negative.

    Example:
        >>> skeletonize(torch.ones(1, 1, 3, 7))[0, 0]
        tensor([[0., 0., 0., 0., 0., 0., 0.],
                [0., 1., 1., 1., 1., 0., 0.],
                [0., 0., 0., 0., 0., 0., 0.]])
    """
    return _thinned(input, num_iters, True)


def thin(input: Tensor, num_iters: int = 10000) -> Tensor:
    """Thin shapes to lines one pixel wide, keeping every connected shape.

    Not in Kornia. Z. Guo, R. W. Hall, Parallel thinning with two-subiteration algorithms, CACM 32(3), 1989;
    Like scikit-image's ``thin``.

    Args:
        input: (B, C, H, W), floating point; pixels above 0 are set. Pixels outside the image are not set.
        num_iters: the maximum number of rounds.

    Returns:
        (B, C, H, W), 0 or 1.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D or num_iters is negative.

    Example:
        >>> thin(torch.ones(1, 1, 3, 7))[0, 0]
        tensor([[0., 0., 0., 0., 0., 0., 0.],
                [0., 1., 1., 1., 1., 1., 0.],
                [0., 0., 0., 0., 0., 0., 0.]])
    """
    return _thinned(input, num_iters, False)


def _thinned(input: Tensor, num_iters: int, zhang: bool) -> Tensor:
    check_image(input, "input")
    if num_iters < 0:
        raise ValueError(f"num_iters: expected at least 0, got {num_iters}")
    return thinned(input, num_iters, zhang)
