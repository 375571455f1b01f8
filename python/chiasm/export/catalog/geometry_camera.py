"""Cameras: projection and lens distortion."""

from typing import Any

import numpy as np
import torch
from torch import Generator, Tensor

from ..peer import NEAR_BYTES, Peer, opencv
from ..spec import PIXELS, Frames, InputMaker, Spec, TensorSpec, Tolerance, image
from . import add
from .rigid import linalg, uniform

_DOUBLE = torch.float64


def camera_matrices(generator: Generator, count: int):
    """Focal lengths about 500, principal point about (320, 240)."""
    focal, centre = (
        uniform(generator, 450, 550, count, 2),
        uniform(generator, -10, 10, count, 2) + torch.tensor([320.0, 240.0]),
    )
    matrix = torch.eye(3, dtype=_DOUBLE).repeat(count, 1, 1)
    matrix[:, 0, 0], matrix[:, 1, 1], matrix[:, :2, 2] = focal[:, 0], focal[:, 1], centre
    return matrix


def cast(dtype: torch.dtype, **tensors: Tensor):
    return {name: value.to(dtype) for name, value in tensors.items()}


def _points_in_front(generator: Generator, count: int):
    return torch.cat([uniform(generator, -2, 2, count, 2), uniform(generator, 2, 6, count, 1)], -1)


_CAMERA_MATRIX = TensorSpec("camera_matrix", ("N", 3, 3), description="camera matrices")
_SPACE = TensorSpec("points_in_camera", ("N", 3), description="points in the camera's frame")
_PLANE = TensorSpec(
    "projected_points_in_camera_z1_plane",
    ("N", 2),
    range=(-0.8, 0.8),
    description="points of the plane z = 1",
)
# pixels are about 500, of which float32 keeps 3e-5
_PIXELS = {"float32": Tolerance(5e-4, 1e-5)}

# --- points and pixels --------------------------------------------------------------------------------------

_PERSPECTIVE = opencv(
    lambda cv2, x: cv2.convertPointsFromHomogeneous(x), "batch", after=lambda points: points[:, 0]
)
for _name in ("project_points_z1", "dx_project_points_z1", "project_points_orthographic"):
    add(
        Spec(
            f"geometry.camera.{_name}",
            [_SPACE],
            make_inputs=lambda g, s, dtype: cast(dtype, points_in_camera=_points_in_front(g, s["N"])),
            peer=_PERSPECTIVE if _name == "project_points_z1" else None,
            reference="definition; R. Hartley, A. Zisserman, Multiple View Geometry, 6.1",
        )
    )
add(Spec("geometry.camera.dx_project_points_orthographic", [_SPACE], gradients=(), reference="definition"))
add(
    Spec(
        "geometry.camera.unproject_points_z1",
        [
            TensorSpec("points_in_cam_canonical", ("N", 2), range=(-1, 1)),
            TensorSpec("extension", ("N",), range=(1, 5), description="depths"),
        ],
        [TensorSpec("points")],
        reference="definition",
    )
)
add(
    Spec(
        "geometry.camera.unproject_points_orthographic",
        [
            TensorSpec("points_in_camera", ("N", 2), range=(-1, 1)),
            TensorSpec("extension", ("N",), range=(1, 5), description="depths"),
        ],
        [TensorSpec("points")],
        reference="definition",
    )
)
_NO_TURN = np.zeros(3)
add(
    Spec(
        "geometry.camera.project_points",
        [TensorSpec("point_3d", ("N", 3)), _CAMERA_MATRIX],
        [TensorSpec("pixels")],
        dtypes=("float32", "float64"),
        tolerances=_PIXELS,
        make_inputs=lambda g, s, dtype: cast(
            dtype, point_3d=_points_in_front(g, s["N"]), camera_matrix=camera_matrices(g, s["N"])
        ),
        peer=opencv(
            lambda cv2, x, k: cv2.projectPoints(x, _NO_TURN, _NO_TURN, k, None)[0],
            "samples",
            after=lambda pixels: pixels[0, 0],
            timed=False,
        ),
        reference="OpenCV projectPoints",
    )
)
add(
    Spec(
        "geometry.camera.unproject_points",
        [
            TensorSpec("point_2d", ("N", 2), description="pixels"),
            TensorSpec("depth", ("N", 1)),
            _CAMERA_MATRIX,
        ],
        [TensorSpec("points")],
        make_inputs=lambda g, s, dtype: cast(
            dtype,
            point_2d=uniform(g, 0, 480, s["N"], 2),
            depth=uniform(g, 1, 5, s["N"], 1),
            camera_matrix=camera_matrices(g, s["N"]),
        ),
        reference="the inverse of OpenCV projectPoints",
    )
)


def _proper_inverse_intrinsics(generator: Generator, count: int):
    matrix = torch.eye(4, dtype=_DOUBLE).repeat(count, 1, 1)
    matrix[:, :3, :3] = linalg.inv(camera_matrices(generator, count))
    return matrix


def _make_pixel2cam(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    b, h, w = sizes["B"], sizes["H"], sizes["W"]
    row, column = torch.meshgrid(
        torch.arange(h, dtype=_DOUBLE), torch.arange(w, dtype=_DOUBLE), indexing="ij"
    )
    grid = torch.stack([column, row, torch.ones_like(row)], -1).repeat(b, 1, 1, 1)
    return cast(
        dtype,
        depth=uniform(generator, 1, 5, b, 1, h, w),
        intrinsics_inv=_proper_inverse_intrinsics(generator, b),
        pixel_coords=grid,
    )


def _make_cam2pixel(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    b, h, w = sizes["B"], sizes["H"], sizes["W"]
    points = _points_in_front(generator, b * h * w).reshape(b, h, w, 3)
    projection = torch.eye(4, dtype=_DOUBLE).repeat(b, 1, 1)
    projection[:, :3, :3] = camera_matrices(generator, b)
    projection[:, :3, 3] = uniform(generator, -1, 1, b, 3)
    return cast(dtype, cam_coords_src=points, dst_proj_src=projection)


add(
    Spec(
        "geometry.camera.cam2pixel",
        [TensorSpec("cam_coords_src", ("B", "H", "W", 3)), TensorSpec("dst_proj_src", ("B", 4, 4))],
        [TensorSpec("pixels")],
        tolerances=_PIXELS,
        gradient_tolerances={"float32": Tolerance(1e-3, 1e-3)},
        make_inputs=_make_cam2pixel,
        peer=opencv(
            lambda cv2, x, k, t: cv2.projectPoints(x.reshape(-1, 3), _NO_TURN, t, k, None)[0].reshape(
                *x.shape[:2], 2
            ),
            "samples",
            before=lambda x, p: (x, p[:3, :3], np.linalg.solve(p[:3, :3], p[:3, 3])),
        ),
        reference="definition",
    )
)
add(
    Spec(
        "geometry.camera.pixel2cam",
        [
            TensorSpec("depth", ("B", 1, "H", "W")),
            TensorSpec("intrinsics_inv", ("B", 4, 4)),
            TensorSpec("pixel_coords", ("B", "H", "W", 3)),
        ],
        [TensorSpec("points")],
        gradient_tolerances={"float32": Tolerance(2e-2, 1e-4)},
        make_inputs=_make_pixel2cam,
        reference="definition",
    )
)

# --- distortion ---------------------------------------------------------------------------------------------


def _pinhole_params(generator: Generator, count: int):
    m = camera_matrices(generator, count)
    return torch.stack([m[:, 0, 0], m[:, 1, 1], m[:, 0, 2], m[:, 1, 2]], -1)


def _fisheye_params(generator: Generator, count: int):
    return torch.cat([_pinhole_params(generator, count), uniform(generator, -0.02, 0.02, count, 4)], -1)


def _lens_params(model: str, generator: Generator, count: int):
    return _pinhole_params(generator, count) if model == "affine" else _fisheye_params(generator, count)


def _inputs_of_params(model: str, points: str, low: float, high: float) -> InputMaker:
    return lambda g, s, dtype: cast(
        dtype, **{points: uniform(g, low, high, s["N"], 2), "params": _lens_params(model, g, s["N"])}
    )


def _fisheye(p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Parameters as OpenCV's camera matrix and coefficients."""
    return np.array([[p[0], 0, p[2]], [0, p[1], p[3]], [0, 0, 1]]), p[4:]


def _fisheye_peer(function: str) -> Peer:
    def call(cv2: Any, point: np.ndarray, k: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
        return getattr(cv2.fisheye, function)(point, k, coefficients)

    return opencv(
        call,
        "samples",
        before=lambda point, p: (point[None, None], *_fisheye(p)),
        after=lambda points: points[0, 0],
        timed=False,
    )


for _model, _size, _reference in (
    ("affine", 4, "definition"),
    ("kannala_brandt", 8, "OpenCV fisheye::distortPoints, undistortPoints"),
):
    _params = TensorSpec(
        "params", ("N", _size), description="fx, fy, cx, cy" + (", k1, k2, k3, k4" if _size == 8 else "")
    )
    for _prefix in ("", "dx_"):
        add(
            Spec(
                f"geometry.camera.{_prefix}distort_points_{_model}",
                [_PLANE, _params],
                tolerances=_PIXELS,
                peer=_fisheye_peer("distortPoints") if (_prefix, _size) == ("", 8) else None,
                reference=_reference,
                make_inputs=_inputs_of_params(_model, "projected_points_in_camera_z1_plane", -0.8, 0.8),
            )
        )
    add(
        Spec(
            f"geometry.camera.undistort_points_{_model}",
            [
                TensorSpec("distorted_points_in_camera", ("N", 2), range=(50, 450), description="pixels"),
                _params,
            ],
            make_inputs=_inputs_of_params(_model, "distorted_points_in_camera", 50, 450),
            peer=_fisheye_peer("undistortPoints") if _size == 8 else None,
            reference=_reference,
        )
    )

# k1, k2, p1, p2, k3, k4, k5, k6, s1 to s4, tilt: a wide lens on a tilted sensor
_STRENGTH = torch.tensor(
    [0.2, 0.05, 2e-3, 2e-3, 0.01, 0.05, 0.02, 0.01, 2e-3, 1e-3, 2e-3, 1e-3, 0.02, 0.02], dtype=_DOUBLE
)
_K = TensorSpec("K", ("B", 3, 3), description="camera matrix of the distorted image")


def _distortion(generator: Generator, batch: int, size: int):
    return uniform(generator, -1, 1, batch, 14)[:, :size] * _STRENGTH[:size]


def _inputs_of_lens(size: int) -> InputMaker:
    return lambda g, s, dtype: cast(
        dtype,
        points=uniform(g, 0, 1, s["B"], s["N"], 2) * torch.tensor([640.0, 480.0]),
        K=camera_matrices(g, s["B"]),
        dist=_distortion(g, s["B"], size),
        new_K=camera_matrices(g, s["B"]),
    )


def _rays(points: np.ndarray, k: np.ndarray) -> np.ndarray:
    """Points of the plane z = 1 that a camera without distortion sees there."""
    homogeneous = np.column_stack([points, np.ones(len(points))])
    return np.linalg.solve(k[None], homogeneous[..., None])[..., 0]


_EXACTLY = (3, 200, 1e-14)  # OpenCV's criteria: at most so many steps, until the change is so small
_LENS_PEERS = {
    "distort_points": opencv(
        lambda cv2, rays, k, dist: cv2.projectPoints(rays, _NO_TURN, _NO_TURN, k, dist)[0],
        "samples",
        before=lambda x, k, dist, new: (_rays(x, new), k, dist),
        after=lambda points: points[:, 0],
    ),
    "undistort_points": opencv(
        lambda cv2, x, k, dist, new: cv2.undistortPoints(x, k, dist, None, None, new, _EXACTLY),
        "samples",
        after=lambda points: points[:, 0],
    ),
}
for _size in (4, 5, 8, 12, 14):
    _inputs = [
        TensorSpec("points", ("B", "N", 2), description="pixels"),
        _K,
        TensorSpec("dist", ("B", _size), description="distortion coefficients as OpenCV orders them"),
        TensorSpec("new_K", ("B", 3, 3), description="camera matrix of the undistorted image"),
    ]
    for _name in ("distort_points", "undistort_points"):
        add(
            Spec(
                f"geometry.calibration.{_name}.{_size}",
                _inputs,
                tolerances=_PIXELS,
                gradient_tolerances={"float32": Tolerance(5e-3, 1e-3)},  # sums over points of pixels
                make_inputs=_inputs_of_lens(_size),
                peer=_LENS_PEERS[_name],
                reference="OpenCV projectPoints, undistortPoints",
            ),
            fn=f"geometry.calibration.{_name}",
        )

add(
    Spec(
        "geometry.calibration.tilt_projection",
        [
            TensorSpec("taux", ("N", 1), range=(-0.3, 0.3), description="radians"),
            TensorSpec("tauy", ("N", 1), range=(-0.3, 0.3), description="radians"),
        ],
        [TensorSpec("homography")],
        reference="OpenCV's documentation of calib3d",
    )
)


def _make_undistort_image(
    generator: Generator, sizes: dict[str, int], dtype: torch.dtype
) -> dict[str, Tensor]:
    b, h, w = sizes["B"], sizes["H"], sizes["W"]
    camera = torch.eye(3, dtype=_DOUBLE).repeat(b, 1, 1)
    camera[:, 0, 0], camera[:, 1, 1], camera[:, 0, 2], camera[:, 1, 2] = (
        0.9 * w,
        1.1 * h,
        0.5 * w - 0.3,
        0.5 * h - 0.7,
    )
    return cast(
        dtype,
        image=uniform(generator, 0.0, 1.0, b, sizes["C"], h, w),
        K=camera,
        dist=_distortion(generator, b, 5),
    )


def _undistorted(cv2: Any, x: np.ndarray, k: np.ndarray, dist: np.ndarray) -> np.ndarray:
    size = x.shape[1::-1]
    maps = cv2.initUndistortRectifyMap(k, dist, None, k, size, cv2.CV_32FC1)
    return cv2.remap(x, *maps, cv2.INTER_LINEAR)


add(
    Spec(
        "geometry.calibration.undistort_image",
        [image("image"), _K, TensorSpec("dist", ("B", 5), description="k1, k2, p1, p2, k3")],
        [TensorSpec("output", layout="NCHW")],
        # weights amplify the rounding of coordinates by the contrast, and the gradients by K and dist are
        # sums over all pixels
        tolerances={"float32": Tolerance(1e-3, 1e-3)},
        gradient_tolerances={"float32": Tolerance(5e-2, 2e-3)},
        make_inputs=_make_undistort_image,
        peer=opencv(_undistorted, atol=1e-3, share=1e-3, sizes={"C": 3}),
        reference="OpenCV undistort",
        picture="depth images",
        frames=Frames(PIXELS, peer=opencv(_undistorted, atol=NEAR_BYTES, share=2e-3, sizes={"C": 3})),
    )
)
