"""Telling inputs for the geometry: mild warps of the photographs, a ball before a wall for depth, boxes in a volume."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn import functional

from chiasm.export.spec import Spec
from chiasm.geometry import calibration, conversions, lie, transform

Inputs = dict[str, Tensor]
#: Sizes by the beginning of an op's name: how many points, samples, boxes.
COUNTS = {
    "geometry.bbox": {"B": 4},
    "geometry.bbox.transform_bbox": {"B": 1, "N": 4},
    "geometry.calibration.distort_points": {"N": 15 * 12},
    "geometry.calibration.undistort_points": {"N": 15 * 12},
    "geometry.camera.cam2pixel": {"H": 12, "W": 16},
    "geometry.camera.distort_points": {"N": 15 * 12},
    "geometry.camera.pixel2cam": {"H": 12, "W": 16},
    "geometry.camera.undistort_points": {"N": 15 * 12},
    "geometry.conversions.convert_points": {"D": 2},
    "geometry.depth.unproject_meshgrid": {"H": 12, "W": 16},
    "geometry.depth.depth_from_plane": {"N": 15 * 12},
    "geometry.epipolar": {"N": 10},
    "geometry.epipolar.find_fundamental_7point": {"N": 1},
    "geometry.homography": {"N": 10},
    "geometry.homography.sample_is_valid": {"N": 3},
    "geometry.linalg": {"N": 12},
    "geometry.linalg.transform_points.plane": {"N": 9 * 9},
    "geometry.quaternion.quaternion_slerp": {"N": 3},
    "geometry.solvers": {"N": 3, "K": 1},
    "geometry.solvers.find_affine": {"N": 24},
    "geometry.transform.warp_grid": {"H": 9, "W": 12},
    "geometry.transform.warp_grid3d": {"D": 4, "H": 5, "W": 6},
    "geometry.transform.warp_points_tps": {"N": 11 * 11},
}
#: Ops whose photographs get a lattice.
WARPED = tuple(f"geometry.{name}" for name in (
    "depth.depth_warp", "depth.warp_frame_depth", "transform.affine", "transform.crop_by_transform_mat", "transform.elastic", "transform.homography_warp",
    "transform.remap", "transform.rotate", "transform.scale", "transform.shear", "transform.translate", "transform.warp",
))
#: The depth of a photograph's volume; its other sides are a third of the photograph's.
DEPTH, SHARE = 12, 3
#: Coefficients of a lens as OpenCV orders them: radial and tangential, rational, prisms, tilt.
LENS = [-0.24, 0.06, 0.004, -0.003, -0.01, 0.02, 0.01, 0.005, 0.02, 0.01, -0.02, 0.01, 0.05, -0.04]
#: Corners from the upper left clockwise, of a box the front's first.
FACE = torch.tensor([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
BOX = torch.cat([torch.cat([FACE, torch.full((4, 1), z)], 1) for z in (0.0, 1.0)])


def counts(spec: Spec) -> dict[str, int]:
    """What the table says of an op's sizes; longer names win."""
    known = [name for name in COUNTS if spec.name.startswith(name)]
    return {symbol: size for name in sorted(known, key=len) for symbol, size in COUNTS[name].items()}


@dataclass(frozen=True)
class Setting:
    """What inputs are made for: the op, the sizes of its dimensions, photographs (B, 3, H, W)."""

    spec: Spec
    sizes: dict[str, int]
    rgb: Tensor

    @property
    def width(self) -> int:
        return self.rgb.shape[-1]

    @property
    def height(self) -> int:
        return self.rgb.shape[-2]

    def shape(self, name: str) -> tuple[int | str, ...]:
        """The shape of an input as the spec has it; () where the op has none of that name."""
        return next((tuple(t.shape) for t in self.spec.inputs if t.name == name), ())

    def repeated(self, values: Tensor) -> Tensor:
        """For every entry of the batch."""
        batch = self.sizes.get("B", 1)
        return values.float().expand(batch, *values.shape).contiguous()


def geometric(spec: Spec, sizes: dict[str, int], rgb: Tensor) -> Inputs:
    """Inputs of an op, as far as there are more telling ones than its sampler's."""
    setting = Setting(spec, sizes, rgb)
    known = sorted((name for name in MAKERS if spec.name.startswith(name)), key=len)
    made = {key: value for name in known for key, value in MAKERS[name](setting).items()}
    return {t.name: made[t.name] for t in spec.inputs if t.name in made}


# --- the plane ---------------------------------------------------------------------------------------------------------


def lattice(rgb: Tensor, steps: int = 8) -> Tensor:
    """Photographs with regular lines drawn on them, which show how they are warped."""
    h, w = rgb.shape[-2:]
    step = w / steps
    y, x = torch.arange(h)[:, None] + 0.5 * step, torch.arange(w) + 0.5 * step  # none at the borders, which some warps repeat
    thick = max(1.0, w / 200)
    lines = ((x % step) < thick) | ((y % step) < thick)
    return torch.where(lines, rgb * 0.25 + 0.75 * torch.tensor([1.0, 0.95, 0.35]).view(3, 1, 1), rgb)


def planar(s: Setting) -> Inputs:
    """Transforms of images, in pixels."""
    w, h = s.width, s.height
    affine = torch.tensor([[0.75, -0.28, 0.22 * w], [0.24, 0.7, 0.02 * h]])
    homography = torch.tensor([[0.72, -0.16, 0.14 * w], [0.12, 0.68, 0.02 * h], [0.12 / w, -0.1 / h, 1.0]])
    made = {
        "M": homography if s.shape("M")[1:] == (3, 3) else affine,
        "matrix": affine,
        "transform": homography,
        "src_homo_dst": torch.tensor([[1.0, 0.25, 0.1], [-0.2, 1.1, 0.0], [0.15, 0.25, 1.0]]),
        "center": torch.tensor([0.5 * w, 0.45 * h]),
        "max_radius": torch.tensor(0.55 * h),
        "translations": torch.tensor([0.12 * w, -0.1 * h]),
        "boxes": quadrilateral(w, h),
        "src_box": quadrilateral(w, h),
        "rmat": motion((0.0, 0.0, 0.0), (15.0, 40.0, 10.0))[:3, :3],
        "tvec": torch.tensor([[1.0], [-0.5], [2.0]]),
        "points_src": quadrilateral(w, h),
        "points_dst": FACE * torch.tensor([w - 1.0, h - 1.0]),
        "dst_box": FACE * torch.tensor([s.sizes.get("OW", 9) - 1.0, s.sizes.get("OH", 9) - 1.0]),
    }
    made = {name: s.repeated(value) for name, value in made.items()}
    coarse = torch.rand((1, 2, 5, 7), generator=torch.Generator().manual_seed(3)) * 0.3 - 0.15
    made["noise"] = functional.interpolate(coarse, (h, w), mode="bicubic").expand(s.sizes.get("B", 1), -1, -1, -1).contiguous()
    return made | ripples(s) | {"grid": mesh(s.sizes.get("W", 2), s.sizes.get("H", 2)).expand(s.sizes.get("B", 1), -1, -1, -1).contiguous()}


def quadrilateral(w: int, h: int) -> Tensor:
    """Four corners about the middle of an image, in perspective."""
    return torch.tensor([[0.22, 0.12], [0.7, 0.04], [0.85, 0.8], [0.3, 0.92]]) * torch.tensor([w, h])


def mesh(w: int, h: int) -> Tensor:
    """(h, w, 2), from -1 to 1."""
    y, x = torch.meshgrid(torch.linspace(-1, 1, h), torch.linspace(-1, 1, w), indexing="ij")
    return torch.stack([x, y], -1)


def ripples(s: Setting) -> Inputs:
    """Maps that are twisted about the middle; those in pixels also leave the image a little."""
    x, y = mesh(s.sizes.get("OW", 2), s.sizes.get("OH", 2)).unbind(-1)
    twist = 0.9 * torch.exp(-2.5 * (x * x + y * y))
    u, v = 1.08 * (x * twist.cos() - y * twist.sin()), 1.08 * (x * twist.sin() + y * twist.cos())
    if s.spec.config.get("normalized_coordinates"):
        return {"map_x": s.repeated(u), "map_y": s.repeated(v)}
    return {"map_x": s.repeated((u + 1) / 2 * (s.width - 1)), "map_y": s.repeated((v + 1) / 2 * (s.height - 1))}


def whole_box(s: Setting) -> Inputs:
    low, high = (torch.tensor([s.width, s.height]) * share for share in (0.3, 0.68))
    corners = (low + FACE * (high - low)).round().long()
    return {"src_box": corners.expand(s.sizes["B"], 4, 2).contiguous()}


def splines(s: Setting) -> Inputs:
    """Eight points, of which the inner ones move."""
    ends = torch.tensor([[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9], [-0.35, -0.3], [0.35, -0.35], [0.4, 0.35], [-0.3, 0.35]])
    moved = ends + torch.tensor([[0.0, 0.0]] * 4 + [[0.2, -0.15], [0.15, 0.2], [-0.2, 0.15], [-0.15, -0.2]])
    if s.shape("points_src") == ("B", 6, 2):
        return {"points_src": s.repeated(ends[1:7]), "points_dst": s.repeated(moved[1:7])}
    kernel, affine = transform.get_tps_transform(ends[None], moved[None])
    side = math.isqrt(s.sizes.get("N", 1))
    made = {"kernel_centers": moved, "kernel_weights": kernel[0], "affine_weights": affine[0], "points_src": mesh(side, side).flatten(0, 1)}
    return {name: s.repeated(value) for name, value in made.items()}


# --- volumes -----------------------------------------------------------------------------------------------------------


def volume_sizes(spec: Spec, height: int, width: int) -> dict[str, int]:
    """Sizes of the volumes, where there are any."""
    if not any(t.layout == "NCDHW" for t in spec.inputs):
        return {}
    d, h, w = DEPTH, height // SHARE, width // SHARE
    return {"D": d, "H": h, "W": w, "OD": d, "OH": h, "OW": w}


def solid(rgb: Tensor) -> Tensor:
    """A barrel filled with the photographs and a lattice, (B, 3, D, H, W)."""
    h, w = rgb.shape[-2] // SHARE, rgb.shape[-1] // SHARE
    small = functional.interpolate(lattice(rgb, 5), (h, w), mode="bilinear", antialias=True).clamp(0, 1)
    z, y, x = torch.meshgrid(torch.linspace(-1, 1, DEPTH), torch.linspace(-1, 1, h), torch.linspace(-1, 1, w), indexing="ij")
    inside = (x.abs() ** 4 + y.abs() ** 4) < (1.1 - 0.4 * z.abs()) ** 4
    return torch.where(inside, small[:, :, None], torch.full_like(z, 0.1)).contiguous()


def spatial(s: Setting) -> Inputs:
    """Transforms of volumes, in voxels; without a volume, of a box of 24 x 16 x 12 voxels."""
    d, h, w = (s.sizes.get(n, default) for n, default in (("D", 12), ("H", 16), ("W", 24)))
    size = torch.tensor([w, h, d], dtype=torch.float32)
    center, angles, scales = (size - 1) / 2, torch.tensor([1.0, 2.0, 28.0]), torch.tensor([0.85, 0.85, 0.9])
    affine = transform.get_projective_transform(center[None], angles[None], scales[None])[0]
    turn = transform.get_projective_transform(torch.zeros(1, 3), torch.tensor([[0.0, 0.0, -28.0]]), torch.tensor([[1.2, 1.2, 1.1]]))[0]
    last = torch.tensor([[0.0, 0.0, 0.0, 1.0]])
    bent = BOX + torch.tensor([[0.1, 0.1, 0.0], [-0.1, 0.0, 0.0], [0.0, -0.1, 0.0], [0.0, 0.0, 0.0]]).repeat(2, 1)
    out = torch.tensor([s.sizes.get(n, default) - 1.0 for n, default in (("OW", 25), ("OH", 17), ("OD", 13))])
    made = {
        "M": torch.cat([affine, last + torch.tensor([0.006, 0.0, 0.0, 0.0])]) if s.shape("M")[1:] == (4, 4) else affine,
        "matrix": affine,
        "transform": torch.cat([affine, last]),
        "src_homo_dst": torch.cat([turn, last + torch.tensor([0.25, 0.0, 0.0, 0.0])]),
        "boxes": (0.2 + 0.6 * bent) * size,
        "src_box": (0.2 + 0.6 * bent) * size,
        "dst_box": BOX * out,
        "center": center,
        "angles": angles,
        "scale": scales,
        "scales": scales,
        "translations": torch.tensor([4.0, -3.0, 2.0]),
        "sxy": torch.tensor(0.25), "sxz": torch.tensor(0.0), "syx": torch.tensor(-0.15),
        "syz": torch.tensor(0.0), "szx": torch.tensor(0.3), "szy": torch.tensor(0.0),
        "yaw": torch.tensor(1.0), "pitch": torch.tensor(2.0), "roll": torch.tensor(28.0),
    }
    if s.shape("src") == ("B", 8, 3):
        made |= {"src": bent * size, "dst": (0.2 + 0.6 * BOX) * size}
    grid = torch.stack(torch.meshgrid(*(torch.linspace(-1, 1, s.sizes.get(n, 2)) for n in "DHW"), indexing="ij")[::-1], -1)
    return {name: s.repeated(value) for name, value in made.items()} | {"grid": s.repeated(grid)}


# --- cameras and depth -------------------------------------------------------------------------------------------------


def relief(h: int, w: int) -> Tensor:
    """Depths (h, w) of a ball before a wall that leans."""
    grid = mesh(w, h) * torch.tensor([w / h, 1.0])
    x, y = grid.unbind(-1)
    wall = 5.0 + 0.5 * x - 0.4 * y
    height = (0.55 - (x + 0.1) ** 2 - (y - 0.05) ** 2).clamp(min=0)
    return torch.where(height > 0, 4.0 - 1.6 * height.sqrt(), wall)


def camera_of(h: int, w: int) -> Tensor:
    return torch.tensor([[0.9 * w, 0.0, 0.5 * (w - 1)], [0.0, 0.9 * w, 0.5 * (h - 1)], [0.0, 0.0, 1.0]])


def motion(shift: tuple[float, float, float], turn: tuple[float, float, float]) -> Tensor:
    """(4, 4) of a rotation vector in degrees."""
    made = torch.eye(4)
    made[:3, :3] = conversions.axis_angle_to_rotation_matrix(torch.deg2rad(torch.tensor([turn])))[0]
    made[:3, 3] = torch.tensor(shift)
    return made


def depths(s: Setting) -> Inputs:
    h, w = s.sizes.get("H", s.height), s.sizes.get("W", s.width)
    depth, camera, still = relief(h, w), camera_of(h, w), torch.eye(4)
    moved = motion((0.4, -0.1, 0.3), (0.0, -6.0, 4.0))
    shape = (1, h, w) if 1 in s.shape("depth") + s.shape("depth_src") + s.shape("depth_dst") else (h, w)
    made = {
        "depth": depth.reshape(shape), "depth_src": depth[None], "depth_dst": depth[None], "disparity": 100.0 / depth[None],
        "camera_matrix": camera, "intrinsics_src": camera, "intrinsics_dst": camera,
        "extrinsics_src": still, "extrinsics_dst": moved, "src_trans_dst": moved,
        "plane_normals": torch.tensor([0.25, -0.5, 1.0]), "plane_offsets": torch.tensor([4.0]),
        "points_uv": (mesh(15, 12).flatten(0, 1) + 1) / 2 * torch.tensor([s.width - 1.0, s.height - 1.0]),
    }
    if "N" in s.sizes:
        made["camera_matrix"] = camera_of(s.height, s.width)
    return {name: s.repeated(value) for name, value in made.items()} | {"baseline": torch.tensor([0.2]), "focal": torch.tensor([500.0])}


def cameras(s: Setting) -> Inputs:
    """One camera for all points, which sees 640 x 480 pixels."""
    n, h, w = s.sizes.get("N", 1), s.sizes.get("H", 2), s.sizes.get("W", 2)
    camera = torch.tensor([[520.0, 0.0, 320.0], [0.0, 520.0, 240.0], [0.0, 0.0, 1.0]])
    grid = mesh(15, 12).flatten(0, 1)
    bend = torch.tensor([520.0, 520.0, 320.0, 240.0, 0.15, 0.06, 0.02, 0.0])
    size = s.shape("params")[1:] or (8,)
    made: Inputs = {"camera_matrix": camera.expand(n, 3, 3).contiguous(), "params": bend[: int(size[0])].expand(n, -1).contiguous()}
    if n == len(grid) and "params" in {t.name for t in s.spec.inputs}:
        made["projected_points_in_camera_z1_plane"] = grid * torch.tensor([0.9, 0.7])
        made["distorted_points_in_camera"] = (grid + 1) * torch.tensor([320.0, 240.0])
    small = camera_of(h, w)
    inverse = torch.eye(4)
    inverse[:3, :3] = torch.linalg.inv(small)
    projection = torch.eye(4)
    projection[:3, :3] = camera
    rays = torch.cat([mesh(w, h) * torch.tensor([2.0, 1.5]), relief(h, w)[..., None]], -1)
    pixels = torch.cat([(mesh(w, h) + 1) / 2 * torch.tensor([w - 1.0, h - 1.0]), torch.ones(h, w, 1)], -1)
    return made | {
        "depth": relief(h, w)[None, None], "intrinsics_inv": inverse[None], "pixel_coords": pixels[None].contiguous(),
        "cam_coords_src": rays[None].contiguous(), "dst_proj_src": projection[None],
    } if "H" in s.sizes else made


def lenses(s: Setting) -> Inputs:
    """A lens on a camera that sees 640 x 480 pixels, and a grid of them."""
    camera = torch.tensor([[520.0, 0.0, 320.0], [0.0, 520.0, 240.0], [0.0, 0.0, 1.0]])
    size = int((s.shape("dist") or (1, 4))[1])
    made = {"points": (mesh(15, 12).flatten(0, 1) + 1) * torch.tensor([320.0, 240.0]), "K": camera, "new_K": camera, "dist": torch.tensor(LENS[:size])}
    return {name: s.repeated(value) for name, value in made.items()}


def bent_photo(s: Setting) -> Inputs:
    """The photograph as a wide lens would have taken it."""
    camera, bend = camera_of(s.height, s.width)[None], torch.tensor([[-0.45, 0.18, 0.0, 0.0, 0.0]])
    pixels = ((mesh(s.width, s.height) + 1) / 2 * torch.tensor([s.width - 1.0, s.height - 1.0])).flatten(0, 1)[None]
    x, y = calibration.undistort_points(pixels, camera, bend).reshape(1, s.height, s.width, 2).unbind(-1)
    taken = transform.remap(lattice(s.rgb), x.contiguous(), y.contiguous(), padding_mode="border", align_corners=True)
    return {"image": taken.contiguous(), "K": s.repeated(camera[0]), "dist": s.repeated(bend[0])}


# --- points and matrices -----------------------------------------------------------------------------------------------


def pixel_homographies(s: Setting) -> Inputs:
    """From 640 x 480 to 800 x 360 pixels; or between -1 and 1."""
    n = int(s.shape("dst_pix_trans_src_pix")[1])
    if "denormalize" in s.spec.name:
        made = torch.eye(n) + 0.1 * torch.tensor([[1.0, -2.0, 1.0, 0.0], [2.0, 0.0, -1.0, 1.0], [1.0, 1.0, 0.0, -1.0], [0.0, 1.0, 0.0, 0.0]])[:n, :n]
    elif n == 3:
        made = torch.tensor([[0.9, -0.2, 150.0], [0.1, 0.6, 10.0], [2e-4, -1e-4, 1.0]])
    else:
        made = torch.tensor([[0.9, -0.2, 0.0, 14.0], [0.1, 0.6, 0.0, 2.0], [0.0, 0.1, 0.7, 1.0], [0.0, 0.0, 2e-3, 1.0]])
    return {"dst_pix_trans_src_pix": s.repeated(made)}


def affine_matrices(s: Setting) -> Inputs:
    made = torch.tensor([[0.87, -0.5, 0.0, 12.0], [0.5, 0.87, 0.1, -3.0], [0.0, 0.2, 1.1, 5.0]])
    return {"A": s.repeated(made if s.shape("A")[1] == 3 else made[:2, [0, 1, 3]])}


def pixels_of(s: Setting) -> Inputs:
    """Points all over an image or a volume of the op's size."""
    size = torch.tensor([float(s.spec.config[n]) for n in ("width", "height", "depth") if n in s.spec.config])
    share = torch.rand((s.sizes["N"], len(size)), generator=torch.Generator().manual_seed(0))
    return {"pixel_coordinates": share * 2 - 1 if "denormalize" in s.spec.name else share * (size - 1)}


def moved_points(s: Setting) -> Inputs:
    if s.shape("points_1")[-1:] == (2,):
        bend = torch.tensor([[0.8, -0.35, 0.3], [0.3, 0.85, -0.1], [0.15, 0.2, 1.0]])
        return {"trans_01": s.repeated(bend), "points_1": s.repeated(mesh(9, 9).flatten(0, 1))}
    return {"trans_01": s.repeated(motion((0.6, 0.4, -0.3), (10.0, 25.0, 15.0)))}


def slerp(s: Setting) -> Inputs:
    """Three steps from one rotation to another."""
    ends = conversions.axis_angle_to_quaternion(torch.tensor([[0.2, 0.0, 0.1], [0.3, 1.2, 0.9]]))
    q1, q2 = (q.expand(3, 4).contiguous() for q in ends)
    return {"q1": q1, "q2": q2, "t": torch.tensor([0.1, 0.5, 0.9])}


def one_turn(s: Setting) -> Inputs:
    turn = conversions.axis_angle_to_quaternion(torch.tensor([[0.2, 0.7, 0.3]]))
    return {"quaternion": turn.expand(s.sizes["N"], 4).contiguous()}


def tangents(s: Setting) -> Inputs:
    """Matrices of a Lie algebra."""
    group = s.spec.name.split(".")[-1].partition("_")[0]
    size = {"so2": 1, "so3": 3, "se2": 3, "se3": 6}[group]
    v = torch.randn((s.sizes["N"], size), generator=torch.Generator().manual_seed(0))
    return {"omega": getattr(lie, f"{group}_hat")(v[:, 0] if size == 1 else v)}


def affine_pairs(s: Setting) -> Inputs:
    """Points, and where an affine map takes them, with a little noise."""
    random = torch.Generator().manual_seed(0)
    points = torch.rand((s.sizes["N"], 2), generator=random) * 120
    moved = points @ torch.tensor([[0.9, 0.3], [-0.2, 0.8]]) + 5 + torch.randn(points.shape, generator=random)
    return {"points1": s.repeated(points), "points2": s.repeated(moved)}


def straight_boxes(s: Setting) -> Inputs:
    axes = 2 if s.shape("boxes")[1:] == (4, 2) else 3
    corners = (FACE if axes == 2 else BOX) * torch.tensor([22.0, 15.0, 10.0])[:axes]
    starts = torch.tensor([[3.0, 4.0, 6.0], [30.0, 2.0, 9.0], [8.0, 26.0, 7.0], [34.0, 24.0, 5.0]])[:, None, :axes]
    return {"boxes": (starts + corners * torch.tensor([1.0, 0.8, 1.1, 0.9])[:, None, None]).contiguous()}


def bent_boxes(s: Setting) -> Inputs:
    """Four boxes, the last of which is none."""
    boxes = straight_boxes(s)["boxes"]
    boxes[3, 2] += torch.tensor([6.0, 8.0, 0.0])[: boxes.shape[-1]]
    return {"boxes": boxes}


#: By the beginning of an op's name; what a longer one makes, wins.
MAKERS: dict[str, Callable[[Setting], Inputs]] = {
    "geometry.bbox.bbox_to_mask": straight_boxes,
    "geometry.bbox.infer_bbox": straight_boxes,
    "geometry.bbox.is_bbox": bent_boxes,
    "geometry.calibration.distort_points": lenses,
    "geometry.calibration.undistort_image": bent_photo,
    "geometry.calibration.undistort_points": lenses,
    "geometry.camera": cameras,
    "geometry.conversions.convert_affinematrix": affine_matrices,
    "geometry.conversions.denormalize_homography": pixel_homographies,
    "geometry.conversions.denormalize_pixel": pixels_of,
    "geometry.conversions.normalize_homography": pixel_homographies,
    "geometry.conversions.normalize_pixel": pixels_of,
    "geometry.depth": depths,
    "geometry.epipolar.scale_intrinsics": cameras,
    **{f"geometry.lie.{group}_vee": tangents for group in ("so2", "so3", "se2", "se3")},
    "geometry.linalg.transform_points": moved_points,
    "geometry.quaternion.quaternion_rotate": one_turn,
    "geometry.quaternion.quaternion_slerp": slerp,
    "geometry.solvers.find_affine": affine_pairs,
    "geometry.transform": planar,
    "geometry.transform.crop_by_indices": whole_box,
    "geometry.transform.get_tps": splines,
    "geometry.transform.warp_image_tps": splines,
    "geometry.transform.warp_points_tps": splines,
    **{f"geometry.transform.{name}": spatial for name in (
        "affine3d", "center_crop3d", "crop_and_resize3d", "crop_by_boxes3d", "crop_by_transform_mat3d", "get_affine_matrix3d", "get_perspective_transform3d",
        "get_projective_transform", "get_shear_matrix3d", "homography_warp3d", "rotate3d", "warp_affine3d", "warp_grid3d", "warp_perspective3d",
    )},
}
