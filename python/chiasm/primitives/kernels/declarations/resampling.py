"""Resizing, warps, pyramids, flips."""

from ..registry import ROWS, declare

declare(
    """remap(T[B, C, H, W] image, T[B, HO, WO] x, T[B, HO, WO] y, Interpolation mode, Padding padding, bool
    align_corners, T[F] fill) -> T[B, C, HO, WO]""",
    "remap.cpp",
    """The images at pixel positions x and y. With align_corners a reflection is at the corner pixels'
    centres, else at the outer edges. With padding by zeros, pixels outside have the values fill instead, one
    for each channel or one for all. float32 represents all pixel positions exactly.""",
    ["1 <= F", "H <= 2**24", "W <= 2**24", "(H + 1) * (W + 1) <= INT32_MAX"],
)
declare(
    """warp_perspective(T[B, C, H, W] image, T[B, 3, 3] matrix, int height, int width, Interpolation mode,
    Padding padding, bool align_corners, T[F] fill)
    -> T[B, C, height, width]""",
    "remap.cpp",
    "remap at the positions to which each image's matrix maps the output's pixels.",
    [
        "1 <= F",
        "0 <= height <= INT32_MAX",
        "0 <= width <= INT32_MAX",
        "H <= 2**24",
        "W <= 2**24",
        "(H + 1) * (W + 1) <= INT32_MAX",
    ],
)
declare(
    "resize(T[B, C, H, W] x, int height, int width, Interpolation mode, bool align_corners, bool antialias)"
    " -> T[B, C, height, width]",
    "resize.cpp",
    """A resize. With align_corners the centres of the corner pixels coincide, else the outer edges. With
    antialias, the filter is widened by the factor of reduction.""",
    ["1 <= height <= INT32_MAX", "1 <= width <= INT32_MAX"],
    exact=False,
)
declare(
    """resize_bytes(uint8[N, H, W] x, int height, int width, int step, bool align_corners)
    -> uint8[N, height, width * step]""",
    "resize_bytes.cpp",
    """A bilinear resize of rows of pixels with step values, by weights in 1/256, rounded half up.""",
    ["1 <= step", "W % step == 0", "1 <= height <= 2**24", "1 <= width <= 2**24", "H <= 2**24", "W <= 2**24"],
)
declare(
    """resize_cubic_bytes(uint8[N, H, L] x, int64[J, 4] rows, int64[J, 4] down, int64[I, 4] columns,
    int64[I, 4] across, int step) -> uint8[N, J, I * step]""",
    "resize_cubic_bytes.cpp",
    """Pixel i of a row is the sum of its pixels columns[i] times the weights across[i], and row j the sum of
    these rows rows[j] times down[j]. Weights are in units of 1/2^11; sums, in 32 bits, are rounded once, half
    up, and saturated. Indices out of range are clamped. Neighbours in a row are step values apart.""",
    [
        *ROWS,
        "1 <= H",
        "1 <= J",
        "1 <= I",
        "I * step <= INT32_MAX",
        "-4096 <= down <= 4096",
        "-4096 <= across <= 4096",
    ],
)
declare(
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
declare(
    """resample_bytes(uint8[N, H, L] x, int64[J, M] rows, int32[J, M] down, int64[I, K] columns,
    int32[I, K] across, int step)
    -> uint8[N, J, I * step]""",
    "resample_bytes.cpp",
    """Pixel i of a row is the sum of its pixels columns[i] times the taps across[i], and row j the sum of
    these rows rows[j] times down[j]. Taps are in units of 1/2^22; both sums are rounded half up, and
    saturated. Indices out of range are clamped. Neighbours in a row are step values apart.""",
    ["1 <= H", "1 <= L <= INT32_MAX", "1 <= step", "L % step == 0", "1 <= M", "1 <= K"],
)
declare(
    """resample_words(S[N, H, L] x, int64[J, M] rows, int64[J, M] down, int64[I, K] columns,
    int64[I, K] across, int64[1] total, int step) -> S[N, J, I * step]""",
    "resample_words.cpp",
    """Pixel i of a row is the sum of its pixels columns[i] times the weights across[i], and row j the sum of
    these rows rows[j] times down[j]; the sums are divided by total, rounded half up and saturated. They must
    be below 2^53, and are then exact. Indices out of range are clamped. Neighbours in a row are step values
    apart.""",
    [
        *ROWS,
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
declare(
    """resampled(T[B, C, H, W] x, int64[J, M] rows, T[J, M] down, int64[I, K] columns, T[I, K] across)
    -> T[B, C, J, I]""",
    "resize.cpp",
    """Pixel i of a row is the sum of its pixels columns[i] times the weights across[i], and row j the sum of
    these rows rows[j] times down[j]. Indices out of range are clamped. Pixels with a weight of 0 may be
    read, also beside those that rows and columns name: an infinite value or NaN there gives NaN.""",
    ["1 <= J <= INT32_MAX", "1 <= I <= INT32_MAX", "1 <= M", "1 <= K"],
    exact=False,
)
declare(
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
declare(
    "resize_nearest(P[N, H, W] x, int height, int width, int step) -> P[N, height, width * step]",
    "resize_bytes.cpp",
    "Pixel (y, x) is pixel (floor(y H / height), floor(x W / width)). Pixels have step values.",
    ["1 <= step", "W % step == 0", "1 <= height <= INT32_MAX", "1 <= width <= INT32_MAX"],
)
declare(
    """resize_blurred(T[B, C, H, W] x, T[K] taps, int height, int width, bool align_corners, Border border,
    bool before)
    -> T[B, C, height, width]""",
    "resize.cpp",
    "A bilinear resize, after or before a correlation with taps along both axes, as one pass. The border is"
    " not circular.",
    ["1 <= height <= INT32_MAX", "1 <= width <= INT32_MAX", "K % 2 == 1", "border != 'circular'"],
    exact=False,
)
declare(
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
        "height <= 2**24",
        "width <= 2**24",
        "height * width <= L - start",
        "1 <= side <= 2**15",
    ],
)

declare(
    "flip(P[N, H, L] x, int step, bool along, bool down) -> P[N, H, L]",
    "flips.cpp",
    """Each row's pixels reversed (along), and the order of rows reversed (down). Neighbours in a row are step
    values apart.""",
    ROWS,
)
declare(
    "transpose_pixels(P[N, H, L] x, int step) -> P[N, L // step, H * step]",
    "flips.cpp",
    "Rows and columns exchanged. A pixel has step values, which are neighbours in the row.",
    ROWS,
)
declare(
    """pyramid_down_bytes(uint8[N, H, L] x, int step, Border border)
    -> uint8[N, (H + 1) // 2, (L // step + 1) // 2 * step]""",
    "pyramids.cpp",
    """Every other pixel along both axes, from the first on, of the correlation with (1, 4, 6, 4, 1) / 16
    along both, rounded half up. Neighbours in a row are step values apart. A constant border is 0.""",
    ROWS,
)
declare(
    "pyramid_up_bytes(uint8[N, H, L] x, int step) -> uint8[N, 2 * H, 2 * L]",
    "pyramids.cpp",
    """The image with a zero after each pixel along both axes, reflected at its edges and correlated with (1,
    4, 6, 4, 1) / 8 along both, rounded half up. Neighbours in a row are step values apart.""",
    [*ROWS, "2 * H <= INT32_MAX", "2 * L <= INT32_MAX"],
)
_IMAGES_READ = [
    *ROWS,
    "1 <= F",
    "1 <= B",
    "N % B == 0",
    "H <= 2**24",
    "L // step <= 2**24",
    "H * L <= INT32_MAX",
]
declare(
    """remap_bytes(uint8[N, H, L] image, T[B, HO, WO] x, T[B, HO, WO] y, int step, Interpolation mode, Padding
    padding, bool align_corners, uint8[F] fill) -> uint8[N, HO, WO * step]""",
    "warp_bytes.cpp",
    """The images at pixel positions x and y, which N / B images share. Positions are rounded to 1/32 pixel,
    or to the nearest pixel; sums are rounded half up and saturated. Pixels have step values. With
    align_corners a reflection is at the corner pixels' centres, else at the outer edges. With padding by
    zeros, pixels outside have the values fill instead, one for each channel or one for all.""",
    [*_IMAGES_READ, "WO * step <= INT32_MAX"],
)
declare(
    """warp_bytes(uint8[N, H, L] image, float64[B, 3, 3] matrix, int height, int width, int step,
    Interpolation mode, Padding padding, bool align_corners, uint8[F] fill)
    -> uint8[N, height, width * step]""",
    "warp_bytes.cpp",
    "remap_bytes at the positions to which a matrix maps the output's pixels.",
    [*_IMAGES_READ, "0 <= height <= INT32_MAX", "0 <= width <= 2**24", "width * step <= INT32_MAX"],
)
declare(
    """remap_words(S[N, H, L] image, float64[B, HO, WO] x, float64[B, HO, WO] y, int step, Interpolation mode,
    Padding padding, bool align_corners, S[F] fill) -> S[N, HO, WO * step]""",
    "warp_words.cpp",
    """remap_bytes for 16 bits, with positions that are rounded to 1/65536 pixel, or to the nearest pixel.
    Mode is not bicubic.""",
    [*_IMAGES_READ, "WO * step <= INT32_MAX", "mode != 'bicubic'"],
)
declare(
    """warp_words(S[N, H, L] image, float64[B, 3, 3] matrix, int height, int width, int step,
    Interpolation mode, Padding padding, bool align_corners, S[F] fill) -> S[N, height, width * step]""",
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
