"""Geometric transforms of images: matrices and warps."""

from collections.abc import Mapping, Sequence
from typing import Any

import torch
from torch import Generator, Tensor

from ..peer import Peer, opencv, warped
from ..spec import PIXELS, Frames, InputMaker, Maker, Spec, TensorSpec, Tolerance, image, like
from . import STENCIL, add, rejected_sizes, rejected_words, warp_peers
from .geometry_homography import homographies
from .rigid import uniform

SIZES = {"OH": (1, 32768), "OW": (1, 32768)}
OUTPUT = [TensorSpec("output", layout="NCHW")]
_BATCHED = TensorSpec("angle", ("B",), range=(-180, 180), description="degrees, counterclockwise")
#: Weights amplify the rounding of positions by the contrast, and gradients by a matrix are sums over all
#: pixels.
WARP: dict[str, Any] = {
    "tolerances": {"float32": Tolerance(1e-3, 1e-3)},
    "gradient_tolerances": {"float32": Tolerance(5e-3, 2e-3)},
}
#: The derivatives of the cubic kernel are larger still.
_CUBIC: dict[str, Any] = {
    "tolerances": {"float32": Tolerance(1e-3, 1e-3)},
    "gradient_tolerances": {"float32": Tolerance(2e-2, 5e-3)},
}


def _boxes(generator: Generator, sizes: dict[str, int]):
    """Quadrilaterals (B, 4, 2) inside the image, corners from the upper left clockwise."""
    corners = torch.tensor([[0.2, 0.2], [0.8, 0.2], [0.8, 0.8], [0.2, 0.8]], dtype=torch.float64)
    extent = torch.tensor([sizes.get("W", 40), sizes.get("H", 30)], dtype=torch.float64)
    return (corners + uniform(generator, -0.15, 0.15, sizes["B"], 4, 2)) * extent


#: Makers of arguments for which independent uniform values are not suitable.
_MAKERS: dict[str, Maker] = {
    "M": lambda g, s: homographies(g, s["B"])[:, :2],
    "matrix": lambda g, s: homographies(g, s["B"])[:, :2],
    "transform": lambda g, s: homographies(g, s["B"]),
    "homography": lambda g, s: homographies(g, s["B"]),
    # between coordinates in [-1, 1]
    "normalized": lambda g, s: torch.eye(3, dtype=torch.float64) + uniform(g, -0.1, 0.1, s["B"], 3, 3),
    "angle": lambda g, s: uniform(g, -40, 40, s["B"]),
    "scale_factor": lambda g, s: uniform(g, 0.6, 1.6, s["B"], 2),
    "translation": lambda g, s: uniform(g, -5, 5, s["B"], 2),
    "shear": lambda g, s: uniform(g, -0.4, 0.4, s["B"], 2),
    "center": lambda g, s: uniform(g, 3, 30, s["B"], 2),
    "scale": lambda g, s: uniform(g, 0.6, 1.6, s["B"], 2),
    "max_radius": lambda g, s: uniform(g, 5, 30, s["B"]),
    "boxes": _boxes,
    "src_box": _boxes,
    "dst_box": (
        lambda g, s: torch.tensor(
            [[1.0, 2.0], [9.0, 2.0], [9.0, 8.0], [1.0, 8.0]], dtype=torch.float64
        ).expand(s["B"], 4, 2)
    ),
    # some positions lie outside, none near enough to a border between pixels for rounding to decide
    "map_x": (
        lambda g, s: (
            torch.floor(uniform(g, -3, s["W"] + 3, s["B"], s["OH"], s["OW"]))
            + uniform(g, 0.05, 0.45, s["B"], s["OH"], s["OW"])
        )
    ),
    "map_y": (
        lambda g, s: (
            torch.floor(uniform(g, -3, s["H"] + 3, s["B"], s["OH"], s["OW"]))
            + uniform(g, 0.55, 0.95, s["B"], s["OH"], s["OW"])
        )
    ),
}


def _with(inputs: Sequence[TensorSpec], **makers: str) -> InputMaker:
    """A maker of `inputs`, by _MAKERS or by `makers`; other inputs are uniform in their range."""

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


def add_transform(
    name: str,
    inputs: Sequence[TensorSpec],
    reference: str,
    fn: str | None = None,
    makers: Mapping[str, str] | None = None,
    outputs: Sequence[TensorSpec] = OUTPUT,
    picture: str = "warps",
    **rest: Any,
):
    add(
        Spec(
            f"geometry.transform.{name}",
            inputs,
            outputs,
            make_inputs=_with(inputs, **(makers or {})),
            reference=reference,
            picture=picture,
            **rest,
        ),
        fn=fn and f"geometry.transform.{fn}",
    )


# --- matrices -----------------------------------------------------------------------------------------------

_CENTER = TensorSpec("center", ("B", 2), range=(3, 30), description="x and y in pixels")
_SCALE = TensorSpec("scale", ("B", 2), range=(0.6, 1.6), description="factors along x and y")
_SHEARS = [
    TensorSpec("sx", ("B",), range=(-0.5, 0.5), description="radians along x"),
    TensorSpec("sy", ("B",), range=(-0.5, 0.5), description="radians along y"),
]
_TRANSLATIONS = TensorSpec("translations", ("B", 2), range=(-5, 5), description="pixels along x and y")
_MATRIX = [TensorSpec("matrix")]
# entries in pixels: differences are relative to the centre's coordinates
_PIXELS: dict[str, Any] = {
    "tolerances": {"float32": Tolerance(1e-4, 1e-5)},
    "gradient_tolerances": {"float32": Tolerance(1e-3, 1e-4)},
    "outputs": _MATRIX,
    "picture": "maps of the plane",
}

add_transform(
    "get_rotation_matrix2d",
    [_CENTER, _BATCHED, _SCALE],
    "OpenCV getRotationMatrix2D",
    fn="get_rotation_matrix2d",
    **_PIXELS,
)
add_transform(
    "get_translation_matrix2d",
    [_TRANSLATIONS],
    "scikit-image EuclideanTransform",
    peer=Peer(
        "skimage.transform",
        lambda transform, t: transform.EuclideanTransform(translation=t).params,
        "samples",
    ),
    fn="get_translation_matrix2d",
    **_PIXELS,
)
add_transform(
    "get_shear_matrix2d",
    [_CENTER, *_SHEARS],
    "product of matrices in NumPy",
    fn="get_shear_matrix2d",
    **_PIXELS,
)
add_transform(
    "get_affine_matrix2d",
    [_TRANSLATIONS, _CENTER, _SCALE, _BATCHED, *_SHEARS],
    "product of matrices in NumPy",
    fn="get_affine_matrix2d",
    **_PIXELS,
)
_INVERSES: dict[str, Any] = {**_PIXELS, "outputs": [TensorSpec("inverse")]}
add_transform(
    "invert_affine_transform",
    [TensorSpec("matrix", ("B", 2, 3))],
    "OpenCV invertAffineTransform",
    peer=opencv(lambda cv2, m: cv2.invertAffineTransform(m), "samples", atol=1e-3, rtol=1e-4),
    fn="invert_affine_transform",
    **_INVERSES,
)
add_transform(
    "projection_from_Rt",
    [TensorSpec("rmat", ("B", 3, 3)), TensorSpec("tvec", ("B", 3, 1))],
    "definition",
    fn="projection_from_Rt",
    outputs=_MATRIX,
    picture="tensors",
)
add_transform(
    "get_perspective_transform",
    [
        TensorSpec("points_src", ("B", 4, 2), description="four points (x, y)"),
        TensorSpec("points_dst", ("B", 4, 2), description="where they go"),
    ],
    "OpenCV getPerspectiveTransform",
    peer=opencv(lambda cv2, a, b: cv2.getPerspectiveTransform(a, b), "samples", atol=1e-3, rtol=1e-3),
    fn="get_perspective_transform",
    makers={"points_src": "boxes", "points_dst": "dst_box"},
    outputs=_MATRIX,
    tolerances={"float32": Tolerance(1e-3, 1e-4)},
    gradient_tolerances={"float32": Tolerance(1e-2, 1e-3)},
    picture="maps of the plane",
)

# --- warps --------------------------------------------------------------------------------------------------


def _make_warp(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    shape = (sizes["B"], sizes["C"], sizes["H"], sizes["W"])
    return {
        "src": torch.rand(shape, generator=generator, dtype=torch.float64).to(dtype),
        "M": homographies(generator, sizes["B"]).to(dtype),
        "like": torch.zeros((sizes["OH"], sizes["OW"]), dtype=torch.uint8),
    }


_WARPED_FRAMES = (("bilinear", "zeros"), ("nearest", "border"))
for _mode in ("bilinear", "nearest"):
    for _padding in ("zeros", "border", "reflection", "fill"):
        add(
            Spec(
                f"geometry.transform.warp_perspective.{_mode}_{_padding}",
                [
                    image("src"),
                    TensorSpec("M", ("B", 3, 3), description="homography from source to destination pixels"),
                    like("dsize"),
                ],
                [TensorSpec("output", layout="NCHW")],
                config={"mode": _mode, "padding_mode": _padding},
                symbols=SIZES,
                # weights amplify the rounding of coordinates by the contrast, and the gradient by M is a sum
                # over all pixels
                tolerances={"float32": Tolerance(1e-3, 1e-3)},
                gradient_tolerances={"float32": Tolerance(5e-3, 2e-3)},
                make_inputs=_make_warp,
                # nothing fills with 0
                peer=warped("warpPerspective", _mode, "zeros" if _padding == "fill" else _padding),
                reference="OpenCV warpPerspective",
                frames=(
                    Frames(PIXELS, peer=warped("warpPerspective", _mode, _padding, True))
                    if (_mode, _padding) in _WARPED_FRAMES
                    else None
                ),
                picture="warps",
                errors=(*rejected_sizes("dsize"), *rejected_words("mode", "padding_mode")),
            ),
            fn="geometry.transform.warp_perspective",
        )

# Every mode with every padding is tested eagerly, and deployed in one or another of these ops, which sample
# alike.
_WARPED = {
    "warp_affine": (
        [
            image("src"),
            TensorSpec("M", ("B", 2, 3), description="from source to destination pixels"),
            like("dsize"),
        ],
        ("bilinear_zeros", "nearest_border", "bicubic_reflection"),
        {
            "fn": "warp_affine",
            "reference": "OpenCV warpAffine; SciPy map_coordinates",
            "errors": rejected_sizes("dsize"),
        },
    ),
    "warp_perspective": (
        [
            image("src"),
            TensorSpec("M", ("B", 3, 3), description="homography from source to destination pixels"),
            like("dsize"),
        ],
        ("bicubic_border",),
        {
            "fn": "warp_perspective",
            "reference": "OpenCV warpPerspective",
            "makers": {"M": "homography"},
            "errors": rejected_sizes("dsize"),
        },
    ),
    "remap": (
        [
            image("image"),
            TensorSpec("map_x", ("B", "OH", "OW"), description="columns"),
            TensorSpec("map_y", ("B", "OH", "OW"), description="rows"),
        ],
        ("bilinear_zeros", "nearest_border", "bicubic_reflection"),
        {"fn": "remap", "reference": "OpenCV remap; SciPy map_coordinates"},
    ),
}


for _name, (_inputs, _ways, _rest) in _WARPED.items():
    for _way in _ways:
        _mode, _, _padding = _way.partition("_")
        _config = {"mode": _mode, "padding_mode": _padding, "align_corners": True}
        add_transform(
            f"{_name}.{_way}",
            _inputs,
            config=_config,
            symbols=SIZES,
            peer=warp_peers.of_matrix(_name, _mode, _padding),
            frames=Frames(
                ("uint8",) if _mode == "bicubic" else PIXELS,
                peer=warp_peers.of_matrix(_name, _mode, _padding, True),
            ),
            **_rest,
            **(_CUBIC if _mode == "bicubic" else WARP),
        )

add_transform(
    "warp_affine.bilinear_fill",
    [
        image("src"),
        TensorSpec("M", ("B", 2, 3), description="from source to destination pixels"),
        like("dsize"),
        TensorSpec("fill_value", ("C",), description="colour"),
    ],
    "SciPy map_coordinates",
    fn="warp_affine",
    config={"mode": "bilinear", "padding_mode": "fill"},
    symbols=SIZES,
    peer=warp_peers.filled(),
    frames=Frames(ranges={"fill_value": (0.0, 255.0)}, peer=warp_peers.filled(True)),
    **WARP,
    errors=rejected_sizes("dsize"),
)
add_transform(
    "remap.normalized",
    [
        image("image"),
        TensorSpec("map_x", ("B", "OH", "OW"), range=(-1.1, 1.1), description="columns"),
        TensorSpec("map_y", ("B", "OH", "OW"), range=(-1.1, 1.1), description="rows"),
    ],
    "torch.nn.functional.grid_sample",
    fn="remap",
    makers={"map_x": "", "map_y": ""},
    config={"normalized_coordinates": True},
    peer=Peer(
        "torch.nn.functional",
        lambda F, x, grid: F.grid_sample(x, grid, align_corners=False),
        "tensors",
        before=lambda x, columns, rows: (x, torch.stack([columns, rows], -1)),
    ),
    symbols=SIZES,
    **WARP,
)

add_transform(
    "homography_warp",
    [
        image("patch_src"),
        TensorSpec("src_homo_dst", ("B", 3, 3), description="from the output to the image, in [-1, 1]"),
        like("dsize"),
    ],
    "torch.nn.functional.grid_sample",
    fn="homography_warp",
    makers={"src_homo_dst": "normalized"},
    symbols=SIZES,
    peer=warp_peers.NORMALIZED,
    **WARP,
    errors=rejected_sizes("dsize"),
)
add_transform(
    "rotate",
    [image("tensor"), _BATCHED],
    "SciPy map_coordinates",
    fn="rotate",
    config={"mode": "bicubic", "padding_mode": "border"},
    peer=warp_peers.in_place(warp_peers.rotation, "bicubic", "border"),
    frames=Frames(
        PIXELS,
        config={"mode": "bilinear"},
        peer=warp_peers.in_place(warp_peers.rotation, padding="border", of_bytes=True),
    ),
    **_CUBIC,
)
add_transform(
    "affine",
    [image("tensor"), TensorSpec("matrix", ("B", 2, 3), description="from source to destination pixels")],
    "SciPy map_coordinates",
    fn="affine",
    peer=warp_peers.in_place(warp_peers.given),
    **WARP,
)
add_transform(
    "translate",
    [image("tensor"), TensorSpec("translation", ("B", 2), description="pixels to the right and down")],
    "SciPy map_coordinates",
    fn="translate",
    peer=warp_peers.in_place(warp_peers.translation),
    **WARP,
)
add_transform(
    "scale",
    [image("tensor"), TensorSpec("scale_factor", ("B", 2), description="factors along x and y"), _CENTER],
    "SciPy map_coordinates",
    fn="scale",
    peer=warp_peers.in_place(warp_peers.scaling, padding="border"),
    config={"padding_mode": "border"},
    **WARP,
)
add_transform(
    "shear",
    [image("tensor"), TensorSpec("shear", ("B", 2), description="along x and y")],
    "SciPy map_coordinates",
    fn="shear",
    config={"padding_mode": "reflection"},
    **WARP,
)
add_transform(
    "warp_grid",
    [
        TensorSpec("grid", ("B", "H", "W", 2), range=(-1, 1), description="points (x, y)"),
        TensorSpec("src_homo_dst", ("B", 3, 3)),
    ],
    "OpenCV perspectiveTransform",
    peer=opencv(lambda cv2, grid, m: cv2.perspectiveTransform(grid, m), "samples"),
    fn="warp_grid",
    makers={"src_homo_dst": "normalized"},
    outputs=[TensorSpec("points")],
    gradient_tolerances={"float32": Tolerance(1e-3, 1e-4)},
    picture="tensors",
)

for _mapping, _flag in (("linear", "WARP_POLAR_LINEAR"), ("log", "WARP_POLAR_LOG")):
    add_transform(
        f"warp_polar.{_mapping}",
        [
            image("src"),
            TensorSpec("center", ("B", 2), range=(3, 30), description="x and y in pixels"),
            TensorSpec("max_radius", ("B",), description="pixels"),
            like("dsize"),
        ],
        "OpenCV warpPolar",
        fn="warp_polar",
        config={"mapping": _mapping},
        symbols=SIZES,
        peer=warp_peers.polar(_flag),
        frames=Frames(peer=warp_peers.polar(_flag, True)),
        **WARP,
        errors=(*rejected_sizes("dsize"), *rejected_words("mapping")),
    )
add_transform(
    "elastic_transform2d",
    [
        image("image"),
        TensorSpec(
            "noise",
            ("B", 2, "H", "W"),
            range=(-1, 1),
            description="displacements along x and y before smoothing",
        ),
    ],
    "OpenCV GaussianBlur and torch.nn.functional.grid_sample",
    fn="elastic_transform2d",
    config={"kernel_size": (9, 7), "sigma": (2.0, 1.5), "alpha": (0.4, 0.3)},
    symbols=STENCIL,
    **WARP,
)
