"""Crops of images."""

from typing import Any, List, Optional, Tuple, Union

import torch
from torch import Tensor

from ...primitives.core.broadcasting import one_for_each
from ...primitives.core.checks import (
    check_choice,
    check_leading,
    check_one_for_each,
    check_pair,
    check_pixels,
    check_tensor,
)
from ...primitives.core.modules import Module
from ...primitives.core.window_sizes import positive_pair
from ...primitives.numbers.rounding import to_index
from ...primitives.resampling.taps import bounded_taps
from ...primitives.resampling.warping import (
    check_matrices,
    check_sampling,
    check_source,
    position_dtype,
    resample_affine,
    resample_projective,
    rounded_pixels,
    weigh_image,
)
from .matrices import check_points, get_perspective_transform
from .warp import pixels_to_source


def center_crop(
    input_tensor: Tensor,
    size: Tuple[int, int],
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = True,
) -> Tensor:
    """Crop the centre of images. If the image size and the crop size differ by an odd number, the crop begins
    between two pixels; integers are rounded half up there.

    Args:
        input_tensor: (B, C, H, W), floating point, uint8, int16 or uint16.
        size: (height, width) of the crop, which may be larger than the image; may come from another tensor's
            shape.
        mode, padding_mode, align_corners: as in :func:`warp_affine`.

    Returns:
        (B, C, height, width).

    Raises:
        TypeError: if input_tensor is not of a type as above.
        ValueError: if input_tensor is not 4-D or a choice is not as above.

    Example:
        >>> center_crop(torch.arange(16.0).reshape(1, 1, 4, 4), (2, 2))[0, 0]
        tensor([[ 5.,  6.],
                [ 9., 10.]])
    """
    check_pixels(input_tensor, "input_tensor", True)
    check_sampling(mode, padding_mode)
    check_pair(size, "size")
    height, width = size
    one = torch.ones([1], dtype=position_dtype(input_tensor.dtype), device=input_tensor.device)
    zero = torch.zeros_like(one)
    left = one * (input_tensor.size(3) - width) * 0.5
    top = one * (input_tensor.size(2) - height) * 0.5
    matrix = torch.stack([one, zero, left, zero, one, top], 1).reshape(1, 2, 3)
    return resample_affine(input_tensor, matrix, height, width, mode, padding_mode, align_corners, None)


def crop_and_resize(
    input_tensor: Tensor,
    boxes: Tensor,
    size: Tuple[int, int],
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = True,
) -> Tensor:
    """Crop one quadrilateral of each image and resize it; its corners become the centres of the corner
    pixels.

    Args:
        input_tensor: (B, C, H, W), floating point, uint8, int16 or uint16.
        boxes: (B, 4, 2), corners (x, y) from the upper left clockwise.
        size: (height, width) of the crops, more than 1 each; may come from another tensor's shape.
        mode, padding_mode, align_corners: as in :func:`warp_affine`.

    Returns:
        (B, C, height, width). Differentiable in input_tensor and boxes.

    Raises:
        TypeError: if input_tensor is not of a type as above, or another argument not floating point.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> box = torch.tensor([[[1.0, 1.0], [3.0, 1.0], [3.0, 2.0], [1.0, 2.0]]])
        >>> crop_and_resize(torch.arange(16.0).reshape(1, 1, 4, 4), box, (2, 3))[0, 0]
        tensor([[ 5.,  6.,  7.],
                [ 9., 10., 11.]])
    """
    check_pixels(input_tensor, "input_tensor", True)
    check_points(boxes, 4, 2, "boxes")
    check_leading([input_tensor, boxes], ["input_tensor", "boxes"], [3, 2])
    corners = torch.tensor(
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], dtype=torch.float64, device=boxes.device
    )
    span = torch.ones_like(corners[:1])
    check_pair(size, "size")
    check_above_one([size[0], size[1]])
    span = torch.cat([span[:, :1] * (size[1] - 1), span[:, 1:] * (size[0] - 1)], 1)
    target = (corners * span)[None].expand(boxes.size(0), 4, 2)
    matrix = get_perspective_transform(boxes.to(torch.float64), target)
    return crop_by_transform_mat(input_tensor, matrix, size, mode, padding_mode, align_corners)


def check_above_one(size: List[int]) -> None:
    """Raise unless the sides of a crop are above 1, as far as they are known: a box of one pixel has no
    perspective transform."""
    for side in size:
        if isinstance(side, int) and side < 2:
            raise ValueError(f"size: expected numbers above 1, got {size}")


def crop_by_boxes(
    input_tensor: Tensor,
    src_box: Tensor,
    dst_box: Tensor,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = True,
    validate_boxes: bool = True,
    size: Optional[Tuple[int, int]] = None,
) -> Tensor:
    """Warp images so that src_box maps to dst_box, and crop to dst_box. The output has the size of the first
    dst_box, or ``size`` if given: exported programs cannot have sizes that depend on data.

    Args:
        input_tensor: (B, C, H, W), floating point, uint8, int16 or uint16.
        src_box: (B, 4, 2), corners (x, y) in input_tensor from the upper left clockwise.
        dst_box: (B, 4, 2), the corners in the output: rectangles of one size, at whole pixels.
        mode, padding_mode, align_corners: as in :func:`warp_affine`.
        validate_boxes: True raises an error unless dst_box is as described above.
        size: (height, width) of the output.

    Returns:
        (B, C, height, width): ``size``, or that of dst_box from (x, y) to (x + width - 1, y + height - 1).

    Raises:
        TypeError: if input_tensor is not of a type as above, or another argument not floating point.
        ValueError: if a shape or a choice is not as above, or dst_box is not as described above.

    Example:
        >>> source = torch.tensor([[[1.0, 1.0], [2.0, 1.0], [2.0, 3.0], [1.0, 3.0]]])
        >>> target = torch.tensor([[[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0]]])
        >>> crop_by_boxes(torch.arange(16.0).reshape(1, 1, 4, 4), source, target)[0, 0]
        tensor([[ 5.,  6.],
                [ 9., 10.],
                [13., 14.]])
    """
    check_pixels(input_tensor, "input_tensor", True)
    check_points(src_box, 4, 2, "src_box")
    check_points(dst_box, 4, 2, "dst_box")
    check_leading([input_tensor, src_box, dst_box], ["input_tensor", "src_box", "dst_box"], [3, 2, 2])
    extent = dst_box[:, 2] - dst_box[:, 0]
    if validate_boxes:
        rectangle = torch.stack(
            [
                dst_box[:, 0],
                dst_box[:, 0] + extent * _x_axis(extent),
                dst_box[:, 2],
                dst_box[:, 2] - extent * _x_axis(extent),
            ],
            1,
        )
        if bool((rectangle - dst_box).abs().max() > 1e-4) or bool((extent - extent[:1]).abs().max() > 1e-4):
            raise ValueError("dst_box: expected rectangles of one size")
    if size is None:
        size = (int(extent[0, 1].round().item()) + 1, int(extent[0, 0].round().item()) + 1)
    matrix = get_perspective_transform(src_box.to(torch.float64), dst_box.to(torch.float64))
    return crop_by_transform_mat(input_tensor, matrix, size, mode, padding_mode, align_corners)


def _x_axis(like: Tensor) -> Tensor:
    return torch.tensor([1.0, 0.0], dtype=like.dtype, device=like.device)


def crop_by_transform_mat(
    input_tensor: Tensor,
    transform: Tensor,
    out_size: Tuple[int, int],
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = True,
) -> Tensor:
    """Warp images by homographies in pixels: out(p) = input_tensor(transform^-1 p).

    Args:
        input_tensor: (B, C, H, W), floating point, uint8, int16 or uint16.
        transform: (B, 3, 3), or (1, 3, 3) for all images, from input_tensor's pixels to the output's.
        out_size: (height, width) of the output; may come from another tensor's shape.
        mode, padding_mode, align_corners: as in :func:`warp_affine`.

    Returns:
        (B, C, height, width). Differentiable in input_tensor and transform.

    Raises:
        TypeError: if input_tensor is not of a type as above, or another argument not floating point.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> left_by_one = torch.tensor([[[1.0, 0.0, -1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]])
        >>> crop_by_transform_mat(torch.arange(4.0).expand(1, 1, 1, 4), left_by_one, (1, 2))[0, 0]
        tensor([[1., 2.]])
    """
    check_source(input_tensor, mode, padding_mode, "input_tensor")
    check_matrices(transform, 3, 3, "transform")
    check_pair(out_size, "out_size")
    input_tensor = one_for_each(input_tensor, transform, "input_tensor", "transform")
    matrix = transform.expand(input_tensor.size(0), 3, 3)
    return resample_projective(
        input_tensor,
        pixels_to_source(matrix),
        out_size[0],
        out_size[1],
        mode,
        padding_mode,
        align_corners,
        None,
    )


def crop_by_indices(
    input_tensor: Tensor,
    src_box: Tensor,
    size: Optional[Tuple[int, int]] = None,
    interpolation: str = "bilinear",
    align_corners: Optional[bool] = None,
    antialias: bool = False,
    shape_compensation: str = "resize",
) -> Tensor:
    """Crop one box of whole pixels out of each image, and resize the crops to one size. The resize does not
    use pixels outside the crop. For integers, positions are rounded to 1/2048 pixel, or 1/32 for "bicubic",
    and values to integers, half up.

    Args:
        input_tensor: (B, C, H, W), floating point, uint8, int16 or uint16.
        src_box: (B, 4, 2), corner pixels (x, y) from the upper left clockwise, inside the image; fractions
            are cut off. A corner outside the image is moved to the nearest pixel inside; a lower right corner
            before the upper left one is moved to it.
        size: (height, width) of the output. None uses the size of the boxes, which must then all be equal;
            this depends on data and works only in eager Python and TorchScript.
        interpolation, align_corners: as in :func:`resize`.
        antialias: must be False, since the number of taps would depend on the data.
        shape_compensation: "resize", or "pad" to put crops at the upper left and zeros around them.

    Returns:
        (B, C, height, width). Differentiable in input_tensor.

    Raises:
        TypeError: if input_tensor is not of a type as above.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> box = torch.tensor([[[1, 1], [2, 1], [2, 2], [1, 2]]])
        >>> crop_by_indices(torch.arange(16.0).reshape(1, 1, 4, 4), box)[0, 0]
        tensor([[ 5.,  6.],
                [ 9., 10.]])
    """
    check_pixels(input_tensor, "input_tensor", True)
    check_choice(interpolation, ["nearest", "bilinear", "bicubic"], "interpolation")
    check_choice(shape_compensation, ["resize", "pad"], "shape_compensation")
    check_tensor(src_box, "src_box")
    if src_box.dim() != 3 or src_box.size(1) != 4 or src_box.size(2) != 2:
        raise ValueError(f"src_box: expected shape (B, 4, 2), got {list(src_box.shape)}")
    check_one_for_each(src_box, input_tensor, "src_box", "input_tensor")
    if antialias:
        raise ValueError("antialias: expected False, got True")
    rows, columns = input_tensor.size(2), input_tensor.size(3)
    low = torch.stack([_pixel(src_box[:, 0, 0], columns), _pixel(src_box[:, 0, 1], rows)], -1)
    last = torch.stack([_pixel(src_box[:, 2, 0], columns), _pixel(src_box[:, 2, 1], rows)], -1)
    extent = torch.maximum(last, low) - low + 1
    if size is None:
        if bool((extent != extent[:1]).any()):
            raise ValueError("src_box: expected boxes of one size where size is None")
        height, width = int(extent[0, 1].item()), int(extent[0, 0].item())
    else:
        height, width = size
    mode = "pad" if shape_compensation == "pad" else interpolation
    corners = align_corners is not None and align_corners
    pixels, steps = input_tensor, 0
    if not pixels.is_floating_point():
        # With these steps, sums are exact: 16 bits times multiples of 1/2^22, or of 1/2^34.
        pixels, steps = pixels.to(torch.float64), 32 if mode == "bicubic" else 2048
    dtype = position_dtype(pixels.dtype)
    column, across = bounded_taps(low[:, 0], extent[:, 0], width, mode, corners, dtype, steps)
    row, down = bounded_taps(low[:, 1], extent[:, 1], height, mode, corners, dtype, steps)
    index: List[Tensor] = []
    weight: List[Tensor] = []
    for i in range(len(row)):
        for j in range(len(column)):
            index.append((row[i][:, :, None] * columns + column[j][:, None, :]).to(torch.int32))
            weight.append(down[i][:, :, None] * across[j][:, None, :])
    out = weigh_image(pixels, index, weight, None)
    return out if out.dtype == input_tensor.dtype else rounded_pixels(out, input_tensor)


def _pixel(x: Tensor, size: int) -> Tensor:
    """Coordinates as whole numbers inside the image."""
    if x.is_floating_point():
        return to_index(x, size)
    return x.to(torch.int64).clamp(0, size - 1)


class CenterCrop2D(Module):
    """Crop the centre of images at whole pixels; if it lies between two positions, the first one is used.

    Args:
        size: (height, width) of the crop, or a number for both.
        align_corners, resample: as ``align_corners`` and ``mode`` in :func:`warp_affine`; used by "resample".
        cropping_mode: "slice" copies the pixels, and resizes an image that is smaller; "resample" is a warp,
            which has zeros around such an image.

    Shape:
        (B, C, H, W), floating point, uint8, int16 or uint16, to (B, C, height, width).

    Raises:
        TypeError: if the images are not of a type as above.
        ValueError: if they are not 4-D or a choice is not as above.

    Example:
        >>> CenterCrop2D(2)(torch.arange(16.0).reshape(1, 1, 4, 4))[0, 0]
        tensor([[ 5.,  6.],
                [ 9., 10.]])
    """

    def __init__(
        self,
        size: Union[int, Tuple[int, int]],
        align_corners: bool = True,
        resample: Any = "bilinear",
        cropping_mode: str = "slice",
    ) -> None:
        super().__init__()
        self.size = positive_pair(size, "size")
        self.align_corners, self.resample = (
            bool(align_corners),
            str(getattr(resample, "name", resample)).lower(),
        )
        check_choice(self.resample, ["bilinear", "nearest", "bicubic"], "resample")
        check_choice(cropping_mode, ["slice", "resample"], "cropping_mode")
        self.cropping_mode = cropping_mode

    def forward(self, input: Tensor) -> Tensor:
        check_pixels(input, "input", True)
        height, width = self.size
        left, top = _first(input.size(3), width), _first(input.size(2), height)
        if self.cropping_mode == "slice":
            corners = torch.tensor([[0, 0], [width - 1, 0], [width - 1, height - 1], [0, height - 1]])
            box = corners.to(input.device) + torch.tensor([left, top], device=input.device)
            return crop_by_indices(input, box[None].expand(input.size(0), 4, 2), (height, width))
        matrix = torch.eye(3, dtype=torch.float64, device=input.device)
        matrix[0, 2], matrix[1, 2] = -left, -top
        every = matrix[None].expand(input.size(0), 3, 3)
        return crop_by_transform_mat(
            input, every, (height, width), self.resample, "zeros", self.align_corners
        )


def _first(inside: int, size: int) -> int:
    """The first index of the ``size`` pixels at the centre of an axis, rounded towards 0."""
    return (inside - size) // 2 if inside >= size else -((size - inside) // 2)
