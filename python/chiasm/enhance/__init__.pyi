# Written by `make stubs` from the signatures of the functions; do not edit.

from typing import List, Optional, Tuple, Union

from torch import Tensor, nn

from .adjust import adjust_brightness as adjust_brightness
from .adjust import adjust_brightness_accumulative as adjust_brightness_accumulative
from .adjust import adjust_contrast as adjust_contrast
from .adjust import adjust_contrast_with_mean_subtraction as adjust_contrast_with_mean_subtraction
from .adjust import adjust_gamma as adjust_gamma
from .adjust import adjust_log as adjust_log
from .adjust import adjust_saturation_with_gray_subtraction as adjust_saturation_with_gray_subtraction
from .adjust import adjust_sigmoid as adjust_sigmoid
from .arithmetic import Rescale as Rescale
from .arithmetic import add_weighted as add_weighted
from .arithmetic import invert as invert
from .arithmetic import shift_rgb as shift_rgb
from .clahe import clahe as clahe
from .clahe import equalize_clahe as equalize_clahe
from .counting import count_histogram as count_histogram
from .density import histogram as histogram
from .density import histogram2d as histogram2d
from .density import image_histogram2d as image_histogram2d
from .equalization import autocontrast as autocontrast
from .equalization import equalize as equalize
from .equalization import equalize3d as equalize3d
from .hue import adjust_hue as adjust_hue
from .hue import adjust_hue_raw as adjust_hue_raw
from .hue import adjust_saturation as adjust_saturation
from .hue import adjust_saturation_raw as adjust_saturation_raw
from .integral import integral_image as integral_image
from .integral import integral_tensor as integral_tensor
from .jpeg import jpeg_codec_differentiable as jpeg_codec_differentiable
from .lookup import lut as lut
from .names import ThresholdType as ThresholdType
from .normalize import denormalize as denormalize
from .normalize import normalize as normalize
from .normalize import normalize_min_max as normalize_min_max
from .sharp import sharpness as sharpness
from .statistics import mean_std_dev as mean_std_dev
from .statistics import min_max_loc as min_max_loc
from .tone import posterize as posterize
from .tone import solarize as solarize
from .tone import threshold as threshold
from .whitening import linear_transform as linear_transform
from .whitening import zca_mean as zca_mean
from .whitening import zca_whiten as zca_whiten
from .zca import ZCAWhitening as ZCAWhitening

class AddWeighted(nn.Module):
    """`add_weighted` as a module: Weighted sum alpha * src1 + beta * src2 + gamma, like OpenCV's
    ``addWeighted`` (without saturation). For uint8, the sum is computed in float32, with each of its
    four steps rounded; the result is rounded (halves to even) and saturated. It is within one level of
    OpenCV's, which fuses some steps."""

    alpha: Union[float, Tensor]
    beta: Union[float, Tensor]
    gamma: Union[float, Tensor]
    def __init__(
        self, alpha: Union[float, Tensor], beta: Union[float, Tensor], gamma: Union[float, Tensor]
    ) -> None: ...
    def forward(self, src1: Tensor, src2: Tensor) -> Tensor: ...
    def __call__(self, src1: Tensor, src2: Tensor) -> Tensor: ...

class AdjustBrightness(nn.Module):
    """`adjust_brightness` as a module: Add ``factor`` to every value."""

    factor: Union[float, Tensor]
    clip_output: bool
    def __init__(self, brightness_factor: Union[float, Tensor], clip_output: bool = True) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class AdjustBrightnessAccumulative(nn.Module):
    """`adjust_brightness_accumulative` as a module: Multiply every value by ``factor``, like Pillow's
    ``ImageEnhance.Brightness`` does."""

    factor: Union[float, Tensor]
    clip_output: bool
    def __init__(self, brightness_factor: Union[float, Tensor], clip_output: bool = True) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class AdjustContrast(nn.Module):
    """`adjust_contrast` as a module: Multiply every value by ``factor``."""

    factor: Union[float, Tensor]
    clip_output: bool
    def __init__(self, contrast_factor: Union[float, Tensor], clip_output: bool = True) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class AdjustContrastWithMeanSubtraction(nn.Module):
    """`adjust_contrast_with_mean_subtraction` as a module: Stretch the values about the image's mean
    grey, like Pillow's ``ImageEnhance.Contrast`` does (which rounds the mean)."""

    factor: Union[float, Tensor]
    def __init__(self, contrast_factor: Union[float, Tensor]) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class AdjustGamma(nn.Module):
    """`adjust_gamma` as a module: Power law: gain * input ** gamma, limited to [0, 1]. The gradient is
    zero where the input is zero, although it is infinite there for a gamma below 1."""

    gamma: Union[float, Tensor]
    gain: Union[float, Tensor]
    def __init__(self, gamma: Union[float, Tensor], gain: Union[float, Tensor] = 1.0) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class AdjustHue(nn.Module):
    """`adjust_hue` as a module: Rotate the hue of every colour."""

    factor: Union[float, Tensor]
    def __init__(self, hue_factor: Union[float, Tensor]) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class AdjustHueRaw(nn.Module):
    """`adjust_hue_raw` as a module: Rotate the hue of an HSV image; the new hue is in [0, 2 pi) (Kornia
    keeps the sign of the sum)."""

    factor: Union[float, Tensor]
    def __init__(self, factor: Union[float, Tensor]) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class AdjustLog(nn.Module):
    """`adjust_log` as a module: Logarithmic curve gain * log2(1 + image), or its inverse gain * (2 **
    image - 1), like scikit-image's ``adjust_log``."""

    gain: float
    inv: bool
    clip_output: bool
    def __init__(self, gain: float = 1.0, inv: bool = False, clip_output: bool = True) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class AdjustSaturation(nn.Module):
    """`adjust_saturation` as a module: Multiply the saturation of every colour, in HSV, and limit it to
    [0, 1]."""

    factor: Union[float, Tensor]
    def __init__(self, saturation_factor: Union[float, Tensor]) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class AdjustSaturationRaw(nn.Module):
    """`adjust_saturation_raw` as a module: Multiply the saturation of an HSV image and limit it to [0,
    1]."""

    factor: Union[float, Tensor]
    def __init__(self, factor: Union[float, Tensor]) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class AdjustSaturationWithGraySubtraction(nn.Module):
    """`adjust_saturation_with_gray_subtraction` as a module: Blend each colour with its grey, like
    Pillow's ``ImageEnhance.Color`` does."""

    factor: Union[float, Tensor]
    def __init__(self, saturation_factor: Union[float, Tensor]) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class AdjustSigmoid(nn.Module):
    """`adjust_sigmoid` as a module: Sigmoid curve 1 / (1 + exp(gain * (cutoff - image))), or one minus
    this, like scikit-image's ``adjust_sigmoid``."""

    cutoff: float
    gain: float
    inv: bool
    def __init__(self, cutoff: float = 0.5, gain: float = 10.0, inv: bool = False) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class Autocontrast(nn.Module):
    """`autocontrast` as a module: Stretch the levels of each channel to the whole range, like Pillow's
    ``ImageOps.autocontrast``. The image is rounded to the nearest of 256 levels. The exact result is
    rounded down to a level (Pillow's float arithmetic gives one level less at some whole numbers). There
    is no gradient."""

    cutoff: Union[float, Tuple[float, float]]
    def __init__(self, cutoff: Union[float, Tuple[float, float]] = 0.0) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class Clahe(nn.Module):
    """`clahe` as a module: CLAHE of each uint8 channel, identical to OpenCV's ``createCLAHE(clipLimit,
    tileGridSize).apply``."""

    clip_limit: float
    tile_grid_size: Tuple[int, int]
    def __init__(self, clip_limit: float = 40.0, tile_grid_size: Tuple[int, int] = (8, 8)) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class CountHistogram(nn.Module):
    """`count_histogram` as a module: Count the pixels of each channel in n_bins equal bins of [min,
    max), like OpenCV's ``calcHist``."""

    n_bins: int
    min: float
    max: float
    def __init__(self, n_bins: int = 256, min: float = 0.0, max: float = 1.0) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class Denormalize(nn.Module):
    """`denormalize` as a module: The inverse of ``normalize``, for each channel: data * std + mean."""

    mean: Union[float, Tensor]
    std: Union[float, Tensor]
    def __init__(self, mean: Union[float, Tensor], std: Union[float, Tensor]) -> None: ...
    def forward(self, data: Tensor) -> Tensor: ...
    def __call__(self, data: Tensor) -> Tensor: ...

class Equalize(nn.Module):
    """`equalize` as a module: Equalize the histogram of each channel, like Pillow's
    ``ImageOps.equalize``."""
    def __init__(self) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Equalize3d(nn.Module):
    """`equalize3d` as a module: ``equalize`` for volumes, with one histogram for each channel."""
    def __init__(self) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class EqualizeClahe(nn.Module):
    """`equalize_clahe` as a module: Equalize the clipped histogram of each tile, and blend the curves of
    neighbouring tiles (CLAHE). For 256 levels, and for uint8, the result equals OpenCV's
    ``createCLAHE``; Kornia's differs in borders and rounding. Other values are rounded to the nearest
    level, and there is no gradient."""

    clip_limit: Union[float, Tensor]
    grid_size: Tuple[int, int]
    slow_and_differentiable: bool
    def __init__(
        self,
        clip_limit: Union[float, Tensor] = 40.0,
        grid_size: Tuple[int, int] = (8, 8),
        slow_and_differentiable: bool = False,
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Histogram(nn.Module):
    """`histogram` as a module: Density of each row's values at the bins' centres, by a Gaussian kernel,
    normalised to sum to 1."""

    epsilon: float
    def __init__(self, epsilon: float = 1e-10) -> None: ...
    def forward(self, x: Tensor, bins: Tensor, bandwidth: Tensor) -> Tensor: ...
    def __call__(self, x: Tensor, bins: Tensor, bandwidth: Tensor) -> Tensor: ...

class Histogram2d(nn.Module):
    """`histogram2d` as a module: Joint density of pairs of values, by a Gaussian kernel, normalised to
    sum to 1."""

    epsilon: float
    def __init__(self, epsilon: float = 1e-10) -> None: ...
    def forward(self, x1: Tensor, x2: Tensor, bins: Tensor, bandwidth: Tensor) -> Tensor: ...
    def __call__(self, x1: Tensor, x2: Tensor, bins: Tensor, bandwidth: Tensor) -> Tensor: ...

class ImageHistogram2d(nn.Module):
    """`image_histogram2d` as a module: Histogram of each plane; a kernel of u = \|value - centre\| /
    bandwidth splits each pixel between bins."""

    min: float
    max: float
    n_bins: int
    bandwidth: Optional[float]
    centers: Optional[Tensor]
    return_pdf: bool
    kernel: str
    eps: float
    def __init__(
        self,
        min: float = 0.0,
        max: float = 255.0,
        n_bins: int = 256,
        bandwidth: Optional[float] = None,
        centers: Optional[Tensor] = None,
        return_pdf: bool = False,
        kernel: str = "triangular",
        eps: float = 1e-10,
    ) -> None: ...
    def forward(self, image: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, image: Tensor) -> Tuple[Tensor, Tensor]: ...

class IntegralImage(nn.Module):
    """`integral_image` as a module: Summed-area table: each pixel becomes the sum of all values above
    and to the left, including its own."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class IntegralTensor(nn.Module):
    """`integral_tensor` as a module: Cumulative sum along one or more dimensions."""

    dim: Optional[List[int]]
    def __init__(self, dim: Optional[List[int]] = None) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Invert(nn.Module):
    """`invert` as a module: Invert: max_val - image."""

    max_val: Optional[Tensor]
    def __init__(self, max_val: Optional[Tensor] = None) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class JpegCodecDifferentiable(nn.Module):
    """`jpeg_codec_differentiable` as a module: Encode and decode an image as JPEG does: YCbCr with
    halved chroma (4:2:0), 8x8 DCT, quantization, and back."""

    quantization_table_y: Optional[Tensor]
    quantization_table_c: Optional[Tensor]
    def __init__(
        self, quantization_table_y: Optional[Tensor] = None, quantization_table_c: Optional[Tensor] = None
    ) -> None: ...
    def forward(self, input: Tensor, jpeg_quality: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor, jpeg_quality: Tensor) -> Tensor: ...

JPEGCodecDifferentiable = JpegCodecDifferentiable

class LinearTransform(nn.Module):
    """`linear_transform` as a module: Flatten each sample to a row of features and compute (inp -
    mean_vector) @ transform_matrix."""

    dim: int
    def __init__(self, dim: int = 0) -> None: ...
    def forward(self, inp: Tensor, transform_matrix: Tensor, mean_vector: Tensor) -> Tensor: ...
    def __call__(self, inp: Tensor, transform_matrix: Tensor, mean_vector: Tensor) -> Tensor: ...

class Lut(nn.Module):
    """`lut` as a module: Replace each byte by the entry of a table at it, like OpenCV's ``LUT``."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor, table: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor, table: Tensor) -> Tensor: ...

class MeanStdDev(nn.Module):
    """`mean_std_dev` as a module: Mean and standard deviation of each channel, like OpenCV's
    ``meanStdDev``."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, image: Tensor) -> Tuple[Tensor, Tensor]: ...

class MinMaxLoc(nn.Module):
    """`min_max_loc` as a module: The least and the greatest value of each channel and their positions,
    like OpenCV's ``minMaxLoc``. If a value occurs several times, its first position counts, row by row.
    NaN is ignored; for a channel with only NaN, the result is its first pixel."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor]: ...
    def __call__(self, image: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor]: ...

class Normalize(nn.Module):
    """`normalize` as a module: Normalize each channel: (data - mean) / std."""

    mean: Union[float, Tensor]
    std: Union[float, Tensor]
    def __init__(self, mean: Union[float, Tensor], std: Union[float, Tensor]) -> None: ...
    def forward(self, data: Tensor) -> Tensor: ...
    def __call__(self, data: Tensor) -> Tensor: ...

class NormalizeMinMax(nn.Module):
    """`normalize_min_max` as a module: Scale each channel of each sample linearly to [min_val,
    max_val]."""

    min_val: float
    max_val: float
    eps: float
    def __init__(self, min_val: float = 0.0, max_val: float = 1.0, eps: float = 1e-06) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Posterize(nn.Module):
    """`posterize` as a module: Keep only the upper bits of 8-bit levels, like Pillow's
    ``ImageOps.posterize``."""

    bits: Union[int, Tensor]
    def __init__(self, bits: Union[int, Tensor]) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Sharpness(nn.Module):
    """`sharpness` as a module: Sharpen or smooth: blend with a smoothed image, like Pillow's
    ``ImageEnhance.Sharpness``."""

    factor: Union[float, Tensor]
    def __init__(self, factor: Union[float, Tensor]) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class ShiftRgb(nn.Module):
    """`shift_rgb` as a module: Add a number to each channel and limit the result to [0, 1]."""
    def __init__(self) -> None: ...
    def forward(self, image: Tensor, r_shift: Tensor, g_shift: Tensor, b_shift: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor, r_shift: Tensor, g_shift: Tensor, b_shift: Tensor) -> Tensor: ...

class Solarize(nn.Module):
    """`solarize` as a module: Invert the values at or above a threshold, like Pillow's
    ``ImageOps.solarize``."""

    thresholds: Union[float, Tensor]
    additions: Union[float, Tensor, None]
    def __init__(
        self, thresholds: Union[float, Tensor] = 0.5, additions: Union[float, Tensor, None] = None
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Threshold(nn.Module):
    """`threshold` as a module: Compare with a threshold, like OpenCV's ``threshold``."""

    thresh: Union[float, Tensor]
    maxval: Union[float, Tensor]
    type: str
    def __init__(
        self, thresh: Union[float, Tensor], maxval: Union[float, Tensor] = 255.0, type: str = "binary"
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class ZcaMean(nn.Module):
    """`zca_mean` as a module: The matrix (covariance + eps I)^(-1/2) and the mean of ZCA whitening, the
    smallest change that decorrelates."""

    dim: int
    unbiased: bool
    eps: float
    return_inverse: bool
    def __init__(
        self, dim: int = 0, unbiased: bool = True, eps: float = 1e-06, return_inverse: bool = False
    ) -> None: ...
    def forward(self, inp: Tensor) -> Tuple[Tensor, Tensor, Optional[Tensor]]: ...
    def __call__(self, inp: Tensor) -> Tuple[Tensor, Tensor, Optional[Tensor]]: ...

class ZcaWhiten(nn.Module):
    """`zca_whiten` as a module: Apply the transform of ``zca_mean``: the features of the result are
    uncorrelated and have variance 1."""

    dim: int
    unbiased: bool
    eps: float
    def __init__(self, dim: int = 0, unbiased: bool = True, eps: float = 1e-06) -> None: ...
    def forward(self, inp: Tensor) -> Tensor: ...
    def __call__(self, inp: Tensor) -> Tensor: ...

__all__ = [
    "AddWeighted",
    "AdjustBrightness",
    "AdjustBrightnessAccumulative",
    "AdjustContrast",
    "AdjustContrastWithMeanSubtraction",
    "AdjustGamma",
    "AdjustHue",
    "AdjustHueRaw",
    "AdjustLog",
    "AdjustSaturation",
    "AdjustSaturationRaw",
    "AdjustSaturationWithGraySubtraction",
    "AdjustSigmoid",
    "Autocontrast",
    "Clahe",
    "CountHistogram",
    "Denormalize",
    "Equalize",
    "Equalize3d",
    "EqualizeClahe",
    "Histogram",
    "Histogram2d",
    "ImageHistogram2d",
    "IntegralImage",
    "IntegralTensor",
    "Invert",
    "JPEGCodecDifferentiable",
    "JpegCodecDifferentiable",
    "LinearTransform",
    "Lut",
    "MeanStdDev",
    "MinMaxLoc",
    "Normalize",
    "NormalizeMinMax",
    "Posterize",
    "Rescale",
    "Sharpness",
    "ShiftRgb",
    "Solarize",
    "Threshold",
    "ThresholdType",
    "ZCAWhitening",
    "ZcaMean",
    "ZcaWhiten",
    "add_weighted",
    "adjust_brightness",
    "adjust_brightness_accumulative",
    "adjust_contrast",
    "adjust_contrast_with_mean_subtraction",
    "adjust_gamma",
    "adjust_hue",
    "adjust_hue_raw",
    "adjust_log",
    "adjust_saturation",
    "adjust_saturation_raw",
    "adjust_saturation_with_gray_subtraction",
    "adjust_sigmoid",
    "autocontrast",
    "clahe",
    "count_histogram",
    "denormalize",
    "equalize",
    "equalize3d",
    "equalize_clahe",
    "histogram",
    "histogram2d",
    "image_histogram2d",
    "integral_image",
    "integral_tensor",
    "invert",
    "jpeg_codec_differentiable",
    "linear_transform",
    "lut",
    "mean_std_dev",
    "min_max_loc",
    "normalize",
    "normalize_min_max",
    "posterize",
    "sharpness",
    "shift_rgb",
    "solarize",
    "threshold",
    "zca_mean",
    "zca_whiten",
]
