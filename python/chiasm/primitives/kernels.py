"""The operators whose native code is written by hand, for what compiled tensor code measurably cannot reach.

Each function here is, or is called by, the lowering for native code of the primitive that its docstring names. That primitive's definition
stays in tensor code, which runs in eager Python, TorchScript and ONNX, and of which gradients are taken. Here are only names, shapes and
types: the loops are in runtime/artifact/kernels, the exporter (export/native.py) links them into native code, and the parity matrix compares
the two.
"""

from typing import Callable, List, Tuple

import torch
from torch import Tensor

_BORDERS = ("reflect", "replicate", "circular", "constant")
_INTERPOLATIONS = ("bilinear", "nearest")
_FILTERS = ("nearest", "bilinear", "bicubic")
_PADDINGS = ("zeros", "border", "reflection")


def available(x: Tensor, *_: object) -> bool:
    """Whether what is computed of x is being exported for the CPU: the operators below have no computation of their own."""
    return torch.compiler.is_exporting() and x.device.type == "cpu"


def has_kernel(x: Tensor, *_: object) -> bool:
    """``available``, and x is of a floating-point type that the kernels have."""
    return available(x) and (x.dtype == torch.float32 or x.dtype == torch.float64)


def runs_to_its_end(limit: int) -> bool:
    """Whether a loop over connected pixels needs no limit: its steps grow with the logarithm of the pixels' number, and 64 of them are
    enough for any mask."""
    return limit >= 64


def _operator(schema: str, shape: Callable[..., Tensor]) -> Callable[..., Tensor]:
    name = schema.partition("(")[0]
    torch.library.define(f"chiasm::{name}", schema.removeprefix(name))
    torch.library.register_fake(f"chiasm::{name}", shape)
    return getattr(torch.ops.chiasm, name)


_separable = _operator(
    "separable(Tensor x, Tensor kernel_y, Tensor kernel_x, int border, float scale, float centre) -> Tensor", lambda x, *_: x.new_empty(x.shape)
)
_correlate2d = _operator("correlate2d(Tensor x, Tensor kernel, int border) -> Tensor", lambda x, *_: x.new_empty(x.shape))
_bilateral = _operator(
    "bilateral(Tensor x, Tensor guide, Tensor nearness, Tensor falloff, int border, bool squares) -> Tensor", lambda x, *_: x.new_empty(x.shape)
)
_rectangle_extreme = _operator(
    "rectangle_extreme(Tensor x, int rows, int columns, int border, float value, bool largest) -> Tensor", lambda x, *_: x.new_empty(x.shape)
)
_structured_extreme = _operator(
    "structured_extreme(Tensor x, Tensor heights, int row, int column, int border, float value, float absent, bool largest) -> Tensor",
    lambda x, *_: x.new_empty(x.shape),
)
_structured_range = _operator(
    "structured_range(Tensor x, Tensor high_window, Tensor low_window, int row, int column, int border, float high_value, float low_value, "
    "float absent) -> Tensor",
    lambda x, *_: x.new_empty(x.shape),
)
_median3x3 = _operator("median3x3(Tensor x, int border) -> Tensor", lambda x, *_: x.new_empty(x.shape))
_integral = _operator("integral(Tensor x) -> Tensor", lambda x: x.new_empty(x.shape))
_frame_to_grey = _operator(
    "frame_to_grey(Tensor frame) -> Tensor", lambda frame: frame.new_empty([1, 1, frame.size(0), frame.size(1)], dtype=torch.float32)
)
_resize_frame = _operator(
    "resize_frame(Tensor frame, SymInt height, SymInt width) -> Tensor", lambda frame, height, width: frame.new_empty([1, 3, height, width], dtype=torch.float32)
)
_to_levels = _operator("to_levels(Tensor x) -> Tensor", lambda x: x.new_empty(x.shape, dtype=torch.uint8))
_extents = _operator("extents(Tensor x) -> Tensor", lambda x: x.new_empty([2, x.size(0), 1]))
_bin_counts = _operator(
    "bin_counts(Tensor x, Tensor low, Tensor span, int bins) -> Tensor",
    lambda x, low, span, bins: x.new_empty([x.size(0), bins], dtype=torch.int32),
)
_count_each = _operator(
    "count_each(Tensor index, int bins) -> Tensor", lambda index, bins: index.new_empty([index.size(0), bins], dtype=torch.int32)
)
_look_up = _operator("look_up(Tensor table, Tensor index) -> Tensor", lambda table, index: table.new_empty(index.shape))
_tile_counts = _operator(
    "tile_counts(Tensor levels, SymInt tile_y, SymInt tile_x, int tiles_y, int tiles_x) -> Tensor",
    lambda levels, tile_y, tile_x, tiles_y, tiles_x: levels.new_empty([levels.size(0), tiles_y * tiles_x, 256], dtype=torch.int32),
)
_blend_curves = _operator(
    "blend_curves(Tensor table, int tiles_x, Tensor levels, Tensor first_y, Tensor second_y, Tensor weight_y, Tensor first_x, "
    "Tensor second_x, Tensor weight_x) -> Tensor",
    lambda table, tiles_x, levels, *_: levels.new_empty(levels.shape),
)
_component_roots = _operator(
    "component_roots(Tensor mask) -> Tensor", lambda mask: mask.new_empty([mask.size(0), mask.size(1) * mask.size(2)], dtype=torch.int32)
)
_sobel = _operator("sobel(Tensor x, float scale, float eps) -> Tensor", lambda x, *_: x.new_empty(x.shape))
_ridges = _operator("ridges(Tensor x, float eps) -> Tensor", lambda x, eps: x.new_empty(x.shape))
_hysteresis = _operator("hysteresis(Tensor x, float low, float high) -> Tensor", lambda x, low, high: x.new_empty(x.shape, dtype=torch.bool))

_sample = _operator(
    "sample(Tensor src, Tensor x, Tensor y, int mode, int padding, bool corners) -> Tensor",
    lambda src, x, *_: src.new_empty([src.size(0), src.size(1), x.size(1), x.size(2)]),
)
_sample_projective = _operator(
    "sample_projective(Tensor src, Tensor matrix, SymInt height, SymInt width, int mode, int padding, bool corners) -> Tensor",
    lambda src, matrix, height, width, *_: src.new_empty([src.size(0), src.size(1), height, width]),
)
_resize = _operator(
    "resize(Tensor x, SymInt height, SymInt width, int filter, bool corners, bool antialias) -> Tensor",
    lambda x, height, width, *_: x.new_empty([x.size(0), x.size(1), height, width]),
)
_resize_blurred = _operator(
    "resize_blurred(Tensor x, Tensor kernel, SymInt height, SymInt width, bool corners, int border, bool before) -> Tensor",
    lambda x, kernel, height, width, *_: x.new_empty([x.size(0), x.size(1), height, width]),
)
_sample_patches = _operator(
    "sample_patches(Tensor pixels, Tensor start, Tensor height, Tensor width, Tensor frames, int side) -> Tensor",
    lambda pixels, start, height, width, frames, side: pixels.new_empty([pixels.size(0), pixels.size(1), frames.size(1), side, side]),
)
_strongest_extrema = _operator(
    "strongest_extrema(Tensor x, Tensor margins, bool minima, int count) -> Tensor",
    lambda x, margins, minima, count: x.new_empty([x.size(0), count], dtype=torch.int64),
)
_squared_distances = _operator("squared_distances(Tensor a, Tensor b) -> Tensor", lambda a, b: a.new_empty([a.size(0), a.size(1), b.size(1)]))
_two_least = _operator(
    "two_least(Tensor x, bool along_rows) -> Tensor",
    lambda x, along_rows: x.new_empty([x.size(0), x.size(1) if along_rows else x.size(2), 2], dtype=torch.int64),
)
_direction_histograms = _operator(
    "direction_histograms(Tensor patches, Tensor window, Tensor nearness, int bins) -> Tensor",
    lambda patches, window, nearness, bins: patches.new_empty([patches.size(0), bins, nearness.size(0), nearness.size(0)]),
)
_cheapest_models = _operator(
    "cheapest_models(Tensor models, Tensor planes, bool epipolar, int count) -> Tensor",
    lambda models, planes, epipolar, count: models.new_empty([models.size(0), count], dtype=torch.int64),
)
_real_roots = _operator("real_roots(Tensor coefficients) -> Tensor", lambda c: c.new_empty([2, c.size(0) - 1, c.size(1)]))
_gauss_jordan = _operator("gauss_jordan(Tensor m) -> Tensor", lambda m: m.new_empty(m.shape))
_spd_inverse = _operator("spd_inverse(Tensor m) -> Tensor", lambda m: m.new_empty(m.shape))
_high_power = _operator("high_power(Tensor m, int squarings) -> Tensor", lambda m, squarings: m.new_empty(m.shape))


def separable(x: Tensor, kernel_y: Tensor, kernel_x: Tensor, border_type: str, scale: float = 1.0, centre: float = 0.0) -> Tensor:
    """``scale`` times ``stencil.separable`` plus ``centre`` times x."""
    return _separable(x, kernel_y, kernel_x, _BORDERS.index(border_type), scale, centre)


def separable_shared(x: Tensor, taps_y: List[float], taps_x: List[float], border_type: str, scale: float = 1.0, centre: float = 0.0) -> Tensor:
    """``separable`` with taps that are numbers."""
    column = torch.tensor([taps_y], dtype=x.dtype, device=x.device)
    row = torch.tensor([taps_x], dtype=x.dtype, device=x.device)
    return separable(x, column, row, border_type, scale, centre)


def correlate2d(x: Tensor, kernel: Tensor, border_type: str) -> Tensor:
    """``correlation.correlated2d``."""
    return _correlate2d(x, kernel, _BORDERS.index(border_type))


def bilateral(x: Tensor, guide: Tensor, nearness: Tensor, falloff: Tensor, border_type: str, squares: bool) -> Tensor:
    """``nearby.nearby_mean``."""
    return _bilateral(x, guide, nearness, falloff, _BORDERS.index(border_type), squares)


def rectangle_extreme(x: Tensor, rows: int, columns: int, border_type: str, largest: bool, value: float) -> Tensor:
    """``extremes.rectangle_extreme``."""
    return _rectangle_extreme(x, rows, columns, _BORDERS.index(border_type), value, largest)


def structured_extreme(
    x: Tensor, heights: Tensor, row: int, column: int, border_type: str, value: float, absent: float, largest: bool
) -> Tensor:
    """``extremes.structured_extreme``."""
    return _structured_extreme(x, heights, row, column, _BORDERS.index(border_type), value, absent, largest)


def structured_range(
    x: Tensor, high_window: Tensor, low_window: Tensor, row: int, column: int, border_type: str, high_value: float, low_value: float, absent: float
) -> Tensor:
    """``extremes.structured_range``."""
    return _structured_range(x, high_window, low_window, row, column, _BORDERS.index(border_type), high_value, low_value, absent)


def median3x3(x: Tensor, border_type: str) -> Tensor:
    """``selection.window_rank`` with the middle rank of 3 x 3."""
    return _median3x3(x, _BORDERS.index(border_type))


def integral(x: Tensor) -> Tensor:
    """``summed_area.summed_area``."""
    return _integral(x)


def frame_to_grey(frame: Tensor) -> Tensor:
    """``frames.grey_frame``."""
    return _frame_to_grey(frame)


def resize_frame(frame: Tensor, height: int, width: int) -> Tensor:
    """``frames.resized_frame``."""
    return _resize_frame(frame, height, width)


def to_levels(x: Tensor) -> Tensor:
    """``levels.to_levels``, as uint8."""
    return _to_levels(x)


def extents(x: Tensor) -> Tuple[Tensor, Tensor]:
    """``levels.extents``."""
    both = _extents(x)
    return both[0], both[1]


def bin_counts(x: Tensor, low: Tensor, span: Tensor, bins: int) -> Tensor:
    """``levels.bin_counts``."""
    return _bin_counts(x, low, span, bins)


def count_each(index: Tensor, bins: int) -> Tensor:
    """``levels.count_each``."""
    return _count_each(index.to(torch.uint8 if bins <= 256 else torch.int32), bins)


def look_up(table: Tensor, index: Tensor) -> Tensor:
    """``levels.look_up`` in a table of 256."""
    return _look_up(table, index.to(torch.uint8))


def tile_counts(levels: Tensor, tile_y: int, tile_x: int, tiles_y: int, tiles_x: int) -> Tensor:
    """``levels.tile_counts``."""
    return _tile_counts(levels.to(torch.uint8), tile_y, tile_x, tiles_y, tiles_x)


def blend_curves(
    table: Tensor, tiles_x: int, levels: Tensor, first_y: Tensor, second_y: Tensor, weight_y: Tensor, first_x: Tensor, second_x: Tensor, weight_x: Tensor
) -> Tensor:
    """``levels.blend_curves``, as uint8."""
    return _blend_curves(table, tiles_x, levels.to(torch.uint8), first_y, second_y, weight_y, first_x, second_x, weight_x)


def component_roots(mask: Tensor) -> Tensor:
    """``components.component_roots`` without a limit."""
    return _component_roots(mask)


def sobel(x: Tensor, scale: float, eps: float) -> Tensor:
    """``derivatives.sobel_magnitude``."""
    return _sobel(x, scale, eps)


def ridges(x: Tensor, eps: float) -> Tensor:
    """``ridges.ridges``."""
    return _ridges(x, eps)


def hysteresis(x: Tensor, low: float, high: float) -> Tensor:
    """``ridges.linked`` without a limit."""
    return _hysteresis(x, low, high)


def samples(src: Tensor, mode: str, padding_mode: str) -> bool:
    """Whether ``sample`` and ``sample_projective`` have what is wanted."""
    return has_kernel(src) and mode != "bicubic" and padding_mode != "fill"


def sample(src: Tensor, x: Tensor, y: Tensor, mode: str, padding_mode: str, align_corners: bool) -> Tensor:
    """``warping.sample_image``."""
    x, y = torch.broadcast_tensors(x.to(src.dtype), y.to(src.dtype))
    x, y = x.expand(src.size(0), -1, -1).contiguous(), y.expand(src.size(0), -1, -1).contiguous()
    return _sample(src, x, y, _INTERPOLATIONS.index(mode), _PADDINGS.index(padding_mode), align_corners)


def sample_projective(src: Tensor, matrix: Tensor, height: int, width: int, mode: str, padding_mode: str, align_corners: bool) -> Tensor:
    """``warping.sample_projective``."""
    matrix = matrix.to(src.dtype).expand(src.size(0), 3, 3).contiguous()
    return _sample_projective(src, matrix, height, width, _INTERPOLATIONS.index(mode), _PADDINGS.index(padding_mode), align_corners)


def resize(x: Tensor, height: int, width: int, interpolation: str, align_corners: bool, antialias: bool) -> Tensor:
    """``resizing.resized``."""
    return _resize(x, height, width, _FILTERS.index(interpolation), align_corners, antialias)


def resize_blurred(x: Tensor, kernel: List[float], height: int, width: int, align_corners: bool, border_type: str, before: bool) -> Tensor:
    """``resizing.blurred_and_resized`` and ``resizing.resized_and_blurred``."""
    return _resize_blurred(x, torch.tensor(kernel, dtype=x.dtype), height, width, align_corners, _BORDERS.index(border_type), before)


def sample_patches(pixels: Tensor, start: Tensor, height: Tensor, width: Tensor, frames: Tensor, side: int) -> Tensor:
    """``patches.read_levels``."""
    frames = frames.to(pixels.dtype).contiguous()
    return _sample_patches(pixels.contiguous(), start.contiguous(), height.contiguous(), width.contiguous(), frames, side)


def strongest_extrema(x: Tensor, margins: List[int], minima: bool, count: int) -> Tensor:
    """``extrema.strongest_extrema``."""
    return _strongest_extrema(x.contiguous(), torch.tensor(margins, dtype=torch.int64), minima, count)


def squared_distances(a: Tensor, b: Tensor) -> Tensor:
    """``nearest.squared_distances``."""
    return _squared_distances(a.contiguous(), b.contiguous())


def two_least(x: Tensor, along_rows: bool) -> Tensor:
    """``nearest.two_least``."""
    return _two_least(x.contiguous(), along_rows)


def direction_histograms(patches: Tensor, window: Tensor, nearness: Tensor, bins: int) -> Tensor:
    """``directions.direction_histograms``."""
    return _direction_histograms(patches.contiguous(), window.contiguous(), nearness.contiguous(), bins)


def cheapest_models(models: Tensor, planes: Tensor, epipolar: bool, count: int) -> Tensor:
    """``consensus._cheapest``, for models scaled to length 1; zeros cost infinity."""
    return _cheapest_models(models.contiguous(), planes.contiguous(), epipolar, count)


def real_roots(coefficients: Tensor) -> Tuple[Tensor, Tensor]:
    """``polynomials._found`` of polynomials (n + 1, count), n up to 16: (n, count) of places and of whether there is a root."""
    both = _real_roots(coefficients.contiguous())
    return both[0], both[1] > 0


def takes_matrices(m: Tensor, *_: object) -> bool:
    """Whether the next three take matrices (..., n, n)."""
    return available(m) and m.dtype == torch.float64 and isinstance(m.size(-1), int) and 3 <= m.size(-1) <= 16


def gauss_jordan(m: Tensor) -> Tensor:
    """``linalg._eliminated_inverse``."""
    return _gauss_jordan(m.contiguous())


def spd_inverse(m: Tensor) -> Tensor:
    """``linalg.spd_inverse``."""
    return _spd_inverse(m.contiguous())


def high_power(m: Tensor, squarings: int) -> Tensor:
    """``linalg.high_power``."""
    return _high_power(m.contiguous(), squarings)
