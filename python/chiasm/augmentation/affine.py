"""Random affine maps."""

import math
from typing import Any, Dict, List, Optional, Tuple

import torch
from torch import Tensor

from ..geometry.transform.matrices import get_affine_matrix2d
from ..primitives.core.checks import check_interval
from ..primitives.core.modules import shown
from ..primitives.random.draws import between, uniform
from .base import Range, check_batch, pair
from .decisions import below, check_positive_bounds
from .settings import numbers, symmetric
from .warps import Warp, chosen, middle, warped


def _draw(
    seed: Tensor,
    shape: List[int],
    degrees: Tuple[float, float],
    translate: Tuple[float, float],
    scale: Tuple[float, float],
    scale_y: Optional[Tuple[float, float]],
    shear_x: Tuple[float, float],
    shear_y: Tuple[float, float],
    p: float,
) -> Dict[str, Tensor]:
    check_interval(degrees, "degrees")
    check_interval(translate, "translate")
    check_positive_bounds(scale, "scale")
    if scale_y is not None:
        check_positive_bounds(scale_y, "scale_y")
    check_interval(shear_x, "shear_x")
    check_interval(shear_y, "shear_y")
    u = uniform(seed, 8)
    factor_x = between(u[:, 4], scale[0], scale[1])
    factor_y = factor_x if scale_y is None else between(u[:, 5], scale_y[0], scale_y[1])
    moved_x = between(u[:, 2], -translate[0], translate[0]) * shape[3]
    moved_y = between(u[:, 3], -translate[1], translate[1]) * shape[2]
    return {
        "batch_prob": below(u[:, 0], p),
        "angle": between(u[:, 1], degrees[0], degrees[1]),
        "translations": torch.stack([moved_x, moved_y], -1),
        "scale": torch.stack([factor_x, factor_y], -1),
        "shear_x": between(u[:, 6], shear_x[0], shear_x[1]),
        "shear_y": between(u[:, 7], shear_y[0], shear_y[1]),
        "center": middle(u[:, 0], shape[2], shape[3]),
    }


def _matrix(params: Dict[str, Tensor]) -> Tensor:
    radians = math.pi / 180.0
    matrix = get_affine_matrix2d(
        params["translations"].to(torch.float64),
        params["center"].to(torch.float64),
        params["scale"].to(torch.float64),
        params["angle"].to(torch.float64),
        params["shear_x"].to(torch.float64) * radians,
        params["shear_y"].to(torch.float64) * radians,
    )
    return chosen(matrix, params)


def random_affine(
    input: Tensor,
    seed: Tensor,
    degrees: Tuple[float, float],
    translate: Tuple[float, float] = (0.0, 0.0),
    scale: Tuple[float, float] = (1.0, 1.0),
    scale_y: Optional[Tuple[float, float]] = None,
    shear_x: Tuple[float, float] = (0.0, 0.0),
    shear_y: Tuple[float, float] = (0.0, 0.0),
    resample: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = False,
    p: float = 0.5,
) -> Tensor:
    """Shear, scale and rotate some images about their centres, and translate them, by
    ``get_affine_matrix2d``.

    Args:
        input: (B, C, H, W), floating point or uint8.
        seed: (B,), int64.
        degrees: the range of angles, clockwise as seen.
        translate: the largest translation to either side, as fractions of the width and of the height.
        scale: the range of the scale factor along both axes, or along x only if ``scale_y`` is given.
        scale_y: the range of the scale factor along y; by default, the factor along x is used.
        shear_x, shear_y: the ranges of shearing angles along x and y, in degrees.
        resample: "bilinear", "nearest" or "bicubic".
        padding_mode: the values outside the image: "zeros", "border" or "reflection".
        align_corners: True: "reflection" mirrors at the centres of the border pixels; False: at the image's
            outer edges.
        p: the probability of each image.

    Returns:
        (B, C, H, W). Differentiable in input.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> x = torch.arange(5.0).expand(1, 1, 3, 5)
        >>> random_affine(x, torch.tensor([0]), (0.0, 0.0), scale=(2.0, 2.0), p=1.0)[0, 0, 0]
        tensor([1.0000, 1.5000, 2.0000, 2.5000, 3.0000])
    """
    check_batch(input, seed)
    params = _draw(seed, list(input.shape), degrees, translate, scale, scale_y, shear_x, shear_y, p)
    height, width = input.size(2), input.size(3)
    return warped(input, _matrix(params), height, width, resample, padding_mode, align_corners)


class RandomAffine(Warp):
    """``random_affine`` as a module.

    Args:
        degrees: the range of angles, clockwise as seen; a number x means [-x, x].
        translate: the largest translation, as fractions of the width and of the height; no translation by
            default.
        scale: the range of scale factors, or four numbers, the ranges along x and along y; 1 by default.
        shear: the range of shearing angles along x in degrees, a number x for [-x, x], or four numbers, the
            ranges along x and along y; no shear by default.
        resample, align_corners: as in ``random_affine``.
        padding_mode: the values outside the image: "zeros", "border", "reflection" or "fill".
        fill_value: for "fill", a number, which is for masks too, or one for each channel; black by default.
        same_on_batch, p, keepdim: as in ``AugmentationBase``.

    Example:
        >>> augment = RandomAffine(15.0, translate=(0.1, 0.1), scale=(0.8, 1.2))
        >>> augment(torch.rand(2, 3, 8, 10)).shape
        torch.Size([2, 3, 8, 10])
        >>> augment.transform_matrix.shape
        torch.Size([2, 3, 3])
    """

    def __init__(
        self,
        degrees: Range,
        translate: Optional[Any] = None,
        scale: Optional[Any] = None,
        shear: Optional[Any] = None,
        resample: Any = "bilinear",
        same_on_batch: bool = False,
        align_corners: bool = False,
        padding_mode: str = "zeros",
        fill_value: Optional[Any] = None,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None:
        super().__init__(
            resample, padding_mode, align_corners, p, same_on_batch, keepdim, fill_value=fill_value
        )
        self.degrees = symmetric("degrees", degrees)
        moved = [0.0, 0.0] if translate is None else numbers("translate", translate)
        if len(moved) != 2 or min(moved) < 0.0 or max(moved) > 1.0:
            raise ValueError(f"translate: expected two numbers of 0 to 1, got {translate}")
        self.translate = (moved[0], moved[1])
        self.scale, scale_y = two_ranges((1.0, 1.0) if scale is None else scale, "scale")
        self.scale_y: Optional[Tuple[float, float]] = scale_y
        for each in (self.scale, self.scale if scale_y is None else scale_y):
            check_positive_bounds(each, "scale")
        self.shear_x, shear_y = two_ranges(0.0 if shear is None else shear, "shear")
        self.shear_y = (0.0, 0.0) if shear_y is None else shear_y

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        return _draw(
            seed,
            shape,
            self.degrees,
            self.translate,
            self.scale,
            self.scale_y,
            self.shear_x,
            self.shear_y,
            self.p,
        )

    def compute_transformation(self, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        return _matrix(params)

    def extra_repr(self) -> str:
        return shown(self, shear=self.shear_x + self.shear_y)


def two_ranges(value: Any, name: str) -> Tuple[Tuple[float, float], Optional[Tuple[float, float]]]:
    """The range along x, and the range along y if four numbers are given."""
    bounds = value.flatten().tolist() if isinstance(value, Tensor) else pair(value)
    if len(bounds) == 4:
        return symmetric(name, bounds[:2]), symmetric(name, bounds[2:])
    return symmetric(name, value), None


class RandomShear(RandomAffine):
    """Shear some images about their centres.

    Args:
        shear: as in ``RandomAffine``.
        resample, align_corners, padding_mode: as in ``random_affine``.
        same_on_batch, p, keepdim: as in ``AugmentationBase``.

    Example:
        >>> augment = RandomShear(10.0)
        >>> augment(torch.rand(2, 3, 8, 10)).shape
        torch.Size([2, 3, 8, 10])
        >>> augment.transform_matrix.shape
        torch.Size([2, 3, 3])
    """

    def __init__(
        self,
        shear: Any,
        resample: Any = "bilinear",
        same_on_batch: bool = False,
        align_corners: bool = False,
        padding_mode: str = "zeros",
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None:
        super().__init__(
            0.0, None, None, shear, resample, same_on_batch, align_corners, padding_mode, None, p, keepdim
        )


class RandomTranslate(Warp):
    """Translate some images.

    Args:
        translate_x, translate_y: the ranges, as fractions of the width and of the height; 0 by default.
        resample, align_corners, padding_mode: as in ``random_affine``.
        same_on_batch, p, keepdim: as in ``AugmentationBase``.

    Example:
        >>> augment = RandomTranslate((-0.1, 0.1), (-0.2, 0.2))
        >>> augment(torch.rand(2, 3, 8, 10)).shape
        torch.Size([2, 3, 8, 10])
        >>> augment.transform_matrix.shape
        torch.Size([2, 3, 3])
    """

    def __init__(
        self,
        translate_x: Optional[Any] = None,
        translate_y: Optional[Any] = None,
        resample: Any = "bilinear",
        same_on_batch: bool = False,
        align_corners: bool = False,
        padding_mode: str = "zeros",
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None:
        super().__init__(resample, padding_mode, align_corners, p, same_on_batch, keepdim)
        self.translate_x = symmetric("translate_x", 0.0 if translate_x is None else translate_x)
        self.translate_y = symmetric("translate_y", 0.0 if translate_y is None else translate_y)

    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:
        u = uniform(seed, 3)
        return {
            "batch_prob": below(u[:, 0], self.p),
            "translate_x": between(u[:, 1], self.translate_x[0], self.translate_x[1]) * shape[3],
            "translate_y": between(u[:, 2], self.translate_y[0], self.translate_y[1]) * shape[2],
        }

    def compute_transformation(self, params: Dict[str, Tensor], shape: List[int]) -> Tensor:
        x, y = params["translate_x"].to(torch.float64), params["translate_y"].to(torch.float64)
        one, zero = torch.ones_like(x), torch.zeros_like(x)
        rows = [one, zero, x, zero, one, y, zero, zero, one]
        return chosen(torch.stack(rows, -1).reshape(-1, 3, 3), params)
