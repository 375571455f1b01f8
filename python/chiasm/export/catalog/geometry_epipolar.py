"""Views of one scene: fundamental and essential matrices, triangulation, poses."""

from typing import Any

import numpy as np
import torch
from torch import Generator, Tensor

from ..peer import opencv
from ..spec import InputMaker, Spec, TensorSpec, Tolerance, image
from . import add
from .rigid import lengths, linalg, parts, pose, scipys, uniform

_DOUBLE = torch.float64
_MATRICES, _VECTORS = ("B", 3, 3), ("B", 3, 1)


def _cameras(generator: Generator, batch: int, scale: float):
    """Camera matrices with focal lengths and principal points of about `scale`."""
    matrix = torch.eye(3, dtype=_DOUBLE).repeat(batch, 1, 1)
    matrix[:, 0, 0], matrix[:, 1, 1] = (
        uniform(generator, 0.9, 1.1, batch) * scale,
        uniform(generator, 0.9, 1.1, batch) * scale,
    )
    matrix[:, :2, 2] = uniform(generator, 0.4, 0.6, batch, 2) * scale
    return matrix


def _rotations(generator: Generator, batch: int, angle: float) -> Tensor:
    v = torch.randn((batch, 3), generator=generator, dtype=_DOUBLE)
    v = angle * v / lengths(v, 1)
    return linalg.matrix_exp(_skew(v))


def _skew(v: Tensor):
    x, y, z = v.unbind(-1)
    zero = torch.zeros_like(x)
    return torch.stack([zero, -z, y, z, zero, -x, -y, x, zero], -1).reshape(-1, 3, 3)


def _seen(points: Tensor, K: Tensor, R: Tensor, t: Tensor):
    x = (points @ R.transpose(1, 2) + t.transpose(1, 2)) @ K.transpose(1, 2)
    return x[..., :2] / x[..., 2:]


def scene(
    generator: Generator, batch: int, count: int, scale: float = 1.0, noise: float = 2e-4
) -> dict[str, Tensor]:
    """Two cameras 0.3 rad and a unit apart, points 4 to 8 units in front, and where they are seen, with
    noise.

    Pixels are about `scale`: with 1 for gradients, which would be sums of numbers that differ by millions
    otherwise.
    """
    K1, K2 = _cameras(generator, batch, scale), _cameras(generator, batch, scale)
    R = _rotations(generator, batch, 0.3)
    t = torch.randn((batch, 3, 1), generator=generator, dtype=_DOUBLE)
    t = t / lengths(t, 1)
    X = torch.cat([uniform(generator, -2, 2, batch, count, 2), uniform(generator, 4, 8, batch, count, 1)], -1)
    eye, zero = torch.eye(3, dtype=_DOUBLE).expand(batch, 3, 3), torch.zeros((batch, 3, 1), dtype=_DOUBLE)
    blur = torch.randn((2, batch, count, 2), generator=generator, dtype=_DOUBLE) * noise * scale
    E = _skew(t[..., 0]) @ R
    F = linalg.inv(K2).transpose(1, 2) @ E @ linalg.inv(K1)
    return {
        "K1": K1,
        "K2": K2,
        "R": R,
        "t": t,
        "X": X,
        "E": E,
        "F": F / lengths(F.flatten(1), 1)[:, :, None],
        "x1": _seen(X, K1, eye, zero) + blur[0],
        "x2": _seen(X, K2, R, t) + blur[1],
        "r1": _seen(X, eye, eye, zero) + blur[0] / scale,
        "r2": _seen(X, eye, R, t) + blur[1] / scale,
        "P1": K1 @ torch.cat([eye, zero], -1),
        "P2": K2 @ torch.cat([R, t], -1),
        "weights": uniform(generator, 0.5, 1.5, batch, count),
    }


def _from_scene(
    scale: float = 1.0, noise: float = 2e-4, count: int | None = None, batch: str = "B", **names: str
) -> InputMaker:
    """A maker of inputs that takes a scene's parts as inputs: argument name to part."""

    def sample(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        parts = scene(generator, sizes[batch], count or sizes.get("N", 8), scale, noise)
        return {argument: parts[part].to(dtype) for argument, part in names.items()}

    return sample


def points_input(name: str, count: str = "N", description: str = "points"):
    return TensorSpec(name, ("B", count, 2), description=description)


def matrix_input(name: str, description: str = "", shape: tuple[int | str, ...] = _MATRICES):
    return TensorSpec(name, shape, description=description)


def _motion(generator: Generator, batch: int):
    return _rotations(generator, batch, 1.0), torch.randn((batch, 3, 1), generator=generator, dtype=_DOUBLE)


LOOSE = {"float32": Tolerance(1e-3, 1e-3)}
_ZISSERMAN = "R. Hartley, A. Zisserman, Multiple View Geometry"

# --- errors and lines ---------------------------------------------------------------------------------------


def _sampson(cv2: Any, x1: np.ndarray, x2: np.ndarray, fundamental: np.ndarray) -> np.ndarray:
    pairs = zip(x1, x2, strict=True)
    return np.array([cv2.sampsonDistance(p, q, fundamental) for p, q in pairs])


def _homogeneous(x1: np.ndarray, x2: np.ndarray, fundamental: np.ndarray) -> tuple[np.ndarray, ...]:
    """In float64, as OpenCV needs them."""
    made = (np.pad(x.astype(np.float64), ((0, 0), (0, 1)), constant_values=1.0) for x in (x1, x2))
    return (*made, fundamental.astype(np.float64))


for _name, _reference in {
    "sampson_epipolar_distance": "OpenCV sampsonDistance",
    "symmetrical_epipolar_distance": "OpenCV computeCorrespondEpilines",
    "left_to_right_epipolar_distance": "OpenCV computeCorrespondEpilines",
    "right_to_left_epipolar_distance": "OpenCV computeCorrespondEpilines",
    "get_closest_point_on_epipolar_line": "OpenCV computeCorrespondEpilines",
}.items():
    add(
        Spec(
            f"geometry.epipolar.{_name}",
            [points_input("pts1"), points_input("pts2"), matrix_input("Fm", "fundamental matrices")],
            # points a hundredth off their lines: distances are differences, and gradients sums over points
            gradient_tolerances=LOOSE,
            make_inputs=_from_scene(noise=0.02, pts1="x1", pts2="x2", Fm="F"),
            peer=opencv(_sampson, "samples", before=_homogeneous, timed=False)
            if _name == "sampson_epipolar_distance"
            else None,
            reference=_reference,
            picture="epipolar lines",
        )
    )
add(
    Spec(
        "geometry.epipolar.compute_correspond_epilines",
        [points_input("points"), matrix_input("F_mat", "fundamental matrices")],
        [TensorSpec("lines")],
        gradient_tolerances=LOOSE,
        make_inputs=_from_scene(points="x1", F_mat="F"),
        peer=opencv(lambda cv2, x, f: cv2.computeCorrespondEpilines(x[:, None], 1, f)[:, 0], "samples"),
        reference="OpenCV computeCorrespondEpilines",
    )
)
add(
    Spec(
        "geometry.epipolar.get_perpendicular",
        [
            TensorSpec("lines", ("B", "N", 3), range=(-1, 1), description="a, b, c of a x + b y + c = 0"),
            TensorSpec("points", ("B", "N", 2)),
        ],
        [TensorSpec("perpendiculars")],
        reference="definition",
    )
)

# --- matrices of two views ----------------------------------------------------------------------------------

add(
    Spec(
        "geometry.epipolar.cross_product_matrix",
        [TensorSpec("x", ("N", 3), range=(-1, 1))],
        [TensorSpec("matrix")],
        reference="definition",
    )
)
for _name, _from in (("essential_from_fundamental", "F"), ("fundamental_from_essential", "E")):
    add(
        Spec(
            f"geometry.epipolar.{_name}",
            [
                matrix_input(f"{_from}_mat"),
                matrix_input("K1", "camera matrices"),
                matrix_input("K2", "camera matrices"),
            ],
            make_inputs=_from_scene(**{f"{_from}_mat": _from}, K1="K1", K2="K2"),  # pyright: ignore[reportArgumentType]
            reference=f"{_ZISSERMAN}, 9.6",
        )
    )


def _make_two_motions(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    (R1, t1), (R2, t2) = _motion(generator, sizes["B"]), _motion(generator, sizes["B"])
    return {name: value.to(dtype) for name, value in {"R1": R1, "t1": t1, "R2": R2, "t2": t2}.items()}


_TWO_MOTIONS = [
    matrix_input("R1"),
    matrix_input("t1", shape=_VECTORS),
    matrix_input("R2"),
    matrix_input("t2", shape=_VECTORS),
]
add(
    Spec(
        "geometry.epipolar.essential_from_Rt",
        _TWO_MOTIONS,
        [TensorSpec("essential")],
        make_inputs=_make_two_motions,
        reference="definition",
    )
)
add(
    Spec(
        "geometry.epipolar.relative_camera_motion",
        _TWO_MOTIONS,
        [TensorSpec("R"), TensorSpec("t")],
        make_inputs=_make_two_motions,
        peer=scipys(
            lambda transform, r1, t1, r2, t2: parts(pose(transform, r2, t2) * pose(transform, r1, t1).inv()),
            timed=False,
        ),
        reference="SciPy RigidTransform",
    )
)
for _name in ("decompose_essential_matrix", "decompose_essential_matrix_no_svd"):
    add(
        Spec(
            f"geometry.epipolar.{_name}",
            [matrix_input("E_mat", "essential matrices")],
            [TensorSpec("R1"), TensorSpec("R2"), TensorSpec("t")],
            gradient_tolerances=LOOSE,
            make_inputs=_from_scene(E_mat="E"),
            reference="OpenCV decomposeEssentialMat",
        )
    )
add(
    Spec(
        "geometry.epipolar.motion_from_essential",
        [matrix_input("E_mat", "essential matrices")],
        [TensorSpec("rotations"), TensorSpec("translations")],
        gradient_tolerances=LOOSE,
        make_inputs=_from_scene(E_mat="E"),
        reference="OpenCV decomposeEssentialMat",
    )
)
add(
    Spec(
        "geometry.epipolar.motion_from_essential_choose_solution",
        [
            matrix_input("E_mat", "essential matrices"),
            matrix_input("K1"),
            matrix_input("K2"),
            points_input("x1", description="pixels"),
            points_input("x2", description="pixels"),
        ],
        [TensorSpec("R"), TensorSpec("t"), TensorSpec("points"), TensorSpec("in_front")],
        # depths are ill-conditioned
        tolerances=LOOSE,
        gradient_tolerances={"float32": Tolerance(5e-2, 5e-3)},
        make_inputs=_from_scene(E_mat="E", K1="K1", K2="K2", x1="x1", x2="x2"),
        peer=opencv(
            lambda cv2, e, k1, k2, x1, x2: cv2.recoverPose(
                e,
                cv2.undistortPoints(x1, k1, None),
                cv2.undistortPoints(x2, k2, None),
                np.eye(3),
                distanceThresh=1e9,
            )[1:],
            "samples",
            before=lambda e, k1, k2, x1, x2: tuple(m.astype(np.float64) for m in (e, k1, k2, x1, x2)),
            after=lambda made: (made[0], made[1], (made[3][:3] / made[3][3]).T, made[2][:, 0] > 0),
        ),
        reference="OpenCV recoverPose",
    )
)


def _make_near_essential(
    generator: Generator, sizes: dict[str, int], dtype: torch.dtype
) -> dict[str, Tensor]:
    E = scene(generator, sizes["B"], 1)["E"]
    return {"E_mat": (E + uniform(generator, -0.1, 0.1, *E.shape)).to(dtype)}


add(
    Spec(
        "geometry.epipolar.project_to_essential",
        [matrix_input("E_mat")],
        [TensorSpec("essential")],
        gradient_tolerances=LOOSE,
        make_inputs=_make_near_essential,
        reference="NumPy SVD in float64",
    )
)
add(
    Spec(
        "geometry.epipolar.normalize_points",
        [points_input("points")],
        [TensorSpec("normalized"), TensorSpec("similarity")],
        gradient_tolerances=LOOSE,
        make_inputs=_from_scene(points="x1"),
        reference="definition",
    )
)
add(
    Spec(
        "geometry.epipolar.normalize_transformation",
        [TensorSpec("M", _MATRICES, range=(0.5, 1.5))],
        [TensorSpec("normalized")],
        reference="definition",
    )
)

# --- projections --------------------------------------------------------------------------------------------

_PROJECTION = ("B", 3, 4)
add(
    Spec(
        "geometry.epipolar.fundamental_from_projections",
        [matrix_input("P1", shape=_PROJECTION), matrix_input("P2", shape=_PROJECTION)],
        [TensorSpec("fundamental")],
        make_inputs=_from_scene(P1="P1", P2="P2"),
        reference=f"determinants in NumPy; {_ZISSERMAN}, 17.1",
    )
)
add(
    Spec(
        "geometry.epipolar.projections_from_fundamental",
        [matrix_input("F_mat")],
        [TensorSpec("projections")],
        gradient_tolerances=LOOSE,
        make_inputs=_from_scene(F_mat="F"),
        reference=f"{_ZISSERMAN}, result 9.14",
    )
)
add(
    Spec(
        "geometry.epipolar.projection_from_KRt",
        [matrix_input("K"), matrix_input("R"), matrix_input("t", shape=_VECTORS)],
        [TensorSpec("projection")],
        make_inputs=_from_scene(K="K2", R="R", t="t"),
        reference="definition",
    )
)
add(
    Spec(
        "geometry.epipolar.KRt_from_projection",
        [matrix_input("P", shape=_PROJECTION)],
        [TensorSpec("K"), TensorSpec("R"), TensorSpec("t")],
        gradient_tolerances=LOOSE,
        make_inputs=_from_scene(P="P2"),
        peer=opencv(
            lambda cv2, p: cv2.decomposeProjectionMatrix(p)[:3],
            "samples",
            after=lambda made: (made[0], made[1], -made[1] @ made[2][:3] / made[2][3]),
        ),
        reference="OpenCV decomposeProjectionMatrix",
    )
)
add(
    Spec(
        "geometry.epipolar.depth_from_point",
        [matrix_input("R"), matrix_input("t", shape=_VECTORS), TensorSpec("X", ("B", "N", 3))],
        [TensorSpec("depth")],
        gradient_tolerances=LOOSE,
        make_inputs=_from_scene(R="R", t="t", X="X"),
        reference="definition",
    )
)
add(
    Spec(
        "geometry.epipolar.intrinsics_like",
        [image()],
        [TensorSpec("camera_matrix")],
        config={"focal": 500.0},
        gradients=(),
        reference="definition",
    )
)
add(
    Spec(
        "geometry.epipolar.scale_intrinsics",
        [TensorSpec("camera_matrix", ("N", 3, 3)), TensorSpec("scale_factor", ("N",), range=(0.5, 2.0))],
        [TensorSpec("scaled")],
        reference="definition",
    )
)
add(
    Spec(
        "geometry.epipolar.triangulate_points",
        [
            matrix_input("P1", shape=_PROJECTION),
            matrix_input("P2", shape=_PROJECTION),
            points_input("points1", description="pixels"),
            points_input("points2", description="pixels"),
        ],
        [TensorSpec("points")],
        tolerances=LOOSE,
        gradient_tolerances={"float32": Tolerance(5e-2, 5e-3)},
        make_inputs=_from_scene(P1="P1", P2="P2", points1="x1", points2="x2"),
        peer=opencv(
            lambda cv2, p1, p2, x1, x2: cv2.triangulatePoints(p1, p2, x1.T, x2.T),
            "samples",
            after=lambda points: (points[:3] / points[3]).T,
        ),
        reference="OpenCV triangulatePoints",
    )
)
add(
    Spec(
        "geometry.calibration.solve_pnp_dlt",
        [
            TensorSpec("world_points", ("B", "N", 3)),
            points_input("img_points", description="pixels"),
            matrix_input("intrinsics"),
            TensorSpec("weights", ("B", "N")),
        ],
        [TensorSpec("pose")],
        symbols={"N": (6, 1 << 20)},
        tolerances=LOOSE,
        gradient_tolerances={"float32": Tolerance(5e-2, 1e-2)},
        make_inputs=_from_scene(world_points="X", img_points="x2", intrinsics="K2", weights="weights"),
        reference="OpenCV solvePnP",
    )
)

# --- fundamental and essential matrices from points ---------------------------------------------------------

WEIGHTS = TensorSpec("weights", ("B", "N"), range=(0.5, 1.5))
add(
    Spec(
        "geometry.epipolar.find_fundamental",
        [points_input("points1"), points_input("points2"), WEIGHTS],
        [TensorSpec("fundamental")],
        symbols={"N": (8, 1 << 20)},
        tolerances=LOOSE,
        gradient_tolerances={"float32": Tolerance(0.1, 1e-2)},
        make_inputs=_from_scene(points1="x1", points2="x2", weights="weights"),
        reference="OpenCV findFundamentalMat; NumPy SVD in float64",
        picture="epipolar lines on photographs",
    )
)
add(
    Spec(
        # the batch is N, because it is exported at a B of 7
        "geometry.epipolar.find_fundamental_7point",
        [TensorSpec("points1", ("N", 7, 2)), TensorSpec("points2", ("N", 7, 2))],
        [TensorSpec("fundamental"), TensorSpec("exists")],
        tolerances=LOOSE,
        gradient_tolerances={"float32": Tolerance(0.1, 1e-2)},
        make_inputs=_from_scene(count=7, batch="N", points1="x1", points2="x2"),
        reference="OpenCV findFundamentalMat",
        vectorize=False,  # torch 2.13's AOTInductor computes wrong numbers in the SIMD loop of this gradient
        picture="epipolar lines",
    )
)
add(
    Spec(
        "geometry.epipolar.find_essential",
        [points_input("points1"), points_input("points2"), WEIGHTS],
        [TensorSpec("essential"), TensorSpec("exists")],
        symbols={"N": (5, 1 << 20)},
        gradients=(),
        tolerances=LOOSE,
        make_inputs=_from_scene(points1="r1", points2="r2", weights="weights"),
        reference="OpenCV findEssentialMat",
        picture="epipolar lines",
    ),
    fn="geometry.epipolar.find_essential_5point",
)
