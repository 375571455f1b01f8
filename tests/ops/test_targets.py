"""Primitives: every lowering equals its definition, also if it calls a kernel; TorchScript compiles the
definition; and no other module asks for the target. Kernels are those of runtime/artifact/kernels."""

import ast
import importlib
import pkgutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest
import torch
from called_kernels import computing_kernels
from declared_examples import declared_examples
from torch import Tensor
from torch.utils._pytree import tree_leaves

import chiasm
from chiasm.primitives.core.lowering import PRIMITIVES, Lowering, Primitive
from chiasm.primitives.core.target import TARGETS, exporting
from chiasm.primitives.filters.fixed_point import fixed_taps, whole_taps
from chiasm.primitives.filters.padding import join_columns
from chiasm.primitives.filters.stencil import join_channels
from chiasm.primitives.linalg.qr import frobenius_norm, qr

#: Packages without ops: they read, run or make bundles.
NO_OPS = ("__main__", "data", "doctor", "export", "extras", "onnx", "packs", "runtime", "triton")
for module in pkgutil.walk_packages(chiasm.__path__, "chiasm."):
    if module.name.split(".")[1] not in NO_OPS:
        importlib.import_module(module.name)

Example = tuple[Any, ...]
BORDERS = ("reflect", "replicate", "circular", "constant")
DTYPES = (torch.float32, torch.float64)


def numbers(dtype: torch.dtype, *shape: int) -> Tensor:
    """Numbers in [0, 1), different for every shape."""
    generator = torch.Generator().manual_seed(sum(shape))
    return torch.rand(shape, generator=generator, dtype=torch.float64).to(dtype)


def integers(high: int, *shape: int) -> Tensor:
    return torch.randint(0, high, shape, generator=torch.Generator().manual_seed(sum(shape)))


def signed_taps(count: int) -> Tensor:
    """Three taps in units of 1/2^22 for each of ``count`` pixels, some negative."""
    return (integers(3000000, count, 3) - 500000).to(torch.float64)


def quarters(count: int, taps: int) -> Tensor:
    """Weights in units of 1/2^11 for each of ``count`` pixels, some negative."""
    return (integers(1000, count, taps) - 300).to(torch.float64)


def turned(x: Tensor) -> Tensor:
    """The image with reversed rows, in the same layout."""
    layout = torch.contiguous_format if x.is_contiguous() else torch.channels_last
    columns = torch.arange(x.size(-1) - 1, -1, -1)
    return x.index_select(-1, columns).contiguous(memory_format=layout)


def matrices(dtype: torch.dtype, n: int) -> Tensor:
    """(2, n, n), symmetric and positive definite."""
    m = numbers(dtype, 2, n, n) - 0.5
    return m @ m.transpose(-1, -2) + 0.5 * torch.eye(n, dtype=dtype)


def images(dtype: torch.dtype) -> tuple[Tensor, Tensor]:
    return numbers(dtype, 2, 3, 12, 17), numbers(dtype, 1, 1, 9, 8)


#: Rows of weights of three channels, and of what is added.
#: As of luma and chroma in 1/2^20.
WEIGHTS = [1220542, 1673527, -409993, -852492, 2116026, 16]
MATRIX = [5, 3, -2, 7, -4, 9, 1, 100, 1, 1, 1, -300]
#: Factors of red, green and blue in luma, U and V in 1/2^20, and the luma of black.
MIXED = [269484, 528482, 102760, -155188, -305135, 460324, 460324, -385875, -74448, 16]


def bytes_and_words() -> tuple[Tensor, ...]:
    """Integers of 8 and 16 bits: planes, and a frame of interleaved pixels."""
    frame = integers(256, 2, 12, 17, 3).to(torch.uint8).permute(0, 3, 1, 2)
    words = integers(65536, 1, 2, 9, 8)
    return frame, frame.contiguous(), (words - 32768).to(torch.int16), words.to(torch.uint16)


def words() -> list[Tensor]:
    """Two samples of both types of 16 bits, in planes and in frames."""
    planes = [torch.cat([x, turned(x)]) for x in bytes_and_words()[2:]]
    return [*planes, *(x.permute(0, 2, 3, 1).contiguous().permute(0, 3, 1, 2) for x in planes)]


def in_borders(dtype: torch.dtype, *settings: Any, whole: bool = False) -> list[Example]:
    """Examples of both images, or of the integer ones (``whole``), with the settings and every border. A
    setting that is a function is called with the border."""
    return [
        (x, *(s(border) if callable(s) else s for s in settings))
        for x in (bytes_and_words() if whole else images(dtype))
        for border in BORDERS
    ]


def border(name: str) -> str:
    return name


def eigen(dtype: torch.dtype, n: int) -> Example:
    values, vectors = torch.linalg.eigh(matrices(dtype, n))
    a = matrices(dtype, n)
    return values, vectors, a, frobenius_norm(a), torch.eye(n, dtype=dtype)


def singular(dtype: torch.dtype, rows: int, n: int) -> Example:
    a = numbers(dtype, 2, rows, n) - 0.5
    u, s, v = torch.linalg.svd(a, full_matrices=False)
    return u, s, v.transpose(-1, -2), a, frobenius_norm(a)


def null(dtype: torch.dtype) -> Example:
    a = numbers(dtype, 2, 3, 4) - 0.5
    rows = torch.cat([a, torch.zeros_like(a[:, :1])], 1)
    return torch.linalg.svd(rows)[2][:, -1], a, qr(rows)[1]


def scores(dtype: torch.dtype) -> tuple[Tensor, Tensor]:
    """Models (2, 5, 3, 3) of length 1, and points (2, 7, 40) for their costs."""
    models = numbers(dtype, 2, 5, 3, 3) + torch.eye(3, dtype=dtype)
    x, y, u, v = (numbers(dtype, 2, 40) + 0.1 * k for k in range(4))
    one = torch.ones_like(x)
    return models / models.flatten(2).norm(dim=-1)[..., None, None], torch.stack(
        [x, y, one, u, v, one, 0.3 * one], 1
    )


def pose(dtype: torch.dtype) -> Example:
    X = numbers(dtype, 1, 6, 3) + torch.tensor([0.0, 0.0, 4.0], dtype=dtype)
    return (
        torch.eye(4, dtype=dtype)[None, :3],
        X,
        X[..., :2] / X[..., 2:] + 0.01,
        torch.eye(3, dtype=dtype)[None],
        torch.ones(1, 6, dtype=dtype),
    )


def offers() -> Example:
    """Offers that are equal for each place, as from callers that do not repeat."""
    index = integers(10, 2, 10).to(torch.int32)
    return torch.arange(10, dtype=torch.int32).repeat(2, 1), index, index - 3, integers(2, 2, 10) > 0


def bins() -> Example:
    """Images of 5 boxes, and the rows and columns of 2 x 3 bins of each, some of them empty."""
    rows, columns = integers(10, 5, 2), integers(12, 5, 3)
    return integers(2, 5), rows, rows.flip(0), columns, columns.flip(0)


def points(dtype: torch.dtype) -> Example:
    """Positions of 3 x 2 points in 2 x 3 bins of 5 boxes, some of them outside an image of 9 x 11."""
    return numbers(dtype, 5, 2, 3) * 15 - 3, numbers(dtype, 5, 3, 2) * 17 - 3


def curves(dtype: torch.dtype) -> Example:
    first, second = integers(2, 12), integers(2, 17)
    return (numbers(torch.float32, 2, 4 * 256), 2, integers(256, 2, 12, 17).to(torch.int32)) + tuple(
        part
        for index in (first, second)
        for part in (index, 1 - index, numbers(torch.float32, index.size(0)))
    )


def frames(dtype: torch.dtype) -> Example:
    """Pixels of two images, concatenated, and three frames in them."""
    count = torch.tensor([[0, 0, 204]])
    height, width = torch.tensor([[12, 12, 6]]), torch.tensor([[17, 17, 8]])
    frame = 3.0 * numbers(dtype, 1, 3, 2, 3) + torch.tensor([[0.0, 0.0, 3.0], [0.0, 0.0, 2.0]], dtype=dtype)
    return numbers(dtype, 1, 2, 204 + 48), count, height, width, frame, 5


def sampled(dtype: torch.dtype, *of: Any) -> list[Example]:
    """A resampling's arguments with every interpolation and padding."""
    x = numbers(dtype, 2, 3, 9, 11)
    fill = torch.tensor([0.5, 0.25, 0.0], dtype=dtype)
    modes = [
        (mode, padding)
        for mode in ("bilinear", "nearest", "bicubic")
        for padding in ("zeros", "border", "reflection", "fill")
    ]
    return [(x, *of, mode, padding, True, fill if padding == "fill" else None) for mode, padding in modes]


def bytes_sampled(*of: Any) -> list[Example]:
    """``sampled`` of integers."""
    fill = torch.tensor([200.0, 3.4, 0.0])
    return [
        (x, *of, mode, padding, corners, fill[: x.size(1)] if padding == "fill" else None)
        for x in (*bytes_and_words()[:2], *words())
        for mode in ("bilinear", "nearest", "bicubic")
        for padding in ("zeros", "border", "reflection", "fill")
        for corners in (True, False)
    ]


TAPS = [0.25, 0.5, 0.25]
GRADIENTS = ("sobel", "diff", "scharr", "prewitt")
FIVE = [0.1, 0.2, 0.4, 0.2, 0.1]
HEIGHTS = torch.tensor([[0.0, 0.5, -1e4], [0.25, 0.0, 0.0]])

#: Example arguments of primitives, by dtype. A primitive that is not here gets those that the declaration of
#: its kernel allows: enough if the kernel itself is the lowering, and the definition allows the same.
EXAMPLES: dict[str, Callable[[torch.dtype], list[Example]]] = {
    "angles.angle_of": lambda t: [(numbers(t, 40) - 0.5, numbers(t, 41)[:40] - 0.5)],
    "blending.blended_with_plane": lambda t: [
        (x[:, :1], x, factor)
        for x in images(t)
        for factor in (numbers(t, x.size(0), 1, 1, 1), numbers(t, x.size(1), 1, 1), numbers(t, 1))
    ],
    "borders.find_contours": lambda t: [
        (numbers(t, 2, 12, 17) > 0.5, 5, 30),
        (numbers(t, 1, 5, 4) > 0.3, 2, 1),
    ],
    "broadcasting.where_chosen": lambda t: [
        (torch.arange(x.size(0)) % 2 == 0, x, x.flip(-1)) for x in (*bytes_and_words()[:2], *images(t))
    ],
    "connected_components.numbered_components": lambda t: [
        (numbers(t, 2, 3, 12, 17) - 0.5, 100),
        (numbers(t, 1, 1, 5, 4) - 0.3, 3),
    ],
    "connected_components.labelled_components": lambda t: [
        (numbers(t, 2, 3, 12, 17) - 0.5,),
        (integers(3, 1, 2, 9, 70).to(torch.uint8),),
    ],
    "connected_components.lower_at": lambda t: [offers()],
    "consensus._cheapest": lambda t: [
        (scores(t)[0], torch.ones(2, 5, dtype=torch.bool), scores(t)[1], epipolar, 2)
        for epipolar in (True, False)
    ],
    "consensus._forms": lambda t: [
        (numbers(t, 2, 5, 3), torch.cat([numbers(t, 2, 2, 40), torch.ones(2, 1, 40, dtype=t)], 1))
    ],
    "consensus._summed_cost": lambda t: [(*scores(t), epipolar) for epipolar in (True, False)],
    "correlation.box_sums": lambda t: [
        (*e, 0.5, -2.0) for ky, kx in ((3, 3), (5, 5), (4, 3), (2, 6)) for e in in_borders(t, ky, kx, border)
    ],
    "correlation.correlated2d": lambda t: [
        (x, numbers(t, b, 3, 2), name) for x in images(t) for b in (1, x.size(0)) for name in BORDERS
    ],
    "correlation.correlated3d": lambda t: [
        (numbers(t, 2, 1, 5, 6, 7), numbers(t, b, 2, 3, 2), name) for b in (1, 2) for name in BORDERS
    ],
    "correlation.correlate2d_valid": lambda t: [
        (x, numbers(t, b, 3, 2)) for x in images(t) for b in (1, x.size(0))
    ],
    "correlation.correlate3d_valid": lambda t: [
        (numbers(t, 2, 1, 5, 6, 7), numbers(t, b, 2, 3, 2)) for b in (1, 2)
    ],
    "correlation.separable_plus": lambda t: in_borders(t, TAPS, FIVE, border, 0.5, 2.0),
    "correlation.weigh_and_thin": lambda t: [
        (x, TAPS, [0.5, 0.5], stride) for x in images(t) for stride in (1, 2, 3)
    ],
    "derivatives.first_derivatives": lambda t: [
        (x, mode, scaled) for x in images(t) for mode in GRADIENTS for scaled in (True, False)
    ],
    "derivatives.sobel_magnitude": lambda t: [
        (x, scaled, 1e-6) for x in images(t) for scaled in (True, False)
    ],
    "diamond_square.midpoint_displacement": lambda t: [
        (x, numbers(t, x.size(0), 1, 1, 1), 0.5 * numbers(t, 1, 1, 1, 1)) for x in images(t)
    ],
    "orientations.orientation_histograms": lambda t: [
        (numbers(t, 3, 1, 8, 8), numbers(t, 8, 8), numbers(t, 4, 8), 6)
    ],
    "direct_linear.normal_matrix": lambda t: [
        (numbers(torch.float64, a, 30, 9), numbers(torch.float64, b, 30)) for a, b in ((2, 1), (2, 2), (1, 3))
    ],
    "direct_linear.projective_equations": lambda t: [
        (numbers(torch.float64, a, 30, k), numbers(torch.float64, b, 30, 2), numbers(torch.float64, c, 30))
        for k in (3, 4)
        for a, b, c in ((2, 2, 2), (1, 1, 3), (1, 3, 3), (3, 1, 1))
    ],
    "distances.euclidean_distances": lambda t: [(numbers(t, 2, 3, 12, 17) - 0.2,)],
    "distances.grown_distances": lambda t: [
        (
            (numbers(t, 2, 1, 12, 17) > 0.9).to(t),
            29,
            [0.0176, 0.0574, 0.0176, 0.0574, 1.0] + 4 * [0.02],
            3,
            0.35,
        )
    ],
    "drawing.rectangles_over": lambda t: [
        (x, integers(20, 2, 5, 4)[: x.size(0)] - 3, numbers(t, x.size(0), x.size(1), 5), 1, 0, fill)
        for x in images(t)
        for fill in (True, False)
    ],
    "drawing.spans_over": lambda t: [
        (x, integers(12, x.size(0), 2, x.size(2)) - 2, integers(20, x.size(0), 2, x.size(2)), colors)
        for x in images(t)
        for colors in (numbers(t, x.size(0), x.size(1)), numbers(t, 1, 1))
    ],
    "eigen._derived_eigen": lambda t: [eigen(t, 3), eigen(t, 5)],
    "eigen._derived_svd": lambda t: [singular(t, 3, 3), singular(t, 5, 3)],
    "extrema.scale_space_nms": lambda t: [
        (numbers(t, 2, 4, 9, 11) - 0.5, [1.0, 1.2, 1.5, 2.0], signed, 7) for signed in (True, False)
    ],
    "minmax.minmax_filter": lambda t: [
        (*e, largest, value)
        for largest in (True, False)
        for value, whole in ((0.5, False), (7.0, True))
        for e in in_borders(t, 3, 5, border, whole=whole)
    ],
    "minmax.morphology": lambda t: [
        (*e, 0.0, 1e4, up)
        for up in (True, False)
        for whole in (False, True)
        for e in in_borders(t, HEIGHTS.to(t), 1, 1, border, whole=whole)
    ],
    "minmax.morphology_gradient": lambda t: (
        in_borders(t, HEIGHTS.to(t), 1, 1, border, 0.5, 0.25, 1e4)
        + in_borders(t, HEIGHTS.to(t), 1, 1, border, 5.0, 2.0, 1e4, whole=True)
    ),
    "qr._derived": lambda t: [null(t)],
    "flips.flip": lambda t: [
        (x, along, down)
        for x in (*bytes_and_words(), *images(t), numbers(t, 3, 4, 5), numbers(t, 4, 5))
        for along, down in ((True, False), (False, True), (True, True))
    ],
    "histograms.clahe_interpolate": lambda t: [curves(t)],
    "histograms.bincount": lambda t: [(integers(9, 2, 50), 9)],
    "histograms.aminmax": lambda t: [(numbers(t, 2, 50),)],
    "histograms.lut": lambda t: [
        (numbers(t, 2, 256), integers(256, 2, 50)),
        (numbers(t, 2, 9), integers(9, 2, 50)),
    ],
    "histograms.partial_sums": lambda t: [(numbers(t, 2, 3, 12),)],
    "histograms.running_sum": lambda t: [(numbers(t, 2, 32),), (integers(9, 2, 3, 256),)],
    "histograms.clahe_histograms": lambda t: [(integers(256, 2, 12, 17).to(torch.int32), 4, 6, 3, 3)],
    "matrices._derived_from_cofactors": lambda t: [
        (torch.linalg.det(matrices(t, n)), matrices(t, n)) for n in (3, 4)
    ],
    "matrices._eliminated_inverse": lambda t: [(matrices(torch.float64, n),) for n in (3, 6)],
    "matrices.normalized_power": lambda t: [(matrices(torch.float64, n), 6) for n in (3, 6)],
    "matrices.small_matmul": lambda t: [
        (numbers(t, 2, 3, 4), numbers(t, 2, 4, 5)),
        (numbers(t, 1, 3), numbers(t, 2, 3, 3)),
    ],
    "matrices.spd_inverse": lambda t: [(matrices(torch.float64, n),) for n in (3, 6)],
    "materialise.materialised": lambda t: [(x, dim) for x in images(t) for dim in (0, 2)],
    "materialise.stored_index": lambda t: [(torch.arange(9),)],
    "bilateral.bilateral_mean": lambda t: [
        (
            x,
            x[:1],
            *(torch.tensor([taps], dtype=t) for taps in (TAPS, FIVE)),
            torch.full([1, 1, 1, 1], -2.0, dtype=t),
            squares,
            b,
        )
        for x in images(t)
        for squares in (True, False)
        for b in BORDERS
    ],
    "bilateral._mean_of_bytes": lambda t: [
        (
            x,
            guide,
            60.0 * torch.ones(1, 3, 5, dtype=torch.float64),
            1.0 + numbers(torch.float64, n, 195076),
            squares,
            b,
        )
        for x in bytes_and_words()[:2]
        for guide, n in ((x, 1), (x[:1, :2], 2))
        for squares in (True, False)
        for b in BORDERS
    ],
    "matching.cdist_squared": lambda t: [(numbers(t, 2, 5, 8), numbers(t, 2, 7, 8))],
    "matching.two_smallest": lambda t: [(numbers(t, 2, 5, 7), along_rows) for along_rows in (True, False)],
    "padding.padded": lambda t: [(x, (2, 1), (1, 3), b, 0.5) for x in images(t) for b in BORDERS],
    "padding.bordered": lambda t: [
        (x, (2, 1), (1, 3), b, 0.5) for x in images(t) for b in (*BORDERS, "symmetric")
    ],
    "padding.padded_parts": lambda t: [
        (x, (1, 1), margin, b, 0.5) for x in images(t) for b in BORDERS for margin in ((1, 1), (0, 2))
    ],
    "patches.read_patches": lambda t: [frames(t)],
    "color_planes.mix_channels": lambda t: [
        (numbers(t, 2, 3, 4, 5), [0.5, 0.25, 0.0, 0.0, 0.0, 1.0], 0.5, "image")
    ],
    "polynomials._found": lambda t: [(numbers(torch.float64, 6, 20) - 0.5, 48)],
    "polynomials.product_of_coefficients": lambda t: [
        (numbers(t, 2, 3), numbers(t, 2, 2), [0, 1, 1, 2, 2, 3], 4)
    ],
    "power.power": lambda t: [
        (x, exponent)
        for exponent in (1.0 / 3.0, 2.4, 1.0 / 2.4, 0.7)
        for x in (numbers(t, 50) + 0.01, torch.tensor([1e-37, 1e-4, 1e12, 1e38, float("inf")]).to(t))
    ],
    "power.power_each": lambda t: [
        (numbers(t, 2, 50) - 0.1, torch.tensor(0.7, dtype=t)),
        (numbers(t, 2, 50), torch.tensor([[0.0], [2.2]], dtype=t)),
    ],
    "ranking.stable_topk": lambda t: [(numbers(t, 2, n), 3) for n in (20, 100)],
    "reconstruction.reconstructed": lambda t: [
        (x - 0.3 if largest else x + 0.3, x, element, iterations, largest)
        for x in images(t)
        for element in (torch.ones(3, 3, dtype=t), torch.tensor([[0.0, 1.0, 0.0], [1.0, 1.0, 0.0]], dtype=t))
        for iterations in (None, 2)
        for largest in (True, False)
    ],
    "reductions._with_nan": lambda t: [
        (x.amin(dims, keepdim=True), x, dims) for x in images(t) for dims in ([1], [2, 3])
    ],
    "reshaping.reshaped": lambda t: [(numbers(t, 4, 6).t(), [3, 8])],
    "reshaping.split_dim": lambda t: [(numbers(t, 2, 6, 3), 1, 2, 3)],
    "resizing.blurred_and_resized": lambda t: in_borders(t, 6, 7, False, FIVE, border),
    "resizing.resized": lambda t: (
        [
            (x, 7, 20, mode, corners, antialias)
            for x in images(t)
            for mode in ("nearest", "bilinear", "bicubic")
            for corners in (True, False)
            for antialias in (True, False)
            if not (antialias and mode == "nearest")
        ]
        + [
            (x, *size, mode, False, True)
            for x in images(t)
            for size in ((7, 20), (4, 3))
            for mode in ("area", "lanczos")
        ]
        + [(x, 7, 20, "lanczos4", corners, False) for x in images(t) for corners in (True, False)]
    ),
    "subsampled.subsampled_to_rgb": lambda t: [
        (luma[:, :1], chroma[:, :2, :5, :4].contiguous(memory_format=layout), WEIGHTS, swapped)
        for luma, chroma, layout in zip(
            bytes_and_words()[:2],
            bytes_and_words()[:2],
            (torch.channels_last, torch.contiguous_format),
        )
        for swapped in (False, True)
    ],
    "subsampled.planar_to_rgb": lambda t: [
        (luma[:, :1], chroma[:, :1, :5, :4], chroma[:, 1:2, :5, :4], WEIGHTS)
        for luma, chroma in zip(bytes_and_words()[:2], bytes_and_words()[:2])
    ],
    "subsampled.chroma_means": lambda t: [
        (x[..., :height, :width].contiguous(memory_format=layout), both)
        for x in bytes_and_words()[:1]
        for height, width in ((12, 16), (11, 17))
        for layout in (torch.channels_last, torch.contiguous_format)
        for both in (True, False)
    ],
    "grids.in_grid": lambda t: [
        (numbers(t, batch, 2, 4, 5), columns, padding)
        for batch, columns in ((1, 1), (5, 2), (2, 3))
        for padding in (0, 2)
    ],
    "subsampled.packed_to_rgb": lambda t: [
        (torch.cat([x, x[:, :1]], 1).contiguous(memory_format=layout), WEIGHTS, first)
        for x in bytes_and_words()[:1]
        for layout in (torch.channels_last, torch.contiguous_format)
        for first in (False, True)
    ],
    "subsampled.rgb_to_subsampled": lambda t: [
        (x[..., :height, :width].contiguous(memory_format=layout), MIXED)
        for x in bytes_and_words()[:1]
        for height, width in ((12, 16), (11, 17))
        for layout in (torch.channels_last, torch.contiguous_format)
    ],
    "placing.placed_bytes": lambda t: [
        (x, torch.tensor([1, 0, 1]), integers(20, 3, 8), 9, 20, 7) for x in bytes_and_words()[:2]
    ],
    "placing.filled_beside": lambda t: [
        (x, torch.tensor(box), 7.0)
        for x in bytes_and_words()[:2]
        for box in ([2, 1, 5, 3], [-2, 3, 9, 90], [0, 0, 90, 90])
    ],
    "placing.scaled_bytes": lambda t: [(x, [2, 0], [0.5, 2.0], [-1.0, 3.0]) for x in bytes_and_words()[:2]],
    "boxes.kept_boxes": lambda t: [
        (torch.cat([numbers(t, 2, 9, 2), 1 + numbers(t, 2, 9, 3)[..., :2]], -1), integers(2, 2, 9), 0.4, 5)
    ],
    "resizing.resized_and_blurred": lambda t: in_borders(t, 24, 30, False, FIVE, border),
    "canny.canny_hysteresis": lambda t: [(numbers(t, 2, 1, 12, 17), 0.4, 0.8, 100)],
    "search.last_not_above": lambda t: [
        (numbers(t, 2, n).sort().values, 1.4 * numbers(t, 2, 30) - 0.2) for n in (1, 9, 16)
    ],
    "rank.window_rank": lambda t: [
        (*e[:-1], rank, e[-1])
        for n, rank, whole in ((3, 4, False), (5, 12, False), (3, 0, False), (3, 4, True), (7, 3, True))
        for e in in_borders(t, n, n, border, whole=whole)
    ],
    "solvers.equations._derived": lambda t: [
        (numbers(t, 2, 3), torch.tensor([[False, False, True]] * 2), numbers(t, 2, 4))
    ],
    "geometry.pnp._derived": lambda t: [pose(t)],
    "stencil.separable": lambda t: [
        (x, numbers(t, b, 3), numbers(t, b, 5), name)
        for x in images(t)
        for b in (1, x.size(0))
        for name in BORDERS
    ],
    "stencil.separable_each": lambda t: [
        ([x, 2.0 * x], TAPS, FIVE, name) for x in images(t) for name in BORDERS
    ],
    "stencil.separable_scales": lambda t: [
        ([x, 2.0 * x], [TAPS, [0.2, 0.6, 0.2]], name) for x in images(t) for name in BORDERS
    ],
    "bayer.demosaic": lambda t: [
        (x, red // 2, red % 2)
        for x in (
            *(image[:, :1].contiguous() for image in (*bytes_and_words()[1::2], images(t)[0])),
            integers(256, 2, 12, 17, 1).to(torch.uint8).permute(0, 3, 1, 2),
        )
        for red in range(4)
    ],
    "luv.luv_of_bytes": lambda t: [
        (
            x,
            integers(65536, 256).double(),
            integers(349525, 9).double().tolist(),
            100.0 * numbers(torch.float64, 16385),
        )
        for x in bytes_and_words()[:2]
    ],
    "luv.bytes_of_luv": lambda t: [
        (
            x,
            100.0 * numbers(torch.float64, 256),
            numbers(torch.float64, 1, 256)[0],
            (numbers(torch.float64, 9) - 0.3).tolist(),
            integers(256, 16385).to(torch.uint8),
            1e-12,
        )
        for x in bytes_and_words()[:2]
    ],
    "color_planes.arranged": lambda t: [
        (x, order, 7.0)
        for x in (*bytes_and_words(), images(t)[0])
        for order in ([1, 0], [0, 1, 1], [2, 1, 0, -1])
    ],
    "color_planes.hue_of_bytes": lambda t: [
        (x, lightness) for x in bytes_and_words()[:2] for lightness in (False, True)
    ],
    "color_planes.bytes_of_hue": lambda t: [
        (x, lightness) for x in bytes_and_words()[:2] for lightness in (False, True)
    ],
    "color_planes.curved": lambda t: [
        (
            x,
            integers(500, 3, 256).to(torch.int32),
            MATRIX,
            3,
            integers(900, 999).to(torch.int32),
            MATRIX,
            2,
            integers(256, 77).to(torch.int32),
        )
        for x in bytes_and_words()[:2]
    ],
    "color_planes.luma_chroma": lambda t: [
        (x, [4899, 9617, 1868], *factors)
        for x in bytes_and_words()[:2]
        for factors in ((9241, 11682), (0, 32767))
    ],
    "color_planes.mix_bytes": lambda t: [
        (x, weights, 14)
        for x in bytes_and_words()[:2]
        for weights in (
            [4899, 9617, 1868, 8192],
            [9, 8, 7, 6, -5000, 4, 9000, 2, 1, 0, 100, 200],
            [33292, 0, 9, 0] * 3,
        )
    ],
    "fixed_point.box_bytes": lambda t: [
        (x, *size, name)
        for x in bytes_and_words()[:2]
        for name in BORDERS
        for size in ((3, 5), (4, 2), (17, 16))
    ],
    "reductions.extreme_indices": lambda t: [
        (x,)
        for planes in (
            integers(200, 2, 3, 9, 40).to(torch.uint8),
            numbers(t, 2, 3, 5, 30),
            torch.tensor([[float("nan"), 3, 3, float("inf")], [float("nan")] * 4], dtype=t)[None, :, None],
        )
        for x in (planes, planes.permute(0, 2, 3, 1).contiguous().permute(0, 3, 1, 2))
    ],
    "reductions.moments_bytes": lambda t: [
        (x,)
        for planes in (integers(256, 2, 3, 9, 40).to(torch.uint8),)
        for x in (planes, planes.permute(0, 2, 3, 1).contiguous().permute(0, 3, 1, 2))
    ],
    "regions.box_maxima": lambda t: [(numbers(t, 2, 3, 9, 11), *bins())],
    "regions.bilinear_means": lambda t: [
        (numbers(t, 2, 3, planes, 9, 11), integers(2, 5), *points(t), 6 // planes) for planes in (1, 2, 6)
    ],
    "regions.box_means": lambda t: [(numbers(t, 2, 3, 6, 9, 11), *bins())],
    "fixed_point.laplacian_bytes": lambda t: [
        (x, *size, name)
        for x in bytes_and_words()[:2]
        for name in BORDERS
        for size in ((3, 3), (1, 5), (9, 13))
    ],
    "fixed_point.separable_bytes": lambda t: [
        (x, fixed_taps(torch.tensor([TAPS])), fixed_taps(numbers(torch.float64, *rows, 5).softmax(1)), name)
        for x in bytes_and_words()[:2]
        for name in BORDERS
        for rows in ((1,), (2,))
    ],
    "fixed_point.correlated_bytes": lambda t: [
        (x, *whole_taps(numbers(t, *rows, *size) - 0.5), name)
        for x in bytes_and_words()[:2]
        for name in BORDERS
        for rows, size in (((1,), (3, 3)), ((2,), (2, 5)))
    ],
    "layout.in_frames": lambda t: [(x,) for x in (*bytes_and_words(), *images(t))],
    "layout.in_planes": lambda t: [(x,) for x in (*bytes_and_words(), *images(t))],
    "pyramids.blurred_and_thinned": lambda t: (
        in_borders(t, border) + [(x, name) for x in bytes_and_words()[:2] for name in BORDERS]
    ),
    "pyramids.spread_and_blurred": lambda t: [(x,) for x in (*images(t), *bytes_and_words()[:2])],
    "resizing.resized_bytes": lambda t: [
        (x, *size, corners)
        for x in bytes_and_words()[:2]
        for size in ((5, 30), (1, 1))
        for corners in (False, True)
    ],
    "derivatives.magnitude_of_bytes": lambda t: [
        (x, normalized) for x in bytes_and_words()[:2] for normalized in (True, False)
    ],
    "derivatives.lengths_of_bytes": lambda t: [
        (x, *weights) for x in bytes_and_words()[:2] for weights in ((3, 10, 32), (3, 10, 1), (1, 1, 6))
    ],
    "derivatives.derivatives_of_bytes": lambda t: [
        (x, mode) for x in bytes_and_words()[:2] for mode in GRADIENTS
    ],
    "masks.mask_in_range": lambda t: (
        [
            (x, low - 20.0, low + high)
            for x in bytes_and_words()[:2]
            for low, high in (
                (90.5 * numbers(torch.float32, 3, 1, 1), 150.0),
                (90.0 * numbers(torch.float32, 2, 3, 1, 1), torch.full([2, 3, 1, 1], 200.0)),
                (torch.full([3, 1, 1], 300.0), 9.0),
            )
        ]
        + [
            (x, torch.tensor([low, -70000.0])[:, None, None], torch.tensor([high, 40000.0])[:, None, None])
            for x in words()
            for low, high in ((-9000.5, 9000.0), (20000.0, 90000.0), (7.0, 5.0))
        ]
    ),
    "masks.masked_pixels": lambda t: [
        (x, 255 * integers(2, 2, 1, *x.shape[2:]).to(torch.uint8)) for x in (*bytes_and_words()[:2], *words())
    ],
    "masks.split_at": lambda t: (
        [
            (x, torch.tensor(limit, dtype=torch.int32), above, below)
            for x in (*words(), words()[0][0, 0])
            for limit in ([20000], [-40000], [70000])
            for above, below in (
                (torch.tensor([90000], dtype=torch.int32), torch.tensor([-5], dtype=torch.int32)),
                (torch.tensor([9], dtype=torch.int32), None),
                (None, torch.tensor([0], dtype=torch.int32)),
            )
        ]
        + [
            (
                x,
                torch.tensor([9000, 30000], dtype=torch.int32).reshape(2, 1, 1, 1),
                None,
                torch.zeros(1).int(),
            )
            for x in words()
        ]
        + [(x, integers(40000, x.size(-1)).to(torch.int32), None, None) for x in words()]
    ),
    "pixels.difference": lambda t: [(x, turned(x)) for x in bytes_and_words()],
    "pixels.weighted_sum": lambda t: [
        (x, turned(x), *weights)
        for x in bytes_and_words()[:2]
        for weights in (
            (torch.tensor([0.3]), torch.tensor(0.9), torch.tensor([-4.5])),
            tuple(numbers(torch.float32, 3, 2, 1, 1, 1) * 3.0 - 1.0),
            (torch.tensor([1.0]), numbers(torch.float32, *x.shape), torch.tensor([0.0])),
            (torch.tensor([1.0]), numbers(torch.float32, x.size(-1)), torch.tensor([0.0])),
        )
    ],
    "resizing.resampled_bytes": lambda t: [
        (x, integers(9, 7, 3), signed_taps(7), integers(13, 30, 3), signed_taps(30))
        for x in bytes_and_words()[:2]
    ],
    "resizing.summed_bytes": lambda t: [
        (x, integers(9, 7, taps), quarters(7, taps), integers(13, 30, taps), quarters(30, taps))
        for x in bytes_and_words()[:2]
        for taps in (4, 8)
    ],
    "resizing.weighted_means": lambda t: [
        (x, integers(9, 7, taps), quarters(7, taps), integers(8, 30, taps), quarters(30, taps), total)
        for x in (bytes_and_words()[0], *words())
        for taps in (1, 2, 5)
        for total in (torch.tensor([2.0**22], dtype=torch.float64), torch.tensor([3e5 + 1]).double())
    ],
    "resizing.resampled": lambda t: [
        (x, integers(9, 7, 3), numbers(t, 7, 3), integers(8, 30, 3), numbers(t, 30, 3)) for x in images(t)
    ],
    "resizing.area_means": lambda t: [
        (x, *size) for x in bytes_and_words() for size in ((4, 17), (5, 6), (30, 40))
    ],
    "flips.transposed": lambda t: [(x,) for x in (*bytes_and_words(), *images(t), numbers(t, 9, 8))],
    "resizing.resized_nearest": lambda t: [(x, 5, 30) for x in (*bytes_and_words(), *images(t))],
    "tables.table_entries": lambda t: [
        (x, integers(256, x.size(0), 256).to(torch.uint8))
        for x in (*bytes_and_words()[:2], integers(256, 3, 40).to(torch.uint8))
    ],
    "tables.table_colours": lambda t: [
        (integers(256, 2, 9, 8, 1).to(torch.uint8).permute(0, 3, 1, 2), integers(256, 3, 256).to(torch.uint8))
    ],
    "stencil.separable_shared": lambda t: in_borders(t, TAPS, FIVE, border),
    "stencil.split_channels": lambda t: [(x,) for x in (*images(t), numbers(t, 3, 4, 5))],
    "integral.integral_of_bytes": lambda t: [
        (x,)
        for x in (*bytes_and_words()[:2], *(integers(256, *s).to(torch.uint8) for s in ((9, 8), (2, 3, 4))))
    ],
    "warping.resample_affine": lambda t: (
        sampled(t, torch.eye(3, dtype=t)[None, :2] + 0.1 * numbers(t, 2, 2, 3), 6, 7)
        + bytes_sampled(torch.eye(3, dtype=t)[None, :2] + 0.1 * numbers(t, 2, 2, 3), 6, 7)
    ),
    "warping.resample_bytes": lambda t: bytes_sampled(
        20.0 * numbers(t, 2, 6, 7) - 2.0, 16.0 * numbers(t, 1, 6, 7) - 2.0
    ),
    "warping.resample_floating": lambda t: sampled(
        t, 14.0 * numbers(t, 2, 6, 7) - 2.0, 12.0 * numbers(t, 1, 6, 7) - 2.0
    ),
    "warping.resample_projective": lambda t: (
        sampled(t, torch.eye(3, dtype=t)[None] + 0.1 * numbers(t, 2, 3, 3), 6, 7)
        + bytes_sampled(torch.eye(3, dtype=t)[None] + 0.1 * numbers(t, 2, 3, 3), 6, 7)
    ),
    "regions.window_maxima": lambda t: [
        (
            numbers(t, 2, height, 5),
            torch.tensor([0, 1, 1]),
            torch.tensor([0, height // 3, height - 1]),
            torch.tensor([height, height - height // 4, height]),
        )
        for height in (1, 2, 12, 17)
    ],
    "rounding.known_or": lambda t: [(torch.tensor([0.5, torch.nan, torch.inf, -torch.inf], dtype=t), -2.0)],
    "thinning.thinned": lambda t: [(x - 0.2, 1000, zhang) for x in images(t) for zhang in (True, False)],
    "windows.windows": lambda t: [
        (x, (3, 2), (4, 3), (3, 4), first) for x in images(t) for first in ((0, 0), (1, 2), (-1, -2))
    ],
}

#: Native code may store integers that are known to be small with fewer bits; their readers accept both.
FEWER_BITS = {"histograms.quantize_u8", "histograms.clahe_interpolate", "materialise.stored_index"}

#: Joins results in parts, because the parts depend on the target.
WHOLE: dict[str, Callable[[Any], Tensor]] = {
    "padding.padded_parts": lambda parts: join_columns(
        [p[..., 2:] - 3.0 * p[..., 1:-1] + p[..., :-2] for p in parts]
    ),
    "stencil.split_channels": join_channels,
}


def examples(name: str, dtype: torch.dtype) -> list[Example]:
    key = listed(name, EXAMPLES)
    found = EXAMPLES[key](dtype) if key else declared_examples(PRIMITIVES[name].lowerings, dtype)
    assert found, f"{name}: EXAMPLES has no arguments for it"
    return found


def listed(name: str, table: Any) -> str | None:
    return next((key for key in table if name.endswith("." + key)), None)


#: The relative and absolute difference that is allowed; other types are exact.
TOLERANCES = {torch.float32: 1e-5, torch.float64: 1e-12}


def assert_equal(name: str, actual: Any, expected: Any) -> None:
    if key := listed(name, WHOLE):
        actual, expected = WHOLE[key](actual), WHOLE[key](expected)
    for a, e in zip(tree_leaves(actual), tree_leaves(expected), strict=True):
        if listed(name, FEWER_BITS):
            assert a.is_floating_point() == e.is_floating_point() or a.dtype == torch.uint8
            a = a.to(e.dtype)
        tolerance = TOLERANCES.get(e.dtype, 0)
        torch.testing.assert_close(a, e, rtol=tolerance, atol=tolerance, equal_nan=True)


@pytest.fixture(scope="module")
def kernels() -> Iterator[None]:
    with computing_kernels():
        yield


CHOICES = [(name, rule) for name, made in PRIMITIVES.items() for rule in made.lowerings]


@pytest.mark.usefixtures("kernels")
@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@pytest.mark.parametrize(
    ("name", "rule"),
    CHOICES,
    ids=[f"{name.removeprefix('chiasm.')}-{rule.form.__name__}" for name, rule in CHOICES],
)
def test_a_lowering_is_its_definition(name: str, rule: Lowering, dtype: torch.dtype) -> None:
    for example in examples(name, dtype):
        with patch.object(torch.compiler, "is_exporting", lambda: True):  # otherwise no kernel would be used
            taken = rule.when is None or rule.when(*example)
        if not taken:
            continue
        expected = PRIMITIVES[name].definition(*example)
        for target in rule.targets:  # functions that the lowering calls may ask for the target
            with exporting(target):
                assert_equal(name, rule.form(*example), expected)


@pytest.mark.parametrize(
    ("name", "rule"),
    CHOICES,
    ids=[f"{name.removeprefix('chiasm.')}-{rule.form.__name__}" for name, rule in CHOICES],
)
def test_an_example_reaches_every_lowering(name: str, rule: Lowering) -> None:
    with patch.object(torch.compiler, "is_exporting", lambda: True):
        made = [example for dtype in DTYPES for example in examples(name, dtype)]
        earlier = [
            r
            for r in PRIMITIVES[name].lowerings[: PRIMITIVES[name].lowerings.index(rule)]
            if set(rule.targets) <= set(r.targets)
        ]
        assert any(_takes(rule, e) and not any(_takes(r, e) for r in earlier) for e in made)


def _takes(rule: Lowering, example: Example) -> bool:
    return rule.when is None or rule.when(*example)


@pytest.mark.parametrize(("name", "made"), PRIMITIVES.items(), ids=PRIMITIVES)
def test_what_is_scripted_is_the_definition(name: str, made: Primitive[..., Any]) -> None:
    scripted = torch.jit.script(made)
    example = examples(name, torch.float64)[0]
    for target in TARGETS:
        with exporting(target):
            actual = scripted(*example)
        assert_equal(name, actual, made.definition(*example))


#: Names with which code asks for its target, or serves a compiler.
ASKING = {
    "as_rows",
    "available",
    "current_target",
    "exporting",
    "has_kernel",
    "has_pixel_kernel",
    "interleaved",
    "is_compiling",
    "is_dynamo_compiling",
    "is_exporting",
    "is_in_onnx_export",
    "is_scripting",
    "is_tracing",
    "join_channels",
    "join_columns",
    "lowering",
    "padded_parts",
    "split_channels",
    "volume_parts",
}
ROOT = Path(chiasm.__file__).parent
MODULES = [
    p
    for p in sorted(ROOT.rglob("*.py"))
    if p.relative_to(ROOT).parts[0].removesuffix(".py") not in (*NO_OPS, "primitives")
]


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(ROOT)))
def test_no_op_asks_what_it_is_compiled_for(path: Path) -> None:
    used = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and (node.module or "").endswith("primitives"):
            assert not {"kernels", "target"} & {alias.name for alias in node.names}
        if isinstance(node, ast.Name):
            used.add(node.id)
        elif isinstance(node, ast.Attribute):
            used.add(node.attr)
        elif isinstance(node, ast.alias):
            used.add(node.name)
    assert not used & ASKING
