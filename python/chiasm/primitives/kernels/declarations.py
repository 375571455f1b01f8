"""Every kernel, declared once: see schema.py for the language."""

from typing import Dict, Sequence, Tuple

from .schema import DeclarationError, Enumeration, Kernel, kernel

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


def _declare(
    schema: str,
    source: str,
    doc: str,
    where: Sequence[str] = (),
    *,
    tried: Sequence[Tuple[str, int, int]] = (),
    exact: bool = True,
) -> None:
    declared = kernel(
        schema,
        source,
        doc,
        where,
        enumerations=ENUMERATIONS,
        constants=CONSTANTS,
        tried=tried,
        exact=exact,
    )
    if declared.name in KERNELS:
        raise DeclarationError(f"kernel {declared.name}: it is declared twice")
    KERNELS[declared.name] = declared


#: Rows of L values in which neighbours are step apart (layout.as_rows).
_ROWS = ("1 <= L <= INT32_MAX", "1 <= step <= L", "L % step == 0")

# Filters

_declare(
    "separable(T[B, C, H, W] x, T[RY, KY] taps_y, T[RX, KX] taps_x, Border border, float scale, float centre)"
    " -> T[B, C, H, W]",
    "separable.cpp",
    """scale times the correlation with taps_y down the columns and then with taps_x along the rows, plus
    centre times x. The taps have one row for all images, or one per image. A constant border is 0.""",
    ["RY in (1, B)", "RX in (1, B)", "KY % 2 == 1", "KX % 2 == 1"],
)
_declare(
    "correlate2d(T[B, C, H, W] x, T[N, KY, KX] taps, Border border) -> T[B, C, H, W]",
    "separable.cpp",
    """Correlation with one window of taps for all images, or one per image. If a size is even, the window's
    centre is the pixel before the middle. A constant border is 0.""",
    ["N in (1, B)", "1 <= KY <= INT32_MAX", "1 <= KX <= INT32_MAX", "KY * KX <= INT32_MAX"],
)
_declare(
    "correlate3d(T[B, C, D, H, W] x, T[N, KZ, KY, KX] taps, Border border) -> T[B, C, D, H, W]",
    "separable.cpp",
    """Correlation of volumes with one window of taps for all, or one per volume, as `correlate2d`.""",
    ["N in (1, B)", "D >= 1"]
    + [f"1 <= {size} <= INT32_MAX" for size in ("KZ", "KY", "KX", "KZ * KY", "KZ * KY * KX")],
)
_declare(
    """separable_bytes(uint8[N, H, W] x, int32[RY, KY] taps_y, int32[RX, KX] taps_x, int step, Border border)
    -> uint8[N, H, W]""",
    "separable_bytes.cpp",
    """Correlation down the columns and along the rows, in which neighbours are step values apart, rounded
    half up. The taps are symmetric and in units of 1/256; a row has those from the middle outwards, and all
    taps add up to 256. A constant border is 0.""",
    ["1 <= RY", "1 <= RX", "N % RY == 0", "N % RX == 0", "1 <= KY", "1 <= KX", "1 <= step", "W % step == 0"],
)
_declare(
    "box_bytes(uint8[N, H, L] x, int ky, int kx, int step, Border border) -> uint8[N, H, L]",
    "box_bytes.cpp",
    """Means of windows of ky x kx pixels, rounded half to even, in a time that hardly depends on the window.
    An even window reaches one pixel further down and right. Neighbours in a row are step values apart. A
    constant border is 0.""",
    [*_ROWS, "1 <= ky <= 65536", "1 <= kx <= 65536", "ky * kx <= 65536"],
)
_declare(
    "laplacian_bytes(uint8[N, H, L] x, int ky, int kx, int step, Border border) -> int16[N, H, L]",
    "box_bytes.cpp",
    """Sums of windows of ky x kx pixels minus the centre times their number, in a time that hardly depends on
    the window. Neighbours in a row are step values apart. A constant border is 0.""",
    [*_ROWS, "1 <= ky <= 129", "1 <= kx <= 129", "ky % 2 == 1", "kx % 2 == 1", "ky * kx <= 129"],
)
_declare(
    """correlate_bytes(uint8[N, H, L] x, float32[R, KY, KX] taps, float32[R] scale, int step, Border border)
    -> uint8[N, H, L]""",
    "correlate_bytes.cpp",
    """scale times the correlation with a window of integers, one for N / R planes, rounded half to even and
    saturated; exact if the sums are below 2^24. If a size is even, the window's centre is the pixel before
    the middle. Neighbours in a row are step values apart. A constant border is 0.""",
    [
        *_ROWS,
        "1 <= R",
        "N % R == 0",
        "1 <= KY <= INT32_MAX",
        "1 <= KX <= INT32_MAX",
        "KY * KX <= INT32_MAX",
        "KX * step <= INT32_MAX",
    ],
    tried=[("taps", -7, 7)],  # then sums are below 2^24, so exact with every instruction set
)
_declare(
    """bilateral(T[B, C, H, W] x, T[BG, D, H, W] guide, T[BS, KY, KX] space_weights, T[BR] range_coefficient,
    Border border, bool euclidean)
    -> T[B, C, H, W]""",
    "bilateral.cpp",
    """Means of the pixels in a window, weighted by exp(range_coefficient * distance^2) * space_weights. The
    distance between two colours of the guide is the sum of absolute differences, or Euclidean. space_weights
    are symmetric about the centre. Arguments of batch size 1 serve all images. A constant border is 0.""",
    ["BG in (1, B)", "BS in (1, B)", "BR in (1, B)", "KY % 2 == 1", "KX % 2 == 1"],
    exact=False,
    # Weights are positive and finite: others may add up to almost nothing.
    tried=[("space_weights", 1, 9), ("range_coefficient", -5, 0)],
)
_declare(
    """bilateral_bytes(uint8[B, C, H, W] x, uint8[BG, D, H, W] guide, float64[BS, KY, KX] space_weights,
    float64[BA, K] range_weights, Border border, bool squares)
    -> uint8[B, C, H, W]""",
    "bilateral.cpp",
    """Means of the pixels in a window, weighted by space_weights times the entry of range_weights at the
    distance between two colours of the guide, which is the sum of absolute differences, or of squares;
    rounded half up. Both factors are integers, and all sums are below 2^53; space_weights are symmetric about
    the centre. Arguments of batch size 1 serve all images. A constant border is 0.""",
    [
        "BG in (1, B)",
        "BS in (1, B)",
        "BA in (1, B)",
        "KY % 2 == 1",
        "KX % 2 == 1",
        "1 <= K <= INT32_MAX",
    ],
    tried=[("space_weights", 1, 65536), ("range_weights", 1, 65536)],  # their products and sums are exact
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
    """The value of a rank (0 is the smallest) in a centred window of ky x kx pixels, in a time that does not
    depend on the window. Neighbours in a row are step values apart. A constant border is 0.""",
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
    values apart. A constant border is value.""",
    [*_ROWS, "1 <= ky <= INT32_MAX", "1 <= kx <= INT32_MAX", "ky % 2 == 1", "kx % 2 == 1"],
)
_declare(
    """morphology(P[N, H, L] x, int step, float64[KY, KX] heights, int row, int column, Border border, float
    value, float max_val, bool largest)
    -> P[N, H, L]""",
    "morphology.cpp",
    """The largest x + height (dilation, by the mirrored structuring element) or the smallest x - height
    (erosion) in a window that begins row pixels above and column pixels left of the pixel. A height of
    -max_val excludes its pixel. For integers, other heights count as 0. Neighbours in a row are step values
    apart. A constant border is value.""",
    [*_ROWS, "0 <= row < KY", "0 <= column < KX"],
)
_declare(
    """morphology_gradient(P[N, H, L] x, int step, float64[KY, KX] dilation_heights, float64[KY, KX]
    erosion_heights, int row, int column, Border border, float dilation_value, float erosion_value, float
    max_val) -> P[N, H, L]""",
    "morphology.cpp",
    "A dilation minus an erosion, each with its own heights and its own value of a constant border;"
    " otherwise like morphology. Integers saturate.",
    [*_ROWS, "0 <= row < KY", "0 <= column < KX"],
)
_declare(
    "integral(T[..., H, W] x) -> T[..., H, W]",
    "integral.cpp",
    "Sums of all pixels above and to the left, including the pixel: rounded to T along the rows, then along"
    " the columns.",
    exact=False,
)
_declare(
    "integral_bytes(uint8[N, H, L] x, int step) -> int32[N, H, L]",
    "integral.cpp",
    """Sums of all pixels above and to the left, including the pixel; larger sums become the largest int32.
    Neighbours in a row are step values apart.""",
    _ROWS,
)
_declare(
    "sobel(T[..., H, W] x, float scale, float eps) -> T[..., H, W]",
    "edges.cpp",
    "The magnitude sqrt(dx^2 + dy^2 + eps) of scale times Sobel's gradient, the border replicated.",
)
_declare(
    "canny_nms(T[..., H, W] x, float eps) -> T[..., H, W]",
    "edges.cpp",
    "Non-maximum suppression of Canny's detector: the magnitude sqrt(dx^2 + dy^2 + eps) of Sobel's gradient"
    " at its maxima across the edge, else 0.",
)
_declare(
    "canny_hysteresis(T[..., H, W] x, float low, float high) -> bool[..., H, W]",
    "connected_components.cpp",
    "True for values above low that are 8-connected through values above low to one above high.",
    ["H * W <= INT32_MAX"],
)
_declare(
    "connected_components(T[..., H, W] x) -> int64[..., H, W]",
    "connected_components.cpp",
    "1 + the lowest flat index among the pixels that are 8-connected to a pixel through values above 0; 0"
    " for other values.",
    ["H * W <= INT32_MAX"],
)
_declare(
    "consecutive_labels(int64[N, L] x) -> int64[N, L]",
    "connected_components.cpp",
    """The result of connected_components with labels that count from 1 in the order of the components' first
    pixels. Labels that are no earlier pixel's become 0.""",
)
_declare(
    "label_statistics(int64[N, H, W] labels, int slots) -> int64[N, slots, 7]",
    "connected_components.cpp",
    """For each label from 0 on, of its pixels the left column, the top row, the width, the height, the number,
    and the sums of columns and rows; 0 if it has none. Labels from slots on are not counted.""",
    ["1 <= slots <= INT32_MAX"],
)

_declare(
    "find_contours(uint8[..., H, W] mask, int polygons, int numbers) -> int64[..., polygons, numbers]",
    "contours.cpp",
    """The borders of the 8-connected sets of nonzero values, and of their holes, those that enclose the most
    pixels first. A row has the number of points, whether the border is around a hole, and the pixels where an
    8-connected path along the border changes direction; unused entries are -1.""",
    ["polygons >= 1", "numbers >= 3", "H * W <= INT32_MAX"],
)

# Shapes

_declare(
    "distance_transform_edt(T[..., H, W] x) -> T[..., H, W]",
    "distances.cpp",
    "The distance from each value above 0 to the nearest value that is not, infinite if there is none; 0"
    " for other values.",
    ["H <= 2**24", "W <= 2**24"],
)
_declare(
    "grown_distances(T[N, H, W] shape, T[K, K] taps, float scale, int limit) -> T[N, H, W]",
    "distances.cpp",
    """The distance at which a growing shape of ones, with a replicated border, reaches each pixel, in at most
    limit steps. In a step, it reaches the pixels where a correlation with the taps, whose middle is 1, is
    between 0 and 1; their distance is K // 2 times the step's number - scale log(correlation).""",
    ["K % 2 == 1", "K <= INT32_MAX", "(H + K) * (W + K) <= INT32_MAX", "0 <= limit <= INT32_MAX"],
    exact=False,
)
_declare(
    "thin(T[..., H, W] x, int limit, bool zhang) -> T[..., H, W]",
    "thinning.cpp",
    """1 for values above 0 that are left after at most limit rounds of thinning, else 0: by the rules of
    Zhang and Suen, or of Guo and Hall. Values outside are not above 0.""",
    ["(H + 2) * (W + 2) <= INT32_MAX", "limit >= 0"],
)
_declare(
    """reconstructed(T[N, H, W] seed, T[N, H, W] mask, bool[KY, KX] element, float border, bool largest)
    -> T[N, H, W]""",
    "reconstruction.cpp",
    """The seed, dilated by the element, which includes its centre, again and again, but never above the mask,
    until nothing changes; or eroded, but never below the mask. Outside the image is border.""",
    ["1 <= KY <= INT32_MAX", "1 <= KX <= INT32_MAX", "(H + KY) * (W + KX) <= INT32_MAX"],
)

# Drawing

_declare(
    """draw_rectangles(P[B, C, H, W] image, int64[B, N, 4] corners, P[B, C, N] colors, int before, int after,
    bool fill)
    -> P[B, C, H, W]""",
    "drawing.cpp",
    """Rectangles with corners x1, y1, x2, y2, later ones over earlier ones: filled, or edges that reach from
    before pixels above and left of the corners to after pixels below and right of them.""",
    ["0 <= before <= INT32_MAX", "0 <= after <= INT32_MAX"],
)
_declare(
    """fill_spans(P[B, C, H, W] image, int64[B, S, H] first, int64[B, S, H] end, P[B, C] colors) -> P[B, C, H,
    W]""",
    "drawing.cpp",
    "Colours the pixels first..end-1 of each row, with S spans per row.",
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
    ("split_pixels", "Interleaved images as planes."),
    ("join_pixels", "Planes as interleaved images."),
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
    """Interleaved pixels with O channels: the channels of interleaved pixels with the numbers in order; an
    invalid number gives fill.""",
    ["1 <= O", "1 <= channels", "L % channels == 0"],
)
_declare(
    "subtract_pixels(P[N, L] x, P[N, L] y) -> P[N, L]",
    "arithmetic.cpp",
    "x - y; integers saturate.",
)
_declare(
    "add_weighted(uint8[N, L] x, uint8[N, L] y, float32[R, 3] weights) -> uint8[N, L]",
    "arithmetic.cpp",
    """x and y times the first two weights, plus the third, in float32, rounded half to even and saturated;
    NaN becomes 0. Each set of weights serves N / R images.""",
    ["1 <= R", "N % R == 0"],
)
_declare(
    """scaled_bytes(uint8[N, L] x, int32[O] order, float32[O, 2] by, int channels, bool interleaved)
    -> float32[N, O, L // channels]""",
    "arithmetic.cpp",
    """Planes of numbers: the channels with the numbers in order, or 0 for an invalid number, each times one
    number, plus another.""",
    ["1 <= channels <= 256", "L % channels == 0"],
)
_declare(
    "in_range(V[N, L] x, int32[R, C] low, int32[R, C] high, bool interleaved) -> uint8[N, L // C]",
    "ranges.cpp",
    "255 where each of C channels is from low to high, else 0. Each set of bounds serves N / R images.",
    ["1 <= R", "N % R == 0", "1 <= C", "L % C == 0"],
)
_declare(
    "masked_pixels(V[N, L] x, uint8[N, M] mask, bool interleaved) -> V[N, L]",
    "ranges.cpp",
    """The bits of each channel of a pixel that are set in the pixel's mask; that of 16 bits has the sign of the
    mask's byte in its upper half.""",
    ["1 <= M", "L % M == 0"],
)
_declare(
    "split_at(S[N, L] x, int32[R, 3] limits, bool keep_above, bool keep_below) -> S[N, L]",
    "ranges.cpp",
    """The pixels above the first of the limits become the second one, saturated, unless keep_above; the others
    become the third, unless keep_below. Each set of limits serves N / R images.""",
    ["1 <= R", "N % R == 0"],
)
_declare(
    "derivatives_of_bytes(uint8[N, H, W] x, int side, int centre) -> int16[N, 2, H, W]",
    "derivatives_bytes.cpp",
    """Differences of the second neighbours along the rows and down the columns, weighted side, centre, side
    across; the border is replicated. Sobel's weights are 1 and 2, Scharr's 3 and 10, Prewitt's 1 and 1.""",
    ["1 <= H", "1 <= W", "0 <= side <= 63", "0 <= centre <= 127", "2 * side + centre <= 128"],
)
_declare(
    """magnitude_of_bytes(uint8[N, H, L] x, int step, int side, int centre, int divisor) -> uint8[N, H, L]""",
    "derivatives_bytes.cpp",
    """The length of the vector of the sums of derivatives_of_bytes, divided, rounded half to even and saturated.
    Neighbours in a row are step values apart.""",
    [*_ROWS, "0 <= side <= 16", "0 <= centre <= 32", "2 * side + centre <= 32", "1 <= divisor <= 64"],
)
_declare(
    "mix_pixels(uint8[N, L] x, int32[O, 4] weights, int shift, bool interleaved) -> uint8[N, L // 3 * O]",
    "colour_bytes.cpp",
    """Linear mixtures of three channels, in planes or interleaved: the sum of a row's first three weights
    times the channels, plus its fourth, divided by 2^shift, rounded down and saturated. Sums below 2^24 are
    exact.""",
    ["L % 3 == 0", "O in (1, 3)", "0 <= shift <= 23"],
)

_declare(
    """subsampled_pixels(uint8[N, H, W] luma, uint8[N, R, L] chroma, int32[6] weights, bool swapped, bool
    interleaved) -> uint8[N, H * W * 3]""",
    "subsampled.cpp",
    """Red, green and blue, in planes or interleaved, from luma and the nearest pair of chroma, each minus
    128: U and V, or V and U if swapped. The weights are in 1/2^20: of luma; of V in red; of U and of V in
    green; of U in blue; the last is the luma of black. Values are rounded half up and saturated.""",
    ["1 <= R", "2 <= L", "L % 2 == 0"],
)
_declare(
    """packed_pixels(uint8[N, H, L] x, int32[6] weights, bool luma_first, bool interleaved)
    -> uint8[N, H * (L // 2) * 3]""",
    "subsampled.cpp",
    """Like subsampled_pixels, from pairs of pixels: luma, chroma, luma, chroma, or each chroma before its
    luma.""",
    ["L % 4 == 0"],
)
_declare(
    """nv12_pixels(uint8[N, L] x, int32[10] weights, int height, bool interleaved)
    -> uint8[N, L // 3 + (height + 1) // 2 * ((L // 3 // height + 1) // 2) * 2]""",
    "subsampled.cpp",
    """The luma of red, green and blue, in planes or interleaved, then the pairs U and V of the means of 2 x 2
    pixels; the last row or column of an odd size counts twice. The weights are in 1/2^20: of red, green and
    blue in luma, in U and in V; the last is the luma of black, and 128 is added to chroma. Values are rounded
    half up and saturated.""",
    ["L % 3 == 0", "1 <= height <= INT32_MAX", "L // 3 % height == 0"],
)
_declare(
    "demosaic(U[N, H, W] x, int red_row, int red_column, bool interleaved) -> U[N, H * W * 3]",
    "bayer.cpp",
    """Red, green and blue, in planes or interleaved, from a Bayer image: red in every other row and column
    from red_row and red_column on, blue in the other rows and columns, green in the remaining pixels. A
    missing colour is the mean of the nearest two or four pixels that have it, rounded half up. The border is
    mirrored at the pixels' centres.""",
    ["2 <= H", "2 <= W", "0 <= red_row <= 1", "0 <= red_column <= 1"],
)
_declare(
    """luma_chroma_pixels(uint8[N, L] x, int red, int green, int blue, int first, int second, bool
    interleaved) -> uint8[N, L]""",
    "colour_bytes.cpp",
    """Luma Y, the sum of red, green and blue times their weights, and chroma 128 + first (blue - Y) and 128 +
    second (red - Y), in planes or interleaved. Weights and factors are in 1/2^14. Each value is rounded half
    up and saturated.""",
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
    """Hue in degrees / 2 of red, green and blue, then saturation and value, or lightness and saturation, 0 to
    255, in planes or interleaved. Lightness is rounded half up, the others half to even.""",
    ["L % 3 == 0"],
)
_declare(
    "from_hue_pixels(uint8[N, L] x, bool lightness, bool interleaved) -> uint8[N, L]",
    "colour_bytes.cpp",
    """The inverse of hue_pixels: red, green and blue, rounded half up, in planes or interleaved. A hue of 180
    or more wraps around.""",
    ["L % 3 == 0"],
)

_declare(
    """curve_pixels(uint8[N, L] x, int32[3, 256] first, int32[3, 4] before, int32[K] middle, int32[3, 4]
    after, int32[M] last, int shift_before, int shift_after, bool interleaved) -> uint8[N, L]""",
    "colour_bytes.cpp",
    """Three channels, in planes or interleaved, through tables: each by its own first table, mixed, each by
    the middle table, mixed, and each by the last. A mixture is the sum of a row's first three weights times
    the channels, plus its fourth, in 32 bits, divided by 2^shift, rounded down, and limited to the indices of
    the next table. The last table's entries are from 0 to 255.""",
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
    blue: their linear light is mixed to X, Y and Z, which are integers, and L* is the curve's entry nearest
    to Y / 2^22. Values are rounded half up and saturated.""",
    ["L % 3 == 0", "1 <= K <= INT32_MAX"],
)
_declare(
    """from_luv_pixels(uint8[N, L] x, float64[256] lightness, float64[256] luminance, float64[3, 3] matrix,
    uint8[K] curve, float eps, bool interleaved) -> uint8[N, L]""",
    "luv_bytes.cpp",
    """The inverse of luv_pixels: X and Z from u* and v*, and from L* and Y, which are the entries of
    lightness and luminance; mixed to linear light, from 0 to 1, of which the curve has K / 2^14 entries. If
    |v* + 13 L* v'| (v' of white) is at most eps, all three are 0.""",
    ["L % 3 == 0", "1 <= K <= INT32_MAX"],
)

# Levels and histograms

_declare(
    "quantize_u8(T[...] x) -> uint8[...]",
    "histograms.cpp",
    "The nearest of 256 levels of values from 0 to 1, half up. Values outside are clamped, and NaN gives 0.",
)
_declare(
    "aminmax(T[N, L] x) -> T[2, N, 1]",
    "histograms.cpp",
    "The smallest values of the rows, then the greatest; NaN if a row has NaN.",
    ["L >= 1"],
)
_declare(
    "row_histograms(T[N, L] x, T[N, 1] low, T[N, 1] span, int bins) -> int32[N, bins]",
    "histograms.cpp",
    """The counts of a row's values in each bin floor((x - low) / span * bins). Values below and NaN go to the
    first bin, values above to the last. float32 represents all numbers of bins exactly.""",
    ["L <= INT32_MAX", "1 <= bins <= 2**24"],
)
_declare(
    "bincount(I[N, L] x, int bins) -> int32[N, bins]",
    "histograms.cpp",
    "The counts of the numbers 0 to bins - 1 in each row; other numbers are not counted.",
    ["L <= INT32_MAX", "1 <= bins <= INT32_MAX"],
)
_declare(
    "extreme_indices(P[N, L] x, int step) -> int64[N, step, 2]",
    "statistics.cpp",
    """The pixels of the first least and of the first greatest value of each channel; NaN is ignored; 0 for a
    channel of NaN. A row has L / step pixels of step channels.""",
    ["1 <= L <= INT32_MAX", "1 <= step <= L", "L % step == 0"],
)
_declare(
    "moments_bytes(uint8[N, L] x, int step) -> int64[N, step, 2]",
    "statistics.cpp",
    "The sum and the sum of squares of each channel. A row has L / step pixels of step channels.",
    ["1 <= L <= INT32_MAX", "1 <= step <= L", "L % step == 0"],
)
_declare(
    """box_maxima(T[B, C, H, W] x, int64[K] image, int64[K, PH] top, int64[K, PH] bottom, int64[K, PW] left,
    int64[K, PW] right) -> T[K, C, PH, PW]""",
    "regions.cpp",
    """The maxima of the pixels in the bins of boxes, each in one of the images: rows from top to bottom,
    columns from left to right, without the last. Numbers outside the images are limited. An empty bin is 0, a
    bin with NaN is NaN.""",
)
_declare(
    """box_means(T[B, C, Q, H, W] x, int64[K] image, int64[K, PH] top, int64[K, PH] bottom, int64[K, PW] left,
    int64[K, PW] right) -> T[K, C, PH, PW]""",
    "regions.cpp",
    """The means of the pixels in the bins of boxes, as in box_maxima; bin q of a box has plane q of each
    channel. Sums are in float64.""",
    ["Q == PH * PW"],
)
_declare(
    """bilinear_means(T[B, C, Q, H, W] x, int64[K] image, T[K, PH, N] rows, T[K, PW, M] columns, int shared)
    -> T[K, C, PH, PW]""",
    "regions.cpp",
    """The means of points in the bins of boxes, read by bilinear interpolation; each plane of a channel
    serves shared bins in turn. Numbers of images outside the batch are limited. A point up to one pixel
    outside the centres of the border pixels reads the nearest pixel; a point further outside counts as 0.""",
    ["1 <= N", "1 <= M", "1 <= shared", "Q * shared == PH * PW"],
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
    "lut_pixels(uint8[3, 256] tables, uint8[N] x) -> uint8[N, 3]",
    "lut_bytes.cpp",
    "Bytes as pixels of three channels: the entries of each channel's table.",
)
_declare(
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
_declare(
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

# Resampling

_declare(
    "remap(T[B, C, H, W] image, T[B, HO, WO] x, T[B, HO, WO] y, Interpolation mode, Padding padding, bool"
    " align_corners) -> T[B, C, HO, WO]",
    "remap.cpp",
    """The images at pixel positions x and y. With align_corners a reflection is at the corner pixels'
    centres, else at the outer edges. float32 represents all pixel positions exactly.""",
    ["H <= 2**24", "W <= 2**24", "(H + 1) * (W + 1) <= INT32_MAX"],
)
_declare(
    """warp_perspective(T[B, C, H, W] image, T[B, 3, 3] matrix, int height, int width, Interpolation mode,
    Padding padding, bool align_corners)
    -> T[B, C, height, width]""",
    "remap.cpp",
    "remap at the positions to which each image's matrix maps the output's pixels.",
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
    """A resize. With align_corners the centres of the corner pixels coincide, else the outer edges. With
    antialias, the filter is widened by the factor of reduction.""",
    ["1 <= height <= INT32_MAX", "1 <= width <= INT32_MAX"],
    exact=False,
)
_declare(
    """resize_bytes(uint8[N, H, W] x, int height, int width, int step, bool align_corners)
    -> uint8[N, height, width * step]""",
    "resize_bytes.cpp",
    """A bilinear resize of rows of pixels with step values, by weights in 1/256, rounded half up.""",
    ["1 <= step", "W % step == 0", "1 <= height <= 2**24", "1 <= width <= 2**24", "H <= 2**24", "W <= 2**24"],
)
_declare(
    """resize_cubic_bytes(uint8[N, H, L] x, int64[J, 4] rows, int64[J, 4] down, int64[I, 4] columns,
    int64[I, 4] across, int step) -> uint8[N, J, I * step]""",
    "resize_cubic_bytes.cpp",
    """Pixel i of a row is the sum of its pixels columns[i] times the weights across[i], and row j the sum of
    these rows rows[j] times down[j]. Weights are in units of 1/2^11; sums, in 32 bits, are rounded once, half
    up, and saturated. Indices out of range are clamped. Neighbours in a row are step values apart.""",
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
    """Parts of images, resized like resize_bytes, each in a separate output, which is pad around the part. A
    box has left, top, width and height of the part of the image with the number in images, then of its place
    in the output. Outside an image, the pixels at its edge are read.""",
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
    """Pixel i of a row is the sum of its pixels columns[i] times the taps across[i], and row j the sum of
    these rows rows[j] times down[j]. Taps are in units of 1/2^22; both sums are rounded half up, and
    saturated. Indices out of range are clamped. Neighbours in a row are step values apart.""",
    ["1 <= H", "1 <= L <= INT32_MAX", "1 <= step", "L % step == 0", "1 <= M", "1 <= K"],
)
_declare(
    """resample_words(S[N, H, L] x, int64[J, M] rows, int64[J, M] down, int64[I, K] columns,
    int64[I, K] across, int64[1] total, int step) -> S[N, J, I * step]""",
    "resample_words.cpp",
    """Pixel i of a row is the sum of its pixels columns[i] times the weights across[i], and row j the sum of
    these rows rows[j] times down[j]; the sums are divided by total, rounded half up and saturated. They must
    be below 2^53, and are then exact. Indices out of range are clamped. Neighbours in a row are step values
    apart.""",
    [
        *_ROWS,
        "1 <= H <= INT32_MAX",
        "1 <= J",
        "1 <= I",
        "1 <= M",
        "1 <= K",
        "I * step <= INT32_MAX",
        "-2**24 <= down <= 2**24",
        "-2**24 <= across <= 2**24",
        "1 <= total <= 2**52",
    ],
)
_declare(
    """resampled(T[B, C, H, W] x, int64[J, M] rows, T[J, M] down, int64[I, K] columns, T[I, K] across)
    -> T[B, C, J, I]""",
    "resize.cpp",
    """Pixel i of a row is the sum of its pixels columns[i] times the weights across[i], and row j the sum of
    these rows rows[j] times down[j]. Indices out of range are clamped, and pixels with a weight of 0 are not
    read.""",
    ["1 <= J <= INT32_MAX", "1 <= I <= INT32_MAX", "1 <= M", "1 <= K"],
    exact=False,
)
_declare(
    """area_bytes(uint8[N, H, L] x, int height, int width, int step) -> uint8[N, height, width * step]""",
    "area_bytes.cpp",
    """The mean over the area that each pixel of the output covers, rounded half up. Neighbours in a row are
    step values apart.""",
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
    "Pixel (y, x) is pixel (floor(y H / height), floor(x W / width)). Pixels have step values.",
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
    exact=False,
)
_declare(
    """extract_patches(T[B, C, L] pixels, int64[B, N] start, int64[B, N] height, int64[B, N] width, T[B, N, 2,
    3] frames, int side)
    -> T[B, C, N, side, side]""",
    "remap.cpp",
    """Patches of side x side pixels: pixel (i, j) is read bilinearly at the position to which its frame's
    matrix maps ((2 j + 1) / side - 1, (2 i + 1) / side - 1); outside the image, the pixels at its edge are
    read. Each row of pixels contains several images; the frame's image begins at start and has height x width
    pixels.""",
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
    "flip(P[N, H, L] x, int step, bool along, bool down) -> P[N, H, L]",
    "flips.cpp",
    """Each row's pixels reversed (along), and the order of rows reversed (down). Neighbours in a row are step
    values apart.""",
    _ROWS,
)
_declare(
    "transpose_pixels(P[N, H, L] x, int step) -> P[N, L // step, H * step]",
    "flips.cpp",
    "Rows and columns exchanged. A pixel has step values, which are neighbours in the row.",
    _ROWS,
)
_declare(
    """pyramid_down_bytes(uint8[N, H, L] x, int step, Border border)
    -> uint8[N, (H + 1) // 2, (L // step + 1) // 2 * step]""",
    "pyramids.cpp",
    """Every other pixel along both axes, from the first on, of the correlation with (1, 4, 6, 4, 1) / 16
    along both, rounded half up. Neighbours in a row are step values apart. A constant border is 0.""",
    _ROWS,
)
_declare(
    "pyramid_up_bytes(uint8[N, H, L] x, int step) -> uint8[N, 2 * H, 2 * L]",
    "pyramids.cpp",
    """The image with a zero after each pixel along both axes, reflected at its edges and correlated with (1,
    4, 6, 4, 1) / 8 along both, rounded half up. Neighbours in a row are step values apart.""",
    [*_ROWS, "2 * H <= INT32_MAX", "2 * L <= INT32_MAX"],
)
_IMAGES_READ = [
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
    """The images at pixel positions x and y, which N / B images share. Positions are rounded to 1/32 pixel,
    or to the nearest pixel; sums are rounded half up and saturated. Pixels have step values. With
    align_corners a reflection is at the corner pixels' centres, else at the outer edges.""",
    [*_IMAGES_READ, "WO * step <= INT32_MAX"],
)
_declare(
    """warp_bytes(uint8[N, H, L] image, float64[B, 3, 3] matrix, int height, int width, int step,
    Interpolation mode, Padding padding, bool align_corners) -> uint8[N, height, width * step]""",
    "warp_bytes.cpp",
    "remap_bytes at the positions to which a matrix maps the output's pixels.",
    [*_IMAGES_READ, "0 <= height <= INT32_MAX", "0 <= width <= 2**24", "width * step <= INT32_MAX"],
)
_declare(
    """remap_words(S[N, H, L] image, float64[B, HO, WO] x, float64[B, HO, WO] y, int step, Interpolation mode,
    Padding padding, bool align_corners) -> S[N, HO, WO * step]""",
    "warp_words.cpp",
    """remap_bytes for 16 bits, with positions that are rounded to 1/65536 pixel, or to the nearest pixel. Mode
    is not bicubic.""",
    [*_IMAGES_READ, "WO * step <= INT32_MAX", "mode != 'bicubic'"],
)
_declare(
    """warp_words(S[N, H, L] image, float64[B, 3, 3] matrix, int height, int width, int step,
    Interpolation mode, Padding padding, bool align_corners) -> S[N, height, width * step]""",
    "warp_words.cpp",
    "remap_words at the positions to which a matrix maps the output's pixels.",
    [
        *_IMAGES_READ,
        "0 <= height <= INT32_MAX",
        "0 <= width <= 2**24",
        "width * step <= INT32_MAX",
        "mode != 'bicubic'",
    ],
)

# Features

_declare(
    "scale_space_nms(T[B, C, H, W] x, int64[C] margins, bool minima, int count) -> int64[B, count]",
    "scale_space_nms.cpp",
    """Flat indices of the count strongest values that exceed their 26 neighbours and 0 or, with minima, are
    below them and 0, at least margins[c] pixels from the edge: by descending magnitude, equals in their
    order; unused entries are -1.""",
    ["H * W <= INT32_MAX", "0 <= margins <= INT32_MAX", "0 <= count <= INT32_MAX"],
)
_declare(
    "orientation_histograms(T[N, S, S] patches, T[S, S] window, T[P, S] space_weights, int bins) -> T[N,"
    " bins, P, P]",
    "orientation_histograms.cpp",
    """Histograms of the directions of the patches' central differences, with a replicated border: lengths
    times window, divided linearly between the two nearest bins, and weighted by space_weights along the rows
    and along the columns.""",
    ["1 <= S <= INT32_MAX", "1 <= bins <= INT32_MAX"],
    exact=False,
)
_declare(
    "cdist_squared(T[B, N, D] x1, T[B, M, D] x2) -> T[B, N, M]",
    "matching.cpp",
    "Squared Euclidean distances of vectors, as float64 differences of squared lengths and products.",
    exact=False,
)
_declare(
    "two_smallest(T[B, N, M] x, bool along_rows) -> int64[B, N if along_rows else M, 2]",
    "matching.cpp",
    "The positions of the two smallest numbers of each row, or column, the first of equals; -1 if none is"
    " less than infinity.",
    exact=False,
)
_declare(
    "score_models(T[B, S, 3, 3] models, T[B, 7, N] points, bool epipolar, int count) -> int64[B, count]",
    "consensus.cpp",
    """Indices of the count models with the lowest costs, equals in their order; 0 if fewer have a finite
    cost. A cost is the sum of the squared distances in the second image or, with epipolar, of Sampson's
    distances, each limited to its bound. points has the rows x, y, 1, u, v, 1 and the bound.""",
    ["1 <= count <= INT32_MAX"],
)

_declare(
    "nms(T[B, N, 4] boxes, int64[B, N] groups, float threshold, int most) -> bool[B, N]",
    "boxes.cpp",
    """The boxes (left, top, right, bottom) that non-maximum suppression keeps, at most `most`. A box is
    dropped if an earlier box of its group is kept and their intersection is more than threshold of their
    union.""",
    ["N <= INT32_MAX"],
)

_declare(
    "linear_sum_assignment(float64[B, N, M] costs, float64[B, 1] alone) -> int64[B, N]",
    "assignment.cpp",
    """The column of each row in an assignment with the least sum of costs, infinity for a forbidden pair, or
    -1: a row may stay without a column at the cost `alone`, which exceeds all finite costs. Not NaN.""",
    ["M >= 1", "N <= INT32_MAX"],
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
    """Convolution in C / G groups of channels, with zeros outside the image, limited to low and high. The
    weights of a group's outputs are in panels of 16; the last one is padded with zeros.""",
    [
        "1 <= C",
        "1 <= G",
        "C % G == 0",
        "1 <= N",
        "N % (C // G) == 0",
        "P == C // G * ((N // (C // G) + 15) // 16)",
        *_WINDOWS,
    ],
    exact=False,
)
_declare(
    """depthwise_convolution(T[B, H, W, C] x, T[KH, KW, C] weight, T[C] bias, int stride_y, int stride_x,
    int top, int left, int dilation_y, int dilation_x, int height, int width, float low, float high)
    -> T[B, height, width, C]""",
    "convolution.cpp",
    "Convolution of each channel with its own window, with zeros outside the image, limited to low and high.",
    [*_WINDOWS],
    exact=False,
)
_declare(
    """lstm(T[L, B, G] gates, T[P, H, 16] weight, T[B, H] hidden, T[B, H] cell, bool reverse)
    -> T[2, L, B, H]""",
    "recurrent.cpp",
    """The steps of an LSTM layer, in reverse order if asked: hidden states and cells. `gates` has what the
    inputs and biases add to the input, forget, cell and output gates; the weights of the hidden state are in
    panels of 16 outputs, the last one padded with zeros.""",
    ["1 <= H", "G == 4 * H", "P == (G + 15) // 16"],
    tried=[("weight", -1, 1)],  # large ones multiply a rounding error at each step
    exact=False,
)
_declare(
    """gru(T[L, B, G] gates, T[P, H, 16] weight, T[G] bias, T[B, H] hidden, bool reverse) -> T[L, B, H]""",
    "recurrent.cpp",
    """The steps of a GRU layer, in reverse order if asked: hidden states. `gates` has what the inputs add to
    the reset, update and new gates, with the inputs' biases; weight and bias are of the hidden state, in
    panels as for `lstm`.""",
    ["1 <= H", "G == 3 * H", "P == (G + 15) // 16"],
    tried=[("weight", -1, 1)],  # large ones multiply a rounding error at each step
    exact=False,
)

# Matrices and polynomials

for _name, _doc in (
    (
        "batched_inverse",
        (
            "Inverses by Gauss-Jordan elimination with the largest pivot of each column; infinite or NaN"
            " if a matrix is singular."
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
    "Each matrix, divided by its trace and squared, squarings times.",
    ["1 <= N <= MOST_ROWS", "0 <= squarings <= 64"],
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
    """Real roots u / (1 - |u|) of N polynomials with coefficients[k] of x^k: the positions u in ascending
    order, then 1 for each root that exists. If a root does not exist, its position is that of a root of the
    derivative, or the end of the range.""",
    ["1 <= K <= MOST_TERMS"],
)
