# Written by `make stubs` from the signatures of the functions; do not edit.

import enum
from typing import List, Optional, Sequence, Tuple, Union

from torch import Tensor

from . import auto as auto
from .affine import RandomAffine as RandomAffine
from .affine import RandomShear as RandomShear
from .affine import RandomTranslate as RandomTranslate
from .affine import random_affine as random_affine
from .base import AugmentationBase2D as AugmentationBase2D
from .base import AugmentationBase3D as AugmentationBase3D
from .base import GeometricAugmentationBase2D as GeometricAugmentationBase2D
from .base import ImagesOnly as ImagesOnly
from .base import IntensityAugmentationBase2D as IntensityAugmentationBase2D
from .blur import random_box_blur as random_box_blur
from .blur import random_gaussian_blur as random_gaussian_blur
from .blur import random_median_blur as random_median_blur
from .blur import random_motion_blur as random_motion_blur
from .colour import random_brightness as random_brightness
from .colour import random_contrast as random_contrast
from .colour import random_gamma as random_gamma
from .colour import random_grayscale as random_grayscale
from .colour import random_hue as random_hue
from .colour import random_rgb_shift as random_rgb_shift
from .colour import random_saturation as random_saturation
from .container import AugmentationSequential as AugmentationSequential
from .crop import RandomResizedCrop as RandomResizedCrop
from .crop import random_resized_crop as random_resized_crop
from .cut import CenterCrop as CenterCrop
from .cut import PadTo as PadTo
from .cut import RandomCrop as RandomCrop
from .cut import random_crop as random_crop
from .cut3d import CenterCrop3D as CenterCrop3D
from .cut3d import RandomCrop3D as RandomCrop3D
from .cut3d import random_crop3d as random_crop3d
from .displacement import RandomElasticTransform as RandomElasticTransform
from .displacement import RandomFisheye as RandomFisheye
from .displacement import RandomThinPlateSpline as RandomThinPlateSpline
from .displacement import random_elastic_transform as random_elastic_transform
from .displacement import random_fisheye as random_fisheye
from .displacement import random_thin_plate_spline as random_thin_plate_spline
from .distort import random_photometric_distort as random_photometric_distort
from .drawn_sizes import RandomShortestSize as RandomShortestSize
from .drawn_sizes import ScaleJitter as ScaleJitter
from .erasing import RandomErasing as RandomErasing
from .erasing import random_erasing as random_erasing
from .flip import RandomHorizontalFlip as RandomHorizontalFlip
from .flip import RandomVerticalFlip as RandomVerticalFlip
from .flip import random_horizontal_flip as random_horizontal_flip
from .flip import random_vertical_flip as random_vertical_flip
from .flip3d import RandomDepthicalFlip3D as RandomDepthicalFlip3D
from .flip3d import RandomHorizontalFlip3D as RandomHorizontalFlip3D
from .flip3d import RandomVerticalFlip3D as RandomVerticalFlip3D
from .flip3d import random_depthical_flip3d as random_depthical_flip3d
from .flip3d import random_horizontal_flip3d as random_horizontal_flip3d
from .flip3d import random_vertical_flip3d as random_vertical_flip3d
from .iou_crop import RandomIoUCrop as RandomIoUCrop
from .iou_crop import SanitizeBoundingBoxes as SanitizeBoundingBoxes
from .jitter import random_color_jiggle as random_color_jiggle
from .jitter import random_color_jitter as random_color_jitter
from .levels import random_auto_contrast as random_auto_contrast
from .levels import random_clahe as random_clahe
from .levels import random_denormalize as random_denormalize
from .levels import random_equalize as random_equalize
from .levels import random_invert as random_invert
from .levels import random_normalize as random_normalize
from .levels import random_posterize as random_posterize
from .levels import random_sharpness as random_sharpness
from .levels import random_solarize as random_solarize
from .light import random_gaussian_illumination as random_gaussian_illumination
from .light import random_linear_corner_illumination as random_linear_corner_illumination
from .light import random_linear_illumination as random_linear_illumination
from .light import random_planckian_jitter as random_planckian_jitter
from .light import random_plasma_brightness as random_plasma_brightness
from .light import random_plasma_contrast as random_plasma_contrast
from .light import random_plasma_shadow as random_plasma_shadow
from .mix import random_cut_mix as random_cut_mix
from .mix import random_jigsaw as random_jigsaw
from .mix import random_mix_up as random_mix_up
from .mix import random_transplantation as random_transplantation
from .mix import random_transplantation3d as random_transplantation3d
from .mixing import RandomCutMixV2 as RandomCutMixV2
from .mixing import RandomJigsaw as RandomJigsaw
from .mixing import RandomMixUpV2 as RandomMixUpV2
from .mixing import RandomMosaic as RandomMosaic
from .mixing import RandomTransplantation as RandomTransplantation
from .mixing import RandomTransplantation3D as RandomTransplantation3D
from .mosaic import random_mosaic as random_mosaic
from .noise import random_channel_dropout as random_channel_dropout
from .noise import random_channel_shuffle as random_channel_shuffle
from .noise import random_gaussian_noise as random_gaussian_noise
from .noise import random_jpeg as random_jpeg
from .noise import random_salt_and_pepper_noise as random_salt_and_pepper_noise
from .patch_mix import PatchMix as PatchMix
from .patches import PatchSequential as PatchSequential
from .perspective import RandomPerspective as RandomPerspective
from .perspective import random_perspective as random_perspective
from .policies import aug_mix as aug_mix
from .policies import auto_augment as auto_augment
from .policies import rand_augment as rand_augment
from .policies import trivial_augment as trivial_augment
from .quarter_turns import RandomRotation90 as RandomRotation90
from .quarter_turns import random_rotation90 as random_rotation90
from .resizing import LongestMaxSize as LongestMaxSize
from .resizing import Resize as Resize
from .resizing import SmallestMaxSize as SmallestMaxSize
from .rotation import RandomRotation as RandomRotation
from .rotation import random_rotation as random_rotation
from .video import ImageSequential as ImageSequential
from .video import VideoSequential as VideoSequential
from .volume_values import RandomEqualize3D as RandomEqualize3D
from .volume_values import RandomMotionBlur3D as RandomMotionBlur3D
from .volume_values import random_equalize3d as random_equalize3d
from .volume_values import random_motion_blur3d as random_motion_blur3d
from .warps3d import RandomAffine3D as RandomAffine3D
from .warps3d import RandomPerspective3D as RandomPerspective3D
from .warps3d import RandomRotation3D as RandomRotation3D
from .warps3d import random_affine3d as random_affine3d
from .warps3d import random_perspective3d as random_perspective3d
from .warps3d import random_rotation3d as random_rotation3d
from .weather import random_rain as random_rain
from .weather import random_snow as random_snow
from .zoom_out import RandomZoomOut as RandomZoomOut

class ColorJiggle(IntensityAugmentationBase2D):
    """`random_color_jiggle` as a module, which draws the seeds if none are given: Change brightness (a
    sum), contrast (a factor), and saturation and hue in HSV, in a random order."""

    brightness: Tuple[float, float]
    contrast: Tuple[float, float]
    saturation: Tuple[float, float]
    hue: Tuple[float, float]
    order: Optional[List[int]]
    def __init__(
        self,
        brightness: Union[float, Sequence[float], Tensor] = 0.0,
        contrast: Union[float, Sequence[float], Tensor] = 0.0,
        saturation: Union[float, Sequence[float], Tensor] = 0.0,
        hue: Union[float, Sequence[float], Tensor] = 0.0,
        same_on_batch: bool = False,
        p: float = 1.0,
        keepdim: bool = False,
        order: Union[int, Sequence[int], Tensor, None] = None,
    ) -> None: ...

class ColorJitter(IntensityAugmentationBase2D):
    """`random_color_jitter` as a module, which draws the seeds if none are given: Change brightness,
    contrast, saturation and hue like Pillow and torchvision, in a random order."""

    brightness: Tuple[float, float]
    contrast: Tuple[float, float]
    saturation: Tuple[float, float]
    hue: Tuple[float, float]
    order: Optional[List[int]]
    def __init__(
        self,
        brightness: Union[float, Sequence[float], Tensor] = 0.0,
        contrast: Union[float, Sequence[float], Tensor] = 0.0,
        saturation: Union[float, Sequence[float], Tensor] = 0.0,
        hue: Union[float, Sequence[float], Tensor] = 0.0,
        same_on_batch: bool = False,
        p: float = 1.0,
        keepdim: bool = False,
        order: Union[int, Sequence[int], Tensor, None] = None,
    ) -> None: ...

class Denormalize(IntensityAugmentationBase2D):
    """`random_denormalize` as a module, which draws the seeds if none are given: input * std + mean, per
    channel: ``enhance.denormalize``."""

    mean: Tensor
    std: Tensor
    def __init__(
        self,
        mean: Union[float, Sequence[float], Tensor],
        std: Union[float, Sequence[float], Tensor],
        p: float = 1.0,
        keepdim: bool = False,
    ) -> None: ...

class Normalize(IntensityAugmentationBase2D):
    """`random_normalize` as a module, which draws the seeds if none are given: (input - mean) / std, per
    channel: ``enhance.normalize``."""

    mean: Tensor
    std: Tensor
    def __init__(
        self,
        mean: Union[float, Sequence[float], Tensor],
        std: Union[float, Sequence[float], Tensor],
        p: float = 1.0,
        keepdim: bool = False,
    ) -> None: ...

class RandomAutoContrast(IntensityAugmentationBase2D):
    """`random_auto_contrast` as a module, which draws the seeds if none are given: Stretch each channel
    to the whole range, by ``normalize_min_max`` to [0, 1]; uint8 by ``autocontrast``."""

    clip_output: bool
    def __init__(
        self, clip_output: bool = True, same_on_batch: bool = False, p: float = 1.0, keepdim: bool = False
    ) -> None: ...

class RandomBoxBlur(IntensityAugmentationBase2D):
    """`random_box_blur` as a module, which draws the seeds if none are given: Replace each pixel by the
    mean of its window, by ``box_blur``."""

    kernel_size: Tuple[int, int]
    border_type: str
    normalized: bool
    def __init__(
        self,
        kernel_size: Union[int, Sequence[int], Tensor] = (3, 3),
        border_type: Union[str, enum.Enum] = "reflect",
        normalized: bool = True,
        same_on_batch: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None: ...

class RandomBrightness(IntensityAugmentationBase2D):
    """`random_brightness` as a module, which draws the seeds if none are given: Add a number to every
    value, by ``adjust_brightness`` with ``b - 1``, where b is uniform in ``brightness``. For uint8, the
    number is multiplied by 255."""

    brightness: Tuple[float, float]
    clip_output: bool
    def __init__(
        self,
        brightness: Union[float, Sequence[float], Tensor] = (1.0, 1.0),
        clip_output: bool = True,
        same_on_batch: bool = False,
        p: float = 1.0,
        keepdim: bool = False,
    ) -> None: ...

class RandomChannelDropout(IntensityAugmentationBase2D):
    """`random_channel_dropout` as a module, which draws the seeds if none are given: Fill randomly
    chosen channels of each sample with a number."""

    num_drop_channels: int
    fill_value: float
    def __init__(
        self,
        num_drop_channels: int = 1,
        fill_value: float = 0.0,
        same_on_batch: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None: ...

class RandomChannelShuffle(IntensityAugmentationBase2D):
    """`random_channel_shuffle` as a module, which draws the seeds if none are given: Shuffle the
    channels; all orders are equally likely."""
    def __init__(self, same_on_batch: bool = False, p: float = 0.5, keepdim: bool = False) -> None: ...

class RandomClahe(IntensityAugmentationBase2D):
    """`random_clahe` as a module, which draws the seeds if none are given: Equalize the histogram of
    each tile, by ``equalize_clahe``; the limit is uniform in ``clip_limit``."""

    clip_limit: Tuple[float, float]
    grid_size: Tuple[int, int]
    slow_and_differentiable: bool
    def __init__(
        self,
        clip_limit: Union[float, Sequence[float], Tensor] = (40.0, 40.0),
        grid_size: Union[int, Sequence[int], Tensor] = (8, 8),
        slow_and_differentiable: bool = False,
        same_on_batch: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None: ...

class RandomContrast(IntensityAugmentationBase2D):
    """`random_contrast` as a module, which draws the seeds if none are given: Multiply every value by a
    factor, by ``adjust_contrast``; the factor is uniform in ``contrast``."""

    contrast: Tuple[float, float]
    clip_output: bool
    def __init__(
        self,
        contrast: Union[float, Sequence[float], Tensor] = (1.0, 1.0),
        clip_output: bool = True,
        same_on_batch: bool = False,
        p: float = 1.0,
        keepdim: bool = False,
    ) -> None: ...

class RandomEqualize(IntensityAugmentationBase2D):
    """`random_equalize` as a module, which draws the seeds if none are given: Equalize the histogram of
    each channel, by ``equalize``. A changed sample has no gradient."""
    def __init__(self, same_on_batch: bool = False, p: float = 0.5, keepdim: bool = False) -> None: ...

class RandomGamma(IntensityAugmentationBase2D):
    """`random_gamma` as a module, which draws the seeds if none are given: Apply a power law, by
    ``adjust_gamma``; the exponent is uniform in ``gamma``, the factor in ``gain``."""

    gamma: Tuple[float, float]
    gain: Tuple[float, float]
    def __init__(
        self,
        gamma: Union[float, Sequence[float], Tensor] = (1.0, 1.0),
        gain: Union[float, Sequence[float], Tensor] = (1.0, 1.0),
        same_on_batch: bool = False,
        p: float = 1.0,
        keepdim: bool = False,
    ) -> None: ...

class RandomGaussianBlur(IntensityAugmentationBase2D):
    """`random_gaussian_blur` as a module, which draws the seeds if none are given: Convolve with an
    isotropic Gaussian, by ``gaussian_blur2d``; its standard deviation is uniform in ``sigma``."""

    kernel_size: Tuple[int, int]
    sigma: Tuple[float, float]
    border_type: str
    separable: bool
    def __init__(
        self,
        kernel_size: Union[int, Sequence[int], Tensor],
        sigma: Union[float, Sequence[float], Tensor],
        border_type: Union[str, enum.Enum] = "reflect",
        separable: bool = True,
        same_on_batch: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None: ...

class RandomGaussianIllumination(IntensityAugmentationBase2D):
    """`random_gaussian_illumination` as a module, which draws the seeds if none are given: Add or
    subtract a Gaussian spot of light."""

    gain: Tuple[float, float]
    center: Tuple[float, float]
    sigma: Tuple[float, float]
    sign: Tuple[float, float]
    def __init__(
        self,
        gain: Union[float, Sequence[float], Tensor] = (0.01, 0.15),
        center: Union[float, Sequence[float], Tensor] = (0.1, 0.9),
        sigma: Union[float, Sequence[float], Tensor] = (0.2, 1.0),
        sign: Union[float, Sequence[float], Tensor] = (-1.0, 1.0),
        p: float = 0.5,
        same_on_batch: bool = False,
        keepdim: bool = False,
    ) -> None: ...

class RandomGaussianNoise(IntensityAugmentationBase2D):
    """`random_gaussian_noise` as a module, which draws the seeds if none are given: Add an independent
    normally distributed number to every value."""

    mean: float
    std: float
    def __init__(
        self,
        mean: float = 0.0,
        std: float = 1.0,
        same_on_batch: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None: ...

class RandomGrayscale(IntensityAugmentationBase2D):
    """`random_grayscale` as a module, which draws the seeds if none are given: Convert to grey, with the
    same value in all three channels, by ``rgb_to_grayscale``."""

    rgb_weights: Optional[Tensor]
    def __init__(
        self,
        rgb_weights: Optional[Tensor] = None,
        same_on_batch: bool = False,
        p: float = 0.1,
        keepdim: bool = False,
    ) -> None: ...

class RandomHue(IntensityAugmentationBase2D):
    """`random_hue` as a module, which draws the seeds if none are given: Rotate the hue, by
    ``adjust_hue``; the angle is uniform in ``hue``."""

    hue: Tuple[float, float]
    def __init__(
        self,
        hue: Union[float, Sequence[float], Tensor] = (0.0, 0.0),
        same_on_batch: bool = False,
        p: float = 1.0,
        keepdim: bool = False,
    ) -> None: ...

class RandomInvert(IntensityAugmentationBase2D):
    """`random_invert` as a module, which draws the seeds if none are given: Invert: ``max_val - input``;
    for uint8, ``255 - input``."""

    max_val: Union[float, Tensor]
    def __init__(
        self,
        max_val: Union[float, Tensor] = 1.0,
        same_on_batch: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None: ...

class RandomJPEG(IntensityAugmentationBase2D):
    """`random_jpeg` as a module, which draws the seeds if none are given: Add JPEG artifacts, by
    ``jpeg_codec_differentiable``; the quality is uniform in ``jpeg_quality``."""

    jpeg_quality: Tuple[float, float]
    def __init__(
        self,
        jpeg_quality: Union[float, Sequence[float], Tensor] = 50.0,
        same_on_batch: bool = False,
        p: float = 1.0,
        keepdim: bool = False,
    ) -> None: ...

class RandomLinearCornerIllumination(IntensityAugmentationBase2D):
    """`random_linear_corner_illumination` as a module, which draws the seeds if none are given: Add or
    subtract light that rises linearly from 0 at one corner to a gain at the opposite corner."""

    gain: Tuple[float, float]
    sign: Tuple[float, float]
    def __init__(
        self,
        gain: Union[float, Sequence[float], Tensor] = (0.01, 0.2),
        sign: Union[float, Sequence[float], Tensor] = (-1.0, 1.0),
        p: float = 0.5,
        same_on_batch: bool = False,
        keepdim: bool = False,
    ) -> None: ...

class RandomLinearIllumination(IntensityAugmentationBase2D):
    """`random_linear_illumination` as a module, which draws the seeds if none are given: Add or subtract
    light that rises linearly from 0 at one side to a gain at the opposite side."""

    gain: Tuple[float, float]
    sign: Tuple[float, float]
    def __init__(
        self,
        gain: Union[float, Sequence[float], Tensor] = (0.01, 0.2),
        sign: Union[float, Sequence[float], Tensor] = (-1.0, 1.0),
        p: float = 0.5,
        same_on_batch: bool = False,
        keepdim: bool = False,
    ) -> None: ...

class RandomMedianBlur(IntensityAugmentationBase2D):
    """`random_median_blur` as a module, which draws the seeds if none are given: Replace each pixel by
    the median of its window, by ``median_blur``."""

    kernel_size: Tuple[int, int]
    def __init__(
        self,
        kernel_size: Union[int, Sequence[int], Tensor] = (3, 3),
        same_on_batch: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None: ...

class RandomMotionBlur(IntensityAugmentationBase2D):
    """`random_motion_blur` as a module, which draws the seeds if none are given: Blur as if the camera
    had moved along a line, by ``motion_blur``; each sample has its own length, angle and direction."""

    kernel_size: Tuple[int, int]
    angle: Tuple[float, float]
    direction: Tuple[float, float]
    border_type: str
    resample: str
    def __init__(
        self,
        kernel_size: Union[int, Sequence[int], Tensor],
        angle: Union[float, Sequence[float], Tensor],
        direction: Union[float, Sequence[float], Tensor],
        border_type: Union[str, enum.Enum] = "constant",
        resample: Union[str, enum.Enum] = "nearest",
        same_on_batch: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None: ...

class RandomPhotometricDistort(IntensityAugmentationBase2D):
    """`random_photometric_distort` as a module, which draws the seeds if none are given: Change
    brightness, contrast, saturation, hue and the order of the channels, each with probability ``p``,
    like torchvision's ``RandomPhotometricDistort``."""

    brightness: Tuple[float, float]
    contrast: Tuple[float, float]
    saturation: Tuple[float, float]
    hue: Tuple[float, float]
    def __init__(
        self,
        brightness: Union[float, Sequence[float], Tensor] = (0.875, 1.125),
        contrast: Union[float, Sequence[float], Tensor] = (0.5, 1.5),
        saturation: Union[float, Sequence[float], Tensor] = (0.5, 1.5),
        hue: Union[float, Sequence[float], Tensor] = (-0.05, 0.05),
        p: float = 0.5,
    ) -> None: ...

class RandomPlanckianJitter(IntensityAugmentationBase2D):
    """`random_planckian_jitter` as a module, which draws the seeds if none are given: Change the colour
    of the light: multiply red and blue by those of a radiator whose green is 1."""

    mode: str
    select_from: Optional[List[int]]
    def __init__(
        self,
        mode: str = "blackbody",
        select_from: Union[int, Sequence[int], Tensor, None] = None,
        same_on_batch: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None: ...

class RandomPlasmaBrightness(IntensityAugmentationBase2D):
    """`random_plasma_brightness` as a module, which draws the seeds if none are given: Add plasma noise,
    from ``-intensity`` to ``intensity``; it is the same for all channels."""

    roughness: Tuple[float, float]
    intensity: Tuple[float, float]
    def __init__(
        self,
        roughness: Union[float, Sequence[float], Tensor] = (0.1, 0.7),
        intensity: Union[float, Sequence[float], Tensor] = (0.0, 1.0),
        same_on_batch: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None: ...

class RandomPlasmaContrast(IntensityAugmentationBase2D):
    """`random_plasma_contrast` as a module, which draws the seeds if none are given: Multiply the
    difference from 0.5 by plasma noise from 0 to 4; it is the same for all channels."""

    roughness: Tuple[float, float]
    def __init__(
        self,
        roughness: Union[float, Sequence[float], Tensor] = (0.1, 0.7),
        same_on_batch: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None: ...

class RandomPlasmaShadow(IntensityAugmentationBase2D):
    """`random_plasma_shadow` as a module, which draws the seeds if none are given: Darken the pixels
    where plasma noise is below a level; all channels change by the same amount."""

    roughness: Tuple[float, float]
    shade_intensity: Tuple[float, float]
    shade_quantity: Tuple[float, float]
    def __init__(
        self,
        roughness: Union[float, Sequence[float], Tensor] = (0.1, 0.7),
        shade_intensity: Union[float, Sequence[float], Tensor] = (-1.0, 0.0),
        shade_quantity: Union[float, Sequence[float], Tensor] = (0.0, 1.0),
        same_on_batch: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None: ...

class RandomPosterize(IntensityAugmentationBase2D):
    """`random_posterize` as a module, which draws the seeds if none are given: Keep only the upper bits
    of 8-bit values, by ``posterize``. A changed sample has no gradient."""

    bits: Tuple[int, int]
    def __init__(
        self,
        bits: Union[int, Sequence[int], Tensor] = 3,
        same_on_batch: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None: ...

class RandomRain(IntensityAugmentationBase2D):
    """`random_rain` as a module, which draws the seeds if none are given: Draw rain drops: lines of the
    grey 200 / 255; in one image all lines have the same slope."""

    number_of_drops: Tuple[int, int]
    drop_height: Tuple[int, int]
    drop_width: Tuple[int, int]
    def __init__(
        self,
        number_of_drops: Union[int, Sequence[int], Tensor] = (1000, 2000),
        drop_height: Union[int, Sequence[int], Tensor] = (5, 20),
        drop_width: Union[int, Sequence[int], Tensor] = (-5, 5),
        same_on_batch: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None: ...

class RandomRGBShift(IntensityAugmentationBase2D):
    """`random_rgb_shift` as a module, which draws the seeds if none are given: Add a different number to
    each channel, by ``shift_rgb``."""

    r_shift_limit: Tuple[float, float]
    g_shift_limit: Tuple[float, float]
    b_shift_limit: Tuple[float, float]
    def __init__(
        self,
        r_shift_limit: Union[float, Sequence[float], Tensor] = 0.5,
        g_shift_limit: Union[float, Sequence[float], Tensor] = 0.5,
        b_shift_limit: Union[float, Sequence[float], Tensor] = 0.5,
        same_on_batch: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None: ...

class RandomSaltAndPepperNoise(IntensityAugmentationBase2D):
    """`random_salt_and_pepper_noise` as a module, which draws the seeds if none are given: Make random
    pixels white or black, in all channels."""

    amount: Tuple[float, float]
    salt_vs_pepper: Tuple[float, float]
    def __init__(
        self,
        amount: Union[float, Sequence[float], Tensor] = (0.01, 0.06),
        salt_vs_pepper: Union[float, Sequence[float], Tensor] = (0.4, 0.6),
        p: float = 0.5,
        same_on_batch: bool = False,
        keepdim: bool = False,
    ) -> None: ...

class RandomSaturation(IntensityAugmentationBase2D):
    """`random_saturation` as a module, which draws the seeds if none are given: Multiply the saturation
    in HSV, by ``adjust_saturation``; the factor is uniform in ``saturation``."""

    saturation: Tuple[float, float]
    def __init__(
        self,
        saturation: Union[float, Sequence[float], Tensor] = (1.0, 1.0),
        same_on_batch: bool = False,
        p: float = 1.0,
        keepdim: bool = False,
    ) -> None: ...

class RandomSharpness(IntensityAugmentationBase2D):
    """`random_sharpness` as a module, which draws the seeds if none are given: Sharpen or smooth the
    image, by ``enhance.sharpness``."""

    sharpness: Tuple[float, float]
    def __init__(
        self,
        sharpness: Union[float, Sequence[float], Tensor] = 0.5,
        same_on_batch: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None: ...

class RandomSnow(IntensityAugmentationBase2D):
    """`random_snow` as a module, which draws the seeds if none are given: Multiply the lightness in HLS
    by a factor where the lightness is below a threshold."""

    snow_coefficient: Tuple[float, float]
    brightness: Tuple[float, float]
    def __init__(
        self,
        snow_coefficient: Union[float, Sequence[float], Tensor] = (0.5, 0.5),
        brightness: Union[float, Sequence[float], Tensor] = (2, 2),
        same_on_batch: bool = False,
        p: float = 1.0,
        keepdim: bool = False,
    ) -> None: ...

class RandomSolarize(IntensityAugmentationBase2D):
    """`random_solarize` as a module, which draws the seeds if none are given: Add a number, then invert
    the values at or above a threshold, by ``solarize``."""

    thresholds: Tuple[float, float]
    additions: Tuple[float, float]
    def __init__(
        self,
        thresholds: Union[float, Sequence[float], Tensor] = 0.1,
        additions: Union[float, Sequence[float], Tensor] = 0.1,
        same_on_batch: bool = False,
        p: float = 0.5,
        keepdim: bool = False,
    ) -> None: ...

class AutoAugment(ImagesOnly):
    """`auto_augment` as a module, which draws the seeds if none are given: AutoAugment: one of 25 pairs
    of operations with equal probability. Each operation of a pair has its own probability and
    strength."""

    policy: str
    def __init__(self, policy: str = "imagenet") -> None: ...

class RandAugment(ImagesOnly):
    """`rand_augment` as a module, which draws the seeds if none are given: RandAugment: n operations,
    each one of 14 with equal probability, all of the same strength."""

    n: int
    m: int
    def __init__(self, n: int, m: int) -> None: ...

class TrivialAugment(ImagesOnly):
    """`trivial_augment` as a module, which draws the seeds if none are given: TrivialAugment in its wide
    form: one of 14 operations, of one of 31 strengths, all equally likely."""
    def __init__(self) -> None: ...

class AugMix(ImagesOnly):
    """`aug_mix` as a module, which draws the seeds if none are given: AugMix: a blend of the image with
    a blend of chains of operations."""

    severity: int
    mixture_width: int
    chain_depth: int
    alpha: float
    all_ops: bool
    def __init__(
        self,
        severity: int = 3,
        mixture_width: int = 3,
        chain_depth: int = -1,
        alpha: float = 1.0,
        all_ops: bool = True,
    ) -> None: ...

__all__ = [
    "AugMix",
    "AugmentationBase2D",
    "AugmentationBase3D",
    "AugmentationSequential",
    "AutoAugment",
    "CenterCrop",
    "CenterCrop3D",
    "ColorJiggle",
    "ColorJitter",
    "Denormalize",
    "GeometricAugmentationBase2D",
    "ImageSequential",
    "IntensityAugmentationBase2D",
    "LongestMaxSize",
    "Normalize",
    "PadTo",
    "PatchMix",
    "PatchSequential",
    "RandAugment",
    "RandomAffine",
    "RandomAffine3D",
    "RandomAutoContrast",
    "RandomBoxBlur",
    "RandomBrightness",
    "RandomChannelDropout",
    "RandomChannelShuffle",
    "RandomClahe",
    "RandomContrast",
    "RandomCrop",
    "RandomCrop3D",
    "RandomCutMixV2",
    "RandomDepthicalFlip3D",
    "RandomElasticTransform",
    "RandomEqualize",
    "RandomEqualize3D",
    "RandomErasing",
    "RandomFisheye",
    "RandomGamma",
    "RandomGaussianBlur",
    "RandomGaussianIllumination",
    "RandomGaussianNoise",
    "RandomGrayscale",
    "RandomHorizontalFlip",
    "RandomHorizontalFlip3D",
    "RandomHue",
    "RandomInvert",
    "RandomIoUCrop",
    "RandomJPEG",
    "RandomJigsaw",
    "RandomLinearCornerIllumination",
    "RandomLinearIllumination",
    "RandomMedianBlur",
    "RandomMixUpV2",
    "RandomMosaic",
    "RandomMotionBlur",
    "RandomMotionBlur3D",
    "RandomPerspective",
    "RandomPerspective3D",
    "RandomPhotometricDistort",
    "RandomPlanckianJitter",
    "RandomPlasmaBrightness",
    "RandomPlasmaContrast",
    "RandomPlasmaShadow",
    "RandomPosterize",
    "RandomRGBShift",
    "RandomRain",
    "RandomResizedCrop",
    "RandomRotation",
    "RandomRotation3D",
    "RandomRotation90",
    "RandomSaltAndPepperNoise",
    "RandomSaturation",
    "RandomSharpness",
    "RandomShear",
    "RandomShortestSize",
    "RandomSnow",
    "RandomSolarize",
    "RandomThinPlateSpline",
    "RandomTranslate",
    "RandomTransplantation",
    "RandomTransplantation3D",
    "RandomVerticalFlip",
    "RandomVerticalFlip3D",
    "RandomZoomOut",
    "Resize",
    "SanitizeBoundingBoxes",
    "ScaleJitter",
    "SmallestMaxSize",
    "TrivialAugment",
    "VideoSequential",
    "aug_mix",
    "auto",
    "auto_augment",
    "rand_augment",
    "random_affine",
    "random_affine3d",
    "random_auto_contrast",
    "random_box_blur",
    "random_brightness",
    "random_channel_dropout",
    "random_channel_shuffle",
    "random_clahe",
    "random_color_jiggle",
    "random_color_jitter",
    "random_contrast",
    "random_crop",
    "random_crop3d",
    "random_cut_mix",
    "random_denormalize",
    "random_depthical_flip3d",
    "random_elastic_transform",
    "random_equalize",
    "random_equalize3d",
    "random_erasing",
    "random_fisheye",
    "random_gamma",
    "random_gaussian_blur",
    "random_gaussian_illumination",
    "random_gaussian_noise",
    "random_grayscale",
    "random_horizontal_flip",
    "random_horizontal_flip3d",
    "random_hue",
    "random_invert",
    "random_jigsaw",
    "random_jpeg",
    "random_linear_corner_illumination",
    "random_linear_illumination",
    "random_median_blur",
    "random_mix_up",
    "random_mosaic",
    "random_motion_blur",
    "random_motion_blur3d",
    "random_normalize",
    "random_perspective",
    "random_perspective3d",
    "random_photometric_distort",
    "random_planckian_jitter",
    "random_plasma_brightness",
    "random_plasma_contrast",
    "random_plasma_shadow",
    "random_posterize",
    "random_rain",
    "random_resized_crop",
    "random_rgb_shift",
    "random_rotation",
    "random_rotation3d",
    "random_rotation90",
    "random_salt_and_pepper_noise",
    "random_saturation",
    "random_sharpness",
    "random_snow",
    "random_solarize",
    "random_thin_plate_spline",
    "random_transplantation",
    "random_transplantation3d",
    "random_vertical_flip",
    "random_vertical_flip3d",
    "trivial_augment",
]
