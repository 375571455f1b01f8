"""Colour conversions."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import torch
from torch import Generator, Tensor

from ..peer import Peer, cvt_color, opencv
from ..spec import Frames, Spec, TensorSpec, Tolerance, image
from . import add, rejected

_OPENCV = "OpenCV cvtColor({}) on float32 and uint8"
#: Reasons for `special_values`.
_ZERO_FACTORS = (
    "ONNX Runtime multiplies by the zeros of the matrix, which eager code leaves out: NaN of what is not"
    " finite"
)
_LOGARITHM = "powers in ONNX go by logarithms, and ONNX Runtime's logarithm of infinity is finite"


#: Ops that move channels support bytes and 16 bits; alpha is opaque.
_DEEP = Frames(("uint8", "uint16"))
_OPAQUE = Frames(
    config={"alpha_val": 255.0},
    ranges={"alpha_val": None},
    reference="OpenCV mixChannels",
    errors=rejected("alpha_val", "a number of dtype torch.uint8", math.nan),
)


def _rgb(name: str = "image"):
    return image(name, channels=3, color="RGB")


def _in_radians(hsv: Any):
    """OpenCV's hue is in degrees."""
    return hsv * np.array([np.pi / 180, 1.0, 1.0])


def _in_degrees(hue: Any) -> tuple[Any, ...]:
    """The inverse conversion."""
    return (hue * np.array([180 / np.pi, 1.0, 1.0], np.float32),)


def _second_last(pixels: Any) -> Any:
    """OpenCV has the red difference before the blue one, and lightness before saturation."""
    return np.ascontiguousarray(pixels[..., [0, 2, 1]])


def _output(color: str = "RGB", description: str = ""):
    return [TensorSpec("output", layout="NCHW", color=color, description=description)]


# --- grey ---------------------------------------------------------------------------------------------------

add(
    Spec(
        "color.rgb_to_grayscale",
        [_rgb()],
        _output("GRAY"),
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
        _output("GRAY"),
        peer=cvt_color("COLOR_BGR2GRAY"),
        reference=_OPENCV.format("COLOR_BGR2GRAY"),
        frames=Frames(peer=cvt_color("COLOR_BGR2GRAY")),
    )
)
add(
    Spec(
        "color.grayscale_to_rgb",
        [image("image", channels=1, color="GRAY")],
        _output(),
        peer=cvt_color("COLOR_GRAY2RGB"),
        reference=_OPENCV.format("COLOR_GRAY2RGB"),
        frames=_DEEP,
    )
)

# --- channel order, alpha, bytes ----------------------------------------------------------------------------

_BGR = image("image", channels=3, color="BGR")
_RGBA = image("image", channels=4, color="RGBA")
_ALPHA = TensorSpec("alpha_val", ("B", 1, "H", "W"), range=(0.0, 1.0), description="alpha of each pixel")
_BYTES = TensorSpec("image", ("B", 3, "H", "W"), "uint8", "NCHW", "RGB", (0, 255), "image batch")

add(
    Spec(
        "color.bgr_to_rgb",
        [_BGR],
        _output(),
        peer=cvt_color("COLOR_BGR2RGB"),
        reference=_OPENCV.format("COLOR_BGR2RGB"),
        frames=Frames(_DEEP.dtypes, peer=cvt_color("COLOR_BGR2RGB")),
    )
)
add(
    Spec(
        "color.rgb_to_bgr",
        [_rgb()],
        _output("BGR"),
        peer=cvt_color("COLOR_RGB2BGR"),
        reference=_OPENCV.format("COLOR_RGB2BGR"),
        frames=Frames(_DEEP.dtypes, peer=cvt_color("COLOR_RGB2BGR")),
    )
)
add(
    Spec(
        "color.rgb_to_rgba",
        [_rgb(), _ALPHA],
        _output("RGBA"),
        peer=Peer("numpy", lambda np, x, alpha: np.concatenate([x, alpha]), "samples"),
        reference="NumPy concatenate",
        frames=replace(_OPAQUE, peer=cvt_color("COLOR_RGB2RGBA")),
    )
)
add(
    Spec(
        "color.bgr_to_rgba",
        [_BGR, _ALPHA],
        _output("RGBA"),
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
        _output(),
        # the gradient of the background is a sum over all pixels, whose order each backend chooses
        gradient_tolerances={"float32": Tolerance(1e-3, 1e-4)},
        reference="Pillow alpha_composite",
        frames=Frames(
            _DEEP.dtypes,
            ranges={"background_color": None},
            reference=_OPENCV.format("COLOR_RGBA2RGB"),
            peer=cvt_color("COLOR_RGBA2RGB"),
        ),
    )
)
add(
    Spec(
        "color.rgba_to_bgr",
        [_RGBA],
        _output("BGR"),
        peer=cvt_color("COLOR_RGBA2BGR"),
        reference=_OPENCV.format("COLOR_RGBA2BGR"),
        frames=Frames(_DEEP.dtypes, peer=cvt_color("COLOR_RGBA2BGR")),
    )
)
add(
    Spec(
        "color.rgb_to_rgb255",
        [_rgb()],
        _output(description="bytes"),
        gradients=(),
        peer=opencv(lambda cv2, x: cv2.convertScaleAbs(x, alpha=255)),
        reference="NumPy rint; OpenCV addWeighted(dtype=CV_8U)",
    )
)
add(
    Spec(
        "color.rgb255_to_rgb",
        [_BYTES],
        _output(),
        peer=Peer("numpy", lambda np, x: x * np.float32(1 / 255), "batch"),
        reference="NumPy",
    )
)
add(
    Spec(
        "color.normals_to_rgb255",
        [image("image", channels=3, range=(-1.0, 1.0), description="surface normals")],
        _output(description="bytes"),
        gradients=(),
        reference="NumPy rint",
    )
)
add(Spec("color.rgb255_to_normals", [_BYTES], _output("", "unit surface normals"), reference="NumPy float64"))
add(
    Spec(
        "color.sepia",
        [_rgb("input")],
        _output(),
        # the largest value's gradient is a sum over all pixels, whose order each backend chooses
        gradient_tolerances={"float32": Tolerance(1e-3, 1e-4)},
        reference="OpenCV transform; NumPy float64",
        frames=Frames(reference="NumPy whole numbers"),
    )
)

# --- hexagonal spaces ---------------------------------------------------------------------------------------

add(
    Spec(
        "color.rgb_to_hsv",
        [_rgb()],
        _output("HSV", "hue in [0, 2 pi], saturation and value in [0, 1]"),
        peer=cvt_color("COLOR_RGB2HSV", after=_in_radians, atol=1e-4),
        reference="OpenCV cvtColor(COLOR_RGB2HSV) on float32",
        frames=Frames(
            reference="OpenCV cvtColor(COLOR_RGB2HSV)", peer=cvt_color("COLOR_RGB2HSV", atol=1, share=1e-3)
        ),
    )
)


def _hue(name: str):
    """Hues of a turn and the two other channels in [0, 1]."""

    def sample(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        unit = torch.rand((sizes["B"], 3, sizes["H"], sizes["W"]), generator=generator, dtype=torch.float64)
        return {name: (unit * torch.tensor([6.283, 1.0, 1.0], dtype=torch.float64)[:, None, None]).to(dtype)}

    return sample


_EXACT = "OpenCV cvtColor; exact numbers in float64"
for _space in ("hls", "hsl", "hsv"):
    _color = _space.upper()
    if _space == "hsl":  # OpenCV has another order
        _frames = Frames(
            reference=_EXACT, peer=cvt_color("COLOR_RGB2HLS", after=_second_last, atol=1, share=5e-3)
        )
        _frames_back = Frames(
            reference=_EXACT,
            peer=cvt_color("COLOR_HLS2RGB", before=lambda x: (_second_last(x),), atol=1, share=5e-3),
        )
    else:
        _frames, _frames_back = (
            Frames(reference=_EXACT, peer=cvt_color(f"COLOR_{way}", atol=1, share=5e-3))
            for way in (f"RGB2{_color}", f"{_color}2RGB")
        )
    if _space != "hsv":
        add(
            Spec(
                f"color.rgb_to_{_space}",
                [_rgb()],
                _output(_color, "hue in [0, 2 pi], the others in [0, 1]"),
                peer=cvt_color("COLOR_RGB2HLS", after=_in_radians, atol=1e-4) if _space == "hls" else None,
                reference=_OPENCV.format("COLOR_RGB2HLS"),
                frames=_frames,
            )
        )
    add(
        Spec(
            f"color.{_space}_to_rgb",
            [image("image", channels=3, color=_color, description="hue in radians, the others in [0, 1]")],
            _output(),
            sample=_hue("image"),
            peer=(
                None if _space == "hsl" else cvt_color(f"COLOR_{_color}2RGB", before=_in_degrees, atol=1e-4)
            ),
            reference=_OPENCV.format("COLOR_HSV2RGB, COLOR_HLS2RGB") + "; colorsys",
            frames=_frames_back,
        )
    )

# --- CIE ----------------------------------------------------------------------------------------------------

# exp(c log x) for x ^ c, here and in the backends, has a relative error of a few float32 roundings, which
# L*a*b* and L*u*v* multiply by up to 1500
_CIE = {"float32": Tolerance(5e-4, 1e-4)}

add(
    Spec(
        "color.rgb_to_linear_rgb",
        [_rgb()],
        _output(description="linear light"),
        reference="scikit-image; IEC 61966-2-1 in NumPy float64",
    )
)
add(
    Spec(
        "color.linear_rgb_to_rgb",
        [_rgb()],
        _output(),
        special_values=_LOGARITHM,
        reference="scikit-image; IEC 61966-2-1 in NumPy float64",
    )
)
add(
    Spec(
        "color.rgb_to_xyz",
        [_rgb()],
        _output("XYZ"),
        peer=cvt_color("COLOR_RGB2XYZ"),
        reference=_OPENCV.format("COLOR_RGB2XYZ"),
        frames=Frames(peer=cvt_color("COLOR_RGB2XYZ")),
    )
)
add(
    Spec(
        "color.xyz_to_rgb",
        [image("image", channels=3, color="XYZ")],
        _output(),
        peer=cvt_color("COLOR_XYZ2RGB"),
        reference=_OPENCV.format("COLOR_XYZ2RGB"),
        frames=Frames(peer=cvt_color("COLOR_XYZ2RGB")),
    )
)
add(
    Spec(
        "color.rgb_to_lab",
        [_rgb()],
        _output("LAB", "L in [0, 100], a and b within [-128, 127]"),
        tolerances=_CIE,
        # derivatives of a and b with respect to a dark colour are in the hundreds
        gradient_tolerances={"float32": Tolerance(5e-3, 1e-3)},
        special_values=_LOGARITHM,
        peer=cvt_color("COLOR_RGB2Lab", atol=0.5),
        reference="scikit-image rgb2lab; OpenCV cvtColor(COLOR_RGB2Lab)",
        frames=Frames(peer=cvt_color("COLOR_RGB2Lab", atol=3)),
    )
)
add(
    Spec(
        "color.rgb_to_luv",
        [_rgb()],
        _output("LUV", "L in [0, 100], u in [-134, 220], v in [-140, 122]"),
        tolerances=_CIE,
        gradient_tolerances={"float32": Tolerance(5e-3, 1e-3)},
        special_values=_LOGARITHM,
        peer=cvt_color("COLOR_RGB2Luv", atol=0.05),
        reference="scikit-image rgb2luv; OpenCV cvtColor(COLOR_RGB2Luv)",
        frames=Frames(peer=cvt_color("COLOR_RGB2Luv", atol=1)),
    )
)


def _sample_cie(space: str):
    """Colours in sRGB, away from the gamut's faces, where clipping has a kink."""

    def sample(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        from chiasm import color

        unit = torch.rand((sizes["B"], 3, sizes["H"], sizes["W"]), generator=generator, dtype=torch.float64)
        return {"image": getattr(color, f"rgb_to_{space}")(0.05 + 0.9 * unit).to(dtype)}

    return sample


add(
    Spec(
        "color.lab_to_rgb",
        [image("image", channels=3, color="LAB", range=(-128.0, 127.0))],
        _output(),
        sample=_sample_cie("lab"),
        peer=cvt_color("COLOR_Lab2RGB", atol=1e-3),
        reference="scikit-image lab2rgb; OpenCV cvtColor(COLOR_Lab2RGB)",
        frames=Frames(peer=cvt_color("COLOR_Lab2RGB", atol=4, share=0.1)),
    )
)
add(
    Spec(
        "color.luv_to_rgb",
        [image("image", channels=3, color="LUV", range=(-140.0, 220.0))],
        _output(),
        special_values=_LOGARITHM,
        sample=_sample_cie("luv"),
        peer=cvt_color("COLOR_Luv2RGB", atol=1e-3),
        reference="scikit-image luv2rgb; OpenCV cvtColor(COLOR_Luv2RGB)",
        frames=Frames(peer=cvt_color("COLOR_Luv2RGB", atol=4, share=0.1)),
    )
)

# --- video --------------------------------------------------------------------------------------------------

_YUV = "Y in [0, 1], U in [-0.436, 0.436], V in [-0.615, 0.615]"
# the trace needs to know that half of a size is not 1
_HALF = {"H": (3, 32768), "W": (3, 32768)}
_PLANES = [
    TensorSpec("y", layout="NCHW", color="GRAY"),
    TensorSpec("uv", layout="NCHW", color="UV", description="subsampled chroma"),
]

add(
    Spec(
        "color.rgb_to_y",
        [_rgb()],
        _output("GRAY"),
        peer=cvt_color("COLOR_RGB2GRAY", atol=1e-3),
        reference=_OPENCV.format("COLOR_RGB2GRAY"),
        frames=Frames(
            reference="OpenCV cvtColor(COLOR_RGB2YCrCb)",
            peer=cvt_color("COLOR_RGB2YCrCb", after=lambda ycrcb: ycrcb[..., :1]),
        ),
    )
)
add(
    Spec(
        "color.rgb_to_ycbcr",
        [_rgb()],
        _output("YCbCr"),
        peer=cvt_color("COLOR_RGB2YCrCb", after=_second_last),
        reference=_OPENCV.format("COLOR_RGB2YCrCb"),
        frames=Frames(peer=cvt_color("COLOR_RGB2YCrCb", after=_second_last)),
    )
)
add(
    Spec(
        "color.ycbcr_to_rgb",
        [image("image", channels=3, color="YCbCr")],
        _output(),
        peer=cvt_color("COLOR_YCrCb2RGB", before=lambda x: (_second_last(x),), atol=1e-3),
        reference=_OPENCV.format("COLOR_YCrCb2RGB"),
        frames=Frames(peer=cvt_color("COLOR_YCrCb2RGB", before=lambda x: (_second_last(x),))),
    )
)
add(
    Spec(
        "color.rgb_to_yuv",
        [_rgb()],
        _output("YUV", _YUV),
        peer=Peer("skimage.color", lambda color, x: color.rgb2yuv(x)),
        reference="scikit-image rgb2yuv",
        frames=Frames(reference="OpenCV cvtColor(COLOR_RGB2YUV)", peer=cvt_color("COLOR_RGB2YUV")),
    )
)
add(
    Spec(
        "color.yuv_to_rgb",
        [image("image", channels=3, color="YUV", range=(-0.6, 1.0), description=_YUV)],
        _output(),
        special_values=_ZERO_FACTORS,
        peer=Peer("skimage.color", lambda color, x: color.yuv2rgb(x), atol=1e-4),
        reference="scikit-image yuv2rgb",
        frames=Frames(reference="OpenCV cvtColor(COLOR_YUV2RGB)", peer=cvt_color("COLOR_YUV2RGB")),
    )
)
add(
    Spec(
        "color.rgb_to_yuv420",
        [_rgb()],
        _PLANES,
        symbols=_HALF,
        reference="scikit-image rgb2yuv, then NumPy means of 2 x 2",
        frames=Frames(reference="OpenCV cvtColor(COLOR_RGB2YUV), then NumPy means of 2 x 2"),
    )
)
add(
    Spec(
        "color.rgb_to_yuv422",
        [_rgb()],
        _PLANES,
        symbols=_HALF,
        reference="scikit-image rgb2yuv, then NumPy means of 1 x 2",
        frames=Frames(reference="OpenCV cvtColor(COLOR_RGB2YUV), then NumPy means of 1 x 2"),
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
        _output(),
        symbols={"UH": (1, 32768), "UW": (1, 32768)},
        # the gradient of a chroma sample is a sum over its pixels, whose order each backend chooses
        gradient_tolerances={"float32": Tolerance(1e-3, 1e-4)},
        special_values=_ZERO_FACTORS,
        reference="scikit-image yuv2rgb of NumPy repeat",
        frames=Frames(reference="OpenCV cvtColor(COLOR_YUV2RGB) of NumPy repeat"),
    )
)

_LUMA = TensorSpec("y", ("B", 1, "H", "W"), "uint8", "NCHW", "GRAY", (0, 255), "luma, image batch")
_CHROMA = {"UH": (1, 32768), "UW": (1, 32768)}


def _chroma(name: str, channels: int) -> TensorSpec:
    description = f"chroma {name.upper()} around 128, of any resolution, image batch"
    return TensorSpec(name, ("B", channels, "UH", "UW"), "uint8", "NCHW", "UV", (0, 255), description)


def _two_planes(code: str) -> Peer:
    return opencv(
        lambda cv2, y, pairs: cv2.cvtColorTwoPlane(y, pairs, getattr(cv2, code)),
        sizes={"H": 16, "W": 22, "UH": 8, "UW": 11},
    )


for _name, _parts, _peer in (
    ("nv12", [_chroma("uv", 2)], _two_planes("COLOR_YUV2RGB_NV12")),
    ("nv21", [_chroma("vu", 2)], _two_planes("COLOR_YUV2RGB_NV21")),
    ("i420", [_chroma("u", 1), _chroma("v", 1)], None),
):
    add(
        Spec(
            f"color.{_name}_to_rgb",
            [_LUMA, *_parts],
            _output(),
            symbols=_CHROMA,
            peer=_peer,
            also=({"standard": "bt709"}, {"standard": "jpeg"}) if _peer is None else (),
            reference="OpenCV cvtColorTwoPlane; ITU-R BT.601 and BT.709 in NumPy float64",
            frames=Frames(peer=_peer),
        )
    )
add(
    Spec(
        "color.rgb_to_nv12",
        [_BYTES],
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
            _output(),
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
        _output(),
        config={"cfa": "bg"},
        symbols={"H": (2, 32768), "W": (2, 32768)},
        reference="OpenCV cvtColor(COLOR_BayerBG2RGB); SciPy convolve",
        frames=Frames(("uint8", "uint16"), peer=cvt_color("COLOR_BayerBG2RGB", edge=1)),
    )
)
add(
    Spec(
        "color.raw_to_rgb_2x2_downscaled",
        [_RAW],
        _output(),
        config={"cfa": "bg"},
        symbols={"H": (4, 32768), "W": (4, 32768)},
        reference="NumPy slices",
        frames=Frames(("uint8", "uint16")),
    )
)
add(
    Spec(
        "color.rgb_to_raw",
        [_rgb()],
        _output("BAYER"),
        config={"cfa": "bg"},
        reference="NumPy slices",
        frames=Frames(("uint8", "uint16")),
    )
)

# --- false colours ------------------------------------------------------------------------------------------

_CV_MAPS = "OpenCV applyColorMap"
add(
    Spec(
        "color.apply_colormap",
        [image("input_tensor", channels=1, color="GRAY")],
        _output(),
        config={"colormap": "viridis"},
        reference=_CV_MAPS,
    )
)
add(
    Spec(
        "color.apply_colormap.bytes",
        [TensorSpec("input_tensor", ("B", 1, "H", "W"), "uint8", "NCHW", "GRAY", (0, 255), "image batch")],
        _output(),
        config={"colormap": "turbo"},
        peer=opencv(
            lambda cv2, x: cv2.applyColorMap(x, cv2.COLORMAP_TURBO),
            after=lambda bgr: bgr[..., ::-1] / 255,
        ),
        reference=_CV_MAPS,
    ),
    fn="color.apply_colormap",
)
