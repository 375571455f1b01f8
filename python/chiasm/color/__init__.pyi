# Written by `make stubs` from the signatures of the functions; do not edit.

from typing import Optional, Tuple, Union

from torch import Tensor, nn

from .camera import i420_to_rgb as i420_to_rgb
from .camera import nv12_to_rgb as nv12_to_rgb
from .camera import nv21_to_rgb as nv21_to_rgb
from .camera import rgb_to_nv12 as rgb_to_nv12
from .camera import uyvy_to_rgb as uyvy_to_rgb
from .camera import yuyv_to_rgb as yuyv_to_rgb
from .colormap import apply_colormap as apply_colormap
from .gray import bgr_to_grayscale as bgr_to_grayscale
from .gray import grayscale_to_rgb as grayscale_to_rgb
from .gray import rgb_to_grayscale as rgb_to_grayscale
from .hls import hls_to_rgb as hls_to_rgb
from .hls import hsl_to_rgb as hsl_to_rgb
from .hls import rgb_to_hls as rgb_to_hls
from .hls import rgb_to_hsl as rgb_to_hsl
from .hsv import hsv_to_rgb as hsv_to_rgb
from .hsv import rgb_to_hsv as rgb_to_hsv
from .lab import lab_to_rgb as lab_to_rgb
from .lab import rgb_to_lab as rgb_to_lab
from .linear import linear_rgb_to_rgb as linear_rgb_to_rgb
from .linear import rgb_to_linear_rgb as rgb_to_linear_rgb
from .luv import luv_to_rgb as luv_to_rgb
from .luv import rgb_to_luv as rgb_to_luv
from .names import CFA as CFA
from .names import ColorMapType as ColorMapType
from .raw import raw_to_rgb as raw_to_rgb
from .raw import raw_to_rgb_2x2_downscaled as raw_to_rgb_2x2_downscaled
from .raw import rgb_to_raw as rgb_to_raw
from .rgb import bgr_to_rgb as bgr_to_rgb
from .rgb import rgb_to_bgr as rgb_to_bgr
from .rgb255 import normals_to_rgb255 as normals_to_rgb255
from .rgb255 import rgb255_to_normals as rgb255_to_normals
from .rgb255 import rgb255_to_rgb as rgb255_to_rgb
from .rgb255 import rgb_to_rgb255 as rgb_to_rgb255
from .rgba import bgr_to_rgba as bgr_to_rgba
from .rgba import rgb_to_rgba as rgb_to_rgba
from .rgba import rgba_to_bgr as rgba_to_bgr
from .rgba import rgba_to_rgb as rgba_to_rgb
from .sepia import sepia as sepia
from .xyz import rgb_to_xyz as rgb_to_xyz
from .xyz import xyz_to_rgb as xyz_to_rgb
from .ycbcr import rgb_to_y as rgb_to_y
from .ycbcr import rgb_to_ycbcr as rgb_to_ycbcr
from .ycbcr import ycbcr_to_rgb as ycbcr_to_rgb
from .yuv import planar_yuv_to_rgb as planar_yuv_to_rgb
from .yuv import rgb_to_yuv as rgb_to_yuv
from .yuv import rgb_to_yuv420 as rgb_to_yuv420
from .yuv import rgb_to_yuv422 as rgb_to_yuv422
from .yuv import yuv420_to_rgb as yuv420_to_rgb
from .yuv import yuv422_to_rgb as yuv422_to_rgb
from .yuv import yuv_to_rgb as yuv_to_rgb

class ApplyColormap(nn.Module):
    """`apply_colormap` as a module: Apply a colour map to a one-channel image."""

    colormap: str
    def __init__(self, colormap: str) -> None: ...
    def forward(self, input_tensor: Tensor) -> Tensor: ...
    def __call__(self, input_tensor: Tensor) -> Tensor: ...

ApplyColorMap = ApplyColormap

class BgrToGrayscale(nn.Module):
    """`bgr_to_grayscale` as a module: Luma of ITU-R BT.601, 0.299 R + 0.587 G + 0.114 B, of an image
    whose channels are B, G, R."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class BgrToRgb(nn.Module):
    """`bgr_to_rgb` as a module: Reverse the order of the three channels (BGR to RGB, or back)."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class BgrToRgba(nn.Module):
    """`bgr_to_rgba` as a module: Bring the channels into the order red, green, blue and append an alpha
    channel."""

    alpha_val: Union[float, Tensor]
    def __init__(self, alpha_val: Union[float, Tensor]) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class GrayscaleToRgb(nn.Module):
    """`grayscale_to_rgb` as a module: Repeat the grey channel three times."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class HlsToRgb(nn.Module):
    """`hls_to_rgb` as a module: RGB in [0, 1] from hue in radians, lightness and saturation."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class HslToRgb(nn.Module):
    """`hsl_to_rgb` as a module: ``hls_to_rgb`` with channels in the order hue, saturation, lightness,
    also for uint8."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class HsvToRgb(nn.Module):
    """`hsv_to_rgb` as a module: RGB in [0, 1] from hue in radians, saturation and value."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class I420ToRgb(nn.Module):
    """`i420_to_rgb` as a module: RGB from three planes (4:2:0), the format of video codecs; otherwise as
    ``nv12_to_rgb``. YV12 is the same format with V before U."""

    standard: str
    def __init__(self, standard: str = "bt601") -> None: ...
    def forward(self, y: Tensor, u: Tensor, v: Tensor) -> Tensor: ...
    def __call__(self, y: Tensor, u: Tensor, v: Tensor) -> Tensor: ...

class LabToRgb(nn.Module):
    """`lab_to_rgb` as a module: sRGB from CIE 1976 L*a*b* for D65 white, the inverse of
    ``rgb_to_lab``."""

    clip: bool
    def __init__(self, clip: bool = True) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class LinearRgbToRgb(nn.Module):
    """`linear_rgb_to_rgb` as a module: sRGB from linear light: 1.055 c ^ (1 / 2.4) - 0.055 above
    0.0031308, 12.92 c below (IEC 61966-2-1)."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class LuvToRgb(nn.Module):
    """`luv_to_rgb` as a module: sRGB from CIE 1976 L*u*v* for D65 white, the inverse of ``rgb_to_luv``;
    the result is not clipped."""

    eps: float
    def __init__(self, eps: float = 1e-12) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class NormalsToRgb255(nn.Module):
    """`normals_to_rgb255` as a module: Surface normals as uint8 colours: 255 (n + 1) / 2, rounded and
    saturated."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class Nv12ToRgb(nn.Module):
    """`nv12_to_rgb` as a module: RGB from luma and pairs U, V (4:2:0), the format of hardware decoders
    and V4L2 cameras."""

    standard: str
    def __init__(self, standard: str = "bt601") -> None: ...
    def forward(self, y: Tensor, uv: Tensor) -> Tensor: ...
    def __call__(self, y: Tensor, uv: Tensor) -> Tensor: ...

class Nv21ToRgb(nn.Module):
    """`nv21_to_rgb` as a module: RGB from luma and pairs V, U (4:2:0), the format of Android's cameras.
    Otherwise as ``nv12_to_rgb``."""

    standard: str
    def __init__(self, standard: str = "bt601") -> None: ...
    def forward(self, y: Tensor, vu: Tensor) -> Tensor: ...
    def __call__(self, y: Tensor, vu: Tensor) -> Tensor: ...

class PlanarYuvToRgb(nn.Module):
    """`planar_yuv_to_rgb` as a module: RGB from luma and chroma of any resolution, by the nearest chroma
    sample."""
    def __init__(self) -> None: ...
    def forward(self, imagey: Tensor, imageuv: Tensor) -> Tensor: ...
    def __call__(self, imagey: Tensor, imageuv: Tensor) -> Tensor: ...

class RawToRgb(nn.Module):
    """`raw_to_rgb` as a module: RGB from a Bayer raw image, by bilinear interpolation."""

    cfa: str
    def __init__(self, cfa: str) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class RawToRgb2x2Downscaled(nn.Module):
    """`raw_to_rgb_2x2_downscaled` as a module: RGB at half the width and height: each 2 x 2 samples
    become one pixel."""

    cfa: str
    def __init__(self, cfa: str) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class Rgb255ToNormals(nn.Module):
    """`rgb255_to_normals` as a module: Unit surface normals from colours: 2 c / 255 - 1, divided by its
    length."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class Rgb255ToRgb(nn.Module):
    """`rgb255_to_rgb` as a module: Divide an image in [0, 255] by 255."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class RgbToBgr(nn.Module):
    """`rgb_to_bgr` as a module: Reverse the order of the three channels: the same as ``bgr_to_rgb``."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class RgbToGrayscale(nn.Module):
    """`rgb_to_grayscale` as a module: Weighted sum of the channels; by default the luma of ITU-R BT.601:
    0.299 R + 0.587 G + 0.114 B."""

    rgb_weights: Optional[Tensor]
    def __init__(self, rgb_weights: Optional[Tensor] = None) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class RgbToHls(nn.Module):
    """`rgb_to_hls` as a module: Hue in radians [0, 2 pi), lightness (max + min) / 2 and saturation in
    [0, 1]."""

    eps: float
    def __init__(self, eps: float = 1e-08) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class RgbToHsl(nn.Module):
    """`rgb_to_hsl` as a module: ``rgb_to_hls`` with its channels in the order hue, saturation,
    lightness, also for uint8."""

    eps: float
    def __init__(self, eps: float = 1e-08) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class RgbToHsv(nn.Module):
    """`rgb_to_hsv` as a module: Hue in radians [0, 2 pi), saturation and value in [0, 1]."""

    eps: float
    def __init__(self, eps: float = 1e-08) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class RgbToLab(nn.Module):
    """`rgb_to_lab` as a module: CIE 1976 L*a*b* of an sRGB image, for D65 white."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class RgbToLinearRgb(nn.Module):
    """`rgb_to_linear_rgb` as a module: Linear light from sRGB: ((c + 0.055) / 1.055) ^ 2.4 above
    0.04045, c / 12.92 below (IEC 61966-2-1)."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class RgbToLuv(nn.Module):
    """`rgb_to_luv` as a module: CIE 1976 L*u*v* of an sRGB image, for D65 white."""

    eps: float
    def __init__(self, eps: float = 1e-12) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class RgbToNv12(nn.Module):
    """`rgb_to_nv12` as a module: Luma and pairs U, V at half the width and height (4:2:0), the format of
    hardware encoders."""

    standard: str
    def __init__(self, standard: str = "bt601") -> None: ...
    def forward(self, image: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, image: Tensor) -> Tuple[Tensor, Tensor]: ...

class RgbToRaw(nn.Module):
    """`rgb_to_raw` as a module: Keep only the colour of each pixel that a Bayer sensor would record."""

    cfa: str
    def __init__(self, cfa: str) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class RgbToRgb255(nn.Module):
    """`rgb_to_rgb255` as a module: Convert an image in [0, 1] to uint8: 255 times the value, rounded
    (halves to even) and saturated. This is the conversion of OpenCV's ``convertTo`` with scale 255."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class RgbToRgba(nn.Module):
    """`rgb_to_rgba` as a module: Append an alpha channel."""

    alpha_val: Union[float, Tensor]
    def __init__(self, alpha_val: Union[float, Tensor]) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class RgbToXyz(nn.Module):
    """`rgb_to_xyz` as a module: CIE XYZ from linear RGB with the sRGB primaries and D65 white,
    (0.950456, 1, 1.088754)."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class RgbToY(nn.Module):
    """`rgb_to_y` as a module: Luma of ITU-R BT.601, 0.299 R + 0.587 G + 0.114 B: the first channel of
    ``rgb_to_ycbcr``."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class RgbToYcbcr(nn.Module):
    """`rgb_to_ycbcr` as a module: Luma and the two chroma channels, full range."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class RgbToYuv(nn.Module):
    """`rgb_to_yuv` as a module: Luma and the chroma channels of PAL."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class RgbToYuv420(nn.Module):
    """`rgb_to_yuv420` as a module: ``rgb_to_yuv`` with chroma at half the width and height, each the
    mean of 2 x 2 pixels."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, image: Tensor) -> Tuple[Tensor, Tensor]: ...

class RgbToYuv422(nn.Module):
    """`rgb_to_yuv422` as a module: ``rgb_to_yuv`` with chroma at half the width, each the mean of two
    pixels."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, image: Tensor) -> Tuple[Tensor, Tensor]: ...

class RgbaToBgr(nn.Module):
    """`rgba_to_bgr` as a module: Drop the alpha channel and bring the others into the order blue, green,
    red."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class RgbaToRgb(nn.Module):
    """`rgba_to_rgb` as a module: Drop the alpha channel, or blend with a background: alpha C + (1 -
    alpha) background."""

    background_color: Union[Tensor, Tuple[float, float, float], None]
    def __init__(self, background_color: Union[Tensor, Tuple[float, float, float], None] = None) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class Sepia(nn.Module):
    """`sepia` as a module: Apply a sepia tone, by the matrix (0.393, 0.769, 0.189; 0.349, 0.686, 0.168;
    0.272, 0.534, 0.131)."""

    rescale: bool
    eps: float
    def __init__(self, rescale: bool = True, eps: float = 1e-06) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class UyvyToRgb(nn.Module):
    """`uyvy_to_rgb` as a module: RGB from packed pixels U, Y, V, Y (4:2:2), the format of frame
    grabbers. Otherwise as ``yuyv_to_rgb``."""

    standard: str
    def __init__(self, standard: str = "bt601") -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class XyzToRgb(nn.Module):
    """`xyz_to_rgb` as a module: RGB from CIE XYZ, the inverse of ``rgb_to_xyz``; the result is not
    clipped."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class YcbcrToRgb(nn.Module):
    """`ycbcr_to_rgb` as a module: RGB from full-range Y, Cb, Cr. R = Y + 1.403 Cr', G = Y - 0.714 Cr' -
    0.344 Cb', B = Y + 1.773 Cb' with Cr' = Cr - 0.5, Cb' = Cb - 0.5. ITU-R BT.601 with OpenCV's rounded
    constants, so that the round trip is accurate to 1e-3 only. The result is not clipped. For uint8, the
    chroma is around 128, the factors are multiples of 1/2^14, and the sums are rounded (halves up) and
    saturated, so that the result is identical to OpenCV's."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class Yuv420ToRgb(nn.Module):
    """`yuv420_to_rgb` as a module: RGB from luma and chroma of half the width and height; each chroma
    sample is repeated over its 2 x 2 pixels."""
    def __init__(self) -> None: ...
    def forward(self, imagey: Tensor, imageuv: Tensor) -> Tensor: ...
    def __call__(self, imagey: Tensor, imageuv: Tensor) -> Tensor: ...

class Yuv422ToRgb(nn.Module):
    """`yuv422_to_rgb` as a module: RGB from luma and chroma of half the width; each chroma sample is
    repeated over its two pixels."""
    def __init__(self) -> None: ...
    def forward(self, imagey: Tensor, imageuv: Tensor) -> Tensor: ...
    def __call__(self, imagey: Tensor, imageuv: Tensor) -> Tensor: ...

class YuvToRgb(nn.Module):
    """`yuv_to_rgb` as a module: RGB from PAL's Y'UV, the inverse of ``rgb_to_yuv``; the result is not
    clipped."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class YuyvToRgb(nn.Module):
    """`yuyv_to_rgb` as a module: RGB from packed pixels Y, U, Y, V (4:2:2), the format of USB cameras;
    YUY2 is the same."""

    standard: str
    def __init__(self, standard: str = "bt601") -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

__all__ = [
    "CFA",
    "ApplyColorMap",
    "ApplyColormap",
    "BgrToGrayscale",
    "BgrToRgb",
    "BgrToRgba",
    "ColorMapType",
    "GrayscaleToRgb",
    "HlsToRgb",
    "HslToRgb",
    "HsvToRgb",
    "I420ToRgb",
    "LabToRgb",
    "LinearRgbToRgb",
    "LuvToRgb",
    "NormalsToRgb255",
    "Nv12ToRgb",
    "Nv21ToRgb",
    "PlanarYuvToRgb",
    "RawToRgb",
    "RawToRgb2x2Downscaled",
    "Rgb255ToNormals",
    "Rgb255ToRgb",
    "RgbToBgr",
    "RgbToGrayscale",
    "RgbToHls",
    "RgbToHsl",
    "RgbToHsv",
    "RgbToLab",
    "RgbToLinearRgb",
    "RgbToLuv",
    "RgbToNv12",
    "RgbToRaw",
    "RgbToRgb255",
    "RgbToRgba",
    "RgbToXyz",
    "RgbToY",
    "RgbToYcbcr",
    "RgbToYuv",
    "RgbToYuv420",
    "RgbToYuv422",
    "RgbaToBgr",
    "RgbaToRgb",
    "Sepia",
    "UyvyToRgb",
    "XyzToRgb",
    "YcbcrToRgb",
    "Yuv420ToRgb",
    "Yuv422ToRgb",
    "YuvToRgb",
    "YuyvToRgb",
    "apply_colormap",
    "bgr_to_grayscale",
    "bgr_to_rgb",
    "bgr_to_rgba",
    "grayscale_to_rgb",
    "hls_to_rgb",
    "hsl_to_rgb",
    "hsv_to_rgb",
    "i420_to_rgb",
    "lab_to_rgb",
    "linear_rgb_to_rgb",
    "luv_to_rgb",
    "normals_to_rgb255",
    "nv12_to_rgb",
    "nv21_to_rgb",
    "planar_yuv_to_rgb",
    "raw_to_rgb",
    "raw_to_rgb_2x2_downscaled",
    "rgb255_to_normals",
    "rgb255_to_rgb",
    "rgb_to_bgr",
    "rgb_to_grayscale",
    "rgb_to_hls",
    "rgb_to_hsl",
    "rgb_to_hsv",
    "rgb_to_lab",
    "rgb_to_linear_rgb",
    "rgb_to_luv",
    "rgb_to_nv12",
    "rgb_to_raw",
    "rgb_to_rgb255",
    "rgb_to_rgba",
    "rgb_to_xyz",
    "rgb_to_y",
    "rgb_to_ycbcr",
    "rgb_to_yuv",
    "rgb_to_yuv420",
    "rgb_to_yuv422",
    "rgba_to_bgr",
    "rgba_to_rgb",
    "sepia",
    "uyvy_to_rgb",
    "xyz_to_rgb",
    "ycbcr_to_rgb",
    "yuv420_to_rgb",
    "yuv422_to_rgb",
    "yuv_to_rgb",
    "yuyv_to_rgb",
]
