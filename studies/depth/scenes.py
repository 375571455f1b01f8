"""The scenes whose depth is computed: a photographed stereo pair of a motorcycle, and a rendered room. Both
have true depth."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import torch
from PIL import Image
from torch import Tensor

from gallery.photographs import DATA, photograph

from . import raycast
from .raycast import Ball, Board
from .settings import Settings

#: The calibration of the stereo pair in its original size, from the documentation of
#: skimage.data.stereo_motorcycle (Middlebury 2014): the focal length, the left camera's principal point and
#: the offset of the right camera's to the right, in pixels; the distance between the cameras in metres.
FOCAL, CENTER, OFFSET, BASELINE = 994.978, (311.193, 254.877), 31.086, 0.193001
#: A wall, a floor, a leaning picture and two balls; metres, x right, y down, z away from the reference.
ROOM = (
    Board("coffee.png", (-5.0, -3.2, 6.5), (10.0, 0.0, -1.0), (0.0, 5.0, 0.0), (1.5, 1.0)),
    Board("gravel.png", (-5.0, 1.3, 6.8), (10.0, 0.0, 0.0), (0.0, 0.0, -6.8), (3.0, 2.0)),
    Board("astronaut.png", (-2.6, -1.4, 4.9), (1.9, 0.15, -0.9), (0.1, 2.6, 0.3)),
    Ball("chelsea.png", (0.15, 0.55, 3.4), 0.75),
    Ball("brick.png", (1.55, -0.35, 4.3), 0.7),
)
#: Rotations (degrees about x, y, z) and positions (metres) of the cameras other than the reference.
MOVES = (((0.6, 1.5, -0.8), (-0.22, 0.05, 0.04)), ((-0.8, -1.8, 1.0), (0.2, -0.06, -0.05)))


@dataclass(frozen=True)
class Scene:
    """Calibrated views of a scene, the reference first, and the truth of the reference.

    images: (B, 3, H, W), from 0 to 1; cameras: (B, 3, 3); motions: (B, 4, 4), from the reference's frame to
    each camera's. limits: (2,), the smallest and the greatest inverse depth of the search. depth: (H, W),
    metres, NaN if unknown. seen: (H, W), whether a known pixel is visible in every view.
    """

    name: str
    images: Tensor
    cameras: Tensor
    motions: Tensor
    limits: Tensor
    depth: np.ndarray
    seen: np.ndarray


def room(settings: Settings) -> Scene:
    """Views of a room. Rays from each camera to the points that the reference sees show whether every camera
    sees them."""
    width, height = settings.room_size
    camera = np.array([[0.9 * width, 0, (width - 1) / 2], [0, 0.9 * width, (height - 1) / 2], [0, 0, 1.0]])
    motions = [np.eye(4), *(motion(turn, place) for turn, place in MOVES)]
    images, depths = zip(*(raycast.render(ROOM, camera, m, height, width) for m in motions), strict=True)
    y, x = np.indices((height, width))
    points = np.stack([x, y, np.ones_like(x)], -1) @ np.linalg.inv(camera).T * depths[0][..., None]
    seen = np.logical_and.reduce(
        [raycast.visible(ROOM, points, camera, m, height, width) for m in motions[1:]]
    )
    return _scene("room", list(images), [camera] * len(motions), motions, settings, depths[0], seen)


def motion(turn: tuple[float, float, float], place: tuple[float, float, float]) -> np.ndarray:
    """The motion (4, 4) from the scene's frame to that of a camera with a rotation (degrees, axis times
    angle) and a position."""
    rotation = cv2.Rodrigues(np.radians(turn))[0].T
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = rotation, -rotation @ place
    return made


def motorcycle(settings: Settings) -> Scene:
    """The stereo pair, reduced; the left photograph is the reference."""
    width, height = settings.motorcycle_size
    full = photograph("motorcycle_left.png").shape
    sx, sy = width / full[1], height / full[0]
    images = [
        cv2.resize(photograph(f"motorcycle_{side}.png"), (width, height), interpolation=cv2.INTER_AREA)
        for side in ("left", "right")
    ]
    cameras = []
    for offset in (0.0, OFFSET):
        x, y = CENTER[0] + offset, CENTER[1]
        cameras.append(
            np.array(
                [[FOCAL * sx, 0, (x + 0.5) * sx - 0.5], [0, FOCAL * sy, (y + 0.5) * sy - 0.5], [0, 0, 1]]
            )
        )
    with np.load(DATA / "motorcycle_disp.npz") as data:
        disparity = data["arr_0"].astype(np.float64)
    disparity = nearest(np.where(np.isfinite(disparity), disparity, np.nan), width, height)
    depth = BASELINE * FOCAL / (disparity + OFFSET)
    right = np.eye(4)
    right[0, 3] = -BASELINE
    return _scene(
        "motorcycle", images, cameras, [np.eye(4), right], settings, depth, in_the_right_view(disparity * sx)
    )


def nearest(values: np.ndarray, width: int, height: int) -> np.ndarray:
    """The values of an array (H, W) at the centres of fewer pixels, without averaging: means across edges
    would be depths of no surface."""
    rows = ((np.arange(height) + 0.5) * values.shape[0] / height).astype(int)
    columns = ((np.arange(width) + 0.5) * values.shape[1] / width).astype(int)
    return values[np.ix_(rows, columns)]


def in_the_right_view(disparity: np.ndarray) -> np.ndarray:
    """Whether the right view sees the pixels of a left view (H, W): their positions are inside it, and no
    surface there is nearer by more than a pixel of disparity."""
    height, width = disparity.shape
    y, x = np.indices(disparity.shape)
    known = np.isfinite(disparity)
    at = x - np.where(known, disparity, 0)
    inside = known & (at >= 0) & (at <= width - 1)
    front = np.full((height, width), -np.inf)
    for column in (np.floor(at), np.ceil(at)):
        np.maximum.at(front, (y[inside], column[inside].astype(int)), disparity[inside])
    place = np.where(inside, at.round(), 0).astype(int)
    return inside & (np.where(known, disparity, 0) >= front[y, place] - 1)


def save(scene: Scene, settings: Settings, folder: Path) -> None:
    """Write the C++ program's input: the views as pictures, the rest as scene.json."""
    folder.mkdir(parents=True, exist_ok=True)
    files = [f"view{i}.png" for i in range(len(scene.images))]
    for file, image in zip(files, scene.images, strict=True):
        Image.fromarray(pixels(image)).save(folder / file)
    described = {name: getattr(scene, name).tolist() for name in ("cameras", "motions", "limits")}
    wanted = {name: getattr(settings, name) for name in ("scales", "iterations", "rate")}
    (folder / "scene.json").write_text(json.dumps({"views": files} | described | wanted))


def pixels(image: Tensor) -> np.ndarray:
    """An image (3, H, W) from 0 to 1 as bytes (H, W, 3)."""
    return (image.permute(1, 2, 0).numpy() * 255).round().clip(0, 255).astype(np.uint8)


def _scene(
    name: str,
    images: list,
    cameras: list,
    motions: list,
    settings: Settings,
    depth: np.ndarray,
    seen: np.ndarray,
) -> Scene:
    stacked = torch.from_numpy(np.stack(images)).permute(0, 3, 1, 2).contiguous().float() / 255
    near, far = settings.depths
    return Scene(
        name,
        stacked,
        _floats(np.stack(cameras)),
        _floats(np.stack(motions)),
        torch.tensor([1 / far, 1 / near]),
        depth,
        seen,
    )


def _floats(array: np.ndarray) -> Tensor:
    return torch.from_numpy(array).float().contiguous()
