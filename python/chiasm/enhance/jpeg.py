"""A JPEG codec without its entropy coding; entropy coding is lossless and would not change the image."""

import math
from typing import Optional

import torch
from torch import Tensor

from ..primitives.core.broadcasting import in_batch, like_given
from ..primitives.core.checks import check_floating, check_optional, check_rgb
from ..primitives.core.materialise import materialised
from ..primitives.linalg.matrices import small_matmul
from ..primitives.numbers.reshaping import reshaped


def jpeg_codec_differentiable(
    input: Tensor,
    jpeg_quality: Tensor,
    quantization_table_y: Optional[Tensor] = None,
    quantization_table_c: Optional[Tensor] = None,
) -> Tensor:
    """Encode and decode an image as JPEG does: YCbCr with halved chroma (4:2:0), 8x8 DCT, quantization, and
    back.

    ITU-T T.81 with JFIF's colours and libjpeg's scale of quality. For gradients, both coefficients and table
    entries are rounded by round(x) + (x - round(x))^3 (R. Shin, D. Song, JPEG-resistant adversarial images,
    2017).

    Args:
        input: RGB (B, 3, H, W) in [0, 1], floating point; the edge is repeated up to whole blocks of 16.
        jpeg_quality: 1 to 100, floating point: a scalar tensor, (1,) or (B,), one for each sample.
        quantization_table_y: (8, 8) or (B, 8, 8), the quantization steps of luma at quality 50, by default
            those of annex K of T.81.
        quantization_table_c: the same for chroma.

    Returns:
        (B, 3, H, W), in [0, 1].

    Raises:
        TypeError: if input or jpeg_quality is not floating point.
        ValueError: if input is not (B, 3, H, W), or the shape of jpeg_quality or of a table is not as above.

    Example:
        >>> jpeg_codec_differentiable(torch.full((1, 3, 20, 30), 0.5), torch.tensor([90.0])).shape
        torch.Size([1, 3, 20, 30])
    """
    return like_given(
        _jpeg_codec_differentiable_of_batch(
            in_batch(input, "input"), jpeg_quality, quantization_table_y, quantization_table_c
        ),
        input,
    )


def _jpeg_codec_differentiable_of_batch(
    input: Tensor,
    jpeg_quality: Tensor,
    quantization_table_y: Optional[Tensor],
    quantization_table_c: Optional[Tensor],
) -> Tensor:
    check_rgb(input, "input")
    check_floating(input, "input")
    check_floating(jpeg_quality, "jpeg_quality")
    if input.dim() != 4:
        raise ValueError(f"input: expected shape (B, 3, H, W), got {list(input.shape)}")
    batch, height, width = input.size(0), input.size(2), input.size(3)
    if jpeg_quality.dim() > 1 or (
        jpeg_quality.dim() == 1 and jpeg_quality.size(0) != batch and jpeg_quality.size(0) != 1
    ):
        raise ValueError(
            f"jpeg_quality: expected a scalar tensor, (1,) or ({batch},), got {list(jpeg_quality.shape)}"
        )
    # 121 * 5000, at quality 1, is more than float16 holds
    precision = torch.float64 if input.dtype == torch.float64 else torch.float32
    quality = jpeg_quality.to(precision).reshape(-1, 1, 1, 1, 1, 1)
    luma_table = _table(quantization_table_y, _luma(), input, "quantization_table_y").to(precision)
    chroma_table = _table(quantization_table_c, _chroma(), input, "quantization_table_c").to(precision)
    luma = _steps(luma_table, quality).to(input.dtype)
    chroma = _steps(chroma_table, quality).to(input.dtype)

    # whole blocks of 16, so that chroma has whole blocks of 8
    down, across = (height + 15) // 16, (width + 15) // 16
    rows = torch.arange(down * 16, device=input.device).clamp(max=height - 1)
    columns = torch.arange(across * 16, device=input.device).clamp(max=width - 1)
    pixels = input.index_select(2, rows).index_select(3, columns) * 255.0
    red, green, blue = pixels[:, 0], pixels[:, 1], pixels[:, 2]
    y = 0.299 * red + 0.587 * green + 0.114 * blue - 128.0
    cb = -0.168735892 * red - 0.331264108 * green + 0.5 * blue
    cr = 0.5 * red - 0.418687589 * green - 0.081312411 * blue

    y = _coded(y[:, None], luma, down * 2, across * 2)[:, 0] + 128.0
    colour = _coded(_halved(torch.stack([cb, cr], 1), down * 8, across * 8), chroma, down, across)
    colour = _doubled(colour, down * 16, across * 16)
    cb, cr = colour[:, 0], colour[:, 1]
    decoded = torch.stack([y + 1.402 * cr, y - 0.344136286 * cb - 0.714136286 * cr, y + 1.772 * cb], 1)
    # By index, because symbolic sizes cannot prove that the end of a slice lies within the whole blocks.
    rows, columns = torch.arange(height, device=input.device), torch.arange(width, device=input.device)
    return (decoded.index_select(2, rows).index_select(3, columns) / 255.0).clamp(0.0, 1.0)


def _luma() -> Tensor:
    """T.81, table K.1."""
    return torch.tensor([
        [16, 11, 10, 16, 24, 40, 51, 61],
        [12, 12, 14, 19, 26, 58, 60, 55],
        [14, 13, 16, 24, 40, 57, 69, 56],
        [14, 17, 22, 29, 51, 87, 80, 62],
        [18, 22, 37, 56, 68, 109, 103, 77],
        [24, 35, 55, 64, 81, 104, 113, 92],
        [49, 64, 78, 87, 103, 121, 120, 101],
        [72, 92, 95, 98, 112, 100, 103, 99],
    ])  # fmt: skip


def _chroma() -> Tensor:
    """T.81, table K.2."""
    return torch.tensor([
        [17, 18, 24, 47, 99, 99, 99, 99],
        [18, 21, 26, 66, 99, 99, 99, 99],
        [24, 26, 56, 99, 99, 99, 99, 99],
        [47, 66, 99, 99, 99, 99, 99, 99],
        [99, 99, 99, 99, 99, 99, 99, 99],
        [99, 99, 99, 99, 99, 99, 99, 99],
        [99, 99, 99, 99, 99, 99, 99, 99],
        [99, 99, 99, 99, 99, 99, 99, 99],
    ])  # fmt: skip


def _table(table: Optional[Tensor], default: Tensor, like: Tensor, name: str) -> Tensor:
    """(B or 1, 1, 1, 8, 1, 8), to broadcast against planes, rows of blocks, their rows, columns of blocks,
    and their columns."""
    check_optional(table, name)
    if table is None:
        table = default.to(like.device)
    if table.dim() < 2 or table.dim() > 3 or table.size(-1) != 8 or table.size(-2) != 8:
        raise ValueError(f"{name}: expected shape (8, 8) or (B, 8, 8), got {list(table.shape)}")
    if table.dim() == 3 and table.size(0) != like.size(0) and table.size(0) != 1:
        raise ValueError(f"{name}: expected shape (8, 8) or ({like.size(0)}, 8, 8), got {list(table.shape)}")
    return table.reshape(-1, 1, 1, 8, 1, 8)


def _steps(table: Tensor, quality: Tensor) -> Tensor:
    """The table, scaled like in libjpeg: unchanged at quality 50, all ones at quality 100."""
    scale = torch.where(quality < 50.0, 5000.0 / quality.clamp(min=1.0), 200.0 - 2.0 * quality)
    # floor(x + 1/2), T.81's rounding
    return _rounded(table * scale / 100.0).clamp(1.0, 255.0)


def _rounded(x: Tensor) -> Tensor:
    nearest = torch.floor(x.detach() + 0.5)
    rest = x - nearest
    return nearest + rest * rest * rest


def _cosines(like: Tensor) -> Tensor:
    """The matrix of the orthonormal DCT-II, a row for each frequency."""
    k = torch.arange(8, device=like.device).to(torch.float64)
    waves = torch.cos((2.0 * k[None, :] + 1.0) * k[:, None] * (math.pi / 16.0)) * 0.5
    return torch.where(k[:, None] == 0, torch.full_like(waves, 0.125**0.5), waves).to(like.dtype)


def _coded(planes: Tensor, steps: Tensor, down: int, across: int) -> Tensor:
    """(B, P, 8 down, 8 across) through DCT, rounding to whole steps, and inverse DCT."""
    cosines = _cosines(planes)
    waves = cosines.transpose(0, 1)
    batch, count, width = planes.size(0), planes.size(1), across * 8
    tall = materialised(small_matmul(cosines, reshaped(planes, [batch, count, down, 8, width])), 4)
    coefficients = small_matmul(reshaped(tall, [batch, count, down, 8, across, 8]), waves)
    kept = materialised(_rounded(coefficients / steps) * steps, 0)
    tall = materialised(reshaped(small_matmul(kept, cosines), [batch, count, down, 8, width]), 4)
    return reshaped(small_matmul(waves, tall), [batch, count, down * 8, width])


def _halved(planes: Tensor, height: int, width: int) -> Tensor:
    """Mean of each 2x2 square."""
    return reshaped(planes, [planes.size(0), planes.size(1), height, 2, width, 2]).mean([3, 5])


def _doubled(planes: Tensor, height: int, width: int) -> Tensor:
    """Every pixel twice in both directions, to (B, P, height, width)."""
    twice = planes[:, :, :, None, :, None].expand(-1, -1, -1, 2, -1, 2)
    return reshaped(twice, [planes.size(0), planes.size(1), height, width])
