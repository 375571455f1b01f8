"""Random rotations."""

from typing import Any, Dict, List, Tuple

import torch
from torch import Tensor

from ..geometry.transform.matrices import get_rotation_matrix2d, homogeneous
from ..primitives.core.checks import check_interval
from ..primitives.random.draws import between, uniform
from .base import Range, check_batch
from .decisions import below
from .settings import symmetric
from .warps import Warp, chosen, middle, warped


def _draw(seed: Tensor, degrees: Tuple[float, float], p: float) -> Dict[str, Tensor]:
    check_interval(degrees, "degrees")
    u = uniform(seed, 2)
    return {"batch_prob": below(u[:, 0], p), "degrees": between(u[:, 1], degrees[0], degrees[1])}


def _matrix(params: Dict[str, Tensor], height: int, width: int) -> Tensor:
    degrees = params["degrees"].to(torch.float64)
    one = torch.ones_like(degrees)[:, None].expand(-1, 2)
    rotation = get_rotation_matrix2d(middle(degrees, height, width), degrees, one)
    return chosen(homogeneous(rotation), params)


def random_rotation(
    input: Tensor,
    seed: Tensor,
    degrees: Tuple[float, float],
    resample: str = "bilinear",
    align_corners: bool = True,
    p: float = 0.5,
) -> Tensor:
    """Rotate some images about their centres.

    Args:
        input: (B, C, H, W), floating point or uint8.
        seed: (B,), int64.
        degrees: the range of angles, counterclockwise as seen.
        resample: "bilinear", "nearest" or "bicubic".
        align_corners: for compatibility with Kornia; it has no effect, since pixels outside the image are
            black.
        p: the probability of each image.

    Returns:
        (B, C, H, W). Differentiable in input.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> x = torch.tensor([[[[1.0, 2.0], [3.0, 4.0]]]])
        >>> random_rotation(x, torch.tensor([0]), (90.0, 90.0), p=1.0)[0, 0].round()
        tensor([[2., 4.],
                [1., 3.]])
    """
    check_batch(input, seed)
    height, width = input.size(2), input.size(3)
    matrix = _matrix(_draw(seed, degrees, p), height, width)
    return warped(input, matrix, height, width, resample, "zeros", align_corners)


class RandomRotation(Warp):
    """``random_rotation`` as a module.

    Args:
        degrees: the range of angles, counterclockwise as seen; a number x means [-x, x].
        resample, align_corners: as in ``random_rotation``.
        same_on_batch, p, keepdim: as in ``AugmentationBase``.

    Example:
        >>> augment = RandomRotation(30.0)
        >>> augment(torch.rand(2, 3, 8, 10)).shape
        torch.Size([2, 3, 8, 10])
        >>> augment.transform_matrix.shape
        torch.Size([2, 3, 3])
    """

    def __init__(
        self,
        degrees: Range,
        resample: Any = "bilinear",
        same_on_batch: bool = False,
        align_corners: bool = True,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None:
        super().__init__(resample, "zeros", align_corners, p, same_on_batch, keepdim)
        self.degrees = symmetric("degrees", degrees)

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        return _draw(seed, self.degrees, self.p)

    def compute_transformation(self, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return _matrix(params, shape[2], shape[3])
