"""Binary images and their shapes; drawing."""

from ..registry import declare

declare(
    "canny_hysteresis(T[..., H, W] x, float low, float high) -> bool[..., H, W]",
    "connected_components.cpp",
    "True for values above low that are 8-connected through values above low to one above high.",
    ["H * W <= INT32_MAX"],
)
declare(
    "connected_components(P[..., H, W] x, bool consecutive) -> int64[..., H, W]",
    "connected_components.cpp",
    """1 + the lowest flat index among the pixels that are 8-connected to a pixel through values above 0; 0
    for other values. If consecutive, labels count from 1 instead, in the order of the components' first
    pixels.""",
    ["H * W <= INT32_MAX"],
)
declare(
    "label_statistics(int64[N, H, W] labels, int slots) -> int64[N, slots, 7]",
    "connected_components.cpp",
    """For each label from 0 on, of its pixels the left column, the top row, the width, the height, the
    number, and the sums of columns and rows; 0 if it has none. Labels from slots on are not counted.""",
    ["1 <= slots <= INT32_MAX"],
)

declare(
    "find_contours(uint8[..., H, W] mask, int polygons, int numbers) -> int64[..., polygons, numbers]",
    "contours.cpp",
    """The borders of the 8-connected sets of nonzero values, and of their holes, those that enclose the most
    pixels first. A row has the number of points, whether the border is around a hole, and the pixels where an
    8-connected path along the border changes direction; unused entries are -1.""",
    ["polygons >= 1", "numbers >= 3", "H * W <= INT32_MAX"],
)
declare(
    "distance_transform_edt(T[..., H, W] x) -> T[..., H, W]",
    "distances.cpp",
    "The distance from each value above 0 to the nearest value that is not, infinite if there is none; 0"
    " for other values.",
    ["H <= 2**24", "W <= 2**24"],
)
declare(
    "grown_distances(T[N, H, W] shape, T[K, K] taps, float scale, int limit) -> T[N, H, W]",
    "distances.cpp",
    """The distance at which a growing shape of ones, with a replicated border, reaches each pixel, in at most
    limit steps. In a step, it reaches the pixels where a correlation with the taps, whose middle is 1, is
    between 0 and 1; their distance is K // 2 times the step's number - scale log(correlation).""",
    ["K % 2 == 1", "K <= INT32_MAX", "(H + K) * (W + K) <= INT32_MAX", "0 <= limit <= INT32_MAX"],
    exact=False,
)
declare(
    "thin(T[..., H, W] x, int limit, bool zhang) -> T[..., H, W]",
    "thinning.cpp",
    """1 for values above 0 that are left after at most limit rounds of thinning, else 0: by the rules of
    Zhang and Suen, or of Guo and Hall. Values outside are not above 0.""",
    ["(H + 2) * (W + 2) <= INT32_MAX", "limit >= 0"],
)
declare(
    """reconstructed(T[N, H, W] seed, T[N, H, W] mask, bool[KY, KX] element, float border, bool largest)
    -> T[N, H, W]""",
    "reconstruction.cpp",
    """The seed, dilated by the element, which includes its centre, again and again, but never above the mask,
    until nothing changes; or eroded, but never below the mask. Outside the image is border.""",
    ["1 <= KY <= INT32_MAX", "1 <= KX <= INT32_MAX", "(H + KY) * (W + KX) <= INT32_MAX"],
)

declare(
    """draw_rectangles(P[B, C, H, W] image, int64[B, N, 4] corners, P[B, C, N] colors, int before, int after,
    bool fill)
    -> P[B, C, H, W]""",
    "drawing.cpp",
    """Rectangles with corners x1, y1, x2, y2, later ones over earlier ones: filled, or edges that reach from
    before pixels above and left of the corners to after pixels below and right of them.""",
    ["0 <= before <= INT32_MAX", "0 <= after <= INT32_MAX"],
)
declare(
    """fill_spans(P[B, C, H, W] image, int64[B, S, H] first, int64[B, S, H] end, P[B, C] colors) -> P[B, C, H,
    W]""",
    "drawing.cpp",
    "Colours the pixels first..end-1 of each row, with S spans per row.",
)
