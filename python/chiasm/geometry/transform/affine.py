# An attribute of an nn.Module is declared as a Tensor or a Module, whichever it is.
# pyright: reportArgumentType=false, reportCallIssue=false, reportIndexIssue=false, reportOperatorIssue=false
"""Affine warps: rotation, scaling, shearing, translation."""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ...primitives.core.broadcasting import in_batch, like_given, one_for_each
from ...primitives.core.checks import (
    check_leading,
    check_one_for_each,
    check_pair,
    check_pixels,
    check_tensor,
)
from ...primitives.core.modules import Module, hold
from ...primitives.resampling.warping import check_matrices, check_sampling, check_source, resample_affine
from .matrices import (
    check_numbers,
    check_vectors,
    from_rows,
    get_affine_matrix2d,
    get_rotation_matrix2d,
    inverse_affine,
    numbers,
)


def warp_affine(
    src: Tensor,
    M: Tensor,
    dsize: Tuple[int, int],
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = True,
    fill_value: Optional[Tensor] = None,
) -> Tensor:
    """Warp an image by affine transforms: out(p) = src(M^-1 p).

    Pixel centres lie at integers, as for ``cv2.warpAffine(src, M, (width, height))`` with constant border 0
    (older versions of which round positions to 1/32 pixel for uint8).

    For integers, positions are computed in float64. "bilinear" and "bicubic" round positions to 1/32 pixel
    ("bilinear" of 16 bits to 1/65536; halves to even) and values to integers (halves up); for smooth images
    the result is within one level of OpenCV's. Equal positions give equal values on all engines. But engines
    differ in the last digits of a position, so that a position half-way between two such steps (for
    "nearest", between two pixels) may be rounded either way.

    Args:
        src: (B, C, H, W), floating point, uint8, int16 or uint16.
        M: (B, 2, 3), or (1, 2, 3) for all images, invertible, mapping src pixels (x, y) to output pixels.
        dsize: (height, width) of the output; may come from another tensor's shape.
        mode: "bilinear", "nearest" (halves are rounded to the even neighbour) or "bicubic" (a = -0.75, as in
            PyTorch and OpenCV).
        padding_mode: the values outside src: "zeros", "border" (replicate), "reflection" or "fill".
        align_corners: True: "reflection" mirrors at the centres of the border pixels; False: at the outer
            edges. It has no other effect, since M is in pixels.
        fill_value: (C,) colour for "fill", for integers in levels; 0 by default.

    Returns:
        (B, C, height, width). Differentiable in src and M ("nearest": in src).

    Raises:
        TypeError: if an argument is not of a type as above.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> x = torch.arange(4.0).expand(1, 1, 2, 4)
        >>> warp_affine(x, torch.tensor([[[1.0, 0.0, 0.5], [0.0, 1.0, 0.0]]]), (2, 4), padding_mode="border")[
        ...     0, 0, 0
        ... ]
        tensor([0.0000, 0.5000, 1.5000, 2.5000])
    """
    check_source(src, mode, padding_mode, "src")
    check_matrices(M, 2, 3, "M")
    check_pair(dsize, "dsize")
    src = one_for_each(src, M, "src", "M")
    inverse = inverse_affine(M.to(torch.float64))
    return resample_affine(src, inverse, dsize[0], dsize[1], mode, padding_mode, align_corners, fill_value)


def affine(
    tensor: Tensor,
    matrix: Tensor,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = True,
) -> Tensor:
    """``warp_affine`` with an output of the image's size.

    Args:
        tensor: (B, C, H, W), (C, H, W) or (H, W), floating point, uint8, int16 or uint16.
        matrix: (B, 2, 3), or (1, 2, 3) for all images, invertible, mapping source pixels (x, y) to output
            pixels.
        mode, padding_mode, align_corners: as in :func:`warp_affine`.

    Returns:
        (B, C, H, W). Differentiable in tensor and matrix.

    Raises:
        TypeError: if an argument is not of a type as above.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> half = torch.tensor([[[0.5, 0.0, 0.0], [0.0, 0.5, 0.0]]])
        >>> affine(torch.arange(4.0).expand(1, 1, 2, 4), half)[0, 0, 0]
        tensor([0., 2., 0., 0.])
    """
    return like_given(
        _affine_of_batch(in_batch(tensor, "tensor"), matrix, mode, padding_mode, align_corners), tensor
    )


def _affine_of_batch(
    tensor: Tensor, matrix: Tensor, mode: str, padding_mode: str, align_corners: bool
) -> Tensor:
    check_pixels(tensor, "tensor", True)
    check_matrices(matrix, 2, 3, "matrix")
    check_leading([tensor, matrix], ["tensor", "matrix"], [3, 2])
    return warp_affine(tensor, matrix, (tensor.size(2), tensor.size(3)), mode, padding_mode, align_corners)


def rotate(
    tensor: Tensor,
    angle: Tensor,
    center: Optional[Tensor] = None,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = True,
) -> Tensor:
    """Rotate images counterclockwise.

    Args:
        tensor: (B, C, H, W), (C, H, W) or (H, W), floating point, uint8, int16 or uint16.
        angle: (B,) in degrees, or (1,) or a scalar for all images.
        center: (x, y) in pixels for each angle; the centre of the image, ((W - 1) / 2, (H - 1) / 2), by
            default.
        mode, padding_mode, align_corners: as in :func:`warp_affine`.

    Returns:
        (B, C, H, W). Differentiable in tensor, angle and center.

    Raises:
        TypeError: if an argument is not of a type as above.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> rotate(torch.tensor([[[[1.0, 2.0], [3.0, 4.0]]]]), torch.tensor([90.0]))[0, 0].round()
        tensor([[2., 4.],
                [1., 3.]])
    """
    return like_given(
        _rotate_of_batch(in_batch(tensor, "tensor"), angle, center, mode, padding_mode, align_corners), tensor
    )


def _rotate_of_batch(
    tensor: Tensor, angle: Tensor, center: Optional[Tensor], mode: str, padding_mode: str, align_corners: bool
) -> Tensor:
    check_pixels(tensor, "tensor", True)
    angle = numbers(angle, "angle")
    check_leading([tensor, angle], ["tensor", "angle"], [3, 0])
    factor = torch.ones_like(angle)[:, None].expand(-1, 2)
    return _about(tensor, angle, factor, center, "angle", mode, padding_mode, align_corners)


def scale(
    tensor: Tensor,
    scale_factor: Tensor,
    center: Optional[Tensor] = None,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = True,
) -> Tensor:
    """Enlarge or shrink the content of images; the image size stays the same.

    Args:
        tensor: (B, C, H, W), (C, H, W) or (H, W), floating point, uint8, int16 or uint16.
        scale_factor: (B,), or (B, 2) with factors along x and y; B may be 1, for all images, like a scalar.
        center: (x, y) in pixels for each factor, the point that stays fixed; the centre of the image by
            default.
        mode, padding_mode, align_corners: as in :func:`warp_affine`.

    Returns:
        (B, C, H, W). Differentiable in tensor, scale_factor and center.

    Raises:
        TypeError: if an argument is not of a type as above.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> scale(torch.arange(5.0).expand(1, 1, 3, 5), torch.tensor([2.0]))[0, 0, 0]
        tensor([1.0000, 1.5000, 2.0000, 2.5000, 3.0000])
    """
    return like_given(
        _scale_of_batch(in_batch(tensor, "tensor"), scale_factor, center, mode, padding_mode, align_corners),
        tensor,
    )


def _scale_of_batch(
    tensor: Tensor,
    scale_factor: Tensor,
    center: Optional[Tensor],
    mode: str,
    padding_mode: str,
    align_corners: bool,
) -> Tensor:
    check_pixels(tensor, "tensor", True)
    factor = scale_factor
    check_tensor(factor, "scale_factor")
    if factor.dim() == 0:
        factor = factor.reshape(1)
    if factor.dim() == 1:
        factor = factor[:, None].expand(-1, 2)
    check_vectors(factor, 2, "scale_factor")
    check_leading([tensor, factor], ["tensor", "scale_factor"], [3, 1])
    angle = torch.zeros_like(factor[:, 0])
    return _about(tensor, angle, factor, center, "scale_factor", mode, padding_mode, align_corners)


def _about(
    tensor: Tensor,
    angle: Tensor,
    factor: Tensor,
    center: Optional[Tensor],
    name: str,
    mode: str,
    padding_mode: str,
    align_corners: bool,
) -> Tensor:
    """``affine`` by a rotation matrix in float64; ``name`` is that of the argument with the angle or the
    factor."""
    if center is None:
        one = torch.ones_like(angle.to(torch.float64))
        middle = torch.stack([one * (tensor.size(3) - 1) * 0.5, one * (tensor.size(2) - 1) * 0.5], -1)
    else:
        check_vectors(center, 2, "center")
        check_leading([tensor, angle, center], ["tensor", name, "center"], [3, 0, 1])
        middle = center.to(torch.float64)
    return affine(tensor, get_rotation_matrix2d(middle, angle, factor), mode, padding_mode, align_corners)


def shear(
    tensor: Tensor,
    shear: Tensor,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = False,
) -> Tensor:
    """Shear images by the matrix [[1, shear_x, 0], [shear_y, 1, 0]] from source to destination pixels.

    Args:
        tensor: (B, C, H, W), (C, H, W) or (H, W), floating point, uint8, int16 or uint16.
        shear: (B, 2), or (1, 2) or (2,) for all images: pixels along x per pixel of y, and along y per pixel
            of x; their product must not be 1.
        mode, padding_mode, align_corners: as in :func:`warp_affine`.

    Returns:
        (B, C, H, W). Differentiable in tensor and shear.

    Raises:
        TypeError: if an argument is not of a type as above.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> shear(torch.arange(4.0).expand(1, 1, 2, 4), torch.tensor([[1.0, 0.0]]))[0, 0]
        tensor([[0., 1., 2., 3.],
                [0., 0., 1., 2.]])
    """
    return like_given(
        _shear_of_batch(in_batch(tensor, "tensor"), shear, mode, padding_mode, align_corners), tensor
    )


def _shear_of_batch(
    tensor: Tensor, shear: Tensor, mode: str, padding_mode: str, align_corners: bool
) -> Tensor:
    check_pixels(tensor, "tensor", True)
    check_tensor(shear, "shear")
    shear = shear.unsqueeze(0) if shear.dim() == 1 else shear
    check_vectors(shear, 2, "shear")
    check_leading([tensor, shear], ["tensor", "shear"], [3, 1])
    one, zero = torch.ones_like(shear[:, 0]), torch.zeros_like(shear[:, 0])
    matrix = from_rows([[one, shear[:, 0], zero], [shear[:, 1], one, zero]])
    return affine(tensor, matrix, mode, padding_mode, align_corners)


def translate(
    tensor: Tensor,
    translation: Tensor,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = True,
) -> Tensor:
    """Translate images.

    Args:
        tensor: (B, C, H, W), (C, H, W) or (H, W), floating point, uint8, int16 or uint16.
        translation: (B, 2), or (1, 2) or (2,) for all images: in pixels, to the right and down.
        mode, padding_mode, align_corners: as in :func:`warp_affine`.

    Returns:
        (B, C, H, W). Differentiable in tensor and translation.

    Raises:
        TypeError: if an argument is not of a type as above.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> translate(torch.arange(4.0).expand(1, 1, 2, 4), torch.tensor([[1.0, 0.0]]))[0, 0, 0]
        tensor([0., 0., 1., 2.])
    """
    return like_given(
        _translate_of_batch(in_batch(tensor, "tensor"), translation, mode, padding_mode, align_corners),
        tensor,
    )


def _translate_of_batch(
    tensor: Tensor, translation: Tensor, mode: str, padding_mode: str, align_corners: bool
) -> Tensor:
    check_pixels(tensor, "tensor", True)
    check_tensor(translation, "translation")
    translation = translation.unsqueeze(0) if translation.dim() == 1 else translation
    check_vectors(translation, 2, "translation")
    check_leading([tensor, translation], ["tensor", "translation"], [3, 1])
    one, zero = torch.ones_like(translation[:, 0]), torch.zeros_like(translation[:, 0])
    matrix = from_rows([[one, zero, translation[:, 0]], [zero, one, translation[:, 1]]])
    return affine(tensor, matrix, mode, padding_mode, align_corners)


class Affine(Module):
    """Shear, scale, rotate and then translate images: ``affine`` by ``get_affine_matrix2d``. All images get
    the same transform, or each its own. A tensor that is an ``nn.Parameter`` becomes a learnable parameter of
    the module.

    Args:
        angle: (B,) in degrees, counterclockwise as seen; 0 by default. B may be 1 here and below, for all
            images.
        translation: (B, 2), in pixels, to the right and down; 0 by default.
        scale_factor: (B, 2), factors along x and y; 1 by default.
        shear: (B, 2), shearing angles along x and y in radians, as in :func:`get_shear_matrix2d`; 0 by
            default.
        center: (B, 2), x and y in pixels of the fixed point of shearing, scaling and rotation; the centre of
            the image, ((W - 1) / 2, (H - 1) / 2), by default.
        mode, padding_mode, align_corners: as in :func:`warp_affine`.

    Shape:
        (B, C, H, W), floating point, uint8, int16 or uint16, to (B, C, H, W).

    Raises:
        TypeError: if a tensor is not of a type as above.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> mirror = Affine(translation=torch.tensor([[1.0, 0.0]]), scale_factor=torch.tensor([[-1.0, 1.0]]))
        >>> mirror(torch.arange(4.0).expand(1, 1, 2, 4))[0, 0, 0]
        tensor([0., 3., 2., 1.])
    """

    center: Optional[Tensor]

    def __init__(
        self,
        angle: Optional[Tensor] = None,
        translation: Optional[Tensor] = None,
        scale_factor: Optional[Tensor] = None,
        shear: Optional[Tensor] = None,
        center: Optional[Tensor] = None,
        mode: str = "bilinear",
        padding_mode: str = "zeros",
        align_corners: bool = True,
    ) -> None:
        super().__init__()
        check_sampling(mode, padding_mode)
        hold(self, "angle", torch.zeros(1) if angle is None else angle)
        hold(self, "translation", torch.zeros(1, 2) if translation is None else translation)
        hold(self, "scale_factor", torch.ones(1, 2) if scale_factor is None else scale_factor)
        hold(self, "shear", torch.zeros(1, 2) if shear is None else shear)
        check_numbers(self.angle, "angle")
        for name in ("translation", "scale_factor", "shear"):
            check_vectors(getattr(self, name), 2, name)
        if center is None:
            self.center = None
        else:
            check_vectors(center, 2, "center")
            hold(self, "center", center)
        self.mode, self.padding_mode, self.align_corners = mode, padding_mode, align_corners

    def forward(self, input: Tensor) -> Tensor:
        check_pixels(input, "input", True)
        batch = input.size(0)
        check_one_for_each(self.angle, input, "angle", "input")
        check_one_for_each(self.translation, input, "translation", "input")
        check_one_for_each(self.scale_factor, input, "scale_factor", "input")
        check_one_for_each(self.shear, input, "shear", "input")
        fixed = self.center
        if fixed is not None:
            check_one_for_each(fixed, input, "center", "input")
        if fixed is None:
            width, height = (
                torch.ones_like(self.angle[:1]) * input.size(3),
                torch.ones_like(self.angle[:1]) * input.size(2),
            )
            fixed = torch.stack([(width - 1.0) * 0.5, (height - 1.0) * 0.5], -1)
        center = fixed.to(torch.float64).expand(batch, 2)  # the matrix gets this dtype
        shear = self.shear.expand(batch, 2)
        matrix = get_affine_matrix2d(
            self.translation.expand(batch, 2),
            center,
            self.scale_factor.expand(batch, 2),
            -self.angle.expand(batch),
            shear[:, 0],
            shear[:, 1],
        )
        return affine(input, matrix[:, :2], self.mode, self.padding_mode, self.align_corners)
