"""Augmentations of intensities."""

from typing import Any

from ..spec import Frames, Spec, TensorSpec, image
from . import STENCIL, add

SEED = TensorSpec("seed", ("B",), "int64", range=(0, (1 << 31) - 1), description="one seed a sample")
_OUTPUT = [TensorSpec("output", layout="NCHW")]
_FACTORS: dict[str, Any] = {
    "brightness": (0.6, 1.4),
    "contrast": (0.6, 1.4),
    "saturation": (0.6, 1.4),
    "hue": (-0.1, 0.1),
}


#: The form for bytes with the same settings, which are relative to white.
_BYTES = Frames()


def _add(
    name: str,
    config: dict[str, Any],
    reference: str,
    *more: TensorSpec,
    colour: bool = False,
    **options: Any,
) -> None:
    """Add an op of an image and a seed; `colour`: the image must be RGB."""
    images = image(channels=3, color="RGB") if colour else image()
    add(
        Spec(
            f"augmentation.{name}",
            [images, SEED, *more],
            _OUTPUT,
            config=config,
            reference=reference,
            **options,
        )
    )


# --- one number for each sample -----------------------------------------------------------------------------

_add(
    "random_brightness",
    {"brightness": (0.5, 1.5), "p": 0.7},
    "the definition in NumPy, of the drawn number",
    frames=Frames(reference="the definition in NumPy"),
)
_add(
    "random_contrast",
    {"contrast": (0.5, 1.5), "p": 0.7},
    "the definition in NumPy, of the drawn number",
    frames=Frames(reference="torchvision's adjust_brightness, a level"),
)
_add(
    "random_saturation",
    {"saturation": (0.5, 1.5), "p": 0.7},
    "OpenCV's HSV, of the drawn factor",
    colour=True,
    frames=_BYTES,
)
_add(
    "random_hue",
    {"hue": (-0.3, 0.3), "p": 0.7},
    "torchvision's adjust_hue, of the drawn angle",
    colour=True,
    frames=Frames(reference="torchvision's adjust_hue, a level"),
)
_add(
    "random_gamma",
    {"gamma": (0.5, 2.0), "gain": (0.8, 1.2), "p": 0.7},
    "torchvision's adjust_gamma",
    frames=Frames(reference="torchvision's adjust_gamma, a level"),
)
_add(
    "random_sharpness",
    {"sharpness": (0.0, 2.0), "p": 0.7},
    "torchvision's adjust_sharpness",
    symbols={"H": (4, 32768), "W": (4, 32768)},  # 3 x 3 has another graph, in which one pixel is smoothed
    frames=Frames(reference="Pillow's enhancement, a level"),
)
_add(
    "random_solarize",
    {"thresholds": (0.4, 0.6), "additions": (-0.1, 0.1), "p": 0.7},
    "the definition in NumPy",
    frames=_BYTES,
)
_add(
    "random_posterize",
    {"bits": (1, 6), "p": 0.7},
    "torchvision's posterize of bytes",
    gradients=(),
    frames=_BYTES,
)
_add(
    "random_rgb_shift",
    {"p": 0.7},
    "the definition in NumPy, of the drawn numbers",
    colour=True,
    frames=_BYTES,
)
_add(
    "random_jpeg",
    {"jpeg_quality": (20.0, 90.0), "p": 0.7},
    "Pillow's JPEG",
    colour=True,
    gradients=(),
    # as `enhance.jpeg_codec_differentiable`
    symbols={"H": (17, 32768), "W": (17, 32768)},
)

# --- no number ----------------------------------------------------------------------------------------------

_add(
    "random_auto_contrast",
    {"p": 0.7},
    "the definition in NumPy",
    frames=Frames(reference="Pillow's autocontrast, a level"),
)
_add("random_equalize", {"p": 0.7}, "torchvision's equalize of bytes", gradients=(), frames=_BYTES)
_add("random_invert", {"p": 0.7}, "torchvision's invert", frames=_BYTES)
_add(
    "random_grayscale",
    {"p": 0.7},
    "torchvision's rgb_to_grayscale",
    colour=True,
    frames=Frames(reference="OpenCV's cvtColor"),
)

# --- several changes ----------------------------------------------------------------------------------------

_JITTER = "torchvision's adjustments, in the drawn order"
_add(
    "random_color_jitter",
    {**_FACTORS, "p": 0.7},
    _JITTER,
    colour=True,
    also=({"order": [3, 0, 2, 1]},),
    frames=Frames(reference="the form for numbers, rounded"),
)
_add(
    "random_color_jiggle",
    {**_FACTORS, "p": 0.7},
    "chiasm's adjustments, in the drawn order",
    colour=True,
    also=({"order": [2, 1, 0, 3]},),
    frames=Frames(reference="the form for numbers, rounded"),
)
_add(
    "random_photometric_distort",
    {},
    "torchvision's adjustments, as drawn",
    colour=True,
    frames=Frames(reference="the form for numbers, rounded"),
)

# --- standardisation ----------------------------------------------------------------------------------------

_MEAN = TensorSpec("mean", ("C",), description="one value a channel")
_STD = TensorSpec("std", ("C",), range=(0.2, 1.0), description="one value a channel, not zero")
_add("random_normalize", {"p": 0.7}, "torchvision's normalize", _MEAN, _STD, gradients=("input",))
_add("random_denormalize", {"p": 0.7}, "the definition in NumPy", _MEAN, _STD, gradients=("input",))

# --- smoothing ----------------------------------------------------------------------------------------------

_add(
    "random_box_blur",
    {"kernel_size": (3, 5), "p": 0.7},
    "OpenCV's blur",
    symbols=STENCIL,
    special_values="infinities in running sums",
    frames=_BYTES,
)
_add(
    "random_gaussian_blur",
    {"kernel_size": (3, 5), "sigma": (0.3, 2.0), "p": 0.7},
    "torchvision's gaussian_blur",
    symbols=STENCIL,
    frames=Frames(reference="torchvision's gaussian_blur, a level"),
)
_add(
    "random_median_blur",
    {"p": 0.7},
    "OpenCV's medianBlur",
    symbols=STENCIL,
    gradients=(),
    without_nan=True,
    frames=_BYTES,
)
_add(
    "random_motion_blur",
    {"kernel_size": (3, 7), "angle": (-35.0, 35.0), "direction": (-0.5, 0.5), "p": 0.7},
    "OpenCV's filter2D, by the kernel of the drawn numbers",
    symbols=STENCIL,
    frames=Frames(reference="OpenCV's filter2D, a level"),
)

# --- noise and channels -------------------------------------------------------------------------------------

_add("random_gaussian_noise", {"std": 0.1, "p": 0.7}, "the normal distribution (Kolmogorov-Smirnov)")
_add(
    "random_salt_and_pepper_noise",
    {"amount": (0.1, 0.3), "p": 0.7},
    "the binomial distribution",
    frames=_BYTES,
)
_add(
    "random_channel_dropout",
    {"fill_value": 0.5, "p": 0.7},
    "the definition in NumPy; chi-square of the choice",
    frames=_BYTES,
)
_add(
    "random_channel_shuffle",
    {"p": 0.7},
    "a permutation of the channels; chi-square of the orders",
    frames=_BYTES,
)

# --- tiles --------------------------------------------------------------------------------------------------

_add(
    "random_clahe",
    {"clip_limit": (1.0, 10.0), "grid_size": (2, 3), "p": 0.7},
    "OpenCV's createCLAHE",
    gradients=(),
    symbols={"H": (8, 32768), "W": (8, 32768)},
    frames=_BYTES,
)

# --- light and weather --------------------------------------------------------------------------------------

_add("random_linear_illumination", {"p": 0.7}, "the definition in NumPy, of the drawn numbers")
_add("random_linear_corner_illumination", {"p": 0.7}, "the definition in NumPy, of the drawn numbers")
_add("random_gaussian_illumination", {"p": 0.7}, "the definition in NumPy, of the drawn numbers")
# as contrib.diamond_square: the graph of a gradient would be a copy of each of the loop's steps
_add("random_plasma_brightness", {"p": 0.7}, "the definition, of the plasma", gradients=())
_add("random_plasma_contrast", {"p": 0.7}, "the definition, of the plasma", gradients=())
_add("random_plasma_shadow", {"p": 0.7}, "the definition, of the plasma", gradients=())
_add("random_planckian_jitter", {"p": 0.7}, "published chromaticities", colour=True, also=({"mode": "CIED"},))
_add(
    "random_snow",
    {"snow_coefficient": (0.3, 0.7), "brightness": (1.5, 2.5), "p": 0.7},
    "OpenCV's HLS",
    colour=True,
    gradients=(),
)
_add(
    "random_rain",
    {"number_of_drops": (5, 20), "drop_height": (3, 9), "drop_width": (-3, 3), "p": 0.7},
    "the definition as loops in NumPy",
)
