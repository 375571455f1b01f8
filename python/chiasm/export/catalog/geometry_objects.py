"""Geometry: quaternions, Lie groups, boxes, fitted lines and planes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
import torch
from torch import Generator, Tensor

from ..peer import Peer
from ..spec import InputMaker, Maker, Spec, TensorSpec, Tolerance
from . import add
from .rigid import lengths, motions, normal, quaternions, rotations, rotations2d, scipys, uniform


def _inputs_by(makers: Mapping[str, Maker]) -> InputMaker:
    return lambda generator, sizes, dtype: {
        key: make(generator, sizes).to(dtype) for key, make in makers.items()
    }


# --- quaternions --------------------------------------------------------------------------------------------

_Q = ("N", 4)


def _of_length(power: int) -> Callable[..., tuple[Any, ...]]:
    """Quaternions, and the length that SciPy does not keep: the product of theirs to a power."""

    def before(*quaternions: np.ndarray) -> tuple[Any, ...]:
        return (
            *quaternions,
            np.prod([np.linalg.norm(q, axis=-1, keepdims=True) for q in quaternions], 0) ** power,
        )

    return before


def _inverted(transform: Any, q: Any, length: Any) -> Any:
    return transform.Rotation.from_quat(q, scalar_first=True).inv().as_quat(scalar_first=True) * length


def _multiplied(transform: Any, p: Any, q: Any, length: Any) -> Any:
    first, second = (transform.Rotation.from_quat(x, scalar_first=True) for x in (p, q))
    return (first * second).as_quat(scalar_first=True) * length


for _name, _arguments, _peer in (
    ("quaternion_multiply", ("q1", "q2"), scipys(_multiplied, before=_of_length(1))),
    ("quaternion_conjugate", ("quaternion",), scipys(_inverted, before=_of_length(1))),
    ("quaternion_inverse", ("quaternion",), scipys(_inverted, before=_of_length(-1))),
):
    add(
        Spec(
            f"geometry.quaternion.{_name}",
            [TensorSpec(argument, _Q, description="quaternions (w, x, y, z)") for argument in _arguments],
            make_inputs=_inputs_by(
                {argument: lambda g, s: 1.5 * quaternions(g, s["N"]) for argument in _arguments}
            ),
            peer=_peer,
            reference="SciPy Rotation",
        )
    )
add(
    Spec(
        "geometry.quaternion.quaternion_rotate",
        [
            TensorSpec("quaternion", _Q, description="unit quaternions (w, x, y, z)"),
            TensorSpec("points", ("N", 3), description="points"),
        ],
        make_inputs=_inputs_by(
            {"quaternion": lambda g, s: quaternions(g, s["N"]), "points": lambda g, s: normal(g, s["N"], 3)}
        ),
        peer=scipys(lambda transform, q, x: transform.Rotation.from_quat(q, scalar_first=True).apply(x)),
        reference="SciPy Rotation",
    )
)


def _unit(q: Tensor) -> Tensor:
    return q / lengths(q)


def _near(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Pairs of rotations well below half a turn apart, because the shorter arc changes at half a turn."""
    q1 = quaternions(generator, sizes["N"])
    q2 = _unit(q1 + uniform(generator, -0.4, 0.4, sizes["N"], 4))
    return {"q1": q1.to(dtype), "q2": q2.to(dtype), "t": uniform(generator, 0.0, 1.0, sizes["N"]).to(dtype)}


add(
    Spec(
        "geometry.quaternion.quaternion_slerp",
        [
            TensorSpec("q1", _Q, description="quaternions (w, x, y, z)"),
            TensorSpec("q2", _Q, description="quaternions (w, x, y, z)"),
            TensorSpec("t", ("N",), range=(0.0, 1.0), description="0 is q1, 1 is q2"),
        ],
        make_inputs=_near,
        peer=Peer(
            "scipy.spatial.transform",
            lambda transform, a, b, t: transform.Slerp(
                [0, 1], transform.Rotation.from_quat([a, b], scalar_first=True)
            )(t).as_quat(scalar_first=True),
            "samples",
            timed=False,
        ),
        reference="SciPy Slerp",
    )
)


def _clusters(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Rotations near a common one, with w away from 0, where the sign changes."""
    centre = torch.tensor([1.0, -0.5, 0.3, 0.8], dtype=torch.float64)
    q = _unit(centre + 0.3 * normal(generator, sizes["B"], sizes["N"], 4))
    return {"Q": q.to(dtype), "w": uniform(generator, 0.5, 1.5, sizes["B"], sizes["N"]).to(dtype)}


add(
    Spec(
        "geometry.quaternion.average_quaternions",
        [
            TensorSpec("Q", ("B", "N", 4), description="unit quaternions (w, x, y, z)"),
            TensorSpec("w", ("B", "N"), range=(0.5, 1.5), description="weights"),
        ],
        make_inputs=_clusters,
        peer=Peer(
            "scipy.spatial.transform",
            lambda transform, q, w: transform.Rotation.from_quat(q, scalar_first=True).mean(w),
            "samples",
            after=lambda r: r.as_quat(canonical=True, scalar_first=True),
        ),
        reference="NumPy eigh in float64",
        picture="mean rotation",
    )
)

# --- Lie groups ---------------------------------------------------------------------------------------------

_Elements: TypeAlias = Callable[[Generator, int], Tensor]
_GROUPS: dict[str, tuple[tuple[int | str, ...], _Elements, int, _Elements]] = {
    "so2": (("N",), lambda g, n: uniform(g, -2.8, 2.8, n), 2, lambda g, n: rotations2d(g, n)),
    "so3": (("N", 3), lambda g, n: normal(g, n, 3), 3, lambda g, n: rotations(g, n)),
    "se2": (
        ("N", 3),
        lambda g, n: torch.cat([normal(g, n, 2), uniform(g, -2.8, 2.8, n, 1)], -1),
        3,
        lambda g, n: motions(g, rotations2d(g, n)),
    ),
    "se3": (("N", 6), lambda g, n: normal(g, n, 6), 4, lambda g, n: motions(g, rotations(g, n))),
}

_LAST_ONE = np.outer([0, 0, 1], [0, 0, 1])


def _plane_hats(v: np.ndarray) -> tuple[np.ndarray]:
    made = np.zeros((len(v), 3, 3))
    made[:, :2, 2], made[:, 0, 1], made[:, 1, 0] = v[:, :2], -v[:, 2], v[:, 2]
    return (made,)


_PEERS = {
    "se2_exp": Peer("scipy.linalg", lambda linalg, v: linalg.expm(v), "batch", before=_plane_hats),
    "se2_log": Peer(
        "scipy.linalg",
        lambda linalg, m: linalg.logm(m),
        "samples",
        after=lambda m: np.array([m[0, 2], m[1, 2], m[1, 0]]),
        timed=False,
    ),
    "so2_exp": scipys(
        lambda transform, a: transform.Rotation.from_euler("z", a).as_matrix(),
        before=lambda a: (a[:, None],),
        after=lambda m: m[:, :2, :2],
    ),
    "so2_log": scipys(
        lambda transform, m: transform.Rotation.from_matrix(m).as_rotvec(),
        before=lambda m: (np.pad(m, ((0, 0), (0, 1), (0, 1))) + _LAST_ONE,),
        after=lambda v: v[:, 2],
    ),
    "so3_exp": scipys(lambda transform, v: transform.Rotation.from_rotvec(v).as_matrix()),
    "so3_log": scipys(lambda transform, m: transform.Rotation.from_matrix(m).as_rotvec()),
    # SciPy has the rotation first
    "se3_exp": scipys(
        lambda transform, v: transform.RigidTransform.from_exp_coords(v).as_matrix(),
        before=lambda v: (np.roll(v, 3, -1),),
        timed=False,
    ),
    "se3_log": scipys(
        lambda transform, m: transform.RigidTransform.from_matrix(m).as_exp_coords(),
        after=lambda v: np.roll(v, 3, -1),
        timed=False,
    ),
}
_OF_TANGENTS = {"exp": "matrix", "hat": "matrix", "left_jacobian": "jacobian", "right_jacobian": "jacobian"}
_OF_MATRICES = {"log": "tangent", "vee": "tangent", "adjoint": "adjoint"}

for _group, (_shape, _tangents, _size, _elements) in _GROUPS.items():
    _plane = _group[-1] == "2"
    for _name, _output in (_OF_TANGENTS | _OF_MATRICES).items():
        if _name in _OF_TANGENTS:
            _argument, _dims, _make = "theta" if _group == "so2" else "v", _shape, _tangents
            _about = "angles in radians" if _group == "so2" else "tangent vectors, angles in radians"
        else:
            _argument = "omega" if _name == "vee" else "rotation" if _group[1] == "o" else "motion"
            _dims, _make, _about = (
                ("N", _size, _size),
                _elements,
                "skew-symmetric where it rotates" if _name == "vee" else "elements of the group",
            )
        add(
            Spec(
                f"geometry.lie.{_group}_{_name}",
                [TensorSpec(_argument, _dims, description=_about)],
                [TensorSpec(_output)],
                gradients=() if _group == "so2" and _output in ("jacobian", "adjoint") else None,  # constant
                make_inputs=_inputs_by({_argument: lambda g, s, make=_make: make(g, s["N"])}),
                peer=_PEERS.get(f"{_group}_{_name}"),
                reference="SciPy expm, logm",
            )
        )

# --- boxes --------------------------------------------------------------------------------------------------

_STARTS2, _STARTS3 = (
    ("x_start", "y_start", "width", "height"),
    (
        "x_start",
        "y_start",
        "z_start",
        "width",
        "height",
        "depth",
    ),
)
_PICTURES = {"": "boxes", "3d": "boxes in space"}
for _suffix, _arguments in (("", _STARTS2), ("3d", _STARTS3)):
    add(
        Spec(
            f"geometry.bbox.bbox_generator{_suffix}",
            [
                TensorSpec(argument, ("B",), range=(1.0, 50.0), description="in pixels")
                for argument in _arguments
            ],
            [TensorSpec("boxes")],
            reference="definition in NumPy",
            picture=_PICTURES[_suffix],
        )
    )


def _boxes(generator: Generator, count: int, axes: int):
    """Corners (count, 4, 2) or (count, 8, 3) of boxes along the axes, not on whole pixels."""
    low = uniform(generator, -5.0, 40.0, count, axes)
    high = low + uniform(generator, 2.0, 30.0, count, axes)
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    return torch.stack(
        [torch.where(torch.tensor(corner[:axes]) == 1, high, low) for corner in corners[: 4 * (axes - 1)]], 1
    )


_CORNERS = {"": (4, 2), "3d": (8, 3)}
_MASKS = {"": {"width": 64, "height": 48}, "3d": {"size": (24, 32, 40)}}
for _suffix, (_corners, _axes) in _CORNERS.items():
    _input = TensorSpec("boxes", ("B", _corners, _axes), description="corners, clockwise from the top left")
    _made = _inputs_by({"boxes": lambda g, s, axes=_axes: _boxes(g, s["B"], axes)})
    _shape_outputs = [TensorSpec(name) for name in ("depths", "heights", "widths")[3 - _axes :]]
    add(
        Spec(
            f"geometry.bbox.bbox_to_mask{_suffix}",
            [_input],
            [TensorSpec("mask")],
            config=_MASKS[_suffix],
            gradients=(),
            make_inputs=_made,
            special_values="ONNX Runtime passes NaN over in minima and maxima",
            reference="definition in NumPy",
            picture=_PICTURES[_suffix],
        )
    )
    add(
        Spec(
            f"geometry.bbox.infer_bbox_shape{_suffix}",
            [_input],
            _shape_outputs,
            make_inputs=_made,
            reference="definition in NumPy",
            picture=_PICTURES[_suffix],
        )
    )
    add(
        Spec(
            f"geometry.bbox.is_bbox{_suffix}",
            [_input],
            [TensorSpec("valid")],
            gradients=(),
            make_inputs=_made,
            reference="definition in NumPy",
            picture=_PICTURES[_suffix],
        )
    )


def _transforms(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    scale = torch.tensor([[0.2, 0.2, 5.0], [0.2, 0.2, 5.0], [1e-3, 1e-3, 0.0]], dtype=torch.float64)
    matrix = torch.eye(3, dtype=torch.float64) + uniform(generator, -1.0, 1.0, sizes["B"], 3, 3) * scale
    return {
        "trans_mat": matrix.to(dtype),
        "boxes": (
            _boxes(generator, sizes["B"] * sizes["N"], 2)[:, 0::2]
            .reshape(sizes["B"], sizes["N"], 4)
            .to(dtype)
        ),
    }


for _mode in ("xyxy", "xywh"):
    add(
        Spec(
            f"geometry.bbox.transform_bbox.{_mode}",
            [
                TensorSpec("trans_mat", ("B", 3, 3), description="homographies"),
                TensorSpec("boxes", ("B", "N", 4), description=_mode),
            ],
            [TensorSpec("boxes_out")],
            config={"mode": _mode},
            tolerances={"float32": Tolerance(1e-3, 1e-4)},
            make_inputs=_transforms,
            reference="OpenCV perspectiveTransform",
            picture="boxes",
        ),
        fn="geometry.bbox.transform_bbox",
    )


def _scored(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Boxes in clusters, so that there is something to suppress."""
    centre = uniform(generator, 0.0, 100.0, sizes["N"] // 3 + 1, 2).repeat_interleave(3, 0)[: sizes["N"]]
    half = uniform(generator, 4.0, 12.0, sizes["N"], 2)
    return {
        "boxes": torch.cat([centre - half, centre + half], -1).to(dtype),
        "scores": uniform(generator, 0.0, 1.0, sizes["N"]).to(dtype),
    }


def _suppressed(ops: Any, boxes: Tensor, scores: Tensor) -> tuple[Tensor, ...]:
    order = scores.argsort(descending=True)
    return order, torch.isin(order, ops.nms(boxes, scores, 0.3))


add(
    Spec(
        "geometry.bbox.nms_fixed",
        [
            TensorSpec("boxes", ("N", 4), description="x1, y1, x2, y2"),
            TensorSpec("scores", ("N",), range=(0.0, 1.0), description="scores"),
        ],
        [TensorSpec("order"), TensorSpec("kept")],
        config={"iou_threshold": 0.3},
        symbols={"N": (1, 16384)},  # all pairs are compared
        gradients=(),
        make_inputs=_scored,
        peer=Peer("torchvision.ops", _suppressed, "tensors"),
        reference="torchvision.ops.nms; a loop in NumPy",
        picture="boxes",
    )
)

# --- fits ---------------------------------------------------------------------------------------------------


def _scattered(extent: Sequence[float]) -> InputMaker:
    """Points about the mean, spread along the axes by `extent` and then sheared a little: no eigenvalue is
    near another."""
    shear = torch.eye(len(extent), dtype=torch.float64) + 0.3 * torch.ones(
        len(extent), len(extent), dtype=torch.float64
    ).triu(1)

    def sample(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        points = uniform(generator, -1.0, 1.0, sizes["B"], sizes["N"], len(extent)) * torch.tensor(
            extent, dtype=torch.float64
        )
        return {
            "points": (points @ shear + 2.0).to(dtype),
            "weights": uniform(generator, 0.5, 1.5, sizes["B"], sizes["N"]).to(dtype),
        }

    return sample


for _name, _extent, _outputs in (
    ("line.fit_line", (5.0, 0.4), ("origin", "direction")),
    ("line.fit_line", (5.0, 0.4, 0.2), ("origin", "direction")),
    ("plane.fit_plane", (5.0, 3.0, 0.2), ("normal", "offset")),
):
    add(
        Spec(
            f"geometry.{_name}.points{len(_extent)}d",
            [
                TensorSpec("points", ("B", "N", len(_extent)), description="points"),
                TensorSpec("weights", ("B", "N"), range=(0.5, 1.5), description="weights"),
            ],
            [TensorSpec(output) for output in _outputs],
            symbols={"N": (len(_extent), 1 << 20)},
            tolerances={"float32": Tolerance(1e-4, 1e-4)},
            make_inputs=_scattered(_extent),
            reference="NumPy SVD in float64",
            picture="fitted lines and planes",
        ),
        fn=f"geometry.{_name}",
    )
