"""Geometric transforms of volumes, and thin-plate splines."""

from collections.abc import Mapping, Sequence
from typing import Any

import torch
from torch import Generator, Tensor

from ..peer import opencv
from ..spec import InputMaker, Maker, Spec, TensorSpec, Tolerance, image, like
from . import add, rejected_sizes, rejected_words, warp_peers
from .rigid import uniform

_SIZES = {"D": (2, 4096), "OD": (1, 4096), "OH": (1, 32768), "OW": (1, 32768)}
_SHAPE = ("OD", "OH", "OW")
_OUTPUT = [TensorSpec("output", layout="NCDHW")]
#: Weights amplify the rounding of positions by the contrast, and gradients by a matrix are sums over all
#: voxels.
_WARP: dict[str, Any] = {
    "tolerances": {"float32": Tolerance(1e-3, 1e-3)},
    "gradient_tolerances": {"float32": Tolerance(1e-2, 2e-3)},
}
_PIXELS: dict[str, Any] = {
    "tolerances": {"float32": Tolerance(1e-4, 1e-5)},
    "gradient_tolerances": {"float32": Tolerance(1e-3, 1e-4)},
    "picture": "maps of space",
}
_CORNERS = torch.tensor(
    [[x, y, z] for z in (0.0, 1.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], dtype=torch.float64
)


def _homographies(generator: Generator, batch: int, shift: float, depth: float):
    """Mild homographies of space, near the identity."""
    scale = torch.full((4, 4), 0.1, dtype=torch.float64)
    scale[:3, 3], scale[3, :3], scale[3, 3] = shift, depth, 0.0
    return torch.eye(4, dtype=torch.float64) + uniform(generator, -1, 1, batch, 4, 4) * scale


def _boxes(generator: Generator, sizes: dict[str, int]):
    """Boxes (B, 8, 3), a little bent, inside the volume."""
    extent = torch.tensor([sizes.get("W", 30), sizes.get("H", 20), sizes.get("D", 10)], dtype=torch.float64)
    return (0.2 + 0.6 * _CORNERS + uniform(generator, -0.1, 0.1, sizes["B"], 8, 3)) * extent


#: Makers of arguments for which independent uniform values are not suitable.
_MAKERS: dict[str, Maker] = {
    "M": lambda g, s: _homographies(g, s["B"], 2.0, 1e-3)[:, :3],
    "matrix": lambda g, s: _homographies(g, s["B"], 2.0, 1e-3)[:, :3],
    "homography": lambda g, s: _homographies(g, s["B"], 2.0, 1e-3),
    "transform": lambda g, s: _homographies(g, s["B"], 2.0, 1e-3),
    "src_homo_dst": lambda g, s: _homographies(g, s["B"], 0.1, 0.05),
    "boxes": _boxes,
    "src_box": _boxes,
    "dst_box": (
        lambda g, s: (1.0 + _CORNERS * torch.tensor([7.0, 5.0, 3.0], dtype=torch.float64)).expand(
            s["B"], 8, 3
        )
    ),
}


def _with(inputs: Sequence[TensorSpec], makers: Mapping[str, str]) -> InputMaker:
    def sample(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        made: dict[str, Tensor] = {}
        for t in inputs:
            maker = _MAKERS.get(makers.get(t.name, t.name))
            shape = [sizes[d] if isinstance(d, str) else d for d in t.shape]
            if t.dtype == "uint8":
                made[t.name] = torch.zeros(shape, dtype=torch.uint8)
            elif maker is not None:
                made[t.name] = maker(generator, sizes).to(dtype).contiguous()
            else:
                made[t.name] = uniform(generator, *(t.range or (0.0, 1.0)), *shape).to(dtype)
        return made

    return sample


def _add(
    name: str,
    inputs: Sequence[TensorSpec],
    reference: str,
    fn: str,
    makers: Mapping[str, str] | None = None,
    outputs: Sequence[TensorSpec] = _OUTPUT,
    picture: str = "warps",
    **rest: Any,
):
    add(
        Spec(
            f"geometry.transform.{name}",
            inputs,
            outputs,
            make_inputs=_with(inputs, makers or {}),
            reference=reference,
            picture=picture,
            **rest,
        ),
        fn=f"geometry.transform.{fn}",
    )


def _volume(name: str):
    return TensorSpec(
        name, ("B", "C", "D", "H", "W"), layout="NCDHW", range=(0.0, 1.0), description="volumes"
    )


# --- matrices -----------------------------------------------------------------------------------------------

_CENTER = TensorSpec("center", ("B", 3), range=(3, 20), description="x, y and z in voxels")
_ANGLES = TensorSpec("angles", ("B", 3), range=(-60, 60), description="rotation vector in degrees")
_MATRIX = [TensorSpec("matrix")]
_SHEARS = [
    TensorSpec(n, ("B",), range=(-0.4, 0.4), description="radians")
    for n in ("sxy", "sxz", "syx", "syz", "szx", "szy")
]
_FACTORS: dict[str, Any] = {"range": (0.6, 1.6), "description": "factors along x, y and z"}

_add(
    "get_projective_transform",
    [_CENTER, _ANGLES, TensorSpec("scales", ("B", 3), **_FACTORS)],
    "SciPy Rotation",
    "get_projective_transform",
    outputs=_MATRIX,
    **_PIXELS,
)
_add(
    "get_shear_matrix3d",
    [_CENTER, *_SHEARS],
    "product of matrices in NumPy",
    "get_shear_matrix3d",
    outputs=_MATRIX,
    **_PIXELS,
)
_add(
    "get_affine_matrix3d",
    [
        TensorSpec("translations", ("B", 3), range=(-5, 5), description="voxels"),
        _CENTER,
        TensorSpec("scale", ("B", 3), **_FACTORS),
        _ANGLES,
        *_SHEARS,
    ],
    "product of matrices in NumPy",
    "get_affine_matrix3d",
    outputs=_MATRIX,
    **_PIXELS,
)
_add(
    "get_perspective_transform3d",
    [
        TensorSpec("src", ("B", 8, 3), description="corners of boxes"),
        TensorSpec("dst", ("B", 8, 3), description="where they go"),
    ],
    "NumPy",
    "get_perspective_transform3d",
    makers={"src": "src_box", "dst": "dst_box"},
    outputs=_MATRIX,
    tolerances={"float32": Tolerance(1e-3, 1e-3)},
    gradient_tolerances={"float32": Tolerance(1e-2, 2e-3)},
    picture="maps of space",
)

# --- warps --------------------------------------------------------------------------------------------------

_M = TensorSpec("M", ("B", 3, 4), description="from source to destination voxels")
for _mode, _padding in (("bilinear", "reflection"), ("nearest", "border")):
    _add(
        f"warp_affine3d.{_mode}_{_padding}",
        [_volume("src"), _M, like("dsize", shape=_SHAPE)],
        "SciPy map_coordinates",
        "warp_affine3d",
        peer=warp_peers.of_volumes(_mode, _padding),
        config={"flags": _mode, "padding_mode": _padding},
        symbols=_SIZES,
        **_WARP,
        errors=(*rejected_sizes("dsize", 3), *rejected_words("flags")),
    )
_add(
    "warp_perspective3d",
    [
        _volume("src"),
        TensorSpec("M", ("B", 4, 4), description="from source to destination voxels"),
        like("dsize", shape=_SHAPE),
    ],
    "SciPy map_coordinates",
    "warp_perspective3d",
    makers={"M": "homography"},
    symbols=_SIZES,
    **_WARP,
    errors=(*rejected_sizes("dsize", 3), *rejected_words("border_mode")),
)
_add(
    "homography_warp3d",
    [
        _volume("patch_src"),
        TensorSpec("src_homo_dst", ("B", 4, 4), description="from the output to the volume, in [-1, 1]"),
        like("dsize", shape=_SHAPE),
    ],
    "torch.nn.functional.grid_sample",
    "homography_warp3d",
    symbols=_SIZES,
    **_WARP,
    errors=rejected_sizes("dsize", 3),
)
_add(
    "affine3d",
    [_volume("tensor"), TensorSpec("matrix", ("B", 3, 4), description="from source to destination voxels")],
    "SciPy map_coordinates",
    "affine3d",
    symbols=_SIZES,
    **_WARP,
)
_add(
    "rotate3d",
    [
        _volume("tensor"),
        *[TensorSpec(n, ("B",), range=(-40, 40), description="degrees") for n in ("yaw", "pitch", "roll")],
    ],
    "SciPy Rotation and map_coordinates",
    "rotate3d",
    symbols=_SIZES,
    **_WARP,
)
_add(
    "warp_grid3d",
    [
        TensorSpec("grid", ("B", "D", "H", "W", 3), range=(-1, 1), description="points (x, y, z)"),
        TensorSpec("src_homo_dst", ("B", 4, 4)),
    ],
    "OpenCV perspectiveTransform",
    "warp_grid3d",
    peer=opencv(
        lambda cv2, grid, m: cv2.perspectiveTransform(grid.reshape(1, -1, 3), m).reshape(grid.shape),
        "samples",
    ),
    outputs=[TensorSpec("points")],
    symbols=_SIZES,
    gradient_tolerances={"float32": Tolerance(5e-3, 5e-4)},
    picture="tensors",
)
_add(
    "center_crop3d",
    [_volume("tensor")],
    "NumPy slices",
    "center_crop3d",
    config={"size": (5, 12, 10)},
    symbols=_SIZES,
    **_WARP,
    errors=(*rejected_sizes("size", 3), *rejected_words("interpolation")),
)
_add(
    "crop_and_resize3d",
    [_volume("tensor"), TensorSpec("boxes", ("B", 8, 3), description="corners (x, y, z)")],
    "SciPy map_coordinates",
    "crop_and_resize3d",
    config={"size": (5, 12, 10)},
    symbols=_SIZES,
    **_WARP,
    errors=rejected_sizes("size", 3),
)
_add(
    "crop_by_transform_mat3d",
    [
        _volume("tensor"),
        TensorSpec("transform", ("B", 4, 4), description="from source to destination voxels"),
        like("out_size", shape=_SHAPE),
    ],
    "SciPy map_coordinates",
    "crop_by_transform_mat3d",
    symbols=_SIZES,
    **_WARP,
    errors=rejected_sizes("out_size", 3),
)
_add(
    "crop_by_boxes3d",
    [
        _volume("tensor"),
        TensorSpec("src_box", ("B", 8, 3), description="corners (x, y, z)"),
        TensorSpec("dst_box", ("B", 8, 3), description="where they go"),
        like("size", shape=_SHAPE),
    ],
    "NumPy slices",
    "crop_by_boxes3d",
    symbols=_SIZES,
    **_WARP,
    errors=rejected_sizes("size", 3),
)

# --- thin-plate splines -------------------------------------------------------------------------------------

_CENTERS = TensorSpec("kernel_centers", ("B", "N", 2), range=(-1, 1), description="points (x, y)")
_WEIGHTS = [
    TensorSpec("kernel_weights", ("B", "N", 2), range=(-0.1, 0.1), description="of the kernels"),
    TensorSpec("affine_weights", ("B", 3, 2), range=(-1, 1), description="what is added, and a matrix"),
]


def _make_splines(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Points near the corners and the centre of the square from -1 to 1, and their new positions."""
    anchors = torch.tensor(
        [[-0.8, -0.8], [0.8, -0.8], [0.8, 0.8], [-0.8, 0.8], [0.0, 0.0], [0.1, -0.7]], dtype=torch.float64
    )
    noise = uniform(generator, -0.1, 0.1, 2, sizes["B"], 6, 2)
    return {"points_src": (anchors + noise[0]).to(dtype), "points_dst": (anchors + noise[1]).to(dtype)}


add(
    Spec(
        "geometry.transform.get_tps_transform",
        [
            TensorSpec("points_src", ("B", 6, 2), description="points (x, y)"),
            TensorSpec("points_dst", ("B", 6, 2), description="where they go"),
        ],
        [TensorSpec("kernel_weights"), TensorSpec("affine_weights")],
        make_inputs=_make_splines,
        tolerances={"float32": Tolerance(1e-3, 1e-3)},
        gradient_tolerances={"float32": Tolerance(1e-2, 1e-3)},
        reference="NumPy solve; the spline goes through its points",
    )
)
_add(
    "warp_points_tps",
    [
        TensorSpec("points_src", ("B", "N", 2), range=(-1, 1), description="points (x, y)"),
        TensorSpec("kernel_centers", ("B", 8, 2), range=(-1, 1)),
        TensorSpec("kernel_weights", ("B", 8, 2), range=(-0.1, 0.1)),
        _WEIGHTS[1],
    ],
    "NumPy; SciPy RBFInterpolator",
    "warp_points_tps",
    outputs=[TensorSpec("points")],
    gradient_tolerances={"float32": Tolerance(1e-3, 1e-3)},
    picture="tensors",
)
_add(
    "warp_image_tps",
    [image("image"), _CENTERS, *_WEIGHTS],
    "NumPy and torch.nn.functional.grid_sample",
    "warp_image_tps",
    outputs=[TensorSpec("output", layout="NCHW")],
    symbols={"N": (3, 1024)},
    **_WARP,
)
