"""Harris corners."""

from typing import Optional, Tuple, Union

import torch
import torch.nn.functional as F
from torch import Tensor

from ..geometry.subpix import nms2d
from ..primitives.core.checks import check_image, check_one_channel
from ..primitives.numbers.ranking import stable_topk
from ..primitives.resampling.warping import position_dtype
from .structure import normalised_by_scale, structure_tensor


def harris_response(
    input: Tensor, k: float = 0.04, grads_mode: str = "sobel", sigmas: Optional[Tensor] = None
) -> Tensor:
    """Cornerness det(S) - k trace(S)^2 of the structure tensor S, smoothed by a 7x7 Gaussian of sigma 1.

    C. Harris, M. Stephens, A combined corner and edge detector, Alvey Vision Conference 1988.

    Args:
        input: (B, C, H, W), floating point, H and W at least 4. Half precision is computed in float32.
        k: weight of the trace, usually 0.04 to 0.06.
        grads_mode: "sobel" or "diff", see ``spatial_gradient``.
        sigmas: (B,) scales; the response is multiplied by their fourth power.

    Returns:
        (B, C, H, W); large and positive at corners, negative on edges.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not 4-D, sigmas not 1-D, or grads_mode unknown.

    Example:
        >>> harris_response(torch.ones(1, 1, 5, 6)).abs().max()
        tensor(0.)
    """
    check_image(input, "input")
    xx, yy, xy = structure_tensor(input, grads_mode)
    trace = xx + yy
    return normalised_by_scale(xx * yy - xy * xy - k * trace * trace, sigmas).to(input.dtype)


def harris_keypoints(
    input: Tensor,
    max_keypoints: int,
    k: float = 0.04,
    nms_size: Union[int, Tuple[int, int]] = 5,
    threshold: float = 0.0,
) -> Tuple[Tensor, Tensor, Tensor]:
    """Detect the strongest Harris corners, in a fixed number of slots.

    Args:
        input: grey image (B, 1, H, W), floating point.
        max_keypoints: number K of slots.
        k: see ``harris_response``.
        nms_size: size of the window of ``nms2d``: only a strict maximum of its window is kept, and the window
            must lie inside the image.
        threshold: a corner's response must exceed it; not negative.

    Returns:
        keypoints (B, K, 2), x and y in pixels, float32 of half precision, (-1, -1) in slots without a corner;
        scores (B, K), descending, equal ones by position (row by row), 0 in slots without a corner; valid (B,
        K), bool.

    Raises:
        TypeError: if input is not floating point.
        ValueError: if input is not (B, 1, H, W), max_keypoints not positive or threshold negative.

    Example:
        >>> image = torch.zeros(1, 1, 16, 16)
        >>> image[..., 8:, 8:] = 1.0
        >>> keypoints, scores, valid = harris_keypoints(image, 4)
        >>> keypoints.shape, scores.shape, int(valid.sum())
        (torch.Size([1, 4, 2]), torch.Size([1, 4]), 1)
    """
    check_one_channel(input, "input")
    if max_keypoints < 1:
        raise ValueError(f"max_keypoints: expected a positive number, got {max_keypoints}")
    if not threshold >= 0.0:
        raise ValueError(f"threshold: expected a number >= 0, got {threshold}")
    width = input.size(3)
    maxima = nms2d(harris_response(input, k), nms_size)
    # A small image may have fewer pixels than there are slots.
    flat = F.pad(maxima.flatten(1), [0, max_keypoints], "constant", -1.0)
    scores, index = stable_topk(flat, max_keypoints)
    valid = scores > threshold
    # Exact, where integer division in ONNX goes through float32
    row = torch.floor(index.to(torch.float64) / width).to(torch.int64)
    position = torch.stack([index - row * width, row], -1).to(position_dtype(input.dtype))
    keypoints = torch.where(valid[..., None], position, torch.full_like(position, -1.0))
    return keypoints, torch.where(valid, scores, torch.zeros_like(scores)), valid
