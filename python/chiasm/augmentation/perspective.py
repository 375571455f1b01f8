"""Random perspective."""

from typing import Any, Dict, List

import torch
from torch import Tensor

from ..geometry.transform.matrices import get_perspective_transform
from ..primitives.core.checks import check_choice
from ..primitives.random.draws import uniform
from .base import check_batch
from .decisions import below
from .settings import number
from .warps import Warp, chosen, warped


def _draw(seed: Tensor, shape: List[int], scale: float, method: str, p: float) -> Dict[str, Tensor]:
    if not (scale >= 0.0 and scale <= 1.0):
        raise ValueError(f"distortion_scale: expected 0 to 1, got {scale}")
    u = uniform(seed, 9)
    offset = u[:, 1:].to(torch.float64).reshape(-1, 4, 2)
    unit = torch.tensor(
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], dtype=torch.float64, device=seed.device
    )
    size = torch.ones(2, dtype=torch.float64, device=seed.device)
    size = torch.stack([size[0] * shape[3], size[1] * shape[2]])
    # The centres of the corner pixels; along a side of one pixel its edges.
    last = size - 1.0
    start = (0.5 * last + (unit - 0.5) * last.clamp(min=1.0)).expand(seed.size(0), 4, 2)
    # Towards the centre, or in any direction.
    moved = offset * 2.0 - 1.0 if method == "area_preserving" else offset * (1.0 - 2.0 * unit)
    return {
        "batch_prob": below(u[:, 0], p),
        "start_points": start,
        "end_points": start + moved * (size * (0.5 * scale)),
    }


def _matrix(params: Dict[str, Tensor]) -> Tensor:
    start, end = params["start_points"].to(torch.float64), params["end_points"].to(torch.float64)
    return chosen(get_perspective_transform(start, end), params)


def random_perspective(
    input: Tensor,
    seed: Tensor,
    distortion_scale: float = 0.5,
    resample: str = "bilinear",
    align_corners: bool = False,
    p: float = 0.5,
    sampling_method: str = "basic",
) -> Tensor:
    """Warp some images by a random perspective: each corner moves independently.

    Args:
        input: (B, C, H, W), floating point or uint8.
        seed: (B,), int64.
        distortion_scale: the largest move of a corner, as a fraction of half the width and half the height, 0
            to 1.
        resample: "bilinear", "nearest" or "bicubic".
        align_corners: for compatibility with Kornia; it has no effect, since pixels outside the image are
            black.
        p: the probability of each image.
        sampling_method: "basic" moves corners towards the centre, "area_preserving" in any direction.

    Returns:
        (B, C, H, W). Differentiable in input.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> x = torch.arange(9.0).reshape(1, 1, 3, 3)
        >>> random_perspective(x, torch.tensor([0]), 0.0, p=1.0).round().equal(x)
        True
    """
    check_batch(input, seed)
    check_choice(sampling_method, ["basic", "area_preserving"], "sampling_method")
    params = _draw(seed, list(input.shape), distortion_scale, sampling_method, p)
    height, width = input.size(2), input.size(3)
    return warped(input, _matrix(params), height, width, resample, "zeros", align_corners, False)


class RandomPerspective(Warp):
    """``random_perspective`` as a module.

    Args:
        distortion_scale, resample, align_corners, sampling_method: as in ``random_perspective``.
        same_on_batch, p, keepdim: as in ``AugmentationBase``.

    Example:
        >>> augment = RandomPerspective(0.5)
        >>> augment(torch.rand(2, 3, 8, 10)).shape
        torch.Size([2, 3, 8, 10])
        >>> augment.transform_matrix.shape
        torch.Size([2, 3, 3])
    """

    def __init__(
        self,
        distortion_scale: Any = 0.5,
        resample: Any = "bilinear",
        same_on_batch: bool = False,
        align_corners: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
        sampling_method: str = "basic",
    ) -> None:
        super().__init__(resample, "zeros", align_corners, p, same_on_batch, keepdim, affine=False)
        check_choice(sampling_method, ["basic", "area_preserving"], "sampling_method")
        self.distortion_scale = number("distortion_scale", distortion_scale)
        self.sampling_method = sampling_method
        if not 0.0 <= self.distortion_scale <= 1.0:
            raise ValueError(f"distortion_scale: expected 0 to 1, got {distortion_scale}")

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        return _draw(seed, shape, self.distortion_scale, self.sampling_method, self.p)

    def compute_transformation(self, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return _matrix(params)
