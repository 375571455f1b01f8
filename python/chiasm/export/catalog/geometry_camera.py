"""Cameras: projection, lens distortion, depth maps, and homographies of views."""

import torch
from torch import Generator, Tensor

from ..spec import Sampler, Spec, TensorSpec, Tolerance, image, like
from . import add
from .rigid import linalg, uniform

_DOUBLE = torch.float64


def _camera_matrices(generator: Generator, count: int):
    """Focal lengths about 500, principal point about (320, 240)."""
    focal, centre = (
        uniform(generator, 450, 550, count, 2),
        uniform(generator, -10, 10, count, 2) + torch.tensor([320.0, 240.0]),
    )
    matrix = torch.eye(3, dtype=_DOUBLE).repeat(count, 1, 1)
    matrix[:, 0, 0], matrix[:, 1, 1], matrix[:, :2, 2] = focal[:, 0], focal[:, 1], centre
    return matrix


def _cast(dtype: torch.dtype, **tensors: Tensor):
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

for _name in ("project_points_z1", "dx_project_points_z1", "project_points_orthographic"):
    add(
        Spec(
            f"geometry.camera.{_name}",
            [_SPACE],
            sample=lambda g, s, dtype: _cast(dtype, points_in_camera=_points_in_front(g, s["N"])),
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
add(
    Spec(
        "geometry.camera.project_points",
        [TensorSpec("point_3d", ("N", 3)), _CAMERA_MATRIX],
        [TensorSpec("pixels")],
        dtypes=("float32", "float64"),
        tolerances=_PIXELS,
        sample=lambda g, s, dtype: _cast(
            dtype, point_3d=_points_in_front(g, s["N"]), camera_matrix=_camera_matrices(g, s["N"])
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
        sample=lambda g, s, dtype: _cast(
            dtype,
            point_2d=uniform(g, 0, 480, s["N"], 2),
            depth=uniform(g, 1, 5, s["N"], 1),
            camera_matrix=_camera_matrices(g, s["N"]),
        ),
        reference="the inverse of OpenCV projectPoints",
    )
)


def _proper_inverse_intrinsics(generator: Generator, count: int):
    matrix = torch.eye(4, dtype=_DOUBLE).repeat(count, 1, 1)
    matrix[:, :3, :3] = linalg.inv(_camera_matrices(generator, count))
    return matrix


def _sample_pixel2cam(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    b, h, w = sizes["B"], sizes["H"], sizes["W"]
    row, column = torch.meshgrid(
        torch.arange(h, dtype=_DOUBLE), torch.arange(w, dtype=_DOUBLE), indexing="ij"
    )
    grid = torch.stack([column, row, torch.ones_like(row)], -1).repeat(b, 1, 1, 1)
    return _cast(
        dtype,
        depth=uniform(generator, 1, 5, b, 1, h, w),
        intrinsics_inv=_proper_inverse_intrinsics(generator, b),
        pixel_coords=grid,
    )


def _sample_cam2pixel(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    b, h, w = sizes["B"], sizes["H"], sizes["W"]
    points = _points_in_front(generator, b * h * w).reshape(b, h, w, 3)
    projection = torch.eye(4, dtype=_DOUBLE).repeat(b, 1, 1)
    projection[:, :3, :3] = _camera_matrices(generator, b)
    projection[:, :3, 3] = uniform(generator, -1, 1, b, 3)
    return _cast(dtype, cam_coords_src=points, dst_proj_src=projection)


add(
    Spec(
        "geometry.camera.cam2pixel",
        [TensorSpec("cam_coords_src", ("B", "H", "W", 3)), TensorSpec("dst_proj_src", ("B", 4, 4))],
        [TensorSpec("pixels")],
        tolerances=_PIXELS,
        gradient_tolerances={"float32": Tolerance(1e-3, 1e-3)},
        sample=_sample_cam2pixel,
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
        sample=_sample_pixel2cam,
        reference="definition",
    )
)

# --- distortion ---------------------------------------------------------------------------------------------


def _pinhole_params(generator: Generator, count: int):
    m = _camera_matrices(generator, count)
    return torch.stack([m[:, 0, 0], m[:, 1, 1], m[:, 0, 2], m[:, 1, 2]], -1)


def _fisheye_params(generator: Generator, count: int):
    return torch.cat([_pinhole_params(generator, count), uniform(generator, -0.02, 0.02, count, 4)], -1)


def _lens_params(model: str, generator: Generator, count: int):
    return _pinhole_params(generator, count) if model == "affine" else _fisheye_params(generator, count)


def _sampler_of_params(model: str, points: str, low: float, high: float) -> Sampler:
    return lambda g, s, dtype: _cast(
        dtype, **{points: uniform(g, low, high, s["N"], 2), "params": _lens_params(model, g, s["N"])}
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
                reference=_reference,
                sample=_sampler_of_params(_model, "projected_points_in_camera_z1_plane", -0.8, 0.8),
            )
        )
    add(
        Spec(
            f"geometry.camera.undistort_points_{_model}",
            [
                TensorSpec("distorted_points_in_camera", ("N", 2), range=(50, 450), description="pixels"),
                _params,
            ],
            sample=_sampler_of_params(_model, "distorted_points_in_camera", 50, 450),
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


def _sampler_of_lens(size: int) -> Sampler:
    return lambda g, s, dtype: _cast(
        dtype,
        points=uniform(g, 0, 1, s["B"], s["N"], 2) * torch.tensor([640.0, 480.0]),
        K=_camera_matrices(g, s["B"]),
        dist=_distortion(g, s["B"], size),
        new_K=_camera_matrices(g, s["B"]),
    )


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
                sample=_sampler_of_lens(_size),
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


def _sample_undistort_image(
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
    return _cast(
        dtype,
        image=uniform(generator, 0.0, 1.0, b, sizes["C"], h, w),
        K=camera,
        dist=_distortion(generator, b, 5),
    )


add(
    Spec(
        "geometry.calibration.undistort_image",
        [image("image"), _K, TensorSpec("dist", ("B", 5), description="k1, k2, p1, p2, k3")],
        [TensorSpec("output", layout="NCHW")],
        # weights amplify the rounding of coordinates by the contrast, and the gradients by K and dist are
        # sums over all pixels
        tolerances={"float32": Tolerance(1e-3, 1e-3)},
        gradient_tolerances={"float32": Tolerance(5e-2, 2e-3)},
        sample=_sample_undistort_image,
        reference="OpenCV undistort",
        picture="depth images",
    )
)

# --- depth --------------------------------------------------------------------------------------------------


def _image_camera(generator: Generator, sizes: dict[str, int], size: int = 3):
    """A camera whose principal point is near the image's middle."""
    b, h, w = sizes["B"], sizes["H"], sizes["W"]
    matrix = torch.eye(size, dtype=_DOUBLE).repeat(b, 1, 1)
    matrix[:, 0, 0] = matrix[:, 1, 1] = 30.0 + uniform(generator, 0, 5, b)
    matrix[:, 0, 2], matrix[:, 1, 2] = (
        0.5 * w + uniform(generator, 0.0, 1.0, b),
        0.5 * h + uniform(generator, 0.0, 1.0, b),
    )
    return matrix


def _depth(generator: Generator, sizes: dict[str, int]):
    """A slanted, bumpy surface."""
    b, h, w = sizes["B"], sizes["H"], sizes["W"]
    row, column = torch.arange(h, dtype=_DOUBLE)[:, None], torch.arange(w, dtype=_DOUBLE)
    return (
        3.0
        + 0.01 * row
        + 0.02 * column
        + 0.1 * torch.sin(0.5 * column)
        + uniform(generator, 0, 0.1, b, 1, h, w)
    )


def _motion(generator: Generator, batch: int):
    """A small turn and shift."""
    turn = torch.zeros((batch, 4, 4), dtype=_DOUBLE)
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
        sample=lambda g, s, dtype: _cast(
            dtype,
            plane_normals=uniform(g, -0.2, 0.2, s["B"], 3) + torch.tensor([0.0, 0.0, 1.0]),
            plane_offsets=uniform(g, 2, 5, s["B"], 1),
            points_uv=uniform(g, 100, 400, s["B"], s["N"], 2),
            camera_matrix=_camera_matrices(g, s["B"]),
        ),
        reference="definition",
    )
)
for _unit in (False, True):
    add(
        Spec(
            f"geometry.depth.depth_to_3d{'.unit_rays' if _unit else ''}",
            [_DEPTH, _MATRIX],
            [TensorSpec("points", layout="NCHW")],
            config={"normalize_points": _unit},
            gradient_tolerances=_SUMS,
            reference="definition",
            sample=lambda g, s, dtype: _cast(dtype, depth=_depth(g, s), camera_matrix=_image_camera(g, s)),
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
        reference="definition",
        sample=lambda g, s, dtype: _cast(dtype, depth=_depth(g, s)[:, 0], camera_matrix=_image_camera(g, s)),
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
        reference="definition",
        sample=lambda g, s, dtype: {
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
        sample=lambda g, s, dtype: _cast(dtype, depth=_depth(g, s), camera_matrix=_image_camera(g, s)),
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
        sample=lambda g, s, dtype: _cast(
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
        sample=lambda g, s, dtype: _cast(
            dtype,
            image_src=uniform(g, 0.0, 1.0, s["B"], s["C"], s["H"], s["W"]),
            depth_dst=_depth(g, s),
            src_trans_dst=_motion(g, s["B"]),
            camera_matrix=_image_camera(g, s),
        ),
        picture="depth images",
    )
)
