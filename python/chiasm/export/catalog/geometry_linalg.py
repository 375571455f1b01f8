"""Geometry: points, rigid transformations and solvers of small equations."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import torch
from torch import Generator, Tensor

from ..peer import Call, Peer, opencv
from ..spec import InputMaker, Spec, TensorSpec, Tolerance
from . import ZERO_WEIGHTS, add
from .geometry_homography import homographies
from .rigid import rotations, scipys

# --- points and transformations -----------------------------------------------------------------------------

_X = TensorSpec("x", ("B", "N", 3), range=(-1, 1), description="points or vectors")
_Y = TensorSpec("y", ("B", "N", 3), range=(-1, 1), description="points or vectors")

_ON_VECTORS: dict[str, tuple[list[TensorSpec], Peer, str]] = {
    "batched_dot_product": (
        [_X, _Y],
        Peer("numpy", lambda np, x, y: np.vecdot(x, y), "batch"),
        "numpy.vecdot",
    ),
    "batched_squared_norm": ([_X], Peer("numpy", lambda np, x: np.vecdot(x, x), "batch"), "numpy.vecdot"),
    "euclidean_distance": (
        [_X, _Y],
        Peer("torch.nn.functional", lambda F, x, y: F.pairwise_distance(x, y, eps=0.0), "tensors"),
        "torch.nn.functional.pairwise_distance",
    ),
}
for _name, (_inputs, _peer, _reference) in _ON_VECTORS.items():
    add(Spec(f"geometry.linalg.{_name}", _inputs, peer=_peer, reference=_reference))

add(
    Spec(
        "geometry.linalg.point_line_distance",
        [
            TensorSpec("point", ("B", "N", 2), range=(-1, 1), description="points in the plane"),
            TensorSpec(
                "line", ("B", "N", 3), range=(0.2, 1), description="coefficients of a x + b y + c = 0"
            ),
        ],
        reference="NumPy",
    )
)


def _make_transformed(dimensions: int) -> InputMaker:
    def sample(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        points = (
            torch.rand((sizes["B"], sizes["N"], dimensions), generator=generator, dtype=torch.float64) * 2 - 1
        )
        if dimensions == 2:
            return {"trans_01": homographies(generator, sizes["B"]).to(dtype), "points_1": points.to(dtype)}
        return {"trans_01": _rigid(generator, sizes["B"]).to(dtype), "points_1": points.to(dtype)}

    return sample


def _rigid(generator: Generator, count: int):
    shift = torch.randn((count, 3, 1), generator=generator, dtype=torch.float64)
    upper = torch.cat([rotations(generator, count), shift], -1)
    return torch.cat(
        [upper, torch.tensor([[0.0, 0.0, 0.0, 1.0]], dtype=torch.float64).expand(count, 1, 4)], 1
    )


for _name, _d, _what in (("plane", 2, "homographies"), ("space", 3, "rigid transformations")):
    add(
        Spec(
            f"geometry.linalg.transform_points.{_name}",
            [
                TensorSpec("trans_01", ("B", _d + 1, _d + 1), description=_what),
                TensorSpec("points_1", ("B", "N", _d), range=(-1, 1), description="points"),
            ],
            make_inputs=_make_transformed(_d),
            peer=opencv(lambda cv2, m, x: cv2.perspectiveTransform(x[None], m)[0], "samples"),
            reference="OpenCV perspectiveTransform; NumPy",
        ),
        fn="geometry.linalg.transform_points",
    )

_POSES: dict[str, tuple[tuple[str, ...], Call]] = {
    "compose_transformations": (
        ("trans_01", "trans_12"),
        lambda transform, a, b: (
            transform.RigidTransform.from_matrix(a) * transform.RigidTransform.from_matrix(b)
        ),
    ),
    "inverse_transformation": (
        ("trans_12",),
        lambda transform, a: transform.RigidTransform.from_matrix(a).inv(),
    ),
    "relative_transformation": (
        ("trans_01", "trans_02"),
        lambda transform, a, b: (
            transform.RigidTransform.from_matrix(a).inv() * transform.RigidTransform.from_matrix(b)
        ),
    ),
}


def _make_poses(names: Sequence[str]) -> InputMaker:
    return lambda generator, sizes, dtype: {name: _rigid(generator, sizes["N"]).to(dtype) for name in names}


for _name, (_names, _call) in _POSES.items():
    add(
        Spec(
            f"geometry.linalg.{_name}",
            [TensorSpec(n, ("N", 4, 4), description="rigid transformations [R t; 0 1]") for n in _names],
            make_inputs=_make_poses(_names),
            peer=scipys(_call, after=lambda motion: motion.as_matrix(), timed=False),
            reference="SciPy RigidTransform",
        )
    )

# --- polynomials --------------------------------------------------------------------------------------------


def _make_roots(degree: int):
    """Polynomials with the roots well apart, so that rounding changes neither their number nor their order;
    every third of them has two complex ones."""

    def sample(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        count = sizes["N"]
        place = torch.arange(degree, dtype=torch.float64) * 0.7 - 0.9
        roots = (place + 0.3 * torch.rand((count, degree), generator=generator, dtype=torch.float64)).to(
            torch.complex128
        )
        complex_pair = torch.arange(count) % 3 == 2
        pair = torch.complex(roots[:, 0].real, torch.full((count,), 0.8, dtype=torch.float64))
        roots[:, 0] = torch.where(complex_pair, pair, roots[:, 0])
        roots[:, 1] = torch.where(complex_pair, pair.conj(), roots[:, 1])
        coeffs = torch.ones((count, 1), dtype=torch.complex128)
        zero = torch.zeros_like(coeffs)
        for k in range(degree):
            coeffs = torch.cat([coeffs, zero], 1) - torch.cat([zero, coeffs], 1) * roots[:, k : k + 1]
        scale = torch.rand((count, 1), generator=generator, dtype=torch.float64) + 0.5
        return {"coeffs": (coeffs.real * scale).to(dtype)}

    return sample


def _real_first(roots: Any) -> Any:
    real = -np.sort(-roots.real[abs(roots.imag) < 1e-4])
    return np.pad(real, (0, len(roots) - len(real)))


for _name, _degree in {"quadratic": 2, "cubic": 3, "quartic": 4}.items():
    add(
        Spec(
            f"geometry.solvers.solve_{_name}",
            [TensorSpec("coeffs", ("N", _degree + 1), description="coefficients, the highest power first")],
            [TensorSpec("roots", description="real roots in descending order, then zeros")],
            dtypes=("float32", "float64"),
            make_inputs=_make_roots(_degree),
            peer=Peer("numpy", lambda np, p: np.roots(p), "samples", after=_real_first, timed=False),
            special_values="of an infinite coefficient there are no roots, or any",
            reference="NumPy roots",
            picture="polynomials",
        )
    )

add(
    Spec(
        "geometry.solvers.multiply_deg_one_poly",
        [
            TensorSpec("a", ("N", 4), range=(-1, 1), description="coefficients of x, y, z, 1"),
            TensorSpec("b", ("N", 4), range=(-1, 1), description="coefficients of x, y, z, 1"),
        ],
        special_values=ZERO_WEIGHTS,
        reference="NumPy: the product of values",
    )
)
add(
    Spec(
        "geometry.solvers.multiply_deg_two_one_poly",
        [
            TensorSpec(
                "a",
                ("N", 10),
                range=(-1, 1),
                description="coefficients of x^2, xy, xz, x, y^2, yz, y, z^2, z, 1",
            ),
            TensorSpec("b", ("N", 4), range=(-1, 1), description="coefficients of x, y, z, 1"),
        ],
        special_values=ZERO_WEIGHTS,
        reference="NumPy: the product of values",
    )
)
add(
    Spec(
        "geometry.solvers.determinant_to_polynomial",
        # not N, whose size in examples is the result's
        [
            TensorSpec(
                "A", ("K", 3, 13), range=(-1, 1), description="rows of polynomials of degrees 3, 3 and 4"
            )
        ],
        symbols={"K": (1, 1 << 20)},
        special_values=ZERO_WEIGHTS,
        reference="NumPy poly1d",
    )
)

# --- least squares ------------------------------------------------------------------------------------------

add(
    Spec(
        "geometry.solvers.null_vector_3x4",
        [TensorSpec("A", ("N", 3, 4), range=(-1, 1), description="matrices of rank 3")],
        reference="NumPy SVD",
    )
)


def _make_affine(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    shape = (sizes["B"], sizes["N"], 2)
    corners = torch.tensor([[0.0, 0.0], [100.0, 0.0], [0.0, 100.0]], dtype=torch.float64).repeat(
        sizes["N"] // 3 + 1, 1
    )[: sizes["N"]]
    points = corners + 20 * torch.rand(shape, generator=generator, dtype=torch.float64)
    moved = points @ homographies(generator, sizes["B"])[:, :2, :2].transpose(1, 2) + 5.0
    weights = torch.rand(shape[:2], generator=generator, dtype=torch.float64) + 0.5
    noise = torch.randn(shape, generator=generator, dtype=torch.float64) * 0.1
    return {"points1": points.to(dtype), "points2": (moved + noise).to(dtype), "weights": weights.to(dtype)}


add(
    Spec(
        "geometry.solvers.find_affine",
        [
            TensorSpec("points1", ("B", "N", 2), range=(0, 120), description="points (x, y)"),
            TensorSpec(
                "points2", ("B", "N", 2), range=(0, 120), description="where they are in the second image"
            ),
            TensorSpec("weights", ("B", "N"), range=(0, 1), description="weights of the points"),
        ],
        [TensorSpec("affine")],
        symbols={"N": (3, 1 << 20)},
        tolerances={"float32": Tolerance(1e-4, 1e-4)},
        make_inputs=_make_affine,
        peer=Peer(
            "sklearn.linear_model",
            lambda linear_model, p, q, weights: linear_model.LinearRegression().fit(p, q, weights),
            "samples",
            after=lambda fit: np.vstack([np.column_stack([fit.coef_, fit.intercept_]), [[0, 0, 1]]]),
            timed=False,
        ),
        reference="NumPy lstsq",
        picture="fitted maps",
    )
)
