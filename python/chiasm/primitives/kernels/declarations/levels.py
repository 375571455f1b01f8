"""Levels: tables, histograms, statistics."""

from ..registry import declare

declare(
    "quantize_u8(T[...] x) -> uint8[...]",
    "histograms.cpp",
    "The nearest of 256 levels of values from 0 to 1, half up. Values outside are clamped, and NaN gives 0.",
)
declare(
    "aminmax(T[N, L] x) -> T[2, N, 1]",
    "histograms.cpp",
    "The smallest values of the rows, then the greatest; NaN if a row has NaN.",
    ["L >= 1"],
)
declare(
    "row_histograms(T[N, L] x, T[N, 1] low, T[N, 1] span, int bins) -> int32[N, bins]",
    "histograms.cpp",
    """The counts of a row's values in each bin floor((x - low) / span * bins). Values below and NaN go to the
    first bin, values above to the last. float32 represents all numbers of bins exactly.""",
    ["L <= INT32_MAX", "1 <= bins <= 2**24"],
)
declare(
    "bincount(I[N, L] x, int bins) -> int32[N, bins]",
    "histograms.cpp",
    "The counts of the numbers 0 to bins - 1 in each row; other numbers are not counted.",
    ["L <= INT32_MAX", "1 <= bins <= INT32_MAX"],
)
declare(
    "extreme_indices(P[N, L] x, int step) -> int64[N, step, 2]",
    "statistics.cpp",
    """The pixels of the first least and of the first greatest value of each channel; NaN is ignored; 0 for a
    channel of NaN. A row has L / step pixels of step channels.""",
    ["1 <= L <= INT32_MAX", "1 <= step <= L", "L % step == 0"],
)
declare(
    "moments_bytes(uint8[N, L] x, int step) -> int64[N, step, 2]",
    "statistics.cpp",
    "The sum and the sum of squares of each channel. A row has L / step pixels of step channels.",
    ["1 <= L <= INT32_MAX", "1 <= step <= L", "L % step == 0"],
)
declare(
    """box_maxima(T[B, C, H, W] x, int64[K] image, int64[K, PH] top, int64[K, PH] bottom, int64[K, PW] left,
    int64[K, PW] right) -> T[K, C, PH, PW]""",
    "regions.cpp",
    """The maxima of the pixels in the bins of boxes, each in one of the images: rows from top to bottom,
    columns from left to right, without the last. Numbers outside the images are limited. An empty bin is 0, a
    bin with NaN is NaN.""",
)
declare(
    """box_means(T[B, C, Q, H, W] x, int64[K] image, int64[K, PH] top, int64[K, PH] bottom, int64[K, PW] left,
    int64[K, PW] right) -> T[K, C, PH, PW]""",
    "regions.cpp",
    """The means of the pixels in the bins of boxes, as in box_maxima; bin q of a box has plane q of each
    channel. Sums are in float64.""",
    ["Q == PH * PW"],
)
declare(
    """bilinear_means(T[B, C, Q, H, W] x, int64[K] image, T[K, PH, N] rows, T[K, PW, M] columns, int shared)
    -> T[K, C, PH, PW]""",
    "regions.cpp",
    """The means of points in the bins of boxes, read by bilinear interpolation; each plane of a channel
    serves shared bins in turn. Numbers of images outside the batch are limited. A point up to one pixel
    outside the centres of the border pixels reads the nearest pixel; a point further outside counts as 0.""",
    ["1 <= N", "1 <= M", "1 <= shared", "Q * shared == PH * PW"],
)
declare(
    "lut(T[N, 256] table, uint8[N, L] index) -> T[N, L]",
    "histograms.cpp",
    "The entries of each row's table at the row's indices.",
)
declare(
    "lut_bytes(uint8[R, 256] tables, uint8[N, L] x) -> uint8[N, L]",
    "lut_bytes.cpp",
    "The entries of tables at bytes: each table serves N / R rows.",
    ["1 <= R", "N % R == 0"],
)
declare(
    "lut_pixels(uint8[3, 256] tables, uint8[N] x) -> uint8[N, 3]",
    "lut_bytes.cpp",
    "Bytes as pixels of three channels: the entries of each channel's table.",
)
declare(
    "clahe_histograms(uint8[N, H, W] levels, int tile_height, int tile_width, int tiles_y, int tiles_x) ->"
    " int32[N, tiles_y * tiles_x, 256]",
    "histograms.cpp",
    """The counts of each level in each tile of planes that are mirrored at their bottom and right edges, once
    at most.""",
    [
        "1 <= tile_height <= INT32_MAX",
        "1 <= tile_width <= INT32_MAX",
        "tile_height * tile_width <= INT32_MAX",
        "1 <= tiles_y <= INT32_MAX",
        "1 <= tiles_x <= INT32_MAX",
        "tile_height * tiles_y < 2 * H",
        "tile_width * tiles_x < 2 * W",
    ],
)
declare(
    """clahe_interpolate(float32[N, TILES, 256] curves, int tiles_x, uint8[N, H, W] levels, int64[H] first_y,
    int64[H] second_y, float32[H] weight_y, int64[W] first_x, int64[W] second_x, float32[W] weight_x) ->
    uint8[N, H, W]""",
    "histograms.cpp",
    """Each level, mapped by the curves of four tiles, blended bilinearly and rounded half to even. Row y uses
    the tile rows first_y[y] and, with weight weight_y[y], second_y[y]; columns likewise.""",
    [
        "1 <= tiles_x <= TILES",
        *(f"0 <= {which}_y < TILES // tiles_x" for which in ("first", "second")),
        *(f"0 <= {which}_x < tiles_x" for which in ("first", "second")),
    ],
)
