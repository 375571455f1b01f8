"""Matrices and polynomials."""

from ..registry import declare

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
    declare(
        f"{_name}(float64[..., N, N] m) -> float64[..., N, N]", "matrices.cpp", _doc, ["1 <= N <= MOST_ROWS"]
    )
declare(
    "normalized_power(float64[..., N, N] m, int squarings) -> float64[..., N, N]",
    "matrices.cpp",
    "Each matrix, divided by its trace and squared, squarings times.",
    ["1 <= N <= MOST_ROWS", "0 <= squarings <= 64"],
)
declare(
    "weighted_grams(float64[B, N, D] x, float64[B, N, K] weights) -> float64[B, K, D, D]",
    "grams.cpp",
    "The sums over n of weights[n, k] x[n] x[n]^T.",
    ["1 <= D <= MOST_ROWS"],
)
declare(
    "real_roots(float64[K, N] coefficients) -> float64[2, K - 1, N]",
    "real_roots.cpp",
    """Real roots u / (1 - |u|) of N polynomials with coefficients[k] of x^k: the positions u in ascending
    order, then 1 for each root that exists. If a root does not exist, its position is that of a root of the
    derivative, or the end of the range.""",
    ["1 <= K <= MOST_TERMS"],
)
