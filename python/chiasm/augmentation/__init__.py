"""Random augmentations of training images, written as functions of seeds, so that they export like every
op."""

from . import auto
from .affine import RandomAffine, RandomShear, RandomTranslate, random_affine
from .base import (
    AugmentationBase2D,
    AugmentationBase3D,
    GeometricAugmentationBase2D,
    IntensityAugmentationBase2D,
)
from .base import ImagesOnly as ImagesOnly
from .blur import random_box_blur, random_gaussian_blur, random_median_blur, random_motion_blur
from .classes import CLASSES
from .colour import (
    random_brightness,
    random_contrast,
    random_gamma,
    random_grayscale,
    random_hue,
    random_rgb_shift,
    random_saturation,
)
from .container import AugmentationSequential
from .crop import RandomResizedCrop, random_resized_crop
from .cut import CenterCrop, PadTo, RandomCrop, random_crop
from .cut3d import CenterCrop3D, RandomCrop3D, random_crop3d
from .displacement import (
    RandomElasticTransform,
    RandomFisheye,
    RandomThinPlateSpline,
    random_elastic_transform,
    random_fisheye,
    random_thin_plate_spline,
)
from .distort import random_photometric_distort
from .drawn_sizes import RandomShortestSize, ScaleJitter
from .erasing import RandomErasing, random_erasing
from .flip import RandomHorizontalFlip, RandomVerticalFlip, random_horizontal_flip, random_vertical_flip
from .flip3d import (
    RandomDepthicalFlip3D,
    RandomHorizontalFlip3D,
    RandomVerticalFlip3D,
    random_depthical_flip3d,
    random_horizontal_flip3d,
    random_vertical_flip3d,
)
from .iou_crop import RandomIoUCrop, SanitizeBoundingBoxes
from .jitter import random_color_jiggle, random_color_jitter
from .levels import (
    random_auto_contrast,
    random_clahe,
    random_denormalize,
    random_equalize,
    random_invert,
    random_normalize,
    random_posterize,
    random_sharpness,
    random_solarize,
)
from .light import (
    random_gaussian_illumination,
    random_linear_corner_illumination,
    random_linear_illumination,
    random_planckian_jitter,
    random_plasma_brightness,
    random_plasma_contrast,
    random_plasma_shadow,
)
from .mix import (
    random_cut_mix,
    random_jigsaw,
    random_mix_up,
    random_transplantation,
    random_transplantation3d,
)
from .mixing import (
    RandomCutMixV2,
    RandomJigsaw,
    RandomMixUpV2,
    RandomMosaic,
    RandomTransplantation,
    RandomTransplantation3D,
)
from .mosaic import random_mosaic
from .noise import (
    random_channel_dropout,
    random_channel_shuffle,
    random_gaussian_noise,
    random_jpeg,
    random_salt_and_pepper_noise,
)
from .patch_mix import PatchMix
from .patches import PatchSequential
from .perspective import RandomPerspective, random_perspective
from .policies import aug_mix, auto_augment, rand_augment, trivial_augment
from .quarter_turns import RandomRotation90, random_rotation90
from .resizing import LongestMaxSize, Resize, SmallestMaxSize
from .rotation import RandomRotation, random_rotation
from .video import ImageSequential, VideoSequential
from .volume_values import (
    RandomEqualize3D,
    RandomMotionBlur3D,
    random_equalize3d,
    random_motion_blur3d,
)
from .warps3d import (
    RandomAffine3D,
    RandomPerspective3D,
    RandomRotation3D,
    random_affine3d,
    random_perspective3d,
    random_rotation3d,
)
from .weather import random_rain, random_snow
from .zoom_out import RandomZoomOut

__all__ = [
    "AugmentationBase2D",
    "AugmentationBase3D",
    "AugmentationSequential",
    "CenterCrop",
    "CenterCrop3D",
    "GeometricAugmentationBase2D",
    "ImageSequential",
    "IntensityAugmentationBase2D",
    "LongestMaxSize",
    "PadTo",
    "PatchMix",
    "PatchSequential",
    "RandomAffine",
    "RandomAffine3D",
    "RandomCrop",
    "RandomCrop3D",
    "RandomCutMixV2",
    "RandomDepthicalFlip3D",
    "RandomElasticTransform",
    "RandomEqualize3D",
    "RandomErasing",
    "RandomFisheye",
    "RandomHorizontalFlip",
    "RandomHorizontalFlip3D",
    "RandomIoUCrop",
    "RandomJigsaw",
    "RandomMixUpV2",
    "RandomMosaic",
    "RandomMotionBlur3D",
    "RandomPerspective",
    "RandomPerspective3D",
    "RandomResizedCrop",
    "RandomRotation",
    "RandomRotation3D",
    "RandomRotation90",
    "RandomShear",
    "RandomShortestSize",
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

# The classes of augmentations that change values or mix images are generated from their functions.
globals().update(CLASSES)
__all__ += [*CLASSES]


def __dir__() -> list[str]:
    return __all__
