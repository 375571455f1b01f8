"""Geometry: resampling, homographies."""

from typing import Any

import torch
from PIL import Image
from torch import Generator, Tensor

from ..peer import Peer, opencv, warped
from ..spec import ErrorInput, Frames, Spec, TensorSpec, Tolerance, image, like
from . import ZERO_WEIGHTS, add, rejected, rejected_sizes, rejected_words

# --- resize -------------------------------------------------------------------------------------------------


def _resized(interpolation: str, **options: Any) -> Peer:
    return opencv(
        lambda cv2, x, size: cv2.resize(x, size, interpolation=getattr(cv2, interpolation)),
        before=lambda x, like: (x, like.shape[::-1]),
        **options,
    )


def _pillow(resample: str) -> Peer:
    return Peer(
        "PIL.Image",
        lambda Image, x, size: Image.fromarray(x).resize(size, getattr(Image, resample)),
        "planes",
        before=lambda x, like: (x, like.shape[::-1]),
    )


def _pillow_frames(resample: str) -> Peer:
    """Along the rows first: one call with both sizes would choose the faster order."""
    return Peer(
        "PIL.Image",
        lambda Image, x, size: x.resize((size[0], x.size[1]), getattr(Image, resample)).resize(
            size, getattr(Image, resample)
        ),
        before=lambda x, like: (Image.fromarray(x), like.shape[::-1]),
        sizes={"C": 3},
    )


_PEERS = {
    "bilinear": _resized("INTER_LINEAR"),
    "bicubic": _resized("INTER_CUBIC"),
    "nearest": _resized("INTER_NEAREST"),
    "bilinear_antialias": _pillow("BILINEAR"),
    "bicubic_antialias": _pillow("BICUBIC"),
    "lanczos_antialias": _pillow("LANCZOS"),
    # reductions only: OpenCV's INTER_AREA interpolates when it enlarges
    "area": _resized("INTER_AREA", sizes={"C": 3, "OH": 5, "OW": 4}),
}
_FRAMES = {
    "bilinear_antialias": Frames(reference="Pillow resize", peer=_pillow_frames("BILINEAR")),
    "bicubic_antialias": Frames(reference="Pillow resize", peer=_pillow_frames("BICUBIC")),
    "lanczos_antialias": Frames(reference="Pillow resize", peer=_pillow_frames("LANCZOS")),
    "area": Frames(
        reference="OpenCV resize(INTER_AREA)",
        peer=_resized("INTER_AREA", sizes={"C": 3, "OH": 5, "OW": 4}, atol=1),
    ),
    "bilinear": Frames(reference="OpenCV resize(INTER_LINEAR_EXACT)", peer=_resized("INTER_LINEAR_EXACT")),
    "bicubic": Frames(reference="OpenCV resize(INTER_CUBIC)", peer=_resized("INTER_CUBIC", atol=1)),
    "nearest": Frames(
        ("uint8", "int16", "uint16", "float32"),
        reference="OpenCV resize(INTER_NEAREST)",
        peer=_resized("INTER_NEAREST"),
    ),
}
_SIZES = {"OH": (1, 32768), "OW": (1, 32768)}

for _name, _config in {
    "bilinear": {"interpolation": "bilinear"},
    "bicubic": {"interpolation": "bicubic"},
    "nearest": {"interpolation": "nearest"},
    "bilinear_antialias": {"interpolation": "bilinear", "antialias": True},
    "bicubic_antialias": {"interpolation": "bicubic", "antialias": True},
    "lanczos_antialias": {"interpolation": "lanczos", "antialias": True},
    "area": {"interpolation": "area"},
}.items():
    add(
        Spec(
            f"geometry.transform.resize.{_name}",
            [image(), like("size")],
            [TensorSpec("output", layout="NCHW")],
            config=_config,
            symbols=_SIZES,
            peer=_PEERS[_name],
            reference="torch.nn.functional.interpolate; OpenCV resize; Pillow where antialiased",
            frames=_FRAMES[_name],
            special_values="" if _name == "nearest" else ZERO_WEIGHTS,
            picture="warps",
            errors=(
                *rejected_sizes("size"),
                *rejected("size", "positive sizes", (4, 0)),
                ErrorInput("size", (5,), "size: expected 2 numbers, got 1"),
                *rejected_words("interpolation", "side"),
            ),
        ),
        fn="geometry.transform.resize",
    )

# --- warp_perspective ---------------------------------------------------------------------------------------


def homography(generator: Generator, batch: int):
    """Mild homographies in pixel coordinates: near the identity, so that most of the image stays in view."""
    scale = torch.tensor([[0.1, 0.1, 3.0], [0.1, 0.1, 3.0], [1e-3, 1e-3, 0.0]], dtype=torch.float64)
    return (
        torch.eye(3, dtype=torch.float64)
        + (torch.rand((batch, 3, 3), generator=generator, dtype=torch.float64) * 2 - 1) * scale
    )


def _sample_warp(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    shape = (sizes["B"], sizes["C"], sizes["H"], sizes["W"])
    return {
        "src": torch.rand(shape, generator=generator, dtype=torch.float64).to(dtype),
        "M": homography(generator, sizes["B"]).to(dtype),
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
                symbols=_SIZES,
                # weights amplify the rounding of coordinates by the contrast, and the gradient by M is a sum
                # over all pixels
                tolerances={"float32": Tolerance(1e-3, 1e-3)},
                gradient_tolerances={"float32": Tolerance(5e-3, 2e-3)},
                sample=_sample_warp,
                peer=None if _padding == "fill" else warped("warpPerspective", _mode, _padding),
                reference="OpenCV warpPerspective",
                frames=(
                    Frames(
                        peer=None if _padding == "fill" else warped("warpPerspective", _mode, _padding, True)
                    )
                    if (_mode, _padding) in _WARPED_FRAMES
                    else None
                ),
                picture="warps",
                errors=(*rejected_sizes("dsize"), *rejected_words("mode", "padding_mode")),
            ),
            fn="geometry.transform.warp_perspective",
        )

# --- find_homography_dlt ------------------------------------------------------------------------------------


def _sample_points(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Points and where a homography takes them, with a little noise."""
    points = torch.rand((sizes["B"], sizes["N"], 2), generator=generator, dtype=torch.float64) * 200
    h = homography(generator, sizes["B"])
    mapped = torch.cat([points, torch.ones_like(points[..., :1])], -1) @ h.transpose(1, 2)
    noise = torch.randn(points.shape, generator=generator, dtype=torch.float64) * 0.05
    return {"points1": points.to(dtype), "points2": (mapped[..., :2] / mapped[..., 2:] + noise).to(dtype)}


_POINTS = ("B", "N", 2)
add(
    Spec(
        "geometry.homography.find_homography_dlt",
        [
            TensorSpec("points1", _POINTS, range=(0, 200), description="points in the first image (x, y)"),
            TensorSpec("points2", _POINTS, range=(0, 200), description="the same points in the second image"),
        ],
        [TensorSpec("homography")],
        symbols={"N": (4, 1 << 20)},
        tolerances={"float32": Tolerance(1e-3, 1e-3)},
        sample=_sample_points,
        reference="OpenCV findHomography; NumPy SVD in float64",
        picture="fitted maps",
        errors=rejected_words("solver"),
    )
)
