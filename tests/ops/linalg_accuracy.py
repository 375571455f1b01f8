"""docs/linalg.md: the accuracy of the linear algebra in `chiasm.primitives`.

python tests/ops/linalg_accuracy.py            # or `make linalg-accuracy`
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from chiasm.primitives.linalg.eigen import svd, symmetric_eigen
from chiasm.primitives.linalg.matrices import det, inverse, solve
from chiasm.primitives.linalg.qr import null_vector, qr

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "linalg.md"
SIZES = (2, 3, 4, 6, 9)
CONDITIONS = (1.0, 1e2, 1e4, 1e6)
COUNT = 100
PRECISIONS = {"float64": torch.float64, "float32": torch.float32}


def orthogonal(n: int, count: int, generator: torch.Generator) -> Tensor:
    return torch.linalg.qr(torch.randn(count, n, n, generator=generator, dtype=torch.float64))[0]


def singular_values(n: int, condition: float, shape: str) -> Tensor:
    """Singular values from 1 to 1 / condition: evenly spaced exponents, or one large and the rest small, or
    one small and the rest large."""
    if shape == "even":
        return torch.logspace(0, -np.log10(condition), n, dtype=torch.float64)
    values = torch.full((n,), 1.0 if shape == "one small" else 1.0 / condition, dtype=torch.float64)
    values[-1 if shape == "one small" else 0] = 1.0 / condition if shape == "one small" else 1.0
    return values


SHAPES = ("even", "one large", "one small")


def general(n: int, condition: float, shape: str, seed: int = 0) -> Tensor:
    """Random matrices (COUNT, n, n) with these singular values."""
    generator = torch.Generator().manual_seed(seed)
    return (orthogonal(n, COUNT, generator) * singular_values(n, condition, shape)) @ orthogonal(
        n, COUNT, generator
    )


def symmetric(n: int, condition: float, shape: str, seed: int = 0) -> Tensor:
    """Random symmetric matrices whose eigenvalues have these magnitudes and alternating signs."""
    q = orthogonal(n, COUNT, torch.Generator().manual_seed(seed))
    m = (
        q * (singular_values(n, condition, shape) * torch.tensor([(-1.0) ** k for k in range(n)]))
    ) @ q.transpose(1, 2)
    return 0.5 * (m + m.transpose(1, 2))


def relative(actual: Tensor, expected: np.ndarray) -> float:
    """The greatest |actual - expected| / |expected| of the batch, in Frobenius norms."""
    rows = torch.from_numpy(np.asarray(expected)).reshape(COUNT, -1)
    return float(((actual.double().reshape(COUNT, -1) - rows).norm(dim=1) / rows.norm(dim=1)).max())


def _inverse(m: Tensor) -> float:
    return relative(inverse(m), np.linalg.inv(m.double().numpy()))


def _solve(m: Tensor) -> float:
    b = torch.randn(COUNT, m.shape[1], 2, generator=torch.Generator().manual_seed(1), dtype=torch.float64).to(
        m.dtype
    )
    return relative(solve(m, b), np.linalg.solve(m.double().numpy(), b.double().numpy()))


def _det(m: Tensor) -> float:
    """The error of determinants. Matrices are scaled so that the determinants are near 1, because float32 has
    no 1e-48."""
    m = (m.double() / np.abs(np.linalg.det(m.double().numpy())).mean() ** (1.0 / m.shape[1])).to(m.dtype)
    return relative(det(m), np.linalg.det(m.double().numpy()))


def _eigenvalues(m: Tensor) -> float:
    return relative(symmetric_eigen(m)[0], np.linalg.eigvalsh(m.double().numpy()))


def _eigenvectors(m: Tensor) -> float:
    values, vectors = (t.double() for t in symmetric_eigen(m))
    rebuilt = relative(vectors * values[:, None] @ vectors.transpose(1, 2), m.double().numpy())
    return max(rebuilt, unitary(vectors))


def _singular_values(m: Tensor) -> float:
    return relative(svd(m)[1], np.linalg.svd(m.double().numpy(), compute_uv=False))


def _singular_vectors(m: Tensor) -> float:
    u, s, v = (t.double() for t in svd(m))
    return max(relative(u * s[:, None] @ v.transpose(1, 2), m.double().numpy()), unitary(u), unitary(v))


def _qr(m: Tensor) -> float:
    q, r = (t.double() for t in qr(m))
    return max(relative(q @ r, m.double().numpy()), unitary(q))


def _null_vector(m: Tensor) -> float:
    rows = m[:, :-1]
    expected = np.linalg.svd(rows.double().numpy())[2][:, -1]
    actual = null_vector(rows).double()
    sign = torch.sign((actual * torch.from_numpy(expected)).sum(1, keepdim=True))
    return relative(actual * sign, expected)


def unitary(columns: Tensor) -> float:
    """The greatest entry of Q^T Q - 1."""
    return float(
        (columns.transpose(1, 2) @ columns - torch.eye(columns.shape[-1], dtype=columns.dtype)).abs().max()
    )


#: by name: the measured error, the generator of the matrices, and the description for the page
MEASURES: dict[str, tuple[Callable[[Tensor], float], Callable[..., Tensor], str]] = {
    "inverse": (_inverse, general, "of the inverse"),
    "solve": (_solve, general, "of the solutions of two right-hand sides"),
    "det": (_det, general, "of the determinant"),
    "symmetric_eigen, values": (_eigenvalues, symmetric, "of the vector of eigenvalues"),
    "symmetric_eigen, vectors": (
        _eigenvectors,
        symmetric,
        "of V diag(w) V^T, or of V^T V if that is greater",
    ),
    "svd, values": (_singular_values, general, "of the vector of singular values"),
    "svd, vectors": (
        _singular_vectors,
        general,
        "of U diag(s) V^T, or of U^T U or V^T V if that is greater",
    ),
    "qr": (_qr, general, "of Q R, or of Q^T Q if that is greater"),
    "null_vector": (_null_vector, general, "of the null vector of the first n - 1 rows"),
}


def page() -> str:
    lines = [
        "# Linear algebra",
        "",
        "Written by `make linalg-accuracy`; do not edit. The tables have the greatest errors compared with",
        "NumPy in float64 for the same matrices, relative to the norm of the expected values, over",
        f"{COUNT} random matrices for each of {len(SHAPES)} arrangements of singular values",
        f"({', '.join(SHAPES)}) and each size n. Results that are computed in float64 and rounded to",
        "float32 at the end keep float32's rounding error. At a high condition number a part of the errors",
        "in float64 is NumPy's own.",
    ]
    for precision, dtype in PRECISIONS.items():
        columns = [f"n = {n}" for n in SIZES]
        lines += [
            "",
            f"## {precision}",
            "",
            "| | condition | " + " | ".join(columns) + " |",
            "|---|---|" + "---|" * len(SIZES),
        ]
        for name, (measure, make, _) in MEASURES.items():
            for condition in CONDITIONS:
                worst = [max(measure(make(n, condition, shape).to(dtype)) for shape in SHAPES) for n in SIZES]
                lines.append(f"| {name} | {condition:.0e} | " + " | ".join(f"{e:.0e}" for e in worst) + " |")
    lines += ["", "## Definitions of the errors", ""]
    lines += [f"* {name}: the error {about}" for name, (_, _, about) in MEASURES.items()]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    torch.set_num_threads(1)
    PAGE.write_text(page())
    print(f"wrote {PAGE.relative_to(ROOT)}")
