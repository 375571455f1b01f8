"""Which panels the geometry gets."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import torch
from PIL import Image, ImageDraw

from gallery.sheets import ZOOM

from .curves import fit, mean_rotation, polynomials
from .images import image_panels, images, output_panels
from .model import Panel, Shown
from .photographed import stereo_views
from .planar import fitted, plane_boxes, plane_maps, quadrilaterals
from .solid import depth_clouds, depth_images, space_boxes, space_maps, volumes
from .tensors import tensors
from .views import two_views

MARK = (255, 60, 0)


def warps(shown: Shown) -> list[Panel]:
    """Images and maps, with the places that other inputs name marked on the image."""
    if any(t.layout == "NCDHW" for t in shown.spec.inputs):
        return volumes(shown)
    made = []
    for t in shown.spec.inputs:
        tensor = shown.inputs[t.name]
        if t.layout:
            made += [
                Panel(p.label, marked(shown, p.image), p.note, True)
                for p in image_panels(t.name, tensor, t.layout, t.color, True)
            ]
        elif t.shape[1:] == ("OH", "OW"):
            made += image_panels(
                t.name,
                (tensor - tensor.min()) / (tensor.max() - tensor.min()),
                "HW" if tensor.dim() == 2 else "CHW",
                "",
                True,
            )
        elif t.name == "noise":
            made += image_panels("noise: x", tensor[:, :1] / (2 * tensor.abs().max()) + 0.5, "NCHW", "", True)
    return [*made, *output_panels(shown)]


def marked(shown: Shown, pixels: np.ndarray) -> np.ndarray:
    """Boxes, centres and control points of splines, on an image."""
    h, w = pixels.shape[:2]
    canvas = Image.fromarray(pixels).resize((w * ZOOM, h * ZOOM))
    pen = ImageDraw.Draw(canvas)
    scale = ZOOM * np.ones(2)

    def places(tensor: torch.Tensor, normalised: bool = False) -> list[tuple[float, float]]:
        points = tensor[0].reshape(-1, 2).double().numpy()
        points = (points + 1) / 2 * [w - 1, h - 1] if normalised else points
        return [tuple(p) for p in points * scale]

    for name in ("src_box", "boxes"):
        if name in shown.inputs:
            corners = places(shown.inputs[name])
            pen.line([*corners, corners[0]], MARK, 2 * ZOOM)
    for name, normalised in (("center", False), ("kernel_centers", True)):
        for x, y in places(shown.inputs[name], normalised) if name in shown.inputs else ():
            pen.ellipse((x - 4 * ZOOM, y - 4 * ZOOM, x + 4 * ZOOM, y + 4 * ZOOM), MARK)
    return np.asarray(canvas.resize((w, h), Image.Resampling.LANCZOS))


def rendered(shown: Shown) -> list[Panel]:
    """A picture each of the first three."""
    return image_panels("output", shown.first[:3, None], "NCHW", "", False)


#: By the beginning of an op's name; the panels of other ops follow from the kinds of their tensors.
GEOMETRY: dict[str, Callable[[Shown], list[Panel]]] = {
    "geometry": tensors,
    "geometry.bbox": plane_boxes,
    "geometry.calibration.undistort_image": depth_images,
    "geometry.conversions.denormalize_homography": plane_maps,
    "geometry.conversions.denormalize_homography3d": space_maps,
    "geometry.conversions.normalize_homography": plane_maps,
    "geometry.conversions.normalize_homography3d": space_maps,
    "geometry.depth": depth_images,
    "geometry.depth.depth_from_plane": tensors,
    "geometry.depth.depth_to_3d": depth_clouds,
    "geometry.depth.unproject": tensors,
    "geometry.epipolar.find_fundamental": stereo_views,
    "geometry.homography": fitted,
    "geometry.homography.sample_is_valid": quadrilaterals,
    "geometry.line": fit,
    "geometry.plane": fit,
    "geometry.quaternion.average": mean_rotation,
    "geometry.ransac.ransac_fundamental": stereo_views,
    "geometry.solvers.find_affine": fitted,
    "geometry.solvers.solve_": polynomials,
    "geometry.subpix.render_gaussian2d": rendered,
    "geometry.subpix.spatial_softmax2d": images,
    "geometry.transform": warps,
    "geometry.transform.get_": plane_maps,
    "geometry.transform.get_projective_transform": space_maps,
    "geometry.transform.get_tps": tensors,
    "geometry.transform.invert_affine": plane_maps,
    "geometry.transform.projection_from_Rt": tensors,
    "geometry.transform.warp_grid": tensors,
    "geometry.transform.warp_points": tensors,
    **{
        f"geometry.bbox.{name}": space_boxes
        for name in ("bbox_generator3d", "bbox_to_mask3d", "infer_bbox_shape3d", "is_bbox3d")
    },
    **{
        f"geometry.transform.get_{name}3d": space_maps
        for name in ("affine_matrix", "perspective_transform", "shear_matrix")
    },
    **{
        f"geometry.epipolar.{name}": two_views
        for name in (
            "find_essential",
            "find_fundamental_7point",
            "get_closest",
            "left_to_right",
            "right_to_left",
            "sampson",
            "symmetrical",
        )
    },
}
