"""Tensors other than images: the number of their items, and the items' kind."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch

from chiasm.export.spec import TensorSpec

from .model import Shown

POINTS = (
    "point",
    "pts",
    "pixel",
    "coord",
    "center",
    "grid",
    "rays",
    "corner",
    "x, y",
    "rho, phi",
    "where they go",
)
LINES = ("lines", "line", "perpendiculars")
#: Names of rotations and translations that form a pose.
POSES = (
    ("R", "t"),
    ("R1", "t1"),
    ("R2", "t2"),
    ("R_out", "t_out"),
    ("rmat", "tvec"),
    ("rotations", "translations"),
)
EPIPOLAR = ("Fm", "F_mat", "E_mat", "fundamental", "essential")
WEIGHTS = ("weights", "w", "scores")


@dataclass(frozen=True)
class Part:
    """An input or output, or several that are single numbers, as `items` (n, ...) of a kind:

    image: values on a grid (H, W); points, lines, values, flags: many in one part; quaternion, axis_angle,
    rotation, motion (in space), turn, move (in the plane), homography, epipolar (essential and fundamental
    matrices): drawn by their effect; numbers: anything else.
    """

    name: str
    items: np.ndarray
    kind: str
    given: bool

    @property
    def many(self) -> bool:
        return self.kind in ("points", "lines", "values", "flags", "image")


def parts(shown: Shown) -> list[Part]:
    """All tensors other than images, inputs first."""
    given = [
        (t.name, items_of(shown, shown.inputs[t.name], t), t.description)
        for t in shown.spec.inputs
        if not t.layout and t.dtype != "uint8"
    ]
    made = [
        (d["name"], items_of(shown, shown.outputs[d["name"]]), "") for d in shown.described if not d["layout"]
    ]
    first = [part_of(*g, True) for g in grouped(given)]
    like = "point" if any(p.kind in ("points", "lines") for p in first) else ""
    if any("quaternion" in f"{name} {about}" for name, _, about in given):
        like = like or "quaternion"
    if any(n in shown.spec.name for n in ("essential_from", "fundamental_from")):
        like = "fundamental"
    return posed(first) + posed([part_of(name, items, like, False) for name, items, _ in grouped(made)])


def posed(found: list[Part]) -> list[Part]:
    """Joins rotations and the translations after them to motions."""
    made: list[Part] = []
    for part in found:
        before = made[-1] if made else None
        if (
            before
            and before.kind == "rotation"
            and (before.name, part.name) in POSES
            and part.items.shape == (len(before.items), 3)
        ):
            poses = np.tile(np.eye(4, dtype=part.items.dtype), (len(part.items), 1, 1))
            poses[:, :3, :3], poses[:, :3, 3] = before.items, part.items
            made[-1] = Part(f"{before.name}, {part.name}", poses, "motion", part.given)
        else:
            made.append(part)
    return made


def items_of(shown: Shown, tensor: torch.Tensor, described: TensorSpec | None = None) -> np.ndarray:
    """(n, ...): the items of a single sample, or the samples of a batch."""
    sizes = {
        d: s
        for t in shown.spec.inputs
        for d, s in zip(t.shape, shown.inputs[t.name].shape, strict=True)
        if isinstance(d, str)
    }
    array, dims = tensor.numpy(), tuple(sizes.get(d, 0) for d in ("B", "N"))
    plane = tuple(sizes[d] for d in ("D", "H", "W") if d in sizes)
    if len(plane) > 1 and array.shape[1 : 1 + len(plane)] == plane:
        return array[0].reshape(-1, *array.shape[1 + len(plane) :])
    if len(plane) > 1 and array.shape[-len(plane) :] == plane:
        first = array.reshape(-1, *plane)[0]  # the first of several, such as a position's coordinates
        if len(plane) == 2:
            return first
        # If most voxels are 0, show the maximum of all slices
        return first.max(0) if np.median(first) == 0 else first[len(first) // 2]
    if array.ndim > 3 and min(array.shape[-2:]) > 16:
        return array.reshape(-1, *array.shape[-2:])[0]
    if array.ndim == 4 and len(array) == 1 and array.shape[-2:] in ((3, 3), (3, 1)):
        return array[0]
    if array.ndim == 4 and array.shape[-1] == 2:
        return np.moveaxis(array, -1, 1)
    if array.ndim > 1 and (
        array.shape[:2] == dims
        or (dims[0] == 1 and described is not None and is_pointed(described) and array.ndim == 3)
    ):
        return array[0]
    return array


def is_pointed(described: TensorSpec) -> bool:
    return any(word in f"{described.name} {described.description}" for word in POINTS)


def grouped(tensors: list[tuple[str, np.ndarray, str]]) -> list[tuple[str, np.ndarray, str]]:
    """Joins neighbours that are single numbers, unless they belong to adjacent vectors."""
    made: list[tuple[str, np.ndarray, str]] = []
    alone = any(array.ndim == 2 and array.shape[1] > 1 for _, array, _ in tensors)
    for name, array, about in tensors:
        if (
            joins(name, array)
            and not alone
            and made
            and (made[-1][1].ndim == 1 or ", " in made[-1][0])
            and len(made[-1][1]) == len(array)
        ):
            before = made.pop()
            made.append((f"{before[0]}, {name}", np.column_stack([before[1], array]), before[2]))
        else:
            made.append((name, array, about))
    return made


def joins(name: str, array: np.ndarray) -> bool:
    """Whether it has one number per item, and is not a weight or flag of other items."""
    return array.ndim == 1 and name not in WEIGHTS and array.dtype != bool


def part_of(name: str, items: np.ndarray, about: str, given: bool) -> Part:
    if items.ndim > 1 and items.shape[1:] == (1,):
        items = items[:, 0]
    if items.ndim == 3 and items.shape[2] == 1:
        items = items[..., 0]
    kind = kind_of(name, items, about)
    return Part(name, whole(items) if kind == "motion" and items.shape[1] == 3 else items, kind, given)


def kind_of(name: str, items: np.ndarray, about: str) -> str:
    shape = items.shape[1:]
    known = {(4,): "quaternion", (3,): "axis_angle"}
    if items.ndim == 2 and (min(items.shape) > 16 or (name == "depth" and items.shape[1] > 1)):
        return "image"
    if items.dtype == bool:
        return "flags"
    if shape == ():
        return "values"
    if shape == (4,) and ("quaternion" in f"{name} {about}" or name in ("qvec_out", "w, x, y, z")):
        return "quaternion"
    if name == known.get(shape):
        return name
    if shape == (3, 3) and (name in EPIPOLAR or about == "fundamental"):
        return "epipolar"
    if shape == (3, 3) and name == "homography":
        return "homography"
    if shape == (3,) and name in LINES:
        return "lines"
    if shape in ((2,), (3,)) and (
        any(word in f"{name} {about}" for word in POINTS) or name in ("X", "x1", "x2")
    ):
        return "points"
    if shape == (3, 4) and is_rigid(whole(items)):
        return "motion"
    if items.ndim == 3 and shape[0] == shape[1] and is_rigid(items):
        return {2: "turn", 3: "rotation", 4: "motion"}[shape[0]] if not is_move(items) else "move"
    return "numbers"


def whole(matrices: np.ndarray) -> np.ndarray:
    """(n, 3, 4) extended to (n, 4, 4)."""
    return np.concatenate([matrices, np.tile(np.eye(4, dtype=matrices.dtype)[3:], (len(matrices), 1, 1))], 1)


def is_rigid(matrices: np.ndarray) -> bool:
    """Whether all of (n, 2, 2), (n, 3, 3) or (n, 4, 4) are rotations or rigid motions."""
    size = matrices.shape[1]
    upper = matrices[:, :-1, :-1] if size == 4 or is_move(matrices) else matrices
    square = upper @ upper.transpose(0, 2, 1)
    last = np.eye(size)[-1]
    straight = size < 4 or np.allclose(matrices[:, -1], last, atol=1e-4)
    return (
        size <= 4
        and straight
        and np.allclose(square, np.eye(upper.shape[1]), atol=1e-3)
        and bool((np.linalg.det(upper) > 0).all())
    )


def is_move(matrices: np.ndarray) -> bool:
    """Whether (n, 3, 3) are rigid motions in the plane, at least one with a translation."""
    if matrices.shape[1:] != (3, 3) or not np.allclose(matrices[:, 2], [0, 0, 1], atol=1e-4):
        return False
    upper = matrices[:, :2, :2]
    return np.abs(matrices[:, :2, 2]).max() > 1e-3 and np.allclose(
        upper @ upper.transpose(0, 2, 1), np.eye(2), atol=1e-3
    )
