"""Geometry: homographies from points and from segments, and their errors."""

import torch
from torch import Generator, Tensor

from ..spec import InputMaker, Spec, TensorSpec, Tolerance
from . import add, rejected_words
from .geometry_epipolar import LOOSE, WEIGHTS, matrix_input, points_input
from .rigid import uniform


def homographies(generator: Generator, batch: int):
    """Mild homographies in pixel coordinates: near the identity, so that most of the image stays in view."""
    scale = torch.tensor([[0.1, 0.1, 3.0], [0.1, 0.1, 3.0], [1e-3, 1e-3, 0.0]], dtype=torch.float64)
    return torch.eye(3, dtype=torch.float64) + uniform(generator, -1, 1, batch, 3, 3) * scale


def mapped(H: Tensor, points: Tensor):
    """Points (B, N, 2) where homographies take them."""
    x = torch.cat([points, torch.ones_like(points[..., :1])], -1) @ H.transpose(1, 2)
    return x[..., :2] / x[..., 2:]


# --- transfer errors ----------------------------------------------------------------------------------------


def _inputs_of_pairs(first: str, second: str, noise: float, **more: str) -> InputMaker:
    """Points and where a homography takes them, with noise; `more` are further arguments: "H" or
    "weights"."""

    def sample(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        H = homographies(generator, sizes["B"])
        p = uniform(generator, 0, 200, sizes["B"], sizes["N"], 2)
        q = mapped(H, p) + noise * torch.randn(p.shape, generator=generator, dtype=torch.float64)
        parts = {"H": H, "weights": uniform(generator, 0.5, 1.5, sizes["B"], sizes["N"])}
        return {
            name: value.to(dtype)
            for name, value in {first: p, second: q, **{n: parts[p] for n, p in more.items()}}.items()
        }

    return sample


def _inputs_of_segments(noise: float, **more: str) -> InputMaker:
    """Segments, and others on the lines where a homography takes them, with noise."""

    def sample(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        batch, count = sizes["B"], sizes["N"]
        H = homographies(generator, batch)
        ends = uniform(generator, 0, 200, batch, 2 * count, 2)
        along = torch.tensor([[0.9, 0.1], [-0.2, 1.2]], dtype=torch.float64)
        moved = along @ mapped(H, ends).reshape(batch, count, 2, 2)
        moved = moved + noise * torch.randn(moved.shape, generator=generator, dtype=torch.float64)
        parts = {"H": H, "weights": uniform(generator, 0.5, 1.5, batch, count)}
        given = {
            "ls1": ends.reshape(batch, count, 2, 2),
            "ls2": moved,
            **{n: parts[p] for n, p in more.items()},
        }
        return {name: value.to(dtype) for name, value in given.items()}

    return sample


_SEGMENTS = [
    TensorSpec("ls1", ("B", "N", 2, 2), description="segments' end points"),
    TensorSpec("ls2", ("B", "N", 2, 2), description="segments' end points"),
]

# distances of 3 pixels, from coordinates of 200, of which float32 keeps 2e-5
_DISTANCES = {"float32": Tolerance(5e-3, 2e-3)}

for _name in ("oneway_transfer_error", "symmetric_transfer_error", "sampson_homography_distance"):
    add(
        Spec(
            f"geometry.homography.{_name}",
            [points_input("pts1"), points_input("pts2"), matrix_input("H", "homographies")],
            [TensorSpec("error")],
            tolerances=_DISTANCES,
            gradient_tolerances={"float32": Tolerance(20.0, 1e-2)},  # by H: sums of squares of pixels
            make_inputs=_inputs_of_pairs("pts1", "pts2", 3.0, H="H"),
            reference="OpenCV perspectiveTransform; definition",
            picture="fitted maps",
        )
    )

add(
    Spec(
        "geometry.homography.line_segment_transfer_error_one_way",
        [*_SEGMENTS, matrix_input("H", "homographies")],
        [TensorSpec("error")],
        tolerances=_DISTANCES,
        gradient_tolerances={"float32": Tolerance(2.0, 1e-2)},
        make_inputs=_inputs_of_segments(3.0, H="H"),
        reference="definition",
        picture="fitted maps",
    )
)

# --- fits ---------------------------------------------------------------------------------------------------

_FOUR = {"N": (4, 1 << 20)}


def _make_points(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Points and where a homography takes them, with a little noise."""
    points = torch.rand((sizes["B"], sizes["N"], 2), generator=generator, dtype=torch.float64) * 200
    h = homographies(generator, sizes["B"])
    noise = torch.randn(points.shape, generator=generator, dtype=torch.float64) * 0.05
    return {"points1": points.to(dtype), "points2": (mapped(h, points) + noise).to(dtype)}


_POINTS = ("B", "N", 2)

add(
    Spec(
        "geometry.homography.find_homography_dlt",
        [
            TensorSpec("points1", _POINTS, range=(0, 200), description="points in the first image (x, y)"),
            TensorSpec("points2", _POINTS, range=(0, 200), description="the same points in the second image"),
        ],
        [TensorSpec("homography")],
        symbols=_FOUR,
        tolerances={"float32": Tolerance(1e-3, 1e-3)},
        make_inputs=_make_points,
        reference="OpenCV findHomography; NumPy SVD in float64",
        picture="fitted maps",
        errors=rejected_words("solver"),
    )
)

add(
    Spec(
        "geometry.homography.find_homography_dlt_iterated",
        [points_input("points1"), points_input("points2"), WEIGHTS],
        [TensorSpec("homography")],
        config={"n_iter": 3},
        symbols=_FOUR,
        tolerances=LOOSE,
        gradient_tolerances={"float32": Tolerance(2e-2, 1e-2)},
        make_inputs=_inputs_of_pairs("points1", "points2", 0.05, weights="weights"),
        reference="NumPy SVD in float64",
        picture="fitted maps",
    )
)

add(
    Spec(
        "geometry.homography.find_homography_lines_dlt",
        _SEGMENTS,
        [TensorSpec("homography")],
        symbols=_FOUR,
        tolerances=LOOSE,
        gradient_tolerances={"float32": Tolerance(2e-2, 1e-2)},
        make_inputs=_inputs_of_segments(0.01),
        reference="NumPy SVD in float64",
        picture="fitted maps",
    )
)

add(
    Spec(
        "geometry.homography.find_homography_lines_dlt_iterated",
        [*_SEGMENTS, WEIGHTS],
        [TensorSpec("homography")],
        config={"n_iter": 3},
        symbols=_FOUR,
        tolerances=LOOSE,
        gradient_tolerances={"float32": Tolerance(2e-2, 1e-2)},
        make_inputs=_inputs_of_segments(0.01, weights="weights"),
        reference="NumPy SVD in float64",
        picture="fitted maps",
    )
)


def _make_fours(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Corners moved about; every other sample has two of them exchanged."""
    corners = torch.tensor([[0.0, 0.0], [200.0, 0.0], [200.0, 200.0], [0.0, 200.0]], dtype=torch.float64)
    p, q = (corners + uniform(generator, -60, 60, sizes["N"], 4, 2) for _ in range(2))
    q[::2] = q[::2, [1, 0, 2, 3]]
    return {"points1": p.to(dtype), "points2": q.to(dtype)}


add(
    Spec(
        "geometry.homography.sample_is_valid_for_homography",
        [TensorSpec("points1", ("N", 4, 2)), TensorSpec("points2", ("N", 4, 2))],
        [TensorSpec("valid")],
        gradients=(),
        make_inputs=_make_fours,
        reference="definition",
        picture="quadrilaterals",
    )
)
