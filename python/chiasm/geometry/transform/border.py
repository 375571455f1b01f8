"""Borders around images."""

from torch import Tensor

from ...primitives.core.checks import check_choice, check_four_sides, check_number, check_pixels
from ...primitives.core.pixels import check_pixel_value
from ...primitives.filters.padding import bordered


def copy_make_border(
    image: Tensor,
    top: int,
    bottom: int,
    left: int,
    right: int,
    border_type: str = "constant",
    value: float = 0.0,
) -> Tensor:
    """Put images into larger ones, like OpenCV's ``copyMakeBorder``.

    Args:
        image: (B, C, H, W), floating point, uint8, int16 or uint16.
        top, bottom, left, right: how many rows and columns are added on each side.
        border_type: what they hold. "constant" is ``value``; "replicate" the pixel at the edge; "reflect" the
            mirror image without the edge (BORDER_REFLECT_101), at most H - 1 rows and W - 1 columns;
            "symmetric" that with the edge (BORDER_REFLECT), and "circular" the opposite side (BORDER_WRAP),
            at most H rows and W columns.
        value: that of a constant border, in all channels; one of the image's dtype.

    Returns:
        (B, C, top + H + bottom, left + W + right). Differentiable.

    Raises:
        TypeError: if image is not of a type as above, or a size not a whole number.
        ValueError: if image is not 4-D or too small for the border, a size is negative, the type is unknown,
            or the image's dtype cannot represent value.

    Example:
        >>> copy_make_border(torch.tensor([[[[1, 2, 3]]]], dtype=torch.uint8), 0, 0, 2, 1, "symmetric")
        tensor([[[[2, 1, 1, 2, 3, 3]]]], dtype=torch.uint8)
    """
    check_pixels(image, "image", True)
    check_four_sides((top, bottom, left, right), "top, bottom, left, right")
    if top < 0 or bottom < 0 or left < 0 or right < 0:
        raise ValueError(
            f"top, bottom, left, right: expected no negative number, got {(top, bottom, left, right)}"
        )
    check_choice(border_type, ["constant", "replicate", "reflect", "symmetric", "circular"], "border_type")
    check_number(value, "value")
    if border_type == "constant":
        check_pixel_value(value, image, "value")
    _check_room(image.size(2), max(top, bottom), border_type, "rows")
    _check_room(image.size(3), max(left, right), border_type, "columns")
    return bordered(image, (top, bottom), (left, right), border_type, value)


def _check_room(size: int, margin: int, border_type: str, what: str) -> None:
    """A symbol has no size while it is traced: an exported graph has the limits of its spec."""
    if not isinstance(size, int) or border_type == "constant" or border_type == "replicate":
        return
    least = margin + 1 if border_type == "reflect" else margin
    if size < least:
        raise ValueError(
            f"image: expected at least {least} {what} for the border '{border_type}' of {margin}, got {size}"
        )
