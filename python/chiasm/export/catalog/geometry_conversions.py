"""Geometry: conversions of angles, rotations, coordinates, homographies and poses."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import torch
from torch import Generator, Tensor

from ..peer import Peer, opencv
from ..spec import Maker, Spec, TensorSpec, Tolerance
from . import add
from .rigid import motions, normal, parts, pose, quaternions, rotations, scipys, uniform


def _spec(
    name: str,
    inputs: Mapping[str, tuple[tuple[int | str, ...], str]],
    outputs: Sequence[str] = ("output",),
    makers: Mapping[str, Maker] | None = None,
    reference: str = "closed form in NumPy",
    **more: Any,
):
    """A spec with inputs {name: (shape, description)}; `makers` {name: (generator, sizes) -> float64} where
    uniform values would not do."""

    def sample(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        return {key: make(generator, sizes).to(dtype) for key, make in (makers or {}).items()}

    add(
        Spec(
            f"geometry.conversions.{name}",
            [TensorSpec(key, shape, description=description) for key, (shape, description) in inputs.items()],
            [TensorSpec(output) for output in outputs],
            make_inputs=sample if makers else None,
            reference=reference,
            **more,
        )
    )


# --- rotations ----------------------------------------------------------------------------------------------

_KINDS: dict[str, tuple[tuple[int | str, ...], Maker, str]] = {
    "axis_angle": (("N", 3), lambda g, s: normal(g, s["N"], 3), "rotation vectors, angle in radians"),
    "quaternion": (("N", 4), lambda g, s: quaternions(g, s["N"]), "unit quaternions (w, x, y, z)"),
    "rotation_matrix": (("N", 3, 3), lambda g, s: rotations(g, s["N"]), "rotation matrices"),
}

_SCIPYS: dict[str, tuple[Callable[[Any, Any], Any], Callable[[Any], Any]]] = {
    "axis_angle": (lambda cls, x: cls.from_rotvec(x), lambda r: r.as_rotvec()),
    "quaternion": (
        lambda cls, x: cls.from_quat(x, scalar_first=True),
        lambda r: r.as_quat(scalar_first=True),
    ),
    "rotation_matrix": (lambda cls, x: cls.from_matrix(x), lambda r: r.as_matrix()),
}


def _canonical(q: np.ndarray) -> np.ndarray:
    """Of the two quaternions of each rotation that with w >= 0."""
    return np.where(q[:, :1] < 0, -q, q)


def _converted(source: str, target: str) -> Peer:
    read, write = _SCIPYS[source][0], _SCIPYS[target][1]
    return scipys(
        lambda transform, x: write(read(transform.Rotation, x)),
        after=_canonical if (source, target) == ("rotation_matrix", "quaternion") else None,
    )


for _source, (_shape, _maker, _about) in _KINDS.items():
    for _target in _KINDS:
        if _source != _target:
            _spec(
                f"{_source}_to_{_target}",
                {_source: (_shape, _about)},
                [_target],
                {_source: _maker},
                "SciPy Rotation; Eigen",
                peer=_converted(_source, _target),
                dtypes=(
                    ("float32", "float64")
                    if (_source, _target) == ("axis_angle", "rotation_matrix")
                    else ("float32",)
                ),
            )

_QUATERNION = {"quaternion": (("N", 4), "unit quaternions (w, x, y, z)")}
_spec(
    "normalize_quaternion",
    {"quaternion": (("N", 4), "quaternions (w, x, y, z)")},
    ["output"],
    {"quaternion": lambda g, s: 2 * quaternions(g, s["N"])},
    "torch.nn.functional.normalize",
    peer=Peer("torch.nn.functional", lambda F, x: F.normalize(x, dim=-1), "tensors"),
)
_spec(
    "quaternion_exp_to_log",
    _QUATERNION,
    makers={"quaternion": lambda g, s: quaternions(g, s["N"])},
    reference="SciPy Rotation",
)
_spec(
    "quaternion_log_to_exp",
    {"quaternion": (("N", 3), "half rotation vectors, in radians")},
    makers={"quaternion": lambda g, s: normal(g, s["N"], 3)},
    peer=scipys(lambda transform, v: transform.Rotation.from_rotvec(2 * v).as_quat(scalar_first=True)),
    reference="SciPy Rotation",
)
_spec("vector_to_skew_symmetric_matrix", {"vec": (("N", 3), "vectors")})


def _angles(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Away from half a turn and from gimbal lock."""
    n = sizes["N"]
    return {
        "roll": uniform(generator, -2.8, 2.8, n).to(dtype),
        "pitch": uniform(generator, -1.3, 1.3, n).to(dtype),
        "yaw": uniform(generator, -2.8, 2.8, n).to(dtype),
    }


def _quaternions_of_angles(
    generator: Generator, sizes: dict[str, int], dtype: torch.dtype
) -> dict[str, Tensor]:
    """Products of turns about z, y and x, in closed form."""
    half = {name: 0.5 * angle for name, angle in _angles(generator, sizes, torch.float64).items()}
    (cr, cp, cy), (sr, sp, sy) = (
        tuple(f(half[name]) for name in ("roll", "pitch", "yaw")) for f in (torch.cos, torch.sin)
    )
    parts = (
        cy * cp * cr + sy * sp * sr,
        cy * cp * sr - sy * sp * cr,
        cy * sp * cr + sy * cp * sr,
        sy * cp * cr - cy * sp * sr,
    )
    return {name: part.to(dtype) for name, part in zip("wxyz", parts, strict=True)}


add(
    Spec(
        "geometry.conversions.euler_from_quaternion",
        [TensorSpec(part, ("N",), description=f"{part} of unit quaternions") for part in "wxyz"],
        [TensorSpec(angle, description="in radians") for angle in ("roll", "pitch", "yaw")],
        make_inputs=_quaternions_of_angles,
        peer=scipys(
            lambda transform, q: transform.Rotation.from_quat(q, scalar_first=True).as_euler("xyz"),
            before=lambda w, x, y, z: (np.stack([w, x, y, z], -1),),
            after=lambda angles: tuple(angles.T),
        ),
        reference="SciPy Rotation",
    )
)
add(
    Spec(
        "geometry.conversions.quaternion_from_euler",
        [TensorSpec(angle, ("N",), description="in radians") for angle in ("roll", "pitch", "yaw")],
        [TensorSpec(part) for part in "wxyz"],
        make_inputs=_angles,
        peer=scipys(
            lambda transform, angles: transform.Rotation.from_euler("xyz", angles).as_quat(scalar_first=True),
            before=lambda roll, pitch, yaw: (np.stack([roll, pitch, yaw], -1),),
            after=lambda q: tuple(q.T),
        ),
        reference="SciPy Rotation",
    )
)

# --- angles -------------------------------------------------------------------------------------------------

for _name, _argument, _range, _peer in (
    ("deg2rad", "tensor", 180.0, Peer("numpy", lambda np, x: np.deg2rad(x), "batch")),
    ("rad2deg", "tensor", 3.0, Peer("numpy", lambda np, x: np.rad2deg(x), "batch")),
    (
        "angle_to_rotation_matrix",  # which turns the other way
        "angle",
        180.0,
        scipys(
            lambda transform, x: transform.Rotation.from_euler("z", x, degrees=True).as_matrix(),
            before=lambda x: (x[:, None],),
            after=lambda m: m[:, :2, :2].swapaxes(1, 2),
        ),
    ),
):
    _spec(
        _name,
        {_argument: (("N",), "angles in " + ("radians" if _name == "rad2deg" else "degrees"))},
        makers={_argument: lambda g, s, r=_range: uniform(g, -r, r, s["N"])},
        peer=_peer,
    )
_spec(
    "cart2pol",
    {"x": (("N",), "coordinate"), "y": (("N",), "coordinate")},
    ["rho", "phi"],
    {"x": lambda g, s: uniform(g, 0.2, 2.0, s["N"]), "y": lambda g, s: uniform(g, -2.0, 2.0, s["N"])},
    "torch abs and angle of complex numbers",
    peer=Peer("torch", lambda torch, z: (z.abs(), z.angle()), "tensors", before=lambda x, y: (x + 1j * y,)),
)
_spec(
    "pol2cart",
    {"rho": (("N",), "distance from the origin"), "phi": (("N",), "angle in radians")},
    ["x", "y"],
    {"rho": lambda g, s: uniform(g, 0.2, 2.0, s["N"]), "phi": lambda g, s: uniform(g, -3.0, 3.0, s["N"])},
    "torch.polar",
    peer=Peer(
        "torch", lambda torch, rho, phi: torch.polar(rho, phi), "tensors", after=lambda z: (z.real, z.imag)
    ),
)

# --- homogeneous coordinates --------------------------------------------------------------------------------


def _opencvs(function: str, dimensions: int) -> Peer:
    return opencv(
        lambda cv2, x: getattr(cv2, function)(x),
        "samples",
        after=lambda points: points[:, 0],
        sizes={"D": dimensions},
    )


_spec(
    "convert_points_to_homogeneous",
    {"points": (("B", "N", "D"), "points")},
    reference="OpenCV convertPointsToHomogeneous",
    peer=_opencvs("convertPointsToHomogeneous", 3),
    symbols={"D": (1, 64)},
)
_spec(
    "convert_points_from_homogeneous",
    {"points": (("B", "N", "D"), "points, the last coordinate the divisor")},
    makers={"points": lambda g, s: uniform(g, 0.5, 2.0, s["B"], s["N"], s["D"])},
    reference="OpenCV convertPointsFromHomogeneous",
    peer=_opencvs("convertPointsFromHomogeneous", 4),
    symbols={"D": (3, 64)},
)
_spec("convert_affinematrix_to_homography", {"A": (("B", 2, 3), "affine transforms")})
_spec("convert_affinematrix_to_homography3d", {"A": (("B", 3, 4), "affine transforms")})

# --- pixels -------------------------------------------------------------------------------------------------

_IMAGE, _VOLUME = {"height": 480, "width": 640}, {"depth": 64, "height": 96, "width": 128}


def _points(low: float, high: float, n: int) -> dict[str, Maker]:
    return {"pixel_coordinates": lambda g, s: uniform(g, low, high, s["N"], n)}


for _suffix, _sizes, _n in (("", _IMAGE, 2), ("3d", _VOLUME, 3)):
    _spec(
        f"normalize_pixel_coordinates{_suffix}",
        {"pixel_coordinates": (("N", _n), "in pixels")},
        makers=_points(0.0, 640.0, _n),
        config=_sizes,
    )
    _spec(
        f"denormalize_pixel_coordinates{_suffix}",
        {"pixel_coordinates": (("N", _n), "in [-1, 1]")},
        makers=_points(-1.0, 1.0, _n),
        config=_sizes,
        tolerances={"float32": Tolerance(2e-4, 1e-4)},
    )


def _intrinsics(generator: Generator, sizes: dict[str, int]):
    k = torch.zeros(sizes["B"], 3, 3, dtype=torch.float64)
    k[:, 0, 0], k[:, 1, 1], k[:, 2, 2] = (
        uniform(generator, 400.0, 600.0, sizes["B"]),
        uniform(generator, 400.0, 600.0, sizes["B"]),
        1.0,
    )
    k[:, :2, 2] = uniform(generator, 200.0, 300.0, sizes["B"], 2)
    return k


_spec(
    "normalize_points_with_intrinsics",
    {"point_2d": (("B", "N", 2), "in pixels"), "camera_matrix": (("B", 3, 3), "intrinsics")},
    makers={"point_2d": lambda g, s: uniform(g, 0.0, 500.0, s["B"], s["N"], 2), "camera_matrix": _intrinsics},
    reference="OpenCV undistortPoints without distortion",
    peer=opencv(lambda cv2, x, k: cv2.undistortPoints(x, k, None), "samples", after=lambda x: x[:, 0]),
)
_spec(
    "denormalize_points_with_intrinsics",
    {"point_2d_norm": (("B", "N", 2), "in the plane z = 1"), "camera_matrix": (("B", 3, 3), "intrinsics")},
    makers={
        "point_2d_norm": lambda g, s: uniform(g, -0.5, 0.5, s["B"], s["N"], 2),
        "camera_matrix": _intrinsics,
    },
    reference="OpenCV perspectiveTransform",
    peer=opencv(lambda cv2, x, k: cv2.perspectiveTransform(x[None], k)[0], "samples"),
    tolerances={"float32": Tolerance(2e-4, 1e-4)},
)

# --- homographies: the sizes are constants of the matrices that are multiplied ------------------------------

for _suffix, _n, _source, _target in (("", 3, (480, 640), (360, 800)), ("3d", 4, (32, 48, 64), (24, 36, 80))):
    for _name in (f"normalize_homography{_suffix}", f"denormalize_homography{_suffix}"):
        _spec(
            _name,
            {
                "dst_pix_trans_src_pix": (
                    ("B", _n, _n),
                    "from source to destination, " + ("normalised" if _name[0] == "d" else "in pixels"),
                )
            },
            config={"dsize_src": _source, "dsize_dst": _target},
            tolerances={
                "float32": Tolerance(1e-3, 1e-4)
            },  # sums of products with sizes, some of which cancel
            picture="maps of space" if _suffix else "maps of the plane",
        )

# --- poses --------------------------------------------------------------------------------------------------

_POSE = {"R": (("N", 3, 3), "rotation matrices"), "t": (("N", 3, 1), "translations")}
_POSES: dict[str, Maker] = {"R": lambda g, s: rotations(g, s["N"]), "t": lambda g, s: normal(g, s["N"], 3, 1)}
_TRANSFORM = "SciPy RigidTransform"


def _turned(transform: Any, motion: Any) -> Any:
    """Poses after a half turn of the camera about its x axis."""
    return motion * transform.RigidTransform.from_rotation(transform.Rotation.from_rotvec([np.pi, 0, 0]))


_spec(
    "Rt_to_matrix4x4",
    _POSE,
    ["extrinsics"],
    _POSES,
    _TRANSFORM,
    peer=scipys(lambda transform, r, t: pose(transform, r, t).as_matrix(), timed=False),
)
_OTHER_AXES = scipys(lambda transform, r, t: parts(_turned(transform, pose(transform, r, t))), timed=False)
_INVERSE = scipys(lambda transform, r, t: parts(pose(transform, r, t).inv()), timed=False)
for _name, _peer in (
    ("camtoworld_graphics_to_vision_Rt", _OTHER_AXES),
    ("camtoworld_vision_to_graphics_Rt", _OTHER_AXES),
    ("camtoworld_to_worldtocam_Rt", _INVERSE),
    ("worldtocam_to_camtoworld_Rt", _INVERSE),
):
    _spec(_name, _POSE, ["R_out", "t_out"], _POSES, _TRANSFORM, peer=_peer)
_OTHER_AXES_4X4 = scipys(
    lambda transform, m: _turned(transform, transform.RigidTransform.from_matrix(m)).as_matrix(), timed=False
)
for _name, _argument, _peer in (
    ("camtoworld_graphics_to_vision_4x4", "extrinsics_graphics", _OTHER_AXES_4X4),
    ("camtoworld_vision_to_graphics_4x4", "extrinsics_vision", _OTHER_AXES_4X4),
    (
        "matrix4x4_to_Rt",
        "extrinsics",
        scipys(lambda transform, m: parts(transform.RigidTransform.from_matrix(m)), timed=False),
    ),
):
    _spec(
        _name,
        {_argument: (("N", 4, 4), "poses [[R, t], [0, 1]]")},
        ["R", "t"] if _argument == "extrinsics" else ["output"],
        {_argument: lambda g, s: motions(g, rotations(g, s["N"]))},
        _TRANSFORM,
        peer=_peer,
    )


def _of_quaternions(convert: Callable[[Any, Any], Any]) -> Peer:
    """A conversion of poses as quaternions and translations."""

    def call(transform: Any, q: Any, t: Any) -> tuple[Any, Any]:
        rotation = transform.Rotation.from_quat(q, scalar_first=True)
        made = convert(transform, transform.RigidTransform.from_components(t[..., 0], rotation))
        return made.rotation.as_quat(scalar_first=True), made.translation[..., None]

    return scipys(call, after=lambda pose: (_canonical(pose[0]), pose[1]), timed=False)


for _name, _peer in (
    (
        "ARKitQTVecs_to_ColmapQTVecs",
        _of_quaternions(lambda transform, pose: _turned(transform, pose).inv()),
    ),
    (
        "ColmapQTVecs_to_ARKitQTVecs",
        _of_quaternions(lambda transform, pose: _turned(transform, pose.inv())),
    ),
):
    _spec(
        _name,
        {"qvec": (("N", 4), "unit quaternions (w, x, y, z)"), "tvec": (("N", 3, 1), "translations")},
        ["qvec_out", "tvec_out"],
        {"qvec": lambda g, s: quaternions(g, s["N"]), "tvec": _POSES["t"]},
        _TRANSFORM,
        peer=_peer,
    )
