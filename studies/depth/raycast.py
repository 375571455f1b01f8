"""Views of textured planes and balls, by casting rays: camera images, and the exact depth of every pixel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gallery.photographs import photograph

#: The rays along each side of a pixel, for its colour; its depth is that of the ray through its centre.
RAYS = 4


@dataclass(frozen=True)
class Board:
    """A rectangle with a photograph on it.

    corner: the upper left one; right, down: vectors from it to the next corners (3,).
    tiles: the number of photographs along it and down it.
    """

    photo: str
    corner: tuple[float, float, float]
    right: tuple[float, float, float]
    down: tuple[float, float, float]
    tiles: tuple[float, float] = (1.0, 1.0)

    def hit(self, origin: np.ndarray, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The distance of the surface along rays (..., 3), infinite if they miss it, and the photograph's
        coordinates there."""
        right, down = np.array(self.right), np.array(self.down)
        normal = np.cross(right, down)
        with np.errstate(divide="ignore", invalid="ignore"):
            t = ((self.corner - origin) @ normal) / (rays @ normal)
        at = origin + np.where(np.isfinite(t), t, 0)[..., None] * rays - self.corner
        # The sides need not be at right angles.
        gram = np.linalg.inv(np.array([[right @ right, right @ down], [right @ down, down @ down]]))
        along = np.stack([at @ right, at @ down], -1) @ gram
        inside = (t > 1e-6) & (along >= 0).all(-1) & (along <= 1).all(-1)
        return np.where(inside, t, np.inf), along[..., 0] * self.tiles[0], along[..., 1] * self.tiles[1]


@dataclass(frozen=True)
class Ball:
    """A ball with a photograph around it."""

    photo: str
    center: tuple[float, float, float]
    radius: float
    tiles: tuple[float, float] = (2.0, 1.0)

    def hit(self, origin: np.ndarray, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Like :meth:`Board.hit`."""
        away = origin - np.array(self.center)
        a, b, c = (rays * rays).sum(-1), rays @ away, away @ away - self.radius**2
        square = b * b - a * c
        t = np.where(square > 0, (-b - np.sqrt(np.maximum(square, 0))) / a, np.inf)
        t = np.where(t > 1e-6, t, np.inf)
        normal = (away + np.where(np.isfinite(t), t, 0)[..., None] * rays) / self.radius
        around = np.arctan2(normal[..., 0], -normal[..., 2]) / (2 * np.pi) + 0.25  # no seam in front
        height = np.arcsin(normal[..., 1].clip(-1, 1)) / np.pi + 0.5
        return t, around * self.tiles[0], height * self.tiles[1]


Surface = Board | Ball


def cast(
    surfaces: tuple[Surface, ...], origin: np.ndarray, rays: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The colours (..., 3), from 0 to 1, of the first surface on each ray (..., 3), and its distance along
    the ray (...)."""
    nearest = np.full(rays.shape[:-1], np.inf)
    colors = np.zeros((*rays.shape[:-1], 3))
    for surface in surfaces:
        t, x, y = surface.hit(origin, rays)
        first = t < nearest
        nearest[first] = t[first]
        colors[first] = texture(surface.photo, x[first], y[first])
    return colors, nearest


def texture(photo: str, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Colours (N, 3) of a photograph at coordinates (N,), which grow by 1 over its sides; every other tile is
    mirrored, to avoid seams."""
    pixels = photograph(photo) / 255.0
    height, width = pixels.shape[:2]
    u, v = (1 - np.abs(1 - x % 2)) * (width - 1), (1 - np.abs(1 - y % 2)) * (height - 1)
    left, top = np.minimum(u.astype(int), width - 2), np.minimum(v.astype(int), height - 2)
    fx, fy = (u - left)[:, None], (v - top)[:, None]
    upper = pixels[top, left] * (1 - fx) + pixels[top, left + 1] * fx
    lower = pixels[top + 1, left] * (1 - fx) + pixels[top + 1, left + 1] * fx
    return upper * (1 - fy) + lower * fy


def render(
    surfaces: tuple[Surface, ...], camera: np.ndarray, motion: np.ndarray, height: int, width: int
) -> tuple[np.ndarray, np.ndarray]:
    """Render a camera's view.

    Args:
        camera: (3, 3), in pixels.
        motion: (4, 4), from the scene's frame to the camera's.

    Returns:
        The image (height, width, 3), uint8, and the depth (height, width) at the pixels' centres.
    """
    rotation, origin = motion[:3, :3], -motion[:3, :3].T @ motion[:3, 3]

    def rays(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        pixels = np.stack(np.broadcast_arrays(x[None, :], y[:, None], 1.0), -1)
        return pixels @ np.linalg.inv(camera).T @ rotation  # with depth 1 in the camera's frame

    fine = (np.arange(RAYS) + 0.5) / RAYS - 0.5
    colors, _ = cast(
        surfaces,
        origin,
        rays((np.arange(width)[:, None] + fine).ravel(), (np.arange(height)[:, None] + fine).ravel()),
    )
    _, depth = cast(surfaces, origin, rays(np.arange(width, dtype=float), np.arange(height, dtype=float)))
    image = colors.reshape(height, RAYS, width, RAYS, 3).mean((1, 3))
    return (image * 255).round().astype(np.uint8), depth


def visible(
    surfaces: tuple[Surface, ...],
    points: np.ndarray,
    camera: np.ndarray,
    motion: np.ndarray,
    height: int,
    width: int,
) -> np.ndarray:
    """Whether a camera sees points (..., 3) of surfaces: they are not occluded, and inside the image."""
    rotation, shift = motion[:3, :3], motion[:3, 3]
    _, along = cast(surfaces, -rotation.T @ shift, points + rotation.T @ shift)
    seen = (points @ rotation.T + shift) @ camera.T
    x, y = seen[..., 0] / seen[..., 2], seen[..., 1] / seen[..., 2]
    # The distance along a ray to its point is 1: with less, another surface is in front of the point.
    return (
        (along > 1 - 1e-6) & (seen[..., 2] > 0) & (x >= 0) & (x <= width - 1) & (y >= 0) & (y <= height - 1)
    )
