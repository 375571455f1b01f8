"""Filters: sums, orders and extremes over windows."""

from ..registry import ROWS, declare

declare(
    "separable(T[B, C, H, W] x, T[RY, KY] taps_y, T[RX, KX] taps_x, Border border, float scale, float centre)"
    " -> T[B, C, H, W]",
    "separable.cpp",
    """scale times the correlation with taps_y down the columns and then with taps_x along the rows, plus
    centre times x. The taps have one row for all images, or one per image. A constant border is 0.""",
    ["RY in (1, B)", "RX in (1, B)", "KY % 2 == 1", "KX % 2 == 1"],
)
declare(
    "correlate2d(T[B, C, H, W] x, T[N, KY, KX] taps, Border border) -> T[B, C, H, W]",
    "separable.cpp",
    """Correlation with one window of taps for all images, or one per image. If a size is even, the window's
    centre is the pixel before the middle. A constant border is 0.""",
    ["N in (1, B)", "1 <= KY <= INT32_MAX", "1 <= KX <= INT32_MAX", "KY * KX <= INT32_MAX"],
)
declare(
    "correlate3d(T[B, C, D, H, W] x, T[N, KZ, KY, KX] taps, Border border) -> T[B, C, D, H, W]",
    "separable.cpp",
    """Correlation of volumes with one window of taps for all, or one per volume, as `correlate2d`.""",
    ["N in (1, B)", "D >= 1"]
    + [f"1 <= {size} <= INT32_MAX" for size in ("KZ", "KY", "KX", "KZ * KY", "KZ * KY * KX")],
)
declare(
    """separable_bytes(uint8[N, H, W] x, int32[RY, KY] taps_y, int32[RX, KX] taps_x, int step, Border border)
    -> uint8[N, H, W]""",
    "separable_bytes.cpp",
    """Correlation down the columns and along the rows, in which neighbours are step values apart, rounded
    half up. The taps are symmetric and in units of 1/256; a row has those from the middle outwards, and all
    taps add up to 256. A constant border is 0.""",
    ["1 <= RY", "1 <= RX", "N % RY == 0", "N % RX == 0", "1 <= KY", "1 <= KX", "1 <= step", "W % step == 0"],
)
declare(
    "box_bytes(uint8[N, H, L] x, int ky, int kx, int step, Border border) -> uint8[N, H, L]",
    "box_bytes.cpp",
    """Means of windows of ky x kx pixels, rounded half to even, in a time that hardly depends on the window.
    An even window reaches one pixel further down and right. Neighbours in a row are step values apart. A
    constant border is 0.""",
    [*ROWS, "1 <= ky <= 65536", "1 <= kx <= 65536", "ky * kx <= 65536"],
)
declare(
    "laplacian_bytes(uint8[N, H, L] x, int ky, int kx, int step, Border border) -> int16[N, H, L]",
    "box_bytes.cpp",
    """Sums of windows of ky x kx pixels minus the centre times their number, in a time that hardly depends on
    the window. Neighbours in a row are step values apart. A constant border is 0.""",
    [*ROWS, "1 <= ky <= 129", "1 <= kx <= 129", "ky % 2 == 1", "kx % 2 == 1", "ky * kx <= 129"],
)
declare(
    """correlate_bytes(uint8[N, H, L] x, float32[R, KY, KX] taps, float32[R] scale, int step, Border border)
    -> uint8[N, H, L]""",
    "correlate_bytes.cpp",
    """scale times the correlation with a window of integers, one for N / R planes, rounded half to even and
    saturated; exact if the sums are below 2^24. If a size is even, the window's centre is the pixel before
    the middle. Neighbours in a row are step values apart. A constant border is 0.""",
    [
        *ROWS,
        "1 <= R",
        "N % R == 0",
        "1 <= KY <= INT32_MAX",
        "1 <= KX <= INT32_MAX",
        "KY * KX <= INT32_MAX",
        "KX * step <= INT32_MAX",
    ],
    tried=[("taps", -7, 7)],  # then sums are below 2^24, so exact with every instruction set
)
declare(
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
declare(
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
declare(
    "median_filter(P[N, H, L] x, int step, int size, Border border) -> P[N, H, L]",
    "medians.cpp",
    "The median of size x size pixels. Neighbours in a row are step values apart. A constant border is 0.",
    [*ROWS, "size in (3, 5, 7)"],
)
declare(
    "rank_of_bytes(uint8[N, H, L] x, int step, int ky, int kx, int rank, Border border) -> uint8[N, H, L]",
    "medians.cpp",
    """The value of a rank (0 is the smallest) in a centred window of ky x kx pixels, in a time that does not
    depend on the window. Neighbours in a row are step values apart. A constant border is 0.""",
    [
        *ROWS,
        "1 <= ky <= 65535",
        "1 <= kx <= 65535",
        "ky * kx <= 65535",
        "ky % 2 == 1",
        "kx % 2 == 1",
        "0 <= rank < ky * kx",
    ],
)
declare(
    """minmax_filter(P[N, H, L] x, int step, int ky, int kx, Border border, float value, bool largest)
    -> P[N, H, L]""",
    "morphology.cpp",
    """The largest or the smallest value in a centred window of ky x kx pixels. Neighbours in a row are step
    values apart. A constant border is value.""",
    [*ROWS, "1 <= ky <= INT32_MAX", "1 <= kx <= INT32_MAX", "ky % 2 == 1", "kx % 2 == 1"],
)
declare(
    """morphology(P[N, H, L] x, int step, float64[KY, KX] heights, int row, int column, Border border, float
    value, float max_val, bool largest)
    -> P[N, H, L]""",
    "morphology.cpp",
    """The largest x + height (dilation, by the mirrored structuring element) or the smallest x - height
    (erosion) in a window that begins row pixels above and column pixels left of the pixel. A height of
    -max_val excludes its pixel. For integers, other heights count as 0. Neighbours in a row are step values
    apart. A constant border is value.""",
    [*ROWS, "0 <= row < KY", "0 <= column < KX"],
)
declare(
    """morphology_gradient(P[N, H, L] x, int step, float64[KY, KX] dilation_heights, float64[KY, KX]
    erosion_heights, int row, int column, Border border, float dilation_value, float erosion_value, float
    max_val) -> P[N, H, L]""",
    "morphology.cpp",
    "A dilation minus an erosion, each with its own heights and its own value of a constant border;"
    " otherwise like morphology. Integers saturate.",
    [*ROWS, "0 <= row < KY", "0 <= column < KX"],
)
declare(
    "integral(T[..., H, W] x) -> T[..., H, W]",
    "integral.cpp",
    "Sums of all pixels above and to the left, including the pixel: rounded to T along the rows, then along"
    " the columns.",
    exact=False,
)
declare(
    "integral_bytes(uint8[N, H, L] x, int step) -> int32[N, H, L]",
    "integral.cpp",
    """Sums of all pixels above and to the left, including the pixel; larger sums become the largest int32.
    Neighbours in a row are step values apart.""",
    ROWS,
)
declare(
    "sobel(T[..., H, W] x, float scale, float eps) -> T[..., H, W]",
    "edges.cpp",
    "The magnitude sqrt(dx^2 + dy^2 + eps) of scale times Sobel's gradient, the border replicated.",
)
declare(
    "canny_nms(T[..., H, W] x, float eps) -> T[..., H, W]",
    "edges.cpp",
    "Non-maximum suppression of Canny's detector: the magnitude sqrt(dx^2 + dy^2 + eps) of Sobel's gradient"
    " at its maxima across the edge, else 0.",
)
