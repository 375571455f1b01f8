"""Views of one scene with some wrong correspondences, poses by least squares, and stereo pairs."""

from typing import Any

import numpy as np
import torch
from torch import Generator, Tensor

from ..peer import opencv
from ..spec import InputMaker, Spec, TensorSpec, Tolerance, like
from . import add
from .geometry_epipolar import scene
from .geometry_homography import homographies, mapped
from .rigid import linalg, uniform

_DOUBLE = torch.float64
_LOOSE = {"float32": Tolerance(1e-3, 1e-3)}


def _points(name: str, batch: str = "B"):
    return TensorSpec(name, (batch, "N", 2), description="pixels")


def _matrix(name: str, description: str = "", shape: tuple[int | str, ...] = ("B", 3, 3)):
    return TensorSpec(name, shape, description=description)


# --- random sample consensus --------------------------------------------------------------------------------


def _uniforms(size: int, batch: str = "B"):
    return TensorSpec(
        "uniforms",
        (batch, "S", size),
        range=(0, 1),
        description="random numbers, uniform in [0, 1), of which samples are made",
    )


def _with_wrong_ones(generator: Generator, points: Tensor, size: float):
    """From the eleventh on, a quarter of the points are random."""
    count = points.shape[1]
    wrong = (torch.arange(count) >= 10) & (torch.arange(count) % 4 == 2)
    return torch.where(wrong[:, None], uniform(generator, 0.0, size, *points.shape), points)


def _make_plane(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    p = uniform(generator, 0, 200, sizes["B"], sizes["N"], 2)
    q = mapped(homographies(generator, sizes["B"]), p) + 0.05 * torch.randn(
        p.shape, generator=generator, dtype=_DOUBLE
    )
    made = {
        "points1": p,
        "points2": _with_wrong_ones(generator, q, 200),
        "uniforms": uniform(generator, 0.0, 1.0, sizes["B"], sizes["S"], 4),
    }
    return {name: value.to(dtype) for name, value in made.items()}


def _inputs_of_scenes(size: int, batch: str = "B", **more: str) -> InputMaker:
    """Two views with pixels of about 500 and a noise of 0.1; `more` are further arguments: parts of the
    scene."""

    def sample(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        parts = scene(generator, sizes[batch], sizes["N"], 500.0)
        made = {
            "points1": parts["x1"],
            "points2": _with_wrong_ones(generator, parts["x2"], 500.0),
            **{name: parts[part] for name, part in more.items()},
        }
        made["uniforms"] = uniform(generator, 0.0, 1.0, sizes[batch], sizes["S"], size)
        return {name: value.to(dtype) for name, value in made.items()}

    return sample


_MASK = TensorSpec("inliers", description="which correspondences obey the matrix")
_SAMPLES: dict[str, Any] = {"S": (1, 1 << 16)}

add(
    Spec(
        "geometry.ransac.ransac_homography",
        [_points("points1"), _points("points2"), _uniforms(4)],
        [TensorSpec("homography"), _MASK],
        symbols={"N": (4, 1 << 20), **_SAMPLES},
        gradients=("points1", "points2"),
        tolerances=_LOOSE,
        gradient_tolerances={"float32": Tolerance(2e-2, 1e-2)},
        make_inputs=_make_plane,
        reference="OpenCV findHomography with RANSAC",
    )
)


def _make_masked_plane(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    made = _make_plane(generator, sizes, dtype)
    return made | {
        "mask": (
            (torch.arange(sizes["N"]) < 8) | (torch.rand((sizes["B"], sizes["N"]), generator=generator) < 0.6)
        )
    }


add(
    Spec(
        "geometry.ransac.ransac_homography.masked",
        [
            _points("points1"),
            _points("points2"),
            _uniforms(4),
            TensorSpec("mask", ("B", "N"), "bool", description="which correspondences are there"),
        ],
        [TensorSpec("homography"), _MASK],
        symbols={"N": (4, 1 << 20), **_SAMPLES},
        gradients=("points1", "points2"),
        tolerances=_LOOSE,
        gradient_tolerances={"float32": Tolerance(2e-2, 1e-2)},
        make_inputs=_make_masked_plane,
        reference="the same of the others alone",
    ),
    fn="geometry.ransac.ransac_homography",
)
add(
    Spec(
        # the batch is P, because B is 7 in the example, as the size of a sample
        "geometry.ransac.ransac_fundamental",
        [_points("points1", "P"), _points("points2", "P"), _uniforms(7, "P")],
        [TensorSpec("fundamental"), _MASK],
        symbols={"P": (1, 4096), "N": (8, 1 << 20), **_SAMPLES},
        gradients=("points1", "points2"),
        tolerances=_LOOSE,
        gradient_tolerances={"float32": Tolerance(0.1, 1e-2)},
        make_inputs=_inputs_of_scenes(7, "P"),
        reference="OpenCV findFundamentalMat with RANSAC",
        picture="epipolar lines on photographs",
    )
)
add(
    Spec(
        "geometry.ransac.ransac_essential",
        [
            _points("points1"),
            _points("points2"),
            _matrix("K1", "camera matrices"),
            _matrix("K2", "camera matrices"),
            _uniforms(5),
        ],
        [TensorSpec("essential"), _MASK],
        symbols={"N": (6, 1 << 20), **_SAMPLES},
        gradients=(),
        tolerances=_LOOSE,
        make_inputs=_inputs_of_scenes(5, K1="K1", K2="K2"),
        reference="OpenCV findEssentialMat with RANSAC, recoverPose",
    )
)

# --- poses --------------------------------------------------------------------------------------------------


def _make_pose(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Points, and a pose near the true one."""
    parts = scene(generator, sizes["B"], sizes["N"])
    pose = torch.cat([parts["R"], parts["t"]], -1) + uniform(generator, -0.03, 0.03, sizes["B"], 3, 4)
    made = {
        "world_points": parts["X"],
        "img_points": parts["x2"],
        "intrinsics": parts["K2"],
        "pose": pose,
        "weights": parts["weights"],
    }
    return {name: value.to(dtype) for name, value in made.items()}


add(
    Spec(
        "geometry.pnp.refine_pnp",
        [
            TensorSpec("world_points", ("B", "N", 3)),
            _points("img_points"),
            _matrix("intrinsics", "camera matrices"),
            _matrix("pose", "[R | t]", ("B", 3, 4)),
            TensorSpec("weights", ("B", "N"), range=(0.5, 1.5)),
        ],
        [TensorSpec("refined", description="[R | t]")],
        # enough from a pose by the direct linear transform; the graph of the gradient has a copy of each step
        config={"num_iters": 6},
        symbols={"N": (5, 1 << 20)},
        gradients=("world_points", "img_points", "intrinsics", "weights"),
        gradient_tolerances=_LOOSE,
        make_inputs=_make_pose,
        reference="OpenCV solvePnP, solvePnPRefineLM",
    )
)

# --- stereo -------------------------------------------------------------------------------------------------


def _make_rig(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Two cameras side by side, with small rotations."""
    parts = scene(generator, sizes["B"], 1, 50.0)
    v = uniform(generator, -0.05, 0.05, sizes["B"], 3)
    skew = torch.zeros((sizes["B"], 3, 3), dtype=_DOUBLE)
    skew[:, 0, 1], skew[:, 0, 2], skew[:, 1, 2] = -v[:, 2], v[:, 1], -v[:, 0]
    shift = torch.tensor([[-0.5], [0.0], [0.0]], dtype=_DOUBLE) + uniform(
        generator, -0.03, 0.03, sizes["B"], 3, 1
    )
    made = {
        "K1": parts["K1"],
        "K2": parts["K2"],
        "R": linalg.matrix_exp(skew - skew.transpose(1, 2)),
        "t": shift,
    }
    like = torch.zeros((sizes["H"], sizes["W"]), dtype=torch.uint8)
    return {**{name: value.to(dtype) for name, value in made.items()}, "like": like}


add(
    Spec(
        "geometry.stereo.stereo_rectify",
        [
            _matrix("K1", "camera matrices"),
            _matrix("K2", "camera matrices"),
            _matrix("R", "from the first camera to the second"),
            _matrix("t", "from the first camera to the second", ("B", 3, 1)),
            like("height", "width", shape=("H", "W")),
        ],
        [TensorSpec(name) for name in ("R1", "R2", "P1", "P2", "Q")],
        tolerances=_LOOSE,
        gradient_tolerances=_LOOSE,
        make_inputs=_make_rig,
        peer=opencv(
            lambda cv2, k1, k2, r, t, size: cv2.stereoRectify(k1, None, k2, None, size, r, t, alpha=-1)[:5],
            "samples",
            before=lambda k1, k2, r, t, like: (
                *(m.astype(np.float64) for m in (k1, k2, r, t)),
                like.shape[::-1],
            ),
        ),
        reference="OpenCV stereoRectify",
    ),
    fn="geometry.stereo.stereo_rectify",
)


def _make_disparity(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Disparities of 5 to 60 pixels, of rigs with focal lengths of about 500."""
    batch = sizes["B"]
    Q = torch.eye(4, dtype=_DOUBLE).repeat(batch, 1, 1)
    Q[:, :2, 3] = -uniform(generator, 10.0, 20.0, batch, 2)
    Q[:, 2, 2], Q[:, 2, 3], Q[:, 3, 2], Q[:, 3, 3] = (
        0.0,
        uniform(generator, 400, 600, batch),
        uniform(generator, 2, 10, batch),
        1.0,
    )
    return {
        "disparity": uniform(generator, 5, 60, batch, 1, sizes["H"], sizes["W"]).to(dtype),
        "Q": Q.to(dtype),
    }


add(
    Spec(
        "geometry.stereo.reproject_disparity_to_3d",
        [
            TensorSpec("disparity", ("B", 1, "H", "W"), layout="NCHW", range=(5, 60), description="pixels"),
            _matrix("Q", "of the rectified pair", ("B", 4, 4)),
        ],
        [TensorSpec("points")],
        # gradients by Q are sums over all pixels, of points hundreds away
        gradient_tolerances={"float32": Tolerance(1e-1, 1e-3)},
        make_inputs=_make_disparity,
        peer=opencv(lambda cv2, disparity, q: cv2.reprojectImageTo3D(disparity[0], q), "samples"),
        reference="OpenCV reprojectImageTo3D",
    )
)
