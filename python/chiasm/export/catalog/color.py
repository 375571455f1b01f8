"""Colour: grey, the order and number of channels, false colours."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from ..peer import Peer, cvt_color, opencv
from ..spec import Frames, Spec, TensorSpec, Tolerance, image
from . import add, rejected

OPENCV = "OpenCV cvtColor({}) on float32 and uint8"


def rgb(name: str = "image"):
    return image(name, channels=3, color="RGB")


def output(color: str = "RGB", description: str = ""):
    return [TensorSpec("output", layout="NCHW", color=color, description=description)]


def second_last(pixels: Any) -> Any:
    """OpenCV has the red difference before the blue one, and lightness before saturation."""
    return np.ascontiguousarray(pixels[..., [0, 2, 1]])


# --- grey ---------------------------------------------------------------------------------------------------

#: Ops that move channels support bytes and 16 bits; alpha is opaque.
_DEEP = Frames(("uint8", "uint16"))

add(
    Spec(
        "color.rgb_to_grayscale",
        [rgb()],
        output("GRAY"),
        dtypes=("float32", "float64", "float16", "bfloat16"),
        peer=cvt_color("COLOR_RGB2GRAY"),
        reference="OpenCV cvtColor(COLOR_RGB2GRAY)",
        frames=Frames(peer=cvt_color("COLOR_RGB2GRAY")),
    )
)

add(
    Spec(
        "color.bgr_to_grayscale",
        [image("image", channels=3, color="BGR")],
        output("GRAY"),
        peer=cvt_color("COLOR_BGR2GRAY"),
        reference=OPENCV.format("COLOR_BGR2GRAY"),
        frames=Frames(peer=cvt_color("COLOR_BGR2GRAY")),
    )
)

add(
    Spec(
        "color.grayscale_to_rgb",
        [image("image", channels=1, color="GRAY")],
        output(),
        peer=cvt_color("COLOR_GRAY2RGB"),
        reference=OPENCV.format("COLOR_GRAY2RGB"),
        frames=replace(_DEEP, peer=cvt_color("COLOR_GRAY2RGB")),
    )
)

# --- channel order, alpha, bytes ----------------------------------------------------------------------------

_OPAQUE = Frames(
    config={"alpha_val": 255.0},
    ranges={"alpha_val": None},
    reference="OpenCV mixChannels",
    errors=rejected("alpha_val", "a number of dtype torch.uint8", math.nan),
)

_BGR = image("image", channels=3, color="BGR")
_RGBA = image("image", channels=4, color="RGBA")
_ALPHA = TensorSpec("alpha_val", ("B", 1, "H", "W"), range=(0.0, 1.0), description="alpha of each pixel")
BYTES = TensorSpec("image", ("B", 3, "H", "W"), "uint8", "NCHW", "RGB", (0, 255), "image batch")

add(
    Spec(
        "color.bgr_to_rgb",
        [_BGR],
        output(),
        peer=cvt_color("COLOR_BGR2RGB"),
        reference=OPENCV.format("COLOR_BGR2RGB"),
        frames=Frames(_DEEP.dtypes, peer=cvt_color("COLOR_BGR2RGB")),
    )
)

add(
    Spec(
        "color.rgb_to_bgr",
        [rgb()],
        output("BGR"),
        peer=cvt_color("COLOR_RGB2BGR"),
        reference=OPENCV.format("COLOR_RGB2BGR"),
        frames=Frames(_DEEP.dtypes, peer=cvt_color("COLOR_RGB2BGR")),
    )
)

add(
    Spec(
        "color.rgb_to_rgba",
        [rgb(), _ALPHA],
        output("RGBA"),
        peer=Peer("numpy", lambda np, x, alpha: np.concatenate([x, alpha]), "samples"),
        reference="NumPy concatenate",
        frames=replace(_OPAQUE, peer=cvt_color("COLOR_RGB2RGBA")),
    )
)

add(
    Spec(
        "color.bgr_to_rgba",
        [_BGR, _ALPHA],
        output("RGBA"),
        peer=Peer("numpy", lambda np, x, alpha: np.concatenate([x[::-1], alpha]), "samples"),
        reference="NumPy concatenate",
        frames=replace(_OPAQUE, peer=cvt_color("COLOR_BGR2RGBA")),
    )
)

add(
    Spec(
        "color.rgba_to_rgb",
        [
            _RGBA,
            TensorSpec(
                "background_color", (3,), range=(0.0, 1.0), description="red, green, blue of what lies behind"
            ),
        ],
        output(),
        # the gradient of the background is a sum over all pixels, whose order each backend chooses
        gradient_tolerances={"float32": Tolerance(1e-3, 1e-4)},
        peer=opencv(
            lambda cv2, x, behind: cv2.blendLinear(
                x[..., :3].copy(), behind, x[..., 3].copy(), 1 - x[..., 3]
            ),
            before=lambda x, color: (x, np.full((*x.shape[:2], 3), color, np.float32)),
        ),
        reference="Pillow alpha_composite; OpenCV blendLinear",
        frames=Frames(
            _DEEP.dtypes,
            ranges={"background_color": None},
            reference=OPENCV.format("COLOR_RGBA2RGB"),
            peer=cvt_color("COLOR_RGBA2RGB"),
        ),
    )
)

add(
    Spec(
        "color.rgba_to_bgr",
        [_RGBA],
        output("BGR"),
        peer=cvt_color("COLOR_RGBA2BGR"),
        reference=OPENCV.format("COLOR_RGBA2BGR"),
        frames=Frames(_DEEP.dtypes, peer=cvt_color("COLOR_RGBA2BGR")),
    )
)

add(
    Spec(
        "color.rgb_to_rgb255",
        [rgb()],
        output(description="bytes"),
        gradients=(),
        peer=opencv(lambda cv2, x: cv2.convertScaleAbs(x, alpha=255)),
        reference="NumPy rint; OpenCV addWeighted(dtype=CV_8U)",
    )
)

add(
    Spec(
        "color.rgb255_to_rgb",
        [BYTES],
        output(),
        peer=Peer("numpy", lambda np, x: x * np.float32(1 / 255), "batch"),
        reference="NumPy",
    )
)

add(
    Spec(
        "color.normals_to_rgb255",
        [image("image", channels=3, range=(-1.0, 1.0), description="surface normals")],
        output(description="bytes"),
        gradients=(),
        peer=opencv(lambda cv2, x: cv2.convertScaleAbs(x, alpha=127.5, beta=127.5)),
        reference="OpenCV convertScaleAbs",
    )
)

add(
    Spec(
        "color.rgb255_to_normals",
        [BYTES],
        output("", "unit surface normals"),
        peer=Peer("torch.nn.functional", lambda F, x: F.normalize(x / 127.5 - 1, dim=1), "tensors"),
        reference="torch.nn.functional.normalize; NumPy float64",
    )
)

_SEPIA = np.array([[0.393, 0.769, 0.189], [0.349, 0.686, 0.168], [0.272, 0.534, 0.131]], np.float32)


def _toned(cv2: Any, x: Any) -> Any:
    toned = cv2.transform(x, _SEPIA)
    most = max(cv2.minMaxLoc(plane)[1] for plane in cv2.split(toned)) + 1e-6
    return cv2.divide(toned, (most, most, most, 1.0))


add(
    Spec(
        "color.sepia",
        [rgb("input")],
        output(),
        # the largest value's gradient is a sum over all pixels, whose order each backend chooses
        gradient_tolerances={"float32": Tolerance(1e-3, 1e-4)},
        peer=opencv(_toned),
        reference="OpenCV transform; NumPy float64",
        frames=Frames(reference="NumPy whole numbers"),
    )
)

# --- false colours ------------------------------------------------------------------------------------------

_CV_MAPS = "OpenCV applyColorMap"

add(
    Spec(
        "color.apply_colormap",
        [image("input_tensor", channels=1, color="GRAY")],
        output(),
        config={"colormap": "viridis"},
        # between the levels, of which OpenCV's are rounded
        peer=opencv(
            lambda cv2, x: cv2.applyColorMap(x, cv2.COLORMAP_VIRIDIS),
            before=lambda x: (np.rint(255 * x).astype(np.uint8),),
            after=lambda bgr: bgr[..., ::-1] / 255,
            atol=0.01,
        ),
        reference=_CV_MAPS,
        frames=Frames(
            config={"colormap": "turbo"},
            peer=opencv(
                lambda cv2, x: cv2.applyColorMap(x, cv2.COLORMAP_TURBO), after=lambda bgr: bgr[..., ::-1]
            ),
        ),
    )
)
