"""Values for the inputs that are not photographs, chosen to show the ops at work."""

from __future__ import annotations

import math
from typing import Any

import torch

from chiasm.export.spec import Spec

TURNS = [0.0, 30.0, 90.0, 135.0]
ROTATION = [[0.0, -18.0, 30.0]]
EMBOSS = [[-2.0, -1.0, 0.0], [-1.0, 1.0, 1.0], [0.0, 1.0, 2.0]]
STROKE = [[0.0, 0.0, 1 / 3], [0.0, 1 / 3, 0.0], [1 / 3, 0.0, 0.0]]
STREAK = [
    [0.0, 0.0, 0.0, 0.0, 0.2],
    [0.0, 0.0, 0.0, 0.2, 0.0],
    [0.0, 0.0, 0.2, 0.0, 0.0],
    [0.0, 0.2, 0.0, 0.0, 0.0],
    [0.2, 0.0, 0.0, 0.0, 0.0],
]
CROSS = [[0.0, 1.0, 0.0], [1.0, 1.0, 1.0], [0.0, 1.0, 0.0]]
SIGMAS = [0.5, 1.0, 1.5, 3.0]
RED, YELLOW = [0.9, 0.1, 0.1], [1.0, 0.85, 0.1]

#: By an op's name or the beginning of it, then by the input's name. A value is repeated to the input's shape.
VALUES: dict[str, dict[str, Any]] = {
    "color.rgba_to_rgb": {"background_color": [0.1, 0.35, 0.8]},
    "contrib.interp": {"xp": [0.0, 0.25, 0.5, 0.75, 1.0], "fp": [0.0, 0.08, 0.5, 0.92, 1.0]},
    "enhance": {"mean": [0.485, 0.456, 0.406], "std": [0.229, 0.224, 0.225]},
    "enhance.add_weighted": {"alpha": 0.6, "beta": 0.5, "gamma": -0.05},
    "enhance.adjust_brightness": {"factor": 0.25},
    "enhance.adjust_brightness_accumulative": {"factor": 1.5},
    "enhance.adjust_contrast": {"factor": 0.5},
    "enhance.adjust_contrast_with_mean_subtraction": {"factor": 1.8},
    "enhance.adjust_gamma": {"gamma": 0.5, "gain": 1.0},
    "enhance.adjust_hue": {"factor": 2.1},
    "enhance.adjust_saturation": {"factor": 2.0},
    "enhance.adjust_saturation_with_gray_subtraction": {"factor": 0.3},
    "enhance.histogram": {"bandwidth": 0.02, "bins": [i / 63 for i in range(64)]},
    "enhance.histogram2d": {"bandwidth": 0.02, "bins": [i / 47 for i in range(48)]},
    "enhance.invert": {"max_val": 1.0},
    "enhance.jpeg_codec_differentiable": {"jpeg_quality": 8.0},
    "enhance.posterize": {"bits": 2},
    "enhance.sharpness": {"factor": 4.0},
    "enhance.shift_rgb": {"r_shift": 0.2, "g_shift": -0.1, "b_shift": -0.2},
    "enhance.solarize": {"thresholds": 0.5, "additions": 0.1},
    "enhance.threshold": {"thresh": 0.5, "maxval": 0.9},
    "filters.convolve2d": {"kernel": EMBOSS},
    "filters.convolve3d": {"kernel": [[[1 / 3], [0.0], [-1 / 3]]] * 3},
    "filters.correlate2d": {"kernel": [[0.0] * 5, [-1.0, -2.0, 0.0, 2.0, 1.0], [0.0] * 5]},
    "filters.correlate3d": {"kernel": [[STROKE]]},
    "filters.fft_conv": {"kernel": STREAK},
    "filters.filter2d": {"kernel": EMBOSS},
    "filters.filter2d_separable": {"kernel_x": [0.1, 0.2, 0.4, 0.2, 0.1], "kernel_y": [-1.0, 0.0, 1.0]},
    "filters.filter3d": {"kernel": 1 / 27},
    "filters.gabor": {"sigma": 1.6, "theta": 0.0, "lambd": 4.0},
    "filters.gaussian": {"sigma": SIGMAS, "mean": [2.0, 2.0, 1.0, 3.0]},
    "filters.gaussian_blur2d": {"sigma": 1.5},
    "filters.get_gabor_kernel2d": {
        "sigma": 1.8,
        "theta": [0.0, 0.8, 1.57, 0.0],
        "lambd": 4.0,
        "gamma": 0.6,
        "psi": [0.0, 0.0, 0.0, 1.57],
    },
    "filters.get_gaussian": {"sigma": SIGMAS},
    "filters.get_gaussian_kernel2d": {"sigma": [[0.6, 0.6], [1.5, 1.5], [3.0, 0.6], [0.6, 3.0]]},
    "filters.get_gaussian_kernel3d": {"sigma": [[0.8, 1.5, 1.0]]},
    "filters.get_motion_kernel2d": {"angle": TURNS, "direction": [0.0, 0.0, 0.9, -0.5]},
    "filters.get_motion_kernel3d": {"angle": ROTATION, "direction": 0.5},
    "filters.in_range": {"lower": [0.55, 0.1, 0.0], "upper": [1.0, 0.62, 0.42]},
    "filters.motion_blur": {"angle": 45.0, "direction": 0.0},
    "filters.motion_blur3d": {"angle": ROTATION, "direction": 0.0},
    "geometry.transform.get_affine_matrix2d": {"angle": 20.0, "scale": [[0.8, 0.7]], "sx": 0.2, "sy": 0.0},
    "geometry.transform.get_rotation_matrix2d": {"angle": 25.0, "scale": [[0.9, 0.7]]},
    "geometry.transform.get_shear_matrix2d": {"sx": 0.35, "sy": -0.1},
    "geometry.transform.rotate": {"angle": 25.0},
    "geometry.transform.scale": {"scale_factor": [[0.6, 0.8]]},
    "geometry.transform.shear": {"shear": [[0.3, -0.1]]},
    "geometry.transform.translate": {"translation": [[40.0, -25.0]]},
    "geometry.transform.warp_affine.bilinear_fill": {"fill_value": [0.15, 0.3, 0.6]},
    "image.draw_convex_polygon": {"colors": YELLOW},
    "image.draw_line": {"color": YELLOW},
    "image.draw_point2d": {"color": RED},
    "image.draw_rectangle": {"color": [[RED, YELLOW, [0.2, 0.9, 0.3]]]},
    "morphology": {"kernel": CROSS},
    "pipelines.crop_boxes": {
        "boxes": [[66, 5, 140, 80], [150, 8, 226, 150], [8, 62, 120, 172], [0, 0, 62, 84]]
    },
}


def values(spec: Spec) -> dict[str, Any]:
    """The table's values for an op's inputs; longer names take precedence."""
    parts = [
        (name, known)
        for name, known in VALUES.items()
        if spec.name == name or spec.name.startswith((f"{name}.", f"{name}_"))
    ]
    merged = {
        key: value
        for _, known in sorted(parts, key=lambda part: len(part[0]))
        for key, value in known.items()
    }
    return {t.name: merged[t.name] for t in spec.inputs if t.name in merged}


def count(spec: Spec) -> int:
    """The batch size of the table's values."""
    known = values(spec)
    lists = (
        known[t.name]
        for t in spec.inputs
        if t.name in known and t.shape[0] == "B" and isinstance(known[t.name], list)
    )
    return max((len(value) for value in lists), default=1)


def places(spec: Spec, sizes: dict[str, int]) -> dict[str, torch.Tensor]:
    """The positions to draw, in pixels, on images of the given sizes."""
    if not spec.name.startswith("image."):
        return {}
    h, w, b = sizes.get("H", 1), sizes.get("W", 1), sizes.get("B", 1)

    def repeated(points: torch.Tensor) -> torch.Tensor:
        return points.float().expand(b, *points.shape).contiguous()

    names = {t.name for t in spec.inputs}
    size = torch.tensor([w, h])
    if "rectangle" in names:
        share = torch.tensor([[0.08, 0.1, 0.5, 0.6], [0.3, 0.3, 0.8, 0.9], [0.6, 0.05, 0.95, 0.5]])
        return {"rectangle": repeated((share * size.repeat(2)).round())}
    if "p1" in names:
        turns = torch.arange(16) * (math.pi / 8)
        ends = torch.stack([torch.cos(turns), torch.sin(turns)], -1) * min(h, w) * 0.45 + size / 2
        return {"p1": repeated((size / 2).round().expand(16, 2)), "p2": repeated(ends.round())}
    if "polygons" in names:
        turns = torch.arange(6) * (math.pi / 3) + 0.3
        return {
            "polygons": repeated(
                torch.stack([torch.cos(turns), torch.sin(turns)], -1) * min(h, w) * 0.4 + size * 0.49
            )
        }
    if "points" in names:
        steps = torch.arange(200) * 0.12
        spiral = (
            torch.stack([torch.cos(steps), torch.sin(steps)], -1)
            * (steps / steps[-1] * min(h, w) * 0.45)[:, None]
        )
        return {"points": repeated((spiral + size / 2).round())}
    return {}
