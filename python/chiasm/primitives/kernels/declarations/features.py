"""Features and their matching."""

from ..registry import declare

declare(
    "scale_space_nms(T[B, C, H, W] x, int64[C] margins, bool minima, int count) -> int64[B, count]",
    "scale_space_nms.cpp",
    """Flat indices of the count strongest values that exceed their 26 neighbours and 0 or, with minima, are
    below them and 0, at least margins[c] pixels from the edge: by descending magnitude, equals in their
    order; unused entries are -1.""",
    ["H * W <= INT32_MAX", "0 <= margins <= INT32_MAX", "0 <= count <= INT32_MAX"],
)
declare(
    "orientation_histograms(T[N, S, S] patches, T[S, S] window, T[P, S] space_weights, int bins) -> T[N,"
    " bins, P, P]",
    "orientation_histograms.cpp",
    """Histograms of the directions of the patches' central differences, with a replicated border: lengths
    times window, divided linearly between the two nearest bins, and weighted by space_weights along the rows
    and along the columns.""",
    ["1 <= S <= INT32_MAX", "1 <= bins <= INT32_MAX"],
    exact=False,
)
declare(
    "cdist_squared(T[B, N, D] x1, T[B, M, D] x2) -> T[B, N, M]",
    "matching.cpp",
    "Squared Euclidean distances of vectors, as float64 differences of squared lengths and products.",
    exact=False,
)
declare(
    "two_smallest(T[B, N, M] x, bool along_rows) -> int64[B, N if along_rows else M, 2]",
    "matching.cpp",
    "The positions of the two smallest numbers of each row, or column, the first of equals; -1 if none is"
    " less than infinity.",
    exact=False,
)
declare(
    "score_models(T[B, S, 3, 3] models, T[B, 7, N] points, bool epipolar, int count) -> int64[B, count]",
    "consensus.cpp",
    """Indices of the count models with the lowest costs, equals in their order; 0 if fewer have a finite
    cost. A cost is the sum of the squared distances in the second image or, with epipolar, of Sampson's
    distances, each limited to its bound. points has the rows x, y, 1, u, v, 1 and the bound, which
    is not negative.""",
    ["1 <= count <= INT32_MAX"],
)

declare(
    "nms(T[B, N, 4] boxes, int64[B, N] groups, float threshold, int most) -> bool[B, N]",
    "boxes.cpp",
    """The boxes (left, top, right, bottom) that non-maximum suppression keeps, at most `most`. A box is
    dropped if an earlier box of its group is kept and their intersection is more than threshold of their
    union.""",
    ["N <= INT32_MAX"],
)

declare(
    "linear_sum_assignment(float64[B, N, M] costs, float64[B, 1] alone) -> int64[B, N]",
    "assignment.cpp",
    """The column of each row in an assignment with the least sum of costs, infinity for a forbidden pair, or
    -1: a row may stay without a column at the cost `alone`, which exceeds all finite costs. Not NaN.""",
    ["M >= 1", "N <= INT32_MAX"],
)
