"""Image files as tensors, by Pillow, for eager Python."""

from __future__ import annotations

import io
import os
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from ..color import rgb_to_grayscale
from ..primitives.core.checks import check_tensor
from ..writing import write_whole
from .arrays import tensor_to_image


class ImageLoadType(Enum):
    """What ``load_image`` makes of a file: the colours, and uint8 (8) or float32 in [0, 1] (32).

    >>> ImageLoadType.RGB8.name
    'RGB8'
    """

    UNCHANGED = 0
    GRAY8 = 1
    RGB8 = 2
    RGBA8 = 3
    GRAY32 = 4
    RGB32 = 5


def load_image(
    path_file: str | Path,
    desired_type: ImageLoadType = ImageLoadType.RGB32,
    device: str | torch.device | None = "cpu",
) -> Tensor:
    """Read an image file of a format that Pillow knows. The pixels stay where the file has them: an EXIF
    rotation is ignored. Transparency is laid over white, except for RGBA8 and UNCHANGED. Grey is
    ``rgb_to_grayscale``.

    Args:
        path_file: the file.
        desired_type: the colours and the dtype; UNCHANGED keeps the file's.
        device: where the tensor goes.

    Returns:
        (C, H, W).

    Raises:
        TypeError: if path_file is not a path, or desired_type not an ImageLoadType.
        OSError: if the file cannot be read, is not an image, or is a program (PostScript), which Pillow would
            start.
        ValueError: if the file has more than 8 bits to a value and desired_type is not UNCHANGED.

    Example:
        >>> import os, tempfile
        >>> file = os.path.join(tempfile.mkdtemp(), "grey.png")
        >>> write_image(file, torch.full((1, 4, 6), 51, dtype=torch.uint8))
        >>> load_image(file, ImageLoadType.RGB32)[:, 0, 0]
        tensor([0.2000, 0.2000, 0.2000])
    """
    pillow = _pillow()
    if not isinstance(desired_type, ImageLoadType):
        raise TypeError(f"desired_type: expected an ImageLoadType, got {desired_type!r}")
    file = _decoded(path_file)
    if desired_type == ImageLoadType.UNCHANGED:
        return _planes(np.array(file)).to(device)
    if file.mode == "F" or file.mode.startswith("I"):
        raise ValueError(
            f"desired_type: expected UNCHANGED for {path_file}, whose values have more than 8 bits, got"
            f" {desired_type.name}"
        )
    picture = file.convert("RGBA") if file.has_transparency_data else file
    if picture.mode == "RGBA" and desired_type != ImageLoadType.RGBA8:
        picture = pillow.alpha_composite(pillow.new("RGBA", picture.size, "white"), picture)
    grey = desired_type in (ImageLoadType.GRAY8, ImageLoadType.GRAY32)
    mode = "L" if grey and picture.mode in ("1", "L") else "RGB"
    mode = "RGBA" if desired_type == ImageLoadType.RGBA8 else mode
    loaded = _planes(np.array(picture.convert(mode))).to(device)
    loaded = loaded.to(torch.float32) / 255.0 if desired_type.name.endswith("32") else loaded
    return rgb_to_grayscale(loaded) if grey and mode == "RGB" else loaded


def write_image(path_file: str | Path, image: Tensor, quality: int = 80) -> None:
    """Write an image file by Pillow; the name's extension says the format. No value is scaled. A file that is
    there is replaced when the new one is complete.

    Args:
        path_file: the file.
        image: (C, H, W) or (H, W), uint8, of 1, 3 or, for a format with transparency, 4 channels; of 1
            channel also uint16, for PNG and TIFF.
        quality: of JPEG, 0 to 100.

    Raises:
        TypeError: if path_file is not a path, image is not of these dtypes, or quality is not a number.
        ValueError: if image is not of these shapes, quality is not as above, or the extension is unknown.
        OSError: if the file cannot be written.

    Example:
        >>> import os, tempfile
        >>> write_image(os.path.join(tempfile.mkdtemp(), "a.png"), torch.zeros(3, 4, 6, dtype=torch.uint8))
    """
    check_tensor(image, "image")
    channels = image.size(0) if image.dim() == 3 else 1
    if image.dim() not in (2, 3) or channels not in (1, 3, 4) or image.numel() == 0:
        raise ValueError(
            f"image: expected shape (H, W), or (C, H, W) of 1, 3 or 4 channels, got {list(image.shape)}"
        )
    if image.dtype != torch.uint8 and not (image.dtype == torch.uint16 and channels == 1):
        raise TypeError(f"image: expected uint8, or uint16 of one channel, got {image.dtype}")
    if not isinstance(quality, int):
        raise TypeError(f"quality: expected an int, got {type(quality).__name__}")
    if not 0 <= quality <= 100:
        raise ValueError(f"quality: expected 0 to 100, got {quality}")
    pillow = _pillow()
    path = _path(path_file)
    extension = path.suffix.lower()
    form = pillow.registered_extensions().get(extension)
    if form not in pillow.SAVE:
        raise ValueError(f"path_file: expected the extension of an image, such as .png, got {extension!r}")
    picture = pillow.fromarray(tensor_to_image(image, force_contiguous=True))
    encoded = io.BytesIO()  # not directly to the file: Pillow does not report a full disk
    picture.save(encoded, form, **({"quality": quality} if form == "JPEG" else {}))
    try:
        write_whole(path, encoded.getbuffer())
    except OSError as error:  # which names the unfinished file, or none
        raise OSError(error.errno, error.strerror, str(path)) from error


def _decoded(path_file: str | Path) -> Any:
    """An image of Pillow, decoded. What a decoder raises is an OSError."""
    path = _path(path_file)
    try:
        path.stat()
        if not path.is_file():  # opening a pipe would wait for its writer
            raise OSError(f"path_file: {path} is not a regular file")
        with _pillow().open(path) as file:
            if file.format == "EPS":
                raise OSError(f"path_file: {path} is PostScript, which is a program: convert it to an image")
            file.load()
            return file
    except (OSError, ImportError):
        raise
    except Exception as error:  # a decoder may raise any
        raise OSError(f"path_file: {path} is not an image that can be read: {error}") from error


def _path(path_file: object) -> Path:
    if not isinstance(path_file, (str, os.PathLike)):
        raise TypeError(f"path_file: expected a path, got {type(path_file).__name__}")
    return Path(path_file)


def _pillow() -> Any:
    """The module that reads and writes files, which is an extra."""
    try:
        from PIL import Image
    except ImportError as error:
        why = 'image files need Pillow, which is not installed: pip install "chiasm[cli]"'
        raise ImportError(why, name="PIL") from error
    return Image


def _planes(pixels: np.ndarray) -> Tensor:
    """(H, W) or (H, W, C) as (C, H, W), row-major."""
    tensor = torch.from_numpy(pixels)
    return tensor[None] if tensor.dim() == 2 else tensor.permute(2, 0, 1).contiguous()
