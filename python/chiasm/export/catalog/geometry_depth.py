"""Depth maps: points, normals, and warps to other views."""

import numpy as np
import torch
from torch import Generator

from ..peer import opencv
from ..spec import Spec, TensorSpec, Tolerance, image, like
from . import add
from .geometry_camera import camera_matrices, cast
from .rigid import linalg, uniform


def _image_camera(generator: Generator, sizes: dict[str, int], size: int = 3):
    """A camera whose principal point is near the image's middle."""
    b, h, w = sizes["B"], sizes["H"], sizes["W"]
    matrix = torch.eye(size, dtype=torch.float64).repeat(b, 1, 1)
    matrix[:, 0, 0] = matrix[:, 1, 1] = 30.0 + uniform(generator, 0, 5, b)
    matrix[:, 0, 2], matrix[:, 1, 2] = (
        0.5 * w + uniform(generator, 0.0, 1.0, b),
        0.5 * h + uniform(generator, 0.0, 1.0, b),
    )
    return matrix


def _depth(generator: Generator, sizes: dict[str, int]):
    """A slanted, bumpy surface."""
    b, h, w = sizes["B"], sizes["H"], sizes["W"]
    row, column = torch.arange(h, dtype=torch.float64)[:, None], torch.arange(w, dtype=torch.float64)
    return (
        3.0
        + 0.01 * row
        + 0.02 * column
        + 0.1 * torch.sin(0.5 * column)
        + uniform(generator, 0, 0.1, b, 1, h, w)
    )


def _motion(generator: Generator, batch: int):
    """A small turn and shift."""
    turn = torch.zeros((batch, 4, 4), dtype=torch.float64)
    v = uniform(generator, -0.05, 0.05, batch, 3)
    turn[:, 0, 1], turn[:, 0, 2], turn[:, 1, 2] = -v[:, 2], v[:, 1], -v[:, 0]
    motion = linalg.matrix_exp(turn - turn.transpose(1, 2))
    motion[:, :3, 3] = uniform(generator, -0.2, 0.2, batch, 3)
    return motion


_DEPTH = TensorSpec("depth", ("B", 1, "H", "W"), layout="NCHW", range=(3, 6), description="depth map")
_MATRIX = TensorSpec("camera_matrix", ("B", 3, 3), description="camera matrices")
_SUMS = {"float32": Tolerance(2e-3, 1e-3)}  # gradients by camera matrices are sums over all pixels
_READ = {"float32": Tolerance(1e-3, 1e-3)}
_READ_SUMS = {"float32": Tolerance(2e-2, 2e-3)}

add(
    Spec(
        "geometry.depth.depth_from_disparity",
        [
            TensorSpec("disparity", ("B", 1, "H", "W"), layout="NCHW", range=(5, 60), description="pixels"),
            TensorSpec("baseline", (1,), range=(0.1, 0.5)),
            TensorSpec("focal", (1,), range=(400, 600), description="pixels"),
        ],
        [TensorSpec("depth", layout="NCHW")],
        gradient_tolerances=_SUMS,
        reference="definition",
        picture="depth images",
    )
)
add(
    Spec(
        "geometry.depth.depth_from_plane_equation",
        [
            TensorSpec("plane_normals", ("B", 3)),
            TensorSpec("plane_offsets", ("B", 1)),
            TensorSpec("points_uv", ("B", "N", 2)),
            _MATRIX,
        ],
        [TensorSpec("depth")],
        gradient_tolerances=_SUMS,
        make_inputs=lambda g, s, dtype: cast(
            dtype,
            plane_normals=uniform(g, -0.2, 0.2, s["B"], 3) + torch.tensor([0.0, 0.0, 1.0]),
            plane_offsets=uniform(g, 2, 5, s["B"], 1),
            points_uv=uniform(g, 100, 400, s["B"], s["N"], 2),
            camera_matrix=camera_matrices(g, s["B"]),
        ),
        reference="definition",
    )
)
_TO_SPACE = opencv(lambda cv2, depth, k: cv2.depthTo3d(depth, k)[..., :3])
for _unit in (False, True):
    add(
        Spec(
            f"geometry.depth.depth_to_3d{'.unit_rays' if _unit else ''}",
            [_DEPTH, _MATRIX],
            [TensorSpec("points", layout="NCHW")],
            config={"normalize_points": _unit},
            gradient_tolerances=_SUMS,
            peer=None if _unit else _TO_SPACE,
            reference="OpenCV depthTo3d; definition",
            make_inputs=lambda g, s, dtype: cast(
                dtype, depth=_depth(g, s), camera_matrix=_image_camera(g, s)
            ),
            picture="point clouds",
        ),
        fn="geometry.depth.depth_to_3d",
    )
add(
    Spec(
        "geometry.depth.depth_to_3d_v2",
        [TensorSpec("depth", ("B", "H", "W"), range=(3, 6), description="depth map"), _MATRIX],
        [TensorSpec("points")],
        gradient_tolerances=_SUMS,
        peer=opencv(lambda cv2, depth, k: cv2.depthTo3d(depth, k)[..., :3], "samples"),
        reference="OpenCV depthTo3d; definition",
        make_inputs=lambda g, s, dtype: cast(
            dtype, depth=_depth(g, s)[:, 0], camera_matrix=_image_camera(g, s)
        ),
        picture="point clouds",
    )
)
add(
    Spec(
        "geometry.depth.unproject_meshgrid",
        [
            like("height", "width", shape=("H", "W")),
            _MATRIX,
        ],
        [TensorSpec("rays")],
        gradient_tolerances=_SUMS,
        peer=opencv(
            lambda cv2, depth, k: cv2.depthTo3d(depth, k)[..., :3],
            "samples",
            before=lambda like, k: (np.ones(like.shape, np.float32), k),
        ),
        reference="OpenCV depthTo3d; definition",
        make_inputs=lambda g, s, dtype: {
            "like": torch.zeros((s["H"], s["W"]), dtype=torch.uint8),
            "camera_matrix": _image_camera(g, s).to(dtype),
        },
    ),
    fn="geometry.depth.unproject_meshgrid",
)
add(
    Spec(
        "geometry.depth.depth_to_normals",
        [_DEPTH, _MATRIX],
        [TensorSpec("normals", layout="NCHW")],
        symbols={"H": (8, 32768), "W": (8, 32768)},
        gradient_tolerances={"float32": Tolerance(1e-2, 1e-2)},
        reference="definition, in NumPy with OpenCV Sobel",
        make_inputs=lambda g, s, dtype: cast(dtype, depth=_depth(g, s), camera_matrix=_image_camera(g, s)),
        picture="depth images",
    )
)
add(
    Spec(
        "geometry.depth.depth_warp",
        [
            TensorSpec("intrinsics_dst", ("B", 3, 3)),
            TensorSpec("extrinsics_dst", ("B", 4, 4)),
            TensorSpec("intrinsics_src", ("B", 3, 3)),
            TensorSpec("extrinsics_src", ("B", 4, 4)),
            TensorSpec("depth_src", ("B", 1, "H", "W"), layout="NCHW"),
            image("patch_dst"),
        ],
        [TensorSpec("output", layout="NCHW")],
        tolerances=_READ,
        gradient_tolerances=_READ_SUMS,
        reference="OpenCV projectPoints and remap",
        make_inputs=lambda g, s, dtype: cast(
            dtype,
            intrinsics_dst=_image_camera(g, s),
            extrinsics_dst=_motion(g, s["B"]),
            intrinsics_src=_image_camera(g, s),
            extrinsics_src=_motion(g, s["B"]),
            depth_src=_depth(g, s),
            patch_dst=uniform(g, 0.0, 1.0, s["B"], s["C"], s["H"], s["W"]),
        ),
        picture="depth images",
    )
)
add(
    Spec(
        "geometry.depth.warp_frame_depth",
        [
            image("image_src"),
            TensorSpec("depth_dst", ("B", 1, "H", "W"), layout="NCHW"),
            TensorSpec("src_trans_dst", ("B", 4, 4)),
            _MATRIX,
        ],
        [TensorSpec("output", layout="NCHW")],
        tolerances=_READ,
        gradient_tolerances=_READ_SUMS,
        reference="OpenCV projectPoints and remap",
        make_inputs=lambda g, s, dtype: cast(
            dtype,
            image_src=uniform(g, 0.0, 1.0, s["B"], s["C"], s["H"], s["W"]),
            depth_dst=_depth(g, s),
            src_trans_dst=_motion(g, s["B"]),
            camera_matrix=_image_camera(g, s),
        ),
        picture="depth images",
    )
)
