"""Intensity changes."""

from ..spec import Spec, TensorSpec, Tolerance, image
from . import STENCIL, add

_OUTPUT = [TensorSpec("output", layout="NCHW")]
#: The gradient of a number that all pixels share is a sum over them, whose order each backend chooses.
_SUMS = {"float32": Tolerance(1e-3, 1e-4)}


def _factor(name: str, low: float, high: float, description: str) -> TensorSpec:
    return TensorSpec(name, ("B",), range=(low, high), description=f"{description}, of each image")


# --- normalisation -----------------------------------------------------------------------------------------------------

_MEAN = TensorSpec("mean", ("C",), description="one value a channel")
_STD = TensorSpec("std", ("C",), range=(0.2, 1.0), description="one value a channel, not zero")

add(Spec(
    "enhance.normalize",
    [image("data"), _MEAN, _STD],
    _OUTPUT,
    gradient_tolerances=_SUMS,
    reference="(data - mean) / std in NumPy float64",
))

add(Spec(
    "enhance.denormalize",
    [image("data"), _MEAN, _STD],
    _OUTPUT,
    gradient_tolerances=_SUMS,
    reference="data * std + mean in NumPy float64",
))

add(Spec(
    "enhance.normalize_min_max",
    [image()],
    _OUTPUT,
    config={"min_val": -1.0, "max_val": 2.0, "eps": 1e-6},
    # one pixel's gradient is a sum over its channel
    gradient_tolerances=_SUMS,
    symbols=STENCIL,
    reference="the formula in NumPy float64; OpenCV normalize(NORM_MINMAX)",
))

# --- sums and differences ----------------------------------------------------------------------------------------------

add(Spec(
    "enhance.add_weighted",
    [image("src1"), _factor("alpha", -1.0, 1.0, "weight of src1"), image("src2"), _factor("beta", -1.0, 1.0, "weight of src2"),
     _factor("gamma", -1.0, 1.0, "what is added")],
    _OUTPUT,
    gradient_tolerances=_SUMS,
    reference="OpenCV addWeighted",
))

add(Spec(
    "enhance.invert",
    [image("image"), _factor("max_val", 0.5, 1.5, "the value of white")],
    _OUTPUT,
    gradient_tolerances=_SUMS,
    reference="Pillow ImageOps.invert",
))

add(Spec(
    "enhance.shift_rgb",
    [image("image", channels=3, color="RGB"), *(_factor(f"{c}_shift", -0.5, 0.5, "what is added") for c in "rgb")],
    [TensorSpec("output", layout="NCHW", color="RGB")],
    gradient_tolerances=_SUMS,
    reference="clip(image + shift, 0, 1) in NumPy float64",
))

for _name in ("integral_image", "integral_tensor"):
    add(Spec(
        f"enhance.{_name}",
        [image("image" if _name == "integral_image" else "input")],
        _OUTPUT,
        config={} if _name == "integral_image" else {"dim": [1, -1]},
        # sums of up to all pixels, in another order
        tolerances={"float32": Tolerance(1e-3, 1e-4)},
        reference="OpenCV integral; NumPy cumsum",
    ))

# --- brightness, contrast, saturation, curves --------------------------------------------------------------------------

for _name, _low, _high in (
    ("adjust_brightness", -0.3, 0.3),
    ("adjust_brightness_accumulative", 0.5, 1.5),
    ("adjust_contrast", 0.5, 1.5),
):
    add(Spec(
        f"enhance.{_name}",
        [image("image"), _factor("factor", _low, _high, "strength")],
        _OUTPUT,
        config={"clip_output": True},
        gradient_tolerances=_SUMS,
        reference="Pillow ImageEnhance.Brightness; the formula in NumPy float64",
    ))

for _name, _enhancer in (("adjust_contrast_with_mean_subtraction", "Contrast"), ("adjust_saturation_with_gray_subtraction", "Color")):
    add(Spec(
        f"enhance.{_name}",
        [image("image", channels=3, color="RGB"), _factor("factor", 0.5, 1.5, "strength")],
        [TensorSpec("output", layout="NCHW", color="RGB")],
        gradient_tolerances=_SUMS,
        reference=f"Pillow ImageEnhance.{_enhancer}",
    ))

add(Spec(
    "enhance.adjust_gamma",
    [image(), _factor("gamma", 0.5, 2.0, "exponent"), _factor("gain", 0.8, 1.2, "factor")],
    _OUTPUT,
    gradient_tolerances=_SUMS,
    reference="scikit-image adjust_gamma",
))

for _inverse in (False, True):
    add(Spec(
        "enhance.adjust_log" + ".inverse" * _inverse,
        [image("image")],
        _OUTPUT,
        config={"gain": 1.1, "inv": _inverse, "clip_output": True},
        reference="scikit-image adjust_log",
    ), fn="enhance.adjust_log")

add(Spec(
    "enhance.adjust_sigmoid",
    [image("image")],
    _OUTPUT,
    config={"cutoff": 0.5, "gain": 10.0, "inv": False},
    reference="scikit-image adjust_sigmoid",
))

# --- tones -------------------------------------------------------------------------------------------------------------

add(Spec(
    "enhance.posterize",
    [image(), TensorSpec("bits", ("B",), "int64", range=(0, 8), description="bits to keep of each image")],
    _OUTPUT,
    gradients=(),
    reference="Pillow ImageOps.posterize",
))

add(Spec(
    "enhance.solarize",
    [image(), _factor("thresholds", 0.3, 0.7, "threshold"), _factor("additions", -0.2, 0.2, "what is added first")],
    _OUTPUT,
    gradients=("input", "additions"),
    gradient_tolerances=_SUMS,
    reference="Pillow ImageOps.solarize",
))

for _type in ("binary", "binary_inv", "trunc", "tozero", "tozero_inv"):
    _binary = _type.startswith("binary")
    add(Spec(
        f"enhance.threshold.{_type}",
        [image(), _factor("thresh", 0.3, 0.7, "threshold"), *([_factor("maxval", 0.5, 1.0, "value of what is marked")] if _binary else [])],
        _OUTPUT,
        config={"type": _type},
        gradients=("maxval",) if _binary else ("input",),
        gradient_tolerances=_SUMS,
        reference="OpenCV threshold",
    ), fn="enhance.threshold")

add(Spec(
    "enhance.sharpness",
    [image(), _factor("factor", 0.0, 2.0, "strength")],
    _OUTPUT,
    symbols=STENCIL,
    gradient_tolerances=_SUMS,
    reference="Pillow ImageEnhance.Sharpness",
))
