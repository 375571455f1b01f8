"""Geometric transforms of images that keep the axes: sizes, flips, pyramids."""

import math
from typing import Any

from PIL import Image

from ..peer import Peer, opencv
from ..spec import PIXELS, ErrorInput, Frames, Spec, TensorSpec, image, like
from . import STENCIL, ZERO_WEIGHTS, add, rejected, rejected_sizes, rejected_words
from .geometry_transform import SIZES, add_transform

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
    "lanczos4": _resized("INTER_LANCZOS4"),
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
        PIXELS,
        reference="OpenCV resize(INTER_AREA)",
        peer=_resized("INTER_AREA", sizes={"C": 3, "OH": 5, "OW": 4}, atol=1),
    ),
    "bilinear": Frames(
        PIXELS, reference="OpenCV resize(INTER_LINEAR_EXACT)", peer=_resized("INTER_LINEAR_EXACT")
    ),
    "bicubic": Frames(PIXELS, reference="OpenCV resize(INTER_CUBIC)", peer=_resized("INTER_CUBIC", atol=1)),
    "lanczos4": Frames(
        PIXELS, reference="OpenCV resize(INTER_LANCZOS4)", peer=_resized("INTER_LANCZOS4", atol=1)
    ),
    "nearest": Frames(
        (*PIXELS, "float32"),
        reference="OpenCV resize(INTER_NEAREST)",
        peer=_resized("INTER_NEAREST"),
    ),
}

for _name, _config in {
    "bilinear": {"interpolation": "bilinear"},
    "bicubic": {"interpolation": "bicubic"},
    "lanczos4": {"interpolation": "lanczos4"},
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
            symbols=SIZES,
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

_RESIZE = "torch.nn.functional.interpolate"


def _interpolated(mode: str, **options: Any) -> Peer:
    """torch's, to 1.5 times the height and 0.7 times the width."""
    return Peer(
        "torch.nn.functional",
        lambda F, x: F.interpolate(
            x, scale_factor=(1.5, 0.7), mode=mode, recompute_scale_factor=True, **options
        ),
        "tensors",
        atol=3e-4,  # torch computes positions in float32
    )


add_transform(
    "rescale",
    [image()],
    _RESIZE,
    fn="rescale",
    config={"factor": (1.5, 0.7), "interpolation": "bicubic"},
    peer=_interpolated("bicubic"),
    symbols=STENCIL,
    errors=(
        ErrorInput("factor", math.nan, "factor: expected positive numbers, got (nan, nan)"),
        ErrorInput("factor", -1.0, "factor: expected positive numbers, got (-1.0, -1.0)"),
        ErrorInput("factor", 0.01, "factor: expected to leave a pixel of"),
    ),
)

add_transform(
    "rescale.antialias",
    [image()],
    "Pillow resize",
    fn="rescale",
    config={"factor": (1.5, 0.7), "antialias": True},
    peer=_interpolated("bilinear", antialias=True),
    symbols=STENCIL,
    special_values=ZERO_WEIGHTS,
)

add_transform(
    "resize_to_be_divisible",
    [image()],
    _RESIZE,
    fn="resize_to_be_divisible",
    config={"divisible_factor": 8},
    peer=Peer(
        "torch.nn.functional",
        lambda F, x, size: F.interpolate(x, size, mode="bilinear"),
        "tensors",
        before=lambda x: (x, [max(8 * round(n / 8), 8) for n in x.shape[2:]]),
    ),
    symbols=STENCIL,
    special_values=ZERO_WEIGHTS,
    errors=rejected("divisible_factor", "a positive number", 0),
)

# --- flips --------------------------------------------------------------------------------------------------

for _name, _axis in (("hflip", 1), ("vflip", 0), ("rot180", -1)):
    _flip = opencv(lambda cv2, x, axis=_axis: cv2.flip(x, axis))
    add_transform(
        _name,
        [image()],
        "NumPy",
        fn=_name,
        peer=_flip,
        frames=Frames(PIXELS, peer=_flip),
    )

_transpose = opencv(lambda cv2, x: cv2.transpose(x), sizes={"C": 3})
add_transform(
    "transpose",
    [image()],
    "OpenCV transpose",
    fn="transpose",
    peer=_transpose,
    frames=Frames(PIXELS, peer=_transpose),
)

# --- borders ------------------------------------------------------------------------------------------------

_MARGINS = {"top": 3, "bottom": 5, "left": 7, "right": 2}


def _bordered(border: str, value: float) -> Peer:
    """Of up to four channels, which OpenCV's value has."""
    return opencv(
        lambda cv2, x: cv2.copyMakeBorder(x, *_MARGINS.values(), getattr(cv2, border), value=(value,) * 4),
        sizes={"C": 3},
    )


for _name, _border in {
    "constant": "BORDER_CONSTANT",
    "replicate": "BORDER_REPLICATE",
    "reflect": "BORDER_REFLECT_101",
    "symmetric": "BORDER_REFLECT",
    "circular": "BORDER_WRAP",
}.items():
    add_transform(
        f"copy_make_border.{_name}",
        [image("image")],
        "OpenCV copyMakeBorder",
        fn="copy_make_border",
        config={**_MARGINS, "border_type": _name, "value": 0.5},
        symbols=STENCIL,
        peer=_bordered(_border, 0.5),
        frames=Frames(PIXELS, config={"value": 114.0}, peer=_bordered(_border, 114.0)),
        errors=rejected_words("border_type"),
    )

# --- pyramids -----------------------------------------------------------------------------------------------


def _blurred(cv2: Any, x: Any) -> Any:
    return cv2.GaussianBlur(x, (5, 5), 0, borderType=cv2.BORDER_REFLECT_101)


def _halved(cv2: Any, x: Any) -> Any:
    return cv2.resize(_blurred(cv2, x), (x.shape[1] // 2, x.shape[0] // 2))


def _pyramid(cv2: Any, x: Any) -> tuple[Any, ...]:
    half = _halved(cv2, x)
    return x, half, _halved(cv2, half)


def _alternate_pyramid(cv2: Any, x: Any) -> tuple[Any, ...]:
    half = cv2.pyrDown(x)
    return x, half, cv2.pyrDown(half)


add_transform(
    "pyrdown.by_2",
    [image()],
    "OpenCV GaussianBlur and resize",
    fn="pyrdown",
    symbols=STENCIL,
    peer=opencv(_halved),
    special_values=ZERO_WEIGHTS,
    frames=Frames(
        config={"sampling": "alternate"},
        reference="OpenCV pyrDown",
        peer=opencv(lambda cv2, x: cv2.pyrDown(x)),
    ),
)

add_transform(
    "pyrdown.by_1_5",
    [image()],
    "OpenCV GaussianBlur and torch.nn.functional.interpolate",
    fn="pyrdown",
    config={"border_type": "replicate", "align_corners": True, "factor": 1.5},
    errors=(*rejected("factor", "a positive number", 0.0, math.nan), *rejected_words("border_type")),
    symbols=STENCIL,
    special_values=ZERO_WEIGHTS,
)

add_transform(
    "pyrup",
    [image()],
    "OpenCV GaussianBlur and resize",
    fn="pyrup",
    peer=opencv(lambda cv2, x: _blurred(cv2, cv2.resize(x, None, fx=2, fy=2))),
    symbols=STENCIL,
    special_values=ZERO_WEIGHTS,
    frames=Frames(
        config={"sampling": "alternate"}, reference="OpenCV pyrUp", peer=opencv(lambda cv2, x: cv2.pyrUp(x))
    ),
)

_LEVELS = [TensorSpec(f"level{i}", layout="NCHW", description=f"1/{2**i} of the size") for i in range(3)]
_HALVES = {"H": (16, 32768), "W": (16, 32768)}

add_transform(
    "build_pyramid",
    [image()],
    "OpenCV GaussianBlur and resize",
    fn="build_pyramid",
    peer=opencv(_pyramid),
    config={"max_level": 3},
    symbols=_HALVES,
    special_values=ZERO_WEIGHTS,
    outputs=_LEVELS,
    frames=Frames(
        config={"sampling": "alternate"}, reference="OpenCV pyrDown", peer=opencv(_alternate_pyramid)
    ),
    errors=rejected("max_level", "a positive number", 0),
)

add_transform(
    "build_laplacian_pyramid",
    [image()],
    "the image comes back",
    fn="build_laplacian_pyramid",
    config={"max_level": 3},
    symbols=_HALVES,
    special_values=ZERO_WEIGHTS,
    outputs=_LEVELS,
)
