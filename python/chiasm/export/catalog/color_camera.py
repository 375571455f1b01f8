"""Colour: luma and chroma, and what cameras deliver."""

from typing import Any

import numpy as np

from ..peer import Peer, cvt_color, opencv
from ..spec import Frames, Spec, TensorSpec, Tolerance, image
from . import add
from .color import BYTES, OPENCV, output, rgb, second_last

# --- luma and chroma ----------------------------------------------------------------------------------------

_YUV = "Y in [0, 1], U in [-0.436, 0.436], V in [-0.615, 0.615]"

#: A reason for `special_values`.
_ZERO_FACTORS = (
    "ONNX Runtime multiplies by the zeros of the matrix, which eager code leaves out: NaN of what is not"
    " finite"
)

# the trace needs to know that half of a size is not 1
_HALF = {"H": (3, 32768), "W": (3, 32768)}

_PLANES = [
    TensorSpec("y", layout="NCHW", color="GRAY"),
    TensorSpec("uv", layout="NCHW", color="UV", description="subsampled chroma"),
]

add(
    Spec(
        "color.rgb_to_y",
        [rgb()],
        output("GRAY"),
        peer=cvt_color("COLOR_RGB2GRAY", atol=1e-3),
        reference=OPENCV.format("COLOR_RGB2GRAY"),
        frames=Frames(
            reference="OpenCV cvtColor(COLOR_RGB2YCrCb)",
            peer=cvt_color("COLOR_RGB2YCrCb", after=lambda ycrcb: ycrcb[..., :1]),
        ),
    )
)

add(
    Spec(
        "color.rgb_to_ycbcr",
        [rgb()],
        output("YCbCr"),
        peer=cvt_color("COLOR_RGB2YCrCb", after=second_last),
        reference=OPENCV.format("COLOR_RGB2YCrCb"),
        frames=Frames(peer=cvt_color("COLOR_RGB2YCrCb", after=second_last)),
    )
)

add(
    Spec(
        "color.ycbcr_to_rgb",
        [image("image", channels=3, color="YCbCr")],
        output(),
        peer=cvt_color("COLOR_YCrCb2RGB", before=lambda x: (second_last(x),), atol=1e-3),
        reference=OPENCV.format("COLOR_YCrCb2RGB"),
        frames=Frames(peer=cvt_color("COLOR_YCrCb2RGB", before=lambda x: (second_last(x),))),
    )
)

add(
    Spec(
        "color.rgb_to_yuv",
        [rgb()],
        output("YUV", _YUV),
        peer=Peer("skimage.color", lambda color, x: color.rgb2yuv(x)),
        reference="scikit-image rgb2yuv",
        frames=Frames(reference="OpenCV cvtColor(COLOR_RGB2YUV)", peer=cvt_color("COLOR_RGB2YUV")),
    )
)

add(
    Spec(
        "color.yuv_to_rgb",
        [image("image", channels=3, color="YUV", range=(-0.6, 1.0), description=_YUV)],
        output(),
        special_values=_ZERO_FACTORS,
        peer=Peer("skimage.color", lambda color, x: color.yuv2rgb(x), atol=1e-4),
        reference="scikit-image yuv2rgb",
        frames=Frames(reference="OpenCV cvtColor(COLOR_YUV2RGB)", peer=cvt_color("COLOR_YUV2RGB")),
    )
)

# without odd sizes, whose last pixels chiasm repeats
_EVEN = {"H": 16, "W": 22}
_WITH_CHROMA = _EVEN | {"UH": 8, "UW": 11}


def _subsampled(rows: int) -> Peer:
    """scikit-image's conversion, and its means of the chroma over 2 columns and some rows."""

    def call(skimage: Any, x: Any) -> tuple[Any, ...]:
        yuv = skimage.color.rgb2yuv(x)
        return yuv[..., 0], skimage.transform.downscale_local_mean(yuv[..., 1:], (rows, 2, 1))

    return Peer("skimage", call, sizes=_EVEN)


def _repeated(y: Any, uv: Any) -> Any:
    """Both at the size of y."""
    return np.dstack([y, uv.repeat(2, 0).repeat(2, 1)])


def _subsampled_frames(rows: int) -> Peer:
    def call(cv2: Any, x: Any) -> tuple[Any, ...]:
        yuv = cv2.cvtColor(x, cv2.COLOR_RGB2YUV)
        return yuv[..., 0], cv2.resize(yuv, None, fx=0.5, fy=1 / rows, interpolation=cv2.INTER_AREA)[..., 1:]

    return opencv(call, sizes=_EVEN, atol=1)


add(
    Spec(
        "color.rgb_to_yuv420",
        [rgb()],
        _PLANES,
        symbols=_HALF,
        peer=_subsampled(2),
        reference="scikit-image rgb2yuv, then NumPy means of 2 x 2",
        frames=Frames(
            reference="OpenCV cvtColor(COLOR_RGB2YUV), then NumPy means of 2 x 2", peer=_subsampled_frames(2)
        ),
    )
)

add(
    Spec(
        "color.rgb_to_yuv422",
        [rgb()],
        _PLANES,
        symbols=_HALF,
        peer=_subsampled(1),
        reference="scikit-image rgb2yuv, then NumPy means of 1 x 2",
        frames=Frames(
            reference="OpenCV cvtColor(COLOR_RGB2YUV), then NumPy means of 1 x 2", peer=_subsampled_frames(1)
        ),
    )
)

add(
    Spec(
        "color.planar_yuv_to_rgb",
        [
            image("imagey", channels=1, color="GRAY"),
            TensorSpec(
                "imageuv",
                ("B", 2, "UH", "UW"),
                layout="NCHW",
                color="UV",
                range=(-0.4, 0.4),
                description="chroma of any resolution: 4:4:4, 4:2:2, 4:2:0",
            ),
        ],
        output(),
        symbols={"UH": (1, 32768), "UW": (1, 32768)},
        # the gradient of a chroma sample is a sum over its pixels, whose order each backend chooses
        gradient_tolerances={"float32": Tolerance(1e-3, 1e-4)},
        special_values=_ZERO_FACTORS,
        peer=Peer(
            "skimage.color",
            lambda color, y, uv: color.yuv2rgb(_repeated(y, uv)),
            atol=1e-4,
            sizes=_WITH_CHROMA,
        ),
        reference="scikit-image yuv2rgb of NumPy repeat",
        frames=Frames(
            reference="OpenCV cvtColor(COLOR_YUV2RGB) of NumPy repeat",
            peer=opencv(
                lambda cv2, y, uv: cv2.cvtColor(_repeated(y, uv), cv2.COLOR_YUV2RGB),
                sizes=_WITH_CHROMA,
            ),
        ),
    )
)

# --- camera formats -----------------------------------------------------------------------------------------

_LUMA = TensorSpec("y", ("B", 1, "H", "W"), "uint8", "NCHW", "GRAY", (0, 255), "luma, image batch")
_CHROMA = {"UH": (1, 32768), "UW": (1, 32768)}


def _chroma(name: str, channels: int) -> TensorSpec:
    description = f"chroma {name.upper()} around 128, of any resolution, image batch"
    return TensorSpec(name, ("B", channels, "UH", "UW"), "uint8", "NCHW", "UV", (0, 255), description)


def in_one_buffer(y: Any, u: Any, v: Any) -> Any:
    """The planes of I420, as OpenCV gets them."""
    return np.reshape(np.concatenate([y.ravel(), u.ravel(), v.ravel()]), (-1, y.shape[1]))


def _two_planes(code: str) -> Peer:
    return opencv(
        lambda cv2, y, pairs: cv2.cvtColorTwoPlane(y, pairs, getattr(cv2, code)),
        sizes=_WITH_CHROMA,
    )


for _name, _parts, _peer in (
    ("nv12", [_chroma("uv", 2)], _two_planes("COLOR_YUV2RGB_NV12")),
    ("nv21", [_chroma("vu", 2)], _two_planes("COLOR_YUV2RGB_NV21")),
    (
        "i420",
        [_chroma("u", 1), _chroma("v", 1)],
        opencv(
            lambda cv2, whole: cv2.cvtColor(whole, cv2.COLOR_YUV2RGB_I420),
            before=lambda y, u, v: (in_one_buffer(y, u, v),),
            sizes=_WITH_CHROMA,
        ),
    ),
):
    add(
        Spec(
            f"color.{_name}_to_rgb",
            [_LUMA, *_parts],
            output(),
            symbols=_CHROMA,
            peer=_peer,
            also=({"standard": "bt709"}, {"standard": "jpeg"}) if _name == "i420" else (),
            reference="OpenCV cvtColorTwoPlane; ITU-R BT.601 and BT.709 in NumPy float64",
            frames=Frames(peer=_peer),
        )
    )

add(
    Spec(
        "color.rgb_to_nv12",
        [BYTES],
        _PLANES,
        symbols=_HALF,
        reference="OpenCV cvtColor(COLOR_RGB2YUV_I420); ITU-R BT.601 and BT.709 in NumPy float64",
        frames=Frames(),
    )
)

for _name in ("yuyv", "uyvy"):
    _code = f"COLOR_YUV2RGB_{_name.upper()}"
    _peer = cvt_color(_code, before=lambda x: (x.reshape(x.shape[0], 2 * x.shape[1], 2),))
    add(
        Spec(
            f"color.{_name}_to_rgb",
            [
                TensorSpec(
                    "image", ("B", 4, "H", "W"), "uint8", "NCHW", "", (0, 255), "pairs of pixels, image batch"
                )
            ],
            output(),
            peer=_peer,
            reference=f"OpenCV cvtColor({_code})",
            frames=Frames(peer=_peer),
        )
    )

# --- raw ----------------------------------------------------------------------------------------------------

_RAW = image("image", channels=1, color="BAYER", description="raw images, red in the top left corner")

add(
    Spec(
        "color.raw_to_rgb",
        [_RAW],
        output(),
        config={"cfa": "bg"},
        symbols={"H": (2, 32768), "W": (2, 32768)},
        peer=cvt_color(
            "COLOR_BayerBG2RGB",
            before=lambda x: (np.rint(65535 * x).astype(np.uint16),),
            after=lambda rgb: rgb / 65535,
            edge=1,
        ),
        reference="OpenCV cvtColor(COLOR_BayerBG2RGB); SciPy convolve",
        frames=Frames(("uint8", "uint16"), peer=cvt_color("COLOR_BayerBG2RGB", edge=1)),
    )
)

add(
    Spec(
        "color.raw_to_rgb_2x2_downscaled",
        [_RAW],
        output(),
        config={"cfa": "bg"},
        symbols={"H": (4, 32768), "W": (4, 32768)},
        reference="NumPy slices",
        frames=Frames(("uint8", "uint16")),
    )
)

add(
    Spec(
        "color.rgb_to_raw",
        [rgb()],
        output("BAYER"),
        config={"cfa": "bg"},
        reference="NumPy slices",
        frames=Frames(("uint8", "uint16")),
    )
)
