"""Every kernel, declared once: see schema.py for the language."""

from typing import Dict, Sequence

from .schema import Enumeration, Kernel, kernel

ENUMERATIONS = (
    Enumeration(
        "Border", ("reflect", "replicate", "circular", "constant"), "What is beyond the edge of an image."
    ),
    Enumeration(
        "Padding", ("zeros", "border", "reflection"), "What a position beyond the edge of an image reads."
    ),
    Enumeration(
        "Interpolation", ("nearest", "bilinear", "bicubic"), "How positions between pixels are read."
    ),
)

#: The most rows of the matrices that are inverted, and the most coefficients of a polynomial: they are kept
#: in registers and on the stack.
CONSTANTS = {"MOST_ROWS": 16, "MOST_TERMS": 17}

KERNELS: Dict[str, Kernel] = {}


def _declare(schema: str, source: str, doc: str, where: Sequence[str] = ()) -> None:
    declared = kernel(schema, source, doc, where, enumerations=ENUMERATIONS, constants=CONSTANTS)
    KERNELS[declared.name] = declared


#: Rows of L values in which neighbours are step apart (layout.as_rows).
_ROWS = ("1 <= L <= INT32_MAX", "1 <= step <= L", "L % step == 0")

# Filters

_declare(
    "separable(T[B, C, H, W] x, T[RY, KY] taps_y, T[RX, KX] taps_x, Border border, float scale, float centre)"
    " -> T[B, C, H, W]",
    "separable.cpp",
    """scale times the correlation with taps_y down the columns and then with taps_x along the rows, plus
    centre times x. The taps have one row for all images or one for each. A constant border is 0.""",
    ["RY in (1, B)", "RX in (1, B)", "KY % 2 == 1", "KX % 2 == 1"],
)
_declare(
    "correlate2d(T[B, C, H, W] x, T[N, KY, KX] taps, Border border) -> T[B, C, H, W]",
    "separable.cpp",
    """Correlation with a window of taps for all images or one for each. Of an even size the pixel is the one
    before the middle. A constant border is 0.""",
    ["N in (1, B)", "1 <= KY <= INT32_MAX", "1 <= KX <= INT32_MAX", "KY * KX <= INT32_MAX"],
)
_declare(
    """separable_bytes(uint8[N, H, W] x, int32[RY, KY] taps_y, int32[RX, KX] taps_x, int step, Border border)
    -> uint8[N, H, W]""",
    "separable_bytes.cpp",
    """Correlation down the columns and along the rows, in which neighbours are step values apart, rounded
    halves up. The taps are multiples of 1/256, the same from both ends, and those of a row add up to 256: the
    first is that of the middle. A constant border is 0.""",
    ["1 <= RY", "1 <= RX", "N % RY == 0", "N % RX == 0", "1 <= KY", "1 <= KX", "1 <= step", "W % step == 0"],
)
_declare(
    "box_bytes(uint8[N, H, L] x, int ky, int kx, int step, Border border) -> uint8[N, H, L]",
    "box_bytes.cpp",
    """Means of windows of ky x kx pixels, rounded halves to even, in a time that hardly depends on the
    window. An even window reaches one pixel further down and right. Neighbours in a row are step values
    apart. A constant border is 0.""",
    [*_ROWS, "1 <= ky <= 65536", "1 <= kx <= 65536", "ky * kx <= 65536"],
)
_declare(
    """correlate_bytes(uint8[N, H, L] x, float32[R, KY, KX] taps, float32[R] scale, int step, Border border)
    -> uint8[N, H, L]""",
    "correlate_bytes.cpp",
    """scale times the correlation with a window of whole numbers, one for N / R planes, rounded halves to
    even and saturated: exact where the sums are below 2^24. Of an even size the pixel is the one before the
    middle. Neighbours in a row are step values apart. A constant border is 0.""",
    [
        *_ROWS,
        "1 <= R",
        "N % R == 0",
        "1 <= KY <= INT32_MAX",
        "1 <= KX <= INT32_MAX",
        "KY * KX <= INT32_MAX",
        "KX * step <= INT32_MAX",
    ],
)
_declare(
    """bilateral(T[B, C, H, W] x, T[BG, D, H, W] guide, T[BS, KY, KX] space_weights, T[BR] range_coefficient,
    Border border, bool euclidean)
    -> T[B, C, H, W]""",
    "bilateral.cpp",
    """Means of the pixels nearby, weighted by exp(range_coefficient * distance^2) * space_weights. The
    distance between two colours of the guide is the sum of absolute differences, or Euclidean. space_weights
    are equal on opposite sides. Arguments of batch size 1 serve all images. A constant border is 0.""",
    ["BG in (1, B)", "BS in (1, B)", "BR in (1, B)", "KY % 2 == 1", "KX % 2 == 1"],
)
_declare(
    """bilateral_bytes(uint8[B, C, H, W] x, uint8[BG, D, H, W] guide, float64[BS, KY, KX] nearness,
    float64[BA, K] alike, Border border, bool squares)
    -> uint8[B, C, H, W]""",
    "bilateral.cpp",
    """Means of the pixels nearby, weighted by nearness times the entry of alike at the distance between two
    colours of the guide, which is the sum of absolute differences, or of squares; rounded halves up. Both
    factors are whole numbers of which all sums are below 2^53; the nearness is equal on opposite sides.
    Arguments of batch size 1 serve all images. A constant border is 0.""",
    [
        "BG in (1, B)",
        "BS in (1, B)",
        "BA in (1, B)",
        "KY % 2 == 1",
        "KX % 2 == 1",
        "1 <= K <= INT32_MAX",
    ],
)
_declare(
    "median_filter(P[N, H, L] x, int step, int size, Border border) -> P[N, H, L]",
    "medians.cpp",
    "The median of size x size pixels. Neighbours in a row are step values apart. A constant border is 0.",
    [*_ROWS, "size in (3, 5, 7)"],
)
_declare(
    "rank_of_bytes(uint8[N, H, L] x, int step, int ky, int kx, int rank, Border border) -> uint8[N, H, L]",
    "medians.cpp",
    """The value of a rank, 0 that of the smallest, in a centred window of ky x kx pixels, in a time that does
    not depend on the window. Neighbours in a row are step values apart. A constant border is 0.""",
    [
        *_ROWS,
        "1 <= ky <= 65535",
        "1 <= kx <= 65535",
        "ky * kx <= 65535",
        "ky % 2 == 1",
        "kx % 2 == 1",
        "0 <= rank < ky * kx",
    ],
)
_declare(
    """minmax_filter(P[N, H, L] x, int step, int ky, int kx, Border border, float value, bool largest)
    -> P[N, H, L]""",
    "morphology.cpp",
    """The largest or the smallest value in a centred window of ky x kx pixels. Neighbours in a row are step
    values apart. Beyond a constant border is value.""",
    [*_ROWS, "1 <= ky <= INT32_MAX", "1 <= kx <= INT32_MAX", "ky % 2 == 1", "kx % 2 == 1"],
)
_declare(
    """morphology(P[N, H, L] x, int step, float64[KY, KX] heights, int row, int column, Border border, float
    value, float absent, bool largest)
    -> P[N, H, L]""",
    "morphology.cpp",
    """The largest x + height (dilation, by the mirrored structuring element) or the smallest x - height
    (erosion) in a window that begins row pixels above and column pixels left of the pixel. A height of
    -absent leaves its pixel out. Of whole numbers others count as 0. Neighbours in a row are step values
    apart. Beyond a constant border is value.""",
    [*_ROWS, "0 <= row < KY", "0 <= column < KX"],
)
_declare(
    """morphology_gradient(P[N, H, L] x, int step, float64[KY, KX] dilation_heights, float64[KY, KX]
    erosion_heights, int row, int column, Border border, float dilation_value, float erosion_value, float
    absent) -> P[N, H, L]""",
    "morphology.cpp",
    "A dilation minus an erosion, each by its own heights and with its own value beyond a constant border;"
    " else as morphology. Of whole numbers the nearest that the type has.",
    [*_ROWS, "0 <= row < KY", "0 <= column < KX"],
)
_declare(
    "integral(T[..., H, W] x) -> T[..., H, W]",
    "integral.cpp",
    "Sums of all pixels above and to the left, the pixel included: rounded to T along the rows, then along"
    " the columns.",
)
_declare(
    "integral_bytes(uint8[N, H, L] x, int step) -> int32[N, H, L]",
    "integral.cpp",
    """Sums of all pixels above and to the left, the pixel included, the largest that int32 has where they are
    larger. Neighbours in a row are step values apart.""",
    _ROWS,
)
_declare(
    "sobel(T[..., H, W] x, float scale, float eps) -> T[..., H, W]",
    "canny_nms.cpp",
    "The magnitude sqrt(dx^2 + dy^2 + eps) of scale times Sobel's gradient, the border replicated.",
)
_declare(
    "canny_nms(T[..., H, W] x, float eps) -> T[..., H, W]",
    "canny_nms.cpp",
    "Non-maximum suppression of Canny's detector: the magnitude sqrt(dx^2 + dy^2 + eps) of Sobel's gradient"
    " where it is largest across the edge, else 0.",
)
_declare(
    "canny_hysteresis(T[..., H, W] x, float low, float high) -> bool[..., H, W]",
    "connected_components.cpp",
    "Which values above low are connected, by eight neighbours, through values above low to one above high.",
    ["H * W <= INT32_MAX"],
)
_declare(
    "connected_components(T[..., H, W] x) -> int64[..., H, W]",
    "connected_components.cpp",
    "1 + the least flat index among the pixels that are connected to a pixel, by eight neighbours, through"
    " values above 0; 0 for other values.",
    ["H * W <= INT32_MAX"],
)

_declare(
    "outlines(uint8[..., H, W] mask, int polygons, int numbers) -> int64[..., polygons, numbers]",
    "outlines.cpp",
    """The borders of the 8-connected sets of values that are not 0, and of the holes in them, those with the
    most pixels inside first: the number of points, whether it is around a hole, and the pixels where an
    8-connected path along the border changes its direction, -1 in places left over.""",
    ["polygons >= 1", "numbers >= 3", "H * W <= INT32_MAX"],
)

# Shapes

_declare(
    "euclidean_distances(T[..., H, W] x) -> T[..., H, W]",
    "distances.cpp",
    "The distance from each value above 0 to the nearest that is not, infinite where there is none; 0 for"
    " other values.",
    ["H <= 2**24", "W <= 2**24"],
)
_declare(
    "grown_distances(T[N, H, W] shape, T[K, K] taps, float scale, int limit) -> T[N, H, W]",
    "distances.cpp",
    """The steps in which a shape of ones, its border replicated, grows to a pixel, at most limit ones: where
    a correlation with the taps, whose middle is 1, is between 0 and 1, K // 2 times the step's number -
    scale log(correlation).""",
    ["K % 2 == 1", "K <= INT32_MAX", "(H + K) * (W + K) <= INT32_MAX", "0 <= limit <= INT32_MAX"],
)
_declare(
    "thinned(T[..., H, W] x, int limit, bool zhang) -> T[..., H, W]",
    "thinning.cpp",
    """1 where a value above 0 is left after at most limit rounds of peeling, else 0: by the table of Zhang
    and Suen, or of Guo and Hall. Values outside are not above 0.""",
    ["(H + 2) * (W + 2) <= INT32_MAX", "limit >= 0"],
)
_declare(
    """reconstructed(T[N, H, W] seed, T[N, H, W] mask, bool[KY, KX] element, float border, bool largest)
    -> T[N, H, W]""",
    "reconstruction.cpp",
    """The seed after each value has again and again become the largest one of its centred window's element,
    but not more than the mask, until nothing changes; or the smallest, but not less. Beyond the edge is
    border.""",
    ["1 <= KY <= INT32_MAX", "1 <= KX <= INT32_MAX", "(H + KY) * (W + KX) <= INT32_MAX"],
)

# Drawing

_declare(
    """draw_rectangles(P[B, C, H, W] image, int64[B, N, 4] corners, P[B, C, N] colors, int before, int after,
    bool fill)
    -> P[B, C, H, W]""",
    "drawing.cpp",
    """Rectangles with corners x1, y1, x2, y2, later ones over earlier ones: filled, or their edges, which
    reach before pixels to the top left and after to the bottom right.""",
    ["0 <= before <= INT32_MAX", "0 <= after <= INT32_MAX"],
)
_declare(
    """fill_spans(P[B, C, H, W] image, int64[B, S, H] first, int64[B, S, H] end, P[B, C] colors) -> P[B, C, H,
    W]""",
    "drawing.cpp",
    "The pixels first..end-1 of each row in a colour, of S spans a row.",
)

# Frames of bytes

_declare(
    "frame_to_grey(uint8[H, W, 3] frame) -> float32[1, 1, H, W]",
    "frames.cpp",
    "The luma of ITU-R BT.601, 0 to 255, of pixels B, G, R.",
    ["W >= 2"],
)
_declare(
    "resize_frame(uint8[H, W, 3] frame, int height, int width) -> float32[1, 3, height, width]",
    "frames.cpp",
    "The planes R, G, B, 0 to 255, of pixels B, G, R, resized bilinearly.",
    ["W >= 2", "1 <= height <= INT32_MAX", "1 <= width <= INT32_MAX"],
)

for _name, _doc in (
    ("split_pixels", "Images whose channels lie next to each other as planes."),
    ("join_pixels", "Images of planes as pixels whose channels lie next to each other."),
):
    _declare(
        f"{_name}(P[N, L] x, int channels) -> P[N, L]",
        "pixels.cpp",
        _doc,
        ["1 <= channels", "L % channels == 0"],
    )
_declare(
    "arrange_pixels(P[N, L] x, int32[O] order, int channels, float fill) -> P[N, L // channels * O]",
    "pixels.cpp",
    """Pixels of O channels, each the channel of that number of pixels whose channels lie next to each
    other, or where there is no such number the fill.""",
    ["1 <= O", "1 <= channels", "L % channels == 0"],
)
_declare(
    "subtract_pixels(P[N, L] x, P[N, L] y) -> P[N, L]",
    "arithmetic.cpp",
    "x - y, of whole numbers the nearest that their type has.",
)
_declare(
    "weighted_bytes(uint8[N, L] x, uint8[N, L] y, float32[R, 3] weights) -> uint8[N, L]",
    "arithmetic.cpp",
    """The sum of x and y by two weights, and the third, in float32, rounded halves to even and saturated;
    what is not a number is 0. Each set of weights serves N / R images.""",
    ["1 <= R", "N % R == 0"],
)
_declare(
    """scaled_bytes(uint8[N, L] x, int32[O] order, float32[O, 2] by, int channels, bool interleaved)
    -> float32[N, O, L // channels]""",
    "arithmetic.cpp",
    """Planes of numbers: the channel of that number of pixels, which is 0 where there is none, times one
    number, plus another.""",
    ["1 <= channels <= 256", "L % channels == 0"],
)
_declare(
    "range_mask(uint8[N, L] x, int32[R, C] low, int32[R, C] high, bool interleaved) -> uint8[N, L // C]",
    "arithmetic.cpp",
    "255 where each of C channels is from low to high, else 0. Each set of bounds serves N / R images.",
    ["1 <= R", "N % R == 0", "1 <= C", "L % C == 0"],
)
_declare(
    "masked_pixels(uint8[N, L] x, uint8[N, M] mask, bool interleaved) -> uint8[N, L]",
    "arithmetic.cpp",
    "The bits of each channel of a pixel that are set in the pixel's mask.",
    ["1 <= M", "L % M == 0"],
)
_declare(
    "sobel_derivatives(uint8[N, H, W] x) -> int16[N, 2, H, W]",
    "derivatives_bytes.cpp",
    "Sobel's sums along the rows and down the columns, without a scale; the border is replicated.",
    ["1 <= H", "1 <= W"],
)
_declare(
    "sobel_bytes(uint8[N, H, L] x, int step, float scale) -> uint8[N, H, L]",
    "derivatives_bytes.cpp",
    """scale times the length of the vector of Sobel's sums, rounded halves to even and saturated; the border
    is replicated. Neighbours in a row are step values apart.""",
    [*_ROWS, "0 <= scale <= 1"],
)
_declare(
    "mix_pixels(uint8[N, L] x, int32[O, 4] weights, int shift, bool interleaved) -> uint8[N, L // 3 * O]",
    "colour_bytes.cpp",
    """Linear mixtures of three channels, in planes or interleaved: the sum of a row's first three weights
    times the channels and of its fourth, over 2^shift, rounded down and saturated. Sums below 2^24 are
    exact.""",
    ["L % 3 == 0", "O in (1, 3)", "0 <= shift <= 23"],
)

_declare(
    """subsampled_pixels(uint8[N, H, W] luma, uint8[N, R, L] chroma, int32[6] weights, bool swapped, bool
    interleaved) -> uint8[N, H * W * 3]""",
    "subsampled.cpp",
    """Red, green and blue, in planes or interleaved, of luma and of the nearest pair of chroma, each less
    128: U and V, swapped V and U. The weights are in 1/2^20: of luma; of V in red; of U and of V in green; of
    U in blue; the last is the luma of black. Values are rounded halves up and saturated.""",
    ["1 <= R", "2 <= L", "L % 2 == 0"],
)
_declare(
    "packed_pixels(uint8[N, H, L] x, int32[6] weights, bool luma_first) -> uint8[N, H * (L // 2) * 3]",
    "subsampled.cpp",
    """The same, interleaved, of pairs of pixels: luma, chroma, luma, chroma, or each chroma before its
    luma.""",
    ["L % 4 == 0"],
)
_declare(
    """nv12_pixels(uint8[N, L] x, int32[10] weights, int height, bool interleaved)
    -> uint8[N, L // 3 + (height + 1) // 2 * ((L // 3 // height + 1) // 2) * 2]""",
    "subsampled.cpp",
    """Luma of red, green and blue, in planes or interleaved, and behind it the pairs U and V of the means of
    2 x 2 pixels, of which the last row or column of an odd size counts twice. The weights are in 1/2^20: of
    red, green and blue in luma, in U and in V; the last is the luma of black, and 128 is added to chroma.
    Values are rounded halves up and saturated.""",
    ["L % 3 == 0", "1 <= height <= INT32_MAX", "L // 3 % height == 0"],
)
_declare(
    "demosaiced(U[N, H, W] x, int red_row, int red_column, bool interleaved) -> U[N, H * W * 3]",
    "bayer.cpp",
    """Red, green and blue, in planes or interleaved, of pixels of one of them: red in every other row and
    column from red_row and red_column on, blue in the others', between them green. What a pixel lacks is the
    mean of the nearest two or four that have it, rounded halves up. The border is mirrored at the pixels'
    centres.""",
    ["2 <= H", "2 <= W", "0 <= red_row <= 1", "0 <= red_column <= 1"],
)
_declare(
    """luma_chroma_pixels(uint8[N, L] x, int red, int green, int blue, int first, int second, bool
    interleaved) -> uint8[N, L]""",
    "colour_bytes.cpp",
    """Luma Y, the sum of red, green and blue by their weights, and of that 128 + first (blue - Y) and 128 +
    second (red - Y), in planes or interleaved. Weights and factors are in 1/2^14, each value is rounded
    halves up and saturated.""",
    [
        "L % 3 == 0",
        "0 <= red <= 32767",
        "0 <= green <= 32767",
        "0 <= blue <= 32767",
        "red + green + blue == 16384",
        "0 <= first <= 32767",
        "0 <= second <= 32767",
    ],
)
_declare(
    "hue_pixels(uint8[N, L] x, bool lightness, bool interleaved) -> uint8[N, L]",
    "colour_bytes.cpp",
    """Hue in degrees / 2 of red, green and blue, and with it saturation and value, or lightness and
    saturation, 0 to 255, in planes or interleaved. Lightnesses are rounded halves up, all else halves to
    even.""",
    ["L % 3 == 0"],
)
_declare(
    "from_hue_pixels(uint8[N, L] x, bool lightness, bool interleaved) -> uint8[N, L]",
    "colour_bytes.cpp",
    """Red, green and blue of what hue_pixels makes, rounded halves up, in planes or interleaved. A hue of 180
    and more is a turn further.""",
    ["L % 3 == 0"],
)

_declare(
    """curve_pixels(uint8[N, L] x, int32[3, 256] first, int32[3, 4] before, int32[K] middle, int32[3, 4]
    after, int32[M] last, int shift_before, int shift_after, bool interleaved) -> uint8[N, L]""",
    "colour_bytes.cpp",
    """Three channels, in planes or interleaved, through tables: each by its own of the first, mixed, each
    by the middle table, mixed, and each by the last. A mixture is the sum of a row's first three weights
    times the channels and of its fourth, in 32 bits, over 2^shift, rounded down, and limited to the table's
    entries. The last table's are from 0 to 255.""",
    [
        "L % 3 == 0",
        "1 <= K <= INT32_MAX",
        "1 <= M <= INT32_MAX",
        "0 <= shift_before <= 31",
        "0 <= shift_after <= 31",
    ],
)

_declare(
    """luv_pixels(uint8[N, L] x, float64[256] light, float64[3, 3] matrix, float64[K] curve, bool interleaved)
    -> uint8[N, L]""",
    "luv_bytes.cpp",
    """L* 2.55, (u* + 134) 255 / 354 and (v* + 140) 255 / 262, in planes or interleaved, of red, green and
    blue: their light is mixed to X, Y and Z, whole numbers, and L* is the entry of the curve nearest to Y /
    2^22. Values are rounded halves up and saturated.""",
    ["L % 3 == 0", "1 <= K <= INT32_MAX"],
)
_declare(
    """from_luv_pixels(uint8[N, L] x, float64[256] lightness, float64[256] luminance, float64[3, 3] matrix,
    uint8[K] curve, float eps, bool interleaved) -> uint8[N, L]""",
    "luv_bytes.cpp",
    """The inverse: X and Z of u* and v*, and of L* and Y, which are the entries of lightness and luminance;
    mixed to linear light, from 0 to 1, of which the curve has K / 2^14 entries. Where |v* + 13 L* v'| of
    white is at most eps, all three are 0.""",
    ["L % 3 == 0", "1 <= K <= INT32_MAX"],
)

# Levels and histograms

_declare(
    "quantize_u8(T[...] x) -> uint8[...]",
    "histograms.cpp",
    "The nearest of 256 levels of values 0 to 1, halves up. Values outside are clamped, and NaN gives 0.",
)
_declare(
    "aminmax(T[N, L] x) -> T[2, N, 1]",
    "histograms.cpp",
    "The least values of the rows, then the greatest; NaN where a row has NaN.",
    ["L >= 1"],
)
_declare(
    "row_histograms(T[N, L] x, T[N, 1] low, T[N, 1] span, int bins) -> int32[N, bins]",
    "histograms.cpp",
    """How many of a row's values are in each bin floor((x - low) / span * bins). Values below go to the first
    bin, also NaN, and values above to the last. float32 has all numbers of bins.""",
    ["L <= INT32_MAX", "1 <= bins <= 2**24"],
)
_declare(
    "bincount(I[N, L] x, int bins) -> int32[N, bins]",
    "histograms.cpp",
    "How often each of the numbers 0 to bins - 1 is in a row; other numbers are not counted.",
    ["L <= INT32_MAX", "1 <= bins <= INT32_MAX"],
)
_declare(
    "lut(T[N, 256] table, uint8[N, L] index) -> T[N, L]",
    "histograms.cpp",
    "The entries of each row's table at the row's indices.",
)
_declare(
    "lut_bytes(uint8[R, 256] tables, uint8[N, L] x) -> uint8[N, L]",
    "lut_bytes.cpp",
    "The entries of tables at bytes: each table serves N / R rows.",
    ["1 <= R", "N % R == 0"],
)
_declare(
    "clahe_histograms(uint8[N, H, W] levels, int tile_height, int tile_width, int tiles_y, int tiles_x) ->"
    " int32[N, tiles_y * tiles_x, 256]",
    "histograms.cpp",
    "How often each level is in each tile, of planes that are mirrored at their bottom and right edges.",
    [
        "1 <= tile_height <= INT32_MAX",
        "1 <= tile_width <= INT32_MAX",
        "tile_height * tile_width <= INT32_MAX",
        "1 <= tiles_y <= INT32_MAX",
        "1 <= tiles_x <= INT32_MAX",
    ],
)
_declare(
    """clahe_interpolate(float32[N, TILES, 256] curves, int tiles_x, uint8[N, H, W] levels, int64[H] first_y,
    int64[H] second_y, float32[H] weight_y, int64[W] first_x, int64[W] second_x, float32[W] weight_x) ->
    uint8[N, H, W]""",
    "histograms.cpp",
    """Each level taken through the curves of four tiles, blended bilinearly and rounded to even. Row y takes
    tile rows first_y[y] and, with weight weight_y[y], second_y[y]; columns likewise.""",
    [
        "1 <= tiles_x <= TILES",
        *(f"0 <= {which}_y < TILES // tiles_x" for which in ("first", "second")),
        *(f"0 <= {which}_x < tiles_x" for which in ("first", "second")),
    ],
)

# Resampling

_declare(
    "remap(T[B, C, H, W] image, T[B, HO, WO] x, T[B, HO, WO] y, Interpolation mode, Padding padding, bool"
    " align_corners) -> T[B, C, HO, WO]",
    "remap.cpp",
    """The images at pixel positions x and y. With align_corners a reflection is at the corner pixels'
    centres, else at the outer edges. float32 has all positions of pixels.""",
    ["H <= 2**24", "W <= 2**24", "(H + 1) * (W + 1) <= INT32_MAX"],
)
_declare(
    """warp_perspective(T[B, C, H, W] image, T[B, 3, 3] matrix, int height, int width, Interpolation mode,
    Padding padding, bool align_corners)
    -> T[B, C, height, width]""",
    "remap.cpp",
    "remap at the positions that each image's matrix maps the output's pixels to.",
    [
        "0 <= height <= INT32_MAX",
        "0 <= width <= INT32_MAX",
        "H <= 2**24",
        "W <= 2**24",
        "(H + 1) * (W + 1) <= INT32_MAX",
    ],
)
_declare(
    "resize(T[B, C, H, W] x, int height, int width, Interpolation mode, bool align_corners, bool antialias)"
    " -> T[B, C, height, width]",
    "resize.cpp",
    """With align_corners the centres of the corner pixels coincide, else the outer edges. With antialias a
    filter that reduces is as wide as the reduction.""",
    ["1 <= height <= INT32_MAX", "1 <= width <= INT32_MAX"],
)
_declare(
    """resize_bytes(uint8[N, H, W] x, int height, int width, int step, bool align_corners)
    -> uint8[N, height, width * step]""",
    "resize_bytes.cpp",
    """A bilinear resize of rows of pixels of step values, by weights in 1/256, rounded halves up.""",
    ["1 <= step", "W % step == 0", "1 <= height <= 2**24", "1 <= width <= 2**24", "H <= 2**24", "W <= 2**24"],
)
_declare(
    """resize_cubic_bytes(uint8[N, H, L] x, int64[J, 4] rows, int64[J, 4] down, int64[I, 4] columns,
    int64[I, 4] across, int step) -> uint8[N, J, I * step]""",
    "resize_cubic_bytes.cpp",
    """Pixel i of a row is the sum of its pixels columns[i] by the weights across[i], and row j the sum of
    such rows rows[j] by down[j]. Weights are multiples of 1/2^11; sums, of 32 bits, are rounded once, halves
    up, and saturated. Numbers of what is not there are those of the nearest. Neighbours in a row are step
    values apart.""",
    [
        *_ROWS,
        "1 <= H",
        "1 <= J",
        "1 <= I",
        "I * step <= INT32_MAX",
        "-4096 <= down <= 4096",
        "-4096 <= across <= 4096",
    ],
)
_declare(
    """placed_bytes(uint8[N, H, W] x, int64[M] images, int64[M, 8] boxes, int height, int width, int step, int
    pad) -> uint8[M, height, width * step]""",
    "resize_bytes.cpp",
    """Parts of images, resized as by resize_bytes, each in an output of its own, which is pad beside it. A
    box has left, top, width and height of what is read of the image of that number, and the same of where it
    comes to. Beyond an image are the pixels at its edge.""",
    [
        "1 <= step",
        "W % step == 0",
        "1 <= height <= 2**24",
        "1 <= width <= 2**24",
        "H <= 2**24",
        "W <= 2**24",
        "0 <= images < N",
        "0 <= pad <= 255",
    ],
)
_declare(
    """resample_bytes(uint8[N, H, L] x, int64[J, M] rows, int32[J, M] down, int64[I, K] columns,
    int32[I, K] across, int step)
    -> uint8[N, J, I * step]""",
    "resample_bytes.cpp",
    """Pixel i of a row is the sum of its pixels columns[i] by the taps across[i], and row j the sum of such
    rows rows[j] by down[j]. Taps are multiples of 1/2^22; either sum is rounded, halves up, and saturated.
    Numbers of what is not there are those of the nearest. Neighbours in a row are step values apart.""",
    ["1 <= H", "1 <= L <= INT32_MAX", "1 <= step", "L % step == 0", "1 <= M", "1 <= K"],
)
_declare(
    """resampled(T[B, C, H, W] x, int64[J, M] rows, T[J, M] down, int64[I, K] columns, T[I, K] across)
    -> T[B, C, J, I]""",
    "resize.cpp",
    """Pixel i of a row is the sum of its pixels columns[i] by the weights across[i], and row j the sum of
    such rows rows[j] by down[j]. Numbers of what is not there are those of the nearest, and what has a weight
    of 0 is not read.""",
    ["1 <= J <= INT32_MAX", "1 <= I <= INT32_MAX", "1 <= M", "1 <= K"],
)
_declare(
    """area_bytes(uint8[N, H, L] x, int height, int width, int step) -> uint8[N, height, width * step]""",
    "area_bytes.cpp",
    """The mean over what each pixel of the output covers, rounded halves up. Neighbours in a row are step
    values apart.""",
    [
        "1 <= step",
        "L % step == 0",
        "1 <= height <= 2**24",
        "1 <= width <= 2**24",
        "H <= 2**24",
        "1 <= L <= 2**24",
    ],
)
_declare(
    "resize_nearest(P[N, H, W] x, int height, int width, int step) -> P[N, height, width * step]",
    "resize_bytes.cpp",
    "Pixel (y, x) is pixel (floor(y H / height), floor(x W / width)) of rows of pixels of step values.",
    ["1 <= step", "W % step == 0", "1 <= height <= INT32_MAX", "1 <= width <= INT32_MAX"],
)
_declare(
    """resize_blurred(T[B, C, H, W] x, T[K] taps, int height, int width, bool align_corners, Border border,
    bool before)
    -> T[B, C, height, width]""",
    "resize.cpp",
    "A bilinear resize, after or before a correlation with taps along both axes, as one pass. The border is"
    " not circular.",
    ["1 <= height <= INT32_MAX", "1 <= width <= INT32_MAX", "K % 2 == 1", "border != 'circular'"],
)
_declare(
    """extract_patches(T[B, C, L] pixels, int64[B, N] start, int64[B, N] height, int64[B, N] width, T[B, N, 2,
    3] frames, int side)
    -> T[B, C, N, side, side]""",
    "remap.cpp",
    """Patches of side x side pixels: pixel (i, j) is read, bilinearly and beyond the edge the last pixel,
    where its frame's matrix maps ((2 j + 1) / side - 1, (2 i + 1) / side - 1). Each row of pixels holds
    several images; the frame's begins at start and has height x width pixels.""",
    [
        "L <= INT32_MAX",
        "0 <= start <= L",
        "1 <= height <= L",
        "1 <= width <= L",
        "height * width <= L - start",
        "1 <= side <= 2**15",
    ],
)

_declare(
    "mirrored(P[N, H, L] x, int step, bool along, bool down) -> P[N, H, L]",
    "flips.cpp",
    """Each row's pixels from the last to the first (along), and the last row first (down). Neighbours in a
    row are step values apart.""",
    _ROWS,
)
_declare(
    """pyramid_down_bytes(uint8[N, H, L] x, int step, Border border)
    -> uint8[N, (H + 1) // 2, (L // step + 1) // 2 * step]""",
    "pyramids.cpp",
    """Every other pixel along both axes, from the first on, of the correlation with (1, 4, 6, 4, 1) / 16
    along both, rounded halves up. Neighbours in a row are step values apart. A constant border is 0.""",
    _ROWS,
)
_declare(
    "pyramid_up_bytes(uint8[N, H, L] x, int step) -> uint8[N, 2 * H, 2 * L]",
    "pyramids.cpp",
    """The image with a zero behind each pixel along both axes, correlated with (1, 4, 6, 4, 1) / 8 along both
    and reflected at its edges, rounded halves up. Neighbours in a row are step values apart.""",
    [*_ROWS, "2 * H <= INT32_MAX", "2 * L <= INT32_MAX"],
)
_BYTES_READ = [
    *_ROWS,
    "1 <= B",
    "N % B == 0",
    "H <= 2**24",
    "L // step <= 2**24",
    "H * L <= INT32_MAX",
]
_declare(
    """remap_bytes(uint8[N, H, L] image, T[B, HO, WO] x, T[B, HO, WO] y, int step, Interpolation mode, Padding
    padding, bool align_corners) -> uint8[N, HO, WO * step]""",
    "warp_bytes.cpp",
    """The images at pixel positions x and y, N / B of them at the same: they are rounded to 1/32 pixel, or to
    the nearest one, and the sums halves up and saturated. Pixels have step values. With align_corners a
    reflection is at the corner pixels' centres, else at the outer edges.""",
    [*_BYTES_READ, "WO * step <= INT32_MAX"],
)
_declare(
    """warp_bytes(uint8[N, H, L] image, float64[B, 3, 3] matrix, int height, int width, int step,
    Interpolation mode, Padding padding, bool align_corners) -> uint8[N, height, width * step]""",
    "warp_bytes.cpp",
    "remap_bytes at the positions that a matrix maps the output's pixels to.",
    [*_BYTES_READ, "0 <= height <= INT32_MAX", "0 <= width <= 2**24", "width * step <= INT32_MAX"],
)

# Features

_declare(
    "scale_space_nms(T[B, C, H, W] x, int64[C] margins, bool minima, int count) -> int64[B, count]",
    "scale_space_nms.cpp",
    """Flat indices of the count strongest places that exceed their 26 neighbours and 0, or with minima also
    fall below them and 0, and lie at least margins[c] pixels from the edge: by descending magnitude, of
    equals the first; -1 where there are no more.""",
    ["H * W <= INT32_MAX", "0 <= margins <= INT32_MAX", "0 <= count <= INT32_MAX"],
)
_declare(
    "orientation_histograms(T[N, S, S] patches, T[S, S] window, T[P, S] space_weights, int bins) -> T[N,"
    " bins, P, P]",
    "orientation_histograms.cpp",
    """Histograms of the directions of the patches' central differences, the border replicated: lengths times
    window, shared linearly by the two nearest of the bins, and by space_weights along the rows and along the
    columns.""",
    ["1 <= S <= INT32_MAX", "1 <= bins <= INT32_MAX"],
)
_declare(
    "cdist_squared(T[B, N, D] x1, T[B, M, D] x2) -> T[B, N, M]",
    "matching.cpp",
    "Squared Euclidean distances of vectors, as float64 differences of squared lengths and products.",
)
_declare(
    "two_smallest(T[B, N, M] x, bool along_rows) -> int64[B, N if along_rows else M, 2]",
    "matching.cpp",
    "Where the two smallest numbers of each row, or column, are, of equals the first; -1 where none is less"
    " than infinity.",
)
_declare(
    "score_models(T[B, S, 3, 3] models, T[B, 7, N] points, bool epipolar, int count) -> int64[B, count]",
    "consensus.cpp",
    """Indices of the count models with the least costs, of equals the first; 0 where fewer have a finite
    cost. A cost is the sum of the squared distances in the second image, or with epipolar of Sampson's, each
    at most its bound. points are rows x, y, 1, then u, v, 1, then the bound.""",
    ["1 <= count <= INT32_MAX"],
)

_declare(
    "kept_boxes(T[B, N, 4] boxes, int64[B, N] groups, float threshold, int most) -> bool[B, N]",
    "boxes.cpp",
    """Which boxes, left, top, right and bottom, are overlapped by none of their group that is kept before
    them by more than a threshold of the union, and are among the first `most` that are kept.""",
    ["N <= INT32_MAX"],
)

# Networks

#: For convolutions: the window's stride and first position, the dilation, and the result's size.
_WINDOWS = (
    *(f"1 <= {name} <= INT32_MAX" for name in ("stride_y", "stride_x", "dilation_y", "dilation_x")),
    *(f"0 <= {name} <= INT32_MAX" for name in ("top", "left", "height", "width")),
    "1 <= KH <= INT32_MAX",
    "1 <= KW <= INT32_MAX",
)
_declare(
    """packed_convolution(T[B, H, W, C] x, T[P, KH, KW, G, 16] weight, T[N] bias, int stride_y, int stride_x,
    int top, int left, int dilation_y, int dilation_x, int height, int width, float low, float high)
    -> T[B, height, width, N]""",
    "convolution.cpp",
    """Convolution in C / G groups of channels, zero beyond the image, limited to low and high. The weights of
    a group's outputs stand in panels of 16, of which the last is filled up with zeros.""",
    [
        "1 <= C",
        "1 <= G",
        "C % G == 0",
        "1 <= N",
        "N % (C // G) == 0",
        "P == C // G * ((N // (C // G) + 15) // 16)",
        *_WINDOWS,
    ],
)
_declare(
    """depthwise_convolution(T[B, H, W, C] x, T[KH, KW, C] weight, T[C] bias, int stride_y, int stride_x,
    int top, int left, int dilation_y, int dilation_x, int height, int width, float low, float high)
    -> T[B, height, width, C]""",
    "convolution.cpp",
    "Convolution of each channel with a window of its own, zero beyond the image, limited to low and high.",
    [*_WINDOWS],
)

# Matrices and polynomials

for _name, _doc in (
    (
        "batched_inverse",
        (
            "Inverses by Gauss-Jordan elimination with the largest pivot of each column; infinite or NaN"
            " where a matrix is singular."
        ),
    ),
    ("spd_inverse", "Inverses of symmetric positive definite matrices, by N sweeps."),
):
    _declare(
        f"{_name}(float64[..., N, N] m) -> float64[..., N, N]", "matrices.cpp", _doc, ["1 <= N <= MOST_ROWS"]
    )
_declare(
    "normalized_power(float64[..., N, N] m, int squarings) -> float64[..., N, N]",
    "matrices.cpp",
    "Each matrix divided by its trace and squared, so many times.",
    ["1 <= N <= MOST_ROWS"],
)
_declare(
    "weighted_grams(float64[B, N, D] x, float64[B, N, K] weights) -> float64[B, K, D, D]",
    "grams.cpp",
    "The sums over n of weights[n, k] x[n] x[n]^T.",
    ["1 <= D <= MOST_ROWS"],
)
_declare(
    "real_roots(float64[K, N] coefficients) -> float64[2, K - 1, N]",
    "real_roots.cpp",
    """Of N polynomials with coefficients[k] of x^k: places u in ascending order, the roots u / (1 - |u|), and
    then 1 where there is one. Where there is none, the place is that of a root of the derivative, or the end
    of the range.""",
    ["1 <= K <= MOST_TERMS"],
)
