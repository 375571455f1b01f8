"""Frames: layouts, arithmetic on pixels, and colours."""

from ..registry import ROWS, declare

declare(
    "frame_to_grey(uint8[H, W, 3] frame) -> float32[1, 1, H, W]",
    "frames.cpp",
    "The luma of ITU-R BT.601, 0 to 255, of pixels B, G, R.",
    ["W >= 2"],
)
declare(
    "resize_frame(uint8[H, W, 3] frame, int height, int width) -> float32[1, 3, height, width]",
    "frames.cpp",
    "The planes R, G, B, 0 to 255, of pixels B, G, R, resized bilinearly.",
    ["W >= 2", "1 <= height <= INT32_MAX", "1 <= width <= INT32_MAX"],
)

for _name, _doc in (
    ("split_pixels", "Interleaved images as planes."),
    ("join_pixels", "Planes as interleaved images."),
):
    declare(
        f"{_name}(A[N, L] x, int channels) -> A[N, L]",
        "pixels.cpp",
        _doc,
        ["1 <= channels", "L % channels == 0"],
    )
declare(
    "arrange_pixels(P[N, L] x, int32[O] order, int channels, float fill) -> P[N, L // channels * O]",
    "pixels.cpp",
    """Interleaved pixels with O channels: the channels of interleaved pixels with the numbers in order; an
    invalid number gives fill.""",
    ["1 <= O", "1 <= channels", "L % channels == 0"],
)
declare(
    """gather_pixels(P[..., H, L] x, int32[J] rows, int32[I] columns, int step, float fill)
    -> P[..., J, I * step]""",
    "gather_pixels.cpp",
    """Pixel (j, i) is pixel (rows[j], columns[i]), or fill if the image has no such row or column. Pixels
    have step values.""",
    ROWS,
)
declare(
    "subtract_pixels(P[N, L] x, P[N, L] y) -> P[N, L]",
    "arithmetic.cpp",
    "x - y; integers saturate.",
)
declare(
    "add_weighted(uint8[N, L] x, uint8[N, L] y, float32[R, 3] weights) -> uint8[N, L]",
    "arithmetic.cpp",
    """x and y times the first two weights, plus the third, in float32, rounded half to even and saturated;
    NaN becomes 0. Each set of weights serves N / R images.""",
    ["1 <= R", "N % R == 0"],
)
declare(
    """scaled_bytes(uint8[N, L] x, int32[O] order, float32[O, 2] by, int channels, bool interleaved)
    -> float32[N, O, L // channels]""",
    "arithmetic.cpp",
    """Planes of numbers: the channels with the numbers in order, or 0 for an invalid number, each times one
    number, plus another.""",
    ["1 <= channels <= 256", "L % channels == 0"],
)
declare(
    "in_range(V[N, L] x, int32[R, C] low, int32[R, C] high, bool interleaved) -> uint8[N, L // C]",
    "ranges.cpp",
    "255 where each of C channels is from low to high, else 0. Each set of bounds serves N / R images.",
    ["1 <= R", "N % R == 0", "1 <= C", "L % C == 0"],
)
declare(
    "masked_pixels(V[N, L] x, uint8[N, M] mask, bool interleaved) -> V[N, L]",
    "ranges.cpp",
    """The bits of each channel of a pixel that are set in the pixel's mask; for 16 bits, the mask's byte is
    widened by its sign.""",
    ["1 <= M", "L % M == 0"],
)
declare(
    "split_at(S[N, L] x, int32[R, 3] limits, bool keep_above, bool keep_below) -> S[N, L]",
    "ranges.cpp",
    """The pixels above the first of the limits become the second one, saturated, unless keep_above; the
    others become the third, unless keep_below. Each set of limits serves N / R images.""",
    ["1 <= R", "N % R == 0"],
)
declare(
    "derivatives_of_bytes(uint8[N, H, W] x, int side, int centre) -> int16[N, 2, H, W]",
    "derivatives_bytes.cpp",
    """Differences of the second neighbours along the rows and down the columns, weighted side, centre, side
    across; the border is replicated. Sobel's weights are 1 and 2, Scharr's 3 and 10, Prewitt's 1 and 1.""",
    ["1 <= H", "1 <= W", "0 <= side <= 63", "0 <= centre <= 127", "2 * side + centre <= 128"],
)
declare(
    """magnitude_of_bytes(uint8[N, H, L] x, int step, int side, int centre, int divisor)
    -> uint8[N, H, L]""",
    "derivatives_bytes.cpp",
    """The length of the vector of the sums of derivatives_of_bytes, divided, rounded half to even and
    saturated. Neighbours in a row are step values apart.""",
    [*ROWS, "0 <= side <= 16", "0 <= centre <= 32", "2 * side + centre <= 32", "1 <= divisor <= 64"],
)
declare(
    "mix_pixels(uint8[N, L] x, int32[O, 4] weights, int shift, bool interleaved) -> uint8[N, L // 3 * O]",
    "colour_bytes.cpp",
    """Linear mixtures of three channels, in planes or interleaved: the sum of a row's first three weights
    times the channels, plus its fourth, divided by 2^shift, rounded down and saturated. Sums below 2^24 are
    exact.""",
    ["L % 3 == 0", "O in (1, 3)", "0 <= shift <= 23"],
)

declare(
    """subsampled_pixels(uint8[N, H, W] luma, uint8[N, R, L] chroma, int32[6] weights, bool swapped, bool
    interleaved) -> uint8[N, H * W * 3]""",
    "subsampled.cpp",
    """Red, green and blue, in planes or interleaved, from luma and the nearest pair of chroma, each minus
    128: U and V, or V and U if swapped. The weights are in 1/2^20: of luma; of V in red; of U and of V in
    green; of U in blue; the last is the luma of black. Values are rounded half up and saturated.""",
    ["1 <= R", "2 <= L", "L % 2 == 0"],
)
declare(
    """subsampled_planes(uint8[N, H, W] luma, uint8[N, R, L] u, uint8[N, R, L] v, int32[6] weights, bool
    interleaved) -> uint8[N, H * W * 3]""",
    "subsampled.cpp",
    "Like subsampled_pixels, with U and V in planes of their own.",
    ["1 <= R", "1 <= L"],
)
declare(
    """packed_pixels(uint8[N, H, L] x, int32[6] weights, bool luma_first, bool interleaved)
    -> uint8[N, H * (L // 2) * 3]""",
    "subsampled.cpp",
    """Like subsampled_pixels, from pairs of pixels: luma, chroma, luma, chroma, or each chroma before its
    luma.""",
    ["L % 4 == 0"],
)
declare(
    """nv12_pixels(uint8[N, L] x, int32[10] weights, int height, bool interleaved)
    -> uint8[N, L // 3 + (height + 1) // 2 * ((L // 3 // height + 1) // 2) * 2]""",
    "subsampled.cpp",
    """The luma of red, green and blue, in planes or interleaved, then the pairs U and V of the means of 2 x 2
    pixels; the last row or column of an odd size counts twice. The weights are in 1/2^20: of red, green and
    blue in luma, in U and in V; the last is the luma of black, and 128 is added to chroma. Values are rounded
    half up and saturated.""",
    ["L % 3 == 0", "1 <= height <= INT32_MAX", "L // 3 % height == 0"],
)
declare(
    "demosaic(U[N, H, W] x, int red_row, int red_column, bool interleaved) -> U[N, H * W * 3]",
    "bayer.cpp",
    """Red, green and blue, in planes or interleaved, from a Bayer image: red in every other row and column
    from red_row and red_column on, blue in the other rows and columns, green in the remaining pixels. A
    missing colour is the mean of the nearest two or four pixels that have it, rounded half up. The border is
    mirrored at the pixels' centres.""",
    ["2 <= H", "2 <= W", "0 <= red_row <= 1", "0 <= red_column <= 1"],
)
declare(
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
declare(
    "hue_pixels(uint8[N, L] x, bool lightness, bool interleaved) -> uint8[N, L]",
    "colour_bytes.cpp",
    """Hue in degrees / 2 of red, green and blue, then saturation and value, or lightness and saturation, 0 to
    255, in planes or interleaved. Lightness is rounded half up, the others half to even.""",
    ["L % 3 == 0"],
)
declare(
    "from_hue_pixels(uint8[N, L] x, bool lightness, bool interleaved) -> uint8[N, L]",
    "colour_bytes.cpp",
    """The inverse of hue_pixels: red, green and blue, rounded half up, in planes or interleaved. A hue of 180
    or more wraps around.""",
    ["L % 3 == 0"],
)

declare(
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

declare(
    """luv_pixels(uint8[N, L] x, float64[256] light, float64[3, 3] matrix, float64[K] curve, bool interleaved)
    -> uint8[N, L]""",
    "luv_bytes.cpp",
    """L* 2.55, (u* + 134) 255 / 354 and (v* + 140) 255 / 262, in planes or interleaved, of red, green and
    blue: their linear light is mixed to X, Y and Z, which are integers, and L* is the curve's entry nearest
    to Y / 2^22. Values are rounded half up and saturated.""",
    ["L % 3 == 0", "1 <= K <= INT32_MAX"],
)
declare(
    """from_luv_pixels(uint8[N, L] x, float64[256] lightness, float64[256] luminance, float64[3, 3] matrix,
    uint8[K] curve, float eps, bool interleaved) -> uint8[N, L]""",
    "luv_bytes.cpp",
    """The inverse of luv_pixels: X and Z from u* and v*, and from L* and Y, which are the entries of
    lightness and luminance; mixed to linear light, from 0 to 1, of which the curve has K / 2^14 entries. If
    |v* + 13 L* v'| (v' of white) is at most eps, all three are 0.""",
    ["L % 3 == 0", "1 <= K <= INT32_MAX"],
)
