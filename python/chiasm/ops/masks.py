"""Instance masks: their boxes, masks from YOLACT's prototypes, and masks pasted into an image."""

from typing import Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_not_empty, check_rank, check_tensor
from ..primitives.core.window_sizes import positive_pair
from ..primitives.geometry.boxes import wide
from ..primitives.linalg.matrices import small_matmul
from ..primitives.numbers.search import first_and_last
from ..primitives.resampling.resizing import resized
from ..primitives.resampling.warping import position_dtype, resample_image


def masks_to_boxes(masks: Tensor) -> Tensor:
    """The bounding boxes of masks, as indices of their corner pixels. As in torchvision, the corner x2, y2 is
    the last pixel of the mask, not the one after it.

    Args:
        masks: (N, H, W), any dtype: nonzero pixels belong to the mask.

    Returns:
        (N, 4) as x1, y1, x2, y2, float32; zeros for an empty mask.

    Raises:
        ValueError: if masks is not (N, H, W), or has no pixels.

    Example:
        >>> masks_to_boxes(torch.tensor([[[0, 0, 0], [0, 1, 1]], [[0, 0, 0], [0, 0, 0]]]))
        tensor([[1., 1., 2., 1.],
                [0., 0., 0., 0.]])
    """
    check_rank(masks, 3, "(N, H, W)", "masks")
    if masks.size(1) < 1 or masks.size(2) < 1:
        raise ValueError(f"masks: expected H and W of at least 1, got {list(masks.shape)}")
    inside = masks.to(torch.bool)
    left, right = first_and_last(inside.any(1))
    top, bottom = first_and_last(inside.any(2))
    return torch.stack([left, top, right, bottom], 1).to(torch.float32)


def masks_from_prototypes(
    prototypes: Tensor, coefficients: Tensor, boxes: Tensor, size: Tuple[int, int]
) -> Tensor:
    """Compute masks of detections from an image's prototypes, as in YOLACT and in YOLO segmentation.

    D. Bolya et al., YOLACT, ICCV 2019, equation 1: the sigmoid of the product of coefficients and prototypes.
    It is resized by bilinear interpolation (aligned at the pixels' outer edges) and cropped: column j is
    inside a box if x1 <= j < x2; the same for rows. Usually a pixel belongs to the object if the mask is
    above 0.5.

    Args:
        prototypes: (B, P, h, w), floating point.
        coefficients: (B, N, P), those of each detection.
        boxes: (B, N, 4) as x1, y1, x2, y2 in pixels of the result. They have no gradient.
        size: the result's height H and width W.

    Returns:
        (B, N, H, W), in [0, 1], 0 outside of the boxes.

    Raises:
        TypeError: if an argument is not floating point, or coefficients are of another dtype than prototypes.
        ValueError: if a shape is not as above, or size is not positive.

    Example:
        >>> prototypes = torch.tensor([[[[2.0, -2.0]]]])
        >>> boxes = torch.tensor([[[1.0, 0.0, 4.0, 1.0]]])
        >>> masks_from_prototypes(prototypes, torch.ones(1, 1, 1), boxes, (1, 4))
        tensor([[[[0.0000, 0.6904, 0.3096, 0.1192]]]])
    """
    check_rank(prototypes, 4, "(B, P, h, w)", "prototypes")
    check_floating(prototypes, "prototypes")
    check_not_empty(prototypes, 2, "prototypes")
    batch, count = prototypes.size(0), prototypes.size(1)
    check_tensor(coefficients, "coefficients")
    if coefficients.dim() != 3 or coefficients.size(0) != batch or coefficients.size(2) != count:
        raise ValueError(
            f"coefficients: expected shape (B, N, P) for prototypes {list(prototypes.shape)}, got"
            f" {list(coefficients.shape)}"
        )
    check_floating(coefficients, "coefficients")
    if coefficients.dtype != prototypes.dtype:
        raise TypeError(
            f"coefficients: expected prototypes' dtype {prototypes.dtype}, got {coefficients.dtype}"
        )
    check_tensor(boxes, "boxes")
    if boxes.dim() != 3 or boxes.shape[:2] != coefficients.shape[:2] or boxes.size(2) != 4:
        raise ValueError(
            f"boxes: expected shape (B, N, 4) for coefficients {list(coefficients.shape)}, got"
            f" {list(boxes.shape)}"
        )
    check_floating(boxes, "boxes")
    height, width = positive_pair(size, "size")
    mixed = small_matmul(coefficients, prototypes.flatten(2))
    masks = torch.sigmoid(mixed).unflatten(2, [prototypes.size(2), prototypes.size(3)])
    large = resized(masks, height, width, "bilinear", False, False)
    corners = wide(boxes)  # half precision has no odd columns beyond 256 or 2048
    column = torch.arange(width, device=boxes.device).to(corners.dtype)
    row = torch.arange(height, device=boxes.device).to(corners.dtype)
    across = (column >= corners[..., 0:1]) & (column < corners[..., 2:3])
    down = (row >= corners[..., 1:2]) & (row < corners[..., 3:4])
    return torch.where(down[..., None] & across[:, :, None], large, torch.zeros_like(large))


def paste_masks(masks: Tensor, boxes: Tensor, size: Tuple[int, int]) -> Tensor:
    """Paste masks that were predicted for boxes into the image: the last step of Mask R-CNN.

    K. He et al., Mask R-CNN, ICCV 2017. The mask is stretched to its box and read by bilinear interpolation
    at the centres of the image's pixels, like ``grid_sample`` with zero padding. torchvision's
    ``paste_masks_in_image`` rounds boxes to pixels first, and so differs by up to a pixel; without this
    rounding, the result is more exact and has a gradient.

    Args:
        masks: (N, 1, M, M), floating point; the sides may differ.
        boxes: (N, 4) as x1, y1, x2, y2 in pixels; pixel centres are at half-integers.
        size: the image's height H and width W.

    Returns:
        (N, 1, H, W); zeros for a box without area.

    Raises:
        TypeError: if masks or boxes is not floating point.
        ValueError: if masks is not (N, 1, M, M), boxes not (N, 4), or size is not positive.

    Example:
        >>> paste_masks(torch.ones(1, 1, 2, 2), torch.tensor([[1.0, 0.0, 3.0, 2.0]]), (2, 4))
        tensor([[[[0., 1., 1., 0.],
                  [0., 1., 1., 0.]]]])
    """
    check_rank(masks, 4, "(N, 1, M, M)", "masks")
    check_floating(masks, "masks")
    if masks.size(1) != 1:
        raise ValueError(f"masks: expected shape (N, 1, M, M), got {list(masks.shape)}")
    check_not_empty(masks, 2, "masks")
    check_tensor(boxes, "boxes")
    if boxes.dim() != 2 or boxes.size(0) != masks.size(0) or boxes.size(1) != 4:
        raise ValueError(
            f"boxes: expected shape (N, 4) for masks {list(masks.shape)}, got {list(boxes.shape)}"
        )
    check_floating(boxes, "boxes")
    height, width = positive_pair(size, "size")
    corners = boxes.to(position_dtype(masks.dtype))
    x = _in_mask(corners[:, 0:1], corners[:, 2:3], width, masks.size(3))
    y = _in_mask(corners[:, 1:2], corners[:, 3:4], height, masks.size(2))
    x, y = torch.broadcast_tensors(x[:, None], y[:, :, None])
    return resample_image(masks, x, y, "bilinear", "zeros", False, None)


def _in_mask(low: Tensor, high: Tensor, pixels: int, side: int) -> Tensor:
    """The positions (N, pixels) of an axis's pixel centres in the masks; outside if a box has no extent."""
    centre = torch.arange(pixels, device=low.device).to(low.dtype) + 0.5
    extent = high - low
    stretched = (centre - low) / torch.where(extent > 0, extent, torch.ones_like(extent)) * side - 0.5
    return torch.where(extent > 0, stretched, torch.full_like(stretched, -2.0))
