"""Images in a terminal of 256 colours, for eager Python."""

from __future__ import annotations

import os

import torch
from torch import Tensor

from ..primitives.core.checks import check_tensor
from ..primitives.core.modules import eager_only
from .files import ImageLoadType, load_image


@eager_only
def image_to_string(image: Tensor, max_width: int = 256) -> str:
    """The text that shows an image in a terminal: two spaces for each pixel, on the colour that is nearest
    among those that xterm fixes: a cube of 6 x 6 x 6 and 24 shades of grey.

    Args:
        image: (C, H, W) of 1 or 3 channels, floating point in [0, 1], or integers in [0, 255].
        max_width: a wider image is reduced to so many pixels, and its height alike.

    Returns:
        A line for each row, ended by a line break.

    Raises:
        ValueError: if image is not (C, H, W) of 1 or 3 channels, or a value is out of range.

    Example:
        >>> image_to_string(torch.tensor([1.0, 0.0, 0.0]).reshape(3, 1, 1))
        '\\x1b[48;5;196m  \\x1b[0m\\n'
    """
    from ..geometry.transform import resize  # which imports more than a terminal needs

    check_tensor(image, "image")
    if image.dim() != 3 or image.size(0) not in (1, 3):
        raise ValueError(f"image: expected shape (C, H, W) of 1 or 3 channels, got {list(image.shape)}")
    most = 1.0 if image.is_floating_point() else 255.0
    values = image.detach().cpu().to(torch.float64) * (255.0 / most)
    if not bool(((values >= 0.0) & (values <= 255.0)).all()):
        raise ValueError(f"image: expected values in [0, {most:g}], got {image.min():g} to {image.max():g}")
    if values.size(2) > max_width:
        height = max(1, values.size(1) * max_width // values.size(2))
        values = resize(values[None], (height, max_width))[0]
    rows = [
        (16 + torch.cdist(row, _fixed()).argmin(1)).tolist()
        for row in values.expand(3, -1, -1).permute(1, 2, 0)
    ]
    return "".join("".join(f"\033[48;5;{code}m  " for code in row) + "\033[0m\n" for row in rows)


@eager_only
def print_image(image: str | os.PathLike | Tensor, max_width: int = 96) -> None:
    """Print an image to the terminal, as ``image_to_string`` shows it.

    Args:
        image: a file, or a tensor (C, H, W) of 1 or 3 channels.
        max_width: a wider image is reduced to so many pixels.

    Raises:
        TypeError: if image is neither.
        ValueError: if the tensor is not as above.

    Example:
        >>> print_image("missing.png")  # doctest: +IGNORE_EXCEPTION_DETAIL
        Traceback (most recent call last):
        FileNotFoundError: [Errno 2] No such file or directory: 'missing.png'
    """
    if isinstance(image, (str, os.PathLike)):
        image = load_image(os.fspath(image), ImageLoadType.RGB8)
    print(image_to_string(image, max_width))


def _fixed() -> Tensor:
    """The colours (240, 3) of xterm's codes from 16 on."""
    steps = torch.tensor([0.0, 95.0, 135.0, 175.0, 215.0, 255.0], dtype=torch.float64)
    greys = torch.arange(8.0, 239.0, 10.0, dtype=torch.float64)
    return torch.cat([torch.cartesian_prod(steps, steps, steps), greys[:, None].expand(-1, 3)])
